"""Schema of TOML tables: types and bounds of their keys, and reading a table into a typed section.

A section is a frozen dataclass whose fields are made by the functions below. The metadata of each
field holds its ``description``, its ``unit``, its ``options`` if it is one of some words, the
``parse`` function that converts a TOML value to the value of the field or raises `ValidationError`,
and ``json``, the JSON Schema of its TOML values (of `custom` fields none). `read_table` applies
them and collects all faults instead of stopping at the first.
"""

from __future__ import annotations

import dataclasses
import difflib
import logging
import math
import sys
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from granwave.lammps_inputs.case.hints import Usual, hint_for, impossible, unusual
from granwave.lammps_inputs.errors import InputError

Section = TypeVar("Section")
Entry = TypeVar("Entry")
Content = TypeVar("Content")
Parse = Callable[[Any], Any]

_LOG = logging.getLogger("granwave")
REQUIRED: Any = dataclasses.MISSING
_LEAST = 2.3e-308  # magnitude, in messages
_MOST_UNKNOWN = 20  # unknown keys of a table with an error each
LARGEST_COUNT = 2**31 - 1  # ids and counts are 32-bit integers in the default build of LAMMPS
NO_LIMIT = 2**63 - 1  # for counts that the schedule limits to that of the steps
_NOT_A_VALUE = object()  # no key accepts it
_SHOWN_CHARACTERS = 60
LABEL_FORM = "a name that is not empty, without tabs, line breaks and other control characters, nor blanks at its ends"
_LONGEST_NAME = 200  # bytes; file systems allow 255, including suffixes


class ValidationError(Exception):
    """Error of a value that is not valid for its key; the message says what was expected."""


def refuse_if(wrong: object, expected: str) -> None:
    """Raise `ValidationError` with what was ``expected`` if a value is wrong."""
    if wrong:
        raise ValidationError(expected)


@dataclasses.dataclass
class ErrorList:
    """Errors of one file, one line each.

    Attributes
    ----------
    source
        Name of the file, as shown to the user.
    overridden
        Dotted keys that came from the command line; their errors name ``--set`` as the source.
    vocabulary
        All dotted keys, for suggestions.
    lines
        Error messages.
    notes
        Warnings: values that are valid but probably not meant.
    """

    source: str
    overridden: Collection[str] = ()
    vocabulary: Sequence[str] = ()
    lines: list[str] = dataclasses.field(default_factory=list)
    notes: list[str] = dataclasses.field(default_factory=list)

    def add(self, key: str, message: str) -> None:
        """Add an error of the dotted ``key``."""
        top_down = [key.rsplit(".", n)[0] for n in range(key.count(".") + 1)]
        source = "--set" if any(name in self.overridden for name in top_down) else self.source
        self.lines.append(" ".join(f"{source}: {_cut(key)}: {message}".split()))

    def check(self, *rows: tuple[object, str, str]) -> None:
        """Add the errors of rows whose first entry is true: condition, key and message."""
        for wrong, key, message in rows:
            if wrong:
                self.add(key, message)

    def check_first(self, *rows: tuple[object, str, str]) -> bool:
        """Add the error of the first row whose first entry is true; return True if there is none."""
        found = next((row for row in rows if row[0]), None)
        self.check(*([found] if found else []))
        return found is None

    def check_names(self, entries: Mapping[str, Any]) -> None:
        """Add an error for each entry of an array of tables, by key, that has the name of an
        earlier one.
        """
        known: list[str] = []
        for key, entry in entries.items():
            self.check((entry.name in known, f"{key}.name",
                        f"found {show(entry.name)} twice, expected a name of its own"))  # fmt: skip
            known.append(entry.name)

    def check_size(self, key: str, value: Any, unit: str | Usual | None, shown: str) -> None:
        """Add an error if a value is impossible in its unit, a note if it is unusual."""
        if expected := impossible(value, unit_name(unit)):
            self.add(key, f"found {shown}, expected {expected}")
        elif isinstance(unit, Usual) and (odd := unusual(value, unit)):
            self.notes.append(f"{key}: {odd}")

    def add_unknown(self, key: str, message: str) -> None:
        """Add an error of an unknown key; if the key is a table that ``--set`` made, name the key
        given there.
        """
        self.add(next((one for one in self.overridden if one.startswith(f"{key}.")), key), message)

    def report(self, name: str) -> None:
        """Log the notes as warnings that name the case; raise InputError if there are errors."""
        for note in self.notes:
            _LOG.warning("%s: %s", name, note)
        self.notes.clear()
        if self.lines:
            raise InputError(self.lines)


def number(
    description: str,
    unit: str | Usual | None = None,
    *,
    default: Any = REQUIRED,
    above: float = -math.inf,
    below: float = math.inf,
    at_least: float = -math.inf,
    at_most: float = math.inf,
    word: str | None = None,
    units: str | None = None,
) -> Any:
    """Field of a finite number within bounds, or of ``word`` in its place; unusual values give a
    warning.

    ``units`` stands in messages for the unit, of a key that has another one in some tables.
    """
    limits = [(above, "above"), (at_least, "at least"), (below, "below"), (at_most, "at most")]
    wanted = " and ".join(f"{name} {limit:g}" for limit, name in limits if math.isfinite(limit))
    in_units = f" ({units or unit_name(unit)})" if units or unit_name(unit) else ""
    expected = f"a number {wanted}".rstrip() + in_units + (f' or "{word}"' if word else "")

    def parse(value: Any) -> Any:
        if word is not None and value == word:
            return value
        result = finite(value, expected)
        refuse_if(not (above < result < below and at_least <= result <= at_most), expected)
        return result

    bounds = zip(
        ("exclusiveMinimum", "minimum", "exclusiveMaximum", "maximum"), limits, strict=True
    )
    json: dict[str, Any] = {"type": "number"}
    json |= {keyword: limit for keyword, (limit, _) in bounds if math.isfinite(limit)}
    json = {"anyOf": [json, {"const": word}]} if word else json
    options = (word,) if word else None
    return _field(description, unit, default, parse, options, json=json, varies=units is not None)


def positive_or_auto(description: str, unit: Usual, *, default: float | str = "auto") -> Any:
    """A positive number, or "auto"."""
    return number(description, unit, above=0, word="auto", default=default)


def choice(description: str, options: tuple[Any, ...], *, default: Any = REQUIRED) -> Any:
    """Field of one of the listed words, whole numbers or booleans."""
    expected = "one of " + ", ".join(show(option) for option in options)

    def parse(value: Any) -> Any:
        if value not in options or type(value) is not type(options[0]):
            raise ValidationError(expected + did_you_mean(value, map(str, options)))
        return value

    return _field(description, None, default, parse, options=options, json={"enum": list(options)})


def did_you_mean(word: Any, known: Iterable[str], cutoff: float = 0.6) -> str:
    """Return a hint at the known word most like another one; empty if none is like it."""
    near = difflib.get_close_matches(str(word).lower(), list(known), n=1, cutoff=cutoff)
    return f"; did you mean {near[0]}?" if near else ""


def text(description: str, *, default: Any = REQUIRED) -> Any:
    """Field of a string that is not empty."""

    def parse(value: Any) -> Any:
        refuse_if(not isinstance(value, str) or not value.strip(), "a string that is not empty")
        return value

    return _field(description, None, default, parse, json={"type": "string", "pattern": r"\S"})


def parse_label(value: Any) -> str:
    """Return ``value`` if it is a name that stands in one line of a table; raise `ValidationError`
    otherwise.
    """
    refuse_if(
        not isinstance(value, str)
        or not value
        or value != value.strip()
        or not value.isprintable(),
        LABEL_FORM,
    )
    return value


def custom(
    description: str, parse: Parse, *, unit: str | Usual | None = None, default: Any = REQUIRED
) -> Any:
    """Field of a value with its own ``parse`` function; unusual numbers in it give a warning."""
    return _field(description, unit, default, parse)


def finite(value: Any, expected: str) -> float:
    """Convert ``value`` to a finite float; raise `ValidationError` for booleans, strings, NaN and
    infinity.
    """
    refuse_if(isinstance(value, bool) or not isinstance(value, int | float), expected)
    try:
        result = float(value)
    except OverflowError:
        raise ValidationError(expected) from None
    refuse_if(not math.isfinite(result), expected)
    if 0 < abs(result) < sys.float_info.min:  # LAMMPS cannot read it
        raise ValidationError(f"{expected}: 0, or a magnitude from {_LEAST:.3g} up")
    return result


def whole(value: Any, expected: str, *, at_least: int = 1, at_most: int = LARGEST_COUNT) -> int:
    """Return ``value`` as an integer within bounds; raise `ValidationError` for booleans and
    floats.
    """
    refuse_if(isinstance(value, bool) or not isinstance(value, int) or value < at_least, expected)
    refuse_if(value > at_most, f"at most {at_most}")
    return value


def count(
    description: str, *, default: Any = REQUIRED, at_least: int = 1, at_most: int = LARGEST_COUNT
) -> Any:
    """Field of a whole number within bounds."""
    expected = f"a whole number from {at_least} " + (
        "up" if at_most == LARGEST_COUNT else f"to {at_most}"
    )
    json = {"type": "integer", "minimum": at_least, "maximum": at_most}

    def parse(value: Any) -> int:
        return whole(value, expected, at_least=at_least, at_most=at_most)

    return _field(description, None, default, parse, json=json)


def numbers(
    n: int, expected: str, fits: Callable[..., bool] = lambda *_: True, otherwise: str = ""
) -> Parse:
    """Make the parser of a list of ``n`` numbers that ``fits`` accepts.

    Parameters
    ----------
    otherwise
        What was expected of numbers that do not fit; ``expected`` by default.
    """

    def parse(value: Any) -> tuple[float, ...]:
        refuse_if(not isinstance(value, list | tuple) or len(value) != n, expected)
        found = tuple(finite(one, expected) for one in value)
        refuse_if(not fits(*found), otherwise or expected)
        return found

    return parse


def parse_point(value: Any, expected: str) -> tuple[float, float, float]:
    """Convert ``value`` to three numbers; raise `ValidationError` with what was ``expected``."""
    x, y, z = numbers(3, expected)(value)
    return x, y, z


def inner_table(
    value: Any, form: str, known: Collection[str], needed: Collection[str] = ()
) -> Mapping[str, Any]:
    """Return ``value`` if it is a table of known keys, with the needed ones; raise
    `ValidationError` otherwise.
    """
    refuse_if(not isinstance(value, Mapping) or not value, form)
    for name in value:
        refuse_if(name not in known, f"{form}; {name} is unknown")
    for name in needed:
        refuse_if(name not in value, f"{form}; {name} is missing")
    return value  # type: ignore[no-any-return]


def or_word(word: str, parse: Parse) -> Parse:
    """Make a parser that accepts a word beside what ``parse`` accepts."""
    return lambda value: value if value == word else parse(value)


def vector(description: str, unit: Usual) -> Any:
    """Field of three numbers, zero by default; unusual magnitudes give a warning."""
    json = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
    return _field(
        description, unit, (0.0, 0.0, 0.0), numbers(3, f"[x, y, z] in {unit.unit}"), json=json
    )


def plain_name(value: Any) -> str:
    """Return ``value`` if it is a name that can safely be used for a directory; raise
    `ValidationError` otherwise.
    """
    fits = isinstance(value, str) and value.strip() == value != "" and value.isprintable()
    if not fits or "/" in value or value[0] in ".-~":
        raise ValidationError(
            'a plain name, as of a directory: without "/", not beginning with ".", "-" or "~"'
        )
    refuse_if(len(value.encode()) > _LONGEST_NAME, f"a plain name of at most {_LONGEST_NAME} bytes")
    return value


def read_name(data: Mapping[str, Any], source: str | Path, errors: ErrorList) -> str:
    """Read the ``name`` of a case or a scan; the default is the stem of its file."""
    name = data.get("name", Path(source).stem)
    try:
        return plain_name(name)
    except ValidationError as error:
        where = (
            "" if "name" in data else ", from the name of the file: give the case a name of its own"
        )
        errors.add("name", f"found {show(name)}, expected {error}{where}")
        return str(name)


def show(value: Any) -> str:
    """Format ``value`` as in a TOML file, cut to a readable length."""
    if isinstance(value, bool):
        shown = "true" if value else "false"
    elif isinstance(value, str):
        shown = '"' + printable(value.replace("\\", "\\\\")) + '"'
    elif isinstance(value, Mapping):
        shown = "{" + ", ".join(f"{key} = {show(item)}" for key, item in value.items()) + "}"
    elif isinstance(value, list | tuple):
        shown = "[" + ", ".join(show(item) for item in value[:_SHOWN_CHARACTERS]) + "]"
    else:
        shown = str(value)
    return _cut(shown)


def printable(text: str) -> str:
    """Escape line ends, control characters and direction marks, so that ``text`` stays on one line."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def _cut(text: str) -> str:
    """Cut ``text`` to a readable length."""
    return text if len(text) <= _SHOWN_CHARACTERS else text[: _SHOWN_CHARACTERS - 3] + "..."


def read_table(
    section: type[Section], table: Any, prefix: str, errors: ErrorList
) -> Section | None:
    """Read one TOML table into ``section``; on faults, add them all to ``errors`` and return None.

    Fields that are not made by the functions above keep their defaults.

    Parameters
    ----------
    prefix
        Dotted name of the table, as in the file; empty for the top level.
    """
    if not isinstance(table, Mapping):
        errors.add(prefix, f"found {show(table)}, expected a table [{prefix}] of keys and values")
        return None
    before = len(errors.lines)
    values: dict[str, Any] = {}
    for field in dataclasses.fields(section):  # type: ignore[arg-type]
        if "read" in field.metadata and field.name in table:
            values[field.name] = field.metadata["read"](
                table[field.name], errors, f"{prefix}.{field.name}"
            )
    fields = {field.name: field for field in key_fields(section)}
    refuse_unknown(
        {name: value for name, value in table.items() if name not in values},
        list(fields),
        prefix,
        errors,
    )
    for name, field in fields.items():
        key = f"{prefix}.{name}" if prefix else name
        parse: Parse = field.metadata["parse"]
        if name in table:
            try:
                values[name] = parse(table[name])
            except ValidationError as error:
                errors.add(key, f"found {show(table[name])}, expected {error}")
                continue
            unit = field.metadata["usual"] or field.metadata["unit"]
            if not field.metadata["varies"]:
                errors.check_size(key, values[name], unit, show(table[name]))
        elif field.default is REQUIRED and field.default_factory is REQUIRED:
            errors.add(key, f"missing; it is required: {field.metadata['description']}")
    return section(**values) if len(errors.lines) == before else None


def refuse_unknown(
    table: Mapping[str, Any], known: Collection[str], prefix: str, errors: ErrorList
) -> None:
    """Add an error for each key of ``table`` that is not ``known``, with a suggestion; of many keys
    for the first ones, and one for the others.
    """
    unknown = [name for name in table if name not in known]
    keys = [f"{prefix}.{name}" if prefix else name for name in unknown]
    shown = len(keys) if len(keys) <= _MOST_UNKNOWN + 1 else _MOST_UNKNOWN
    for name, key in zip(unknown[:shown], keys, strict=False):
        hint = hint_for(name, known, prefix, errors.vocabulary)
        errors.add_unknown(key, f"unknown key; {hint}")
    if rest := keys[shown:]:
        errors.add_unknown(rest[0], f"unknown key, as are {len(rest) - 1} more that follow it")


def accepted(field: dataclasses.Field[Any]) -> str:
    """Return what the ``parse`` function of a field expects, as its error messages say it, without
    the unit.
    """
    try:
        field.metadata["parse"](_NOT_A_VALUE)
    except ValidationError as error:
        unit = field.metadata["unit"]
        return str(error).replace(f" ({unit})", "") if unit else str(error)
    return "any value"


def read_named(
    key: str, name: Any, expected: str, read: Callable[[Path], Content], errors: ErrorList
) -> Content | None:
    """Return what ``read`` makes of the file that a key names; None with an error if there is a
    fault.
    """
    if not isinstance(name, str) or not name:
        errors.add(key, f"found {show(name)}, expected {expected}")
        return None
    try:
        return read(Path(name))
    except OSError as error:
        errors.add(key, f"{name}: cannot be read: {error.strerror or error}")
    except ValueError as error:
        errors.add(key, f"{name}: {error}")
    return None


def numbered(name: str, entries: Iterable[Entry]) -> dict[str, Entry]:
    """Return the entries of an array of tables by their dotted keys, such as ``replace.1``."""
    return {f"{name}.{n}": entry for n, entry in enumerate(entries, start=1)}


def nested(read: Callable[[Any, ErrorList, str], Any]) -> Any:
    """Field of a table with a reader of its own, which adds its faults, and returns None with any."""
    return dataclasses.field(default=None, metadata={"read": read})


def key_fields(section: type) -> list[dataclasses.Field[Any]]:
    """Return the fields of a section that are keys of its table, other than `nested` ones."""
    return [field for field in dataclasses.fields(section) if "parse" in field.metadata]


def keys_of(sections: Mapping[str, type]) -> list[str]:
    """Return the dotted keys of tables, given by dotted name."""
    return [
        f"{name}.{field.name}"
        for name, section in sections.items()
        for field in key_fields(section)
    ]


def read_list(
    section: type[Entry], tables: Any, prefix: str, errors: ErrorList
) -> tuple[Entry, ...]:
    """Read an array of tables, such as ``[[replace]]``; entry n has the dotted name ``replace.n``,
    from 1.
    """
    if not isinstance(tables, list | tuple):
        errors.add(prefix, f"found {show(tables)}, expected one or more [[{prefix}]] tables")
        return ()
    read = [
        read_table(section, table, key, errors) for key, table in numbered(prefix, tables).items()
    ]
    return tuple(entry for entry in read if entry is not None)


def _field(
    description: str,
    unit: str | Usual | None,
    default: Any,
    parse: Parse,
    options: tuple[Any, ...] | None = None,
    json: Mapping[str, Any] | None = None,
    *,
    varies: bool = False,
) -> Any:
    usual = unit if isinstance(unit, Usual) else None
    metadata: dict[str, Any] = {"description": description, "usual": usual, "parse": parse}
    metadata["unit"] = unit_name(unit)
    metadata["varies"] = varies  # the unit, with other keys, which the reader of the table checks
    return dataclasses.field(
        default=default, metadata=metadata | {"options": options, "json": json}
    )


def unit_name(unit: str | Usual | None) -> str:
    """Return the name of a unit; empty if there is none."""
    return unit.unit if isinstance(unit, Usual) else unit or ""
