"""Reading of TOML tables into sections.

A section is a frozen dataclass whose fields are keys, made by the functions of
`granwave.lammps_inputs.case.schema.fields`. The metadata of a field are defined by `KeyInfo`.
`read_table` reads all keys of a table and collects all faults instead of stopping at the first.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from granwave.lammps_inputs.case.hints import Usual, hint_for, impossible
from granwave.lammps_inputs.case.schema.faults import ErrorList, ValidationError, refuse_if
from granwave.lammps_inputs.case.schema.values import Finish, Json, ValueType, plain_name
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.message_words import did_you_mean, show

Section = TypeVar("Section")
Entry = TypeVar("Entry")
Content = TypeVar("Content")

REQUIRED: Any = dataclasses.MISSING
_MOST_UNKNOWN = 20  # unknown keys of a table that are reported one by one
_KEY = "key"  # key of the metadata of a field
FURTHER_KEYS = "FURTHER_KEYS"  # class attribute of a section: keys that are not fields


@dataclasses.dataclass(frozen=True, kw_only=True)
class KeyInfo:
    """Declaration of a key.

    Attributes
    ----------
    description
        Description of the key, beginning with a noun.
    type
        Type of its values.
    unit
        Unit of its values; empty if there is none.
    usual
        Usual magnitudes, beyond which there is a warning.
    varies
        True if the unit depends on other keys; the reader of the table checks the magnitude.
    reader
        Function of value, faults and dotted key that reads the value instead of its type, for
        values that may have many faults; it returns None if there are faults.
    default_form
        Default in words, of a key whose default is none of its values.
    example
        A value, for the reference of the keys; None: there is an example in `key_examples.toml`, or
        the default is an example.
    """

    description: str
    type: ValueType
    unit: str = ""
    usual: Usual | None = None
    varies: bool = False
    reader: Callable[[Any, ErrorList, str], Any] | None = None
    default_form: str = ""
    example: Any = None

    @property
    def magnitudes(self) -> str | Usual | None:
        """Usual magnitudes, or only the unit; None if the reader of the table checks them."""
        return None if self.varies else self.usual or self.unit


def key_field(info: KeyInfo, default: Any = REQUIRED) -> Any:
    """Field of a section that is a key of its table."""
    return dataclasses.field(default=default, metadata={_KEY: info})


def info_of(field: dataclasses.Field[Any]) -> KeyInfo:
    """Return the declaration of the key of a field."""
    info: KeyInfo = field.metadata[_KEY]
    return info


def is_key(field: dataclasses.Field[Any]) -> bool:
    """Return True if a field is a key of the table."""
    return _KEY in field.metadata


def is_required(field: dataclasses.Field[Any]) -> bool:
    """Return True if a table needs the key of a field."""
    return field.default is REQUIRED and field.default_factory is REQUIRED


def declared_fields(section: type) -> dict[str, dataclasses.Field[Any]]:
    """Return all keys of a section by name, including the keys of its class attribute
    ``FURTHER_KEYS``, for which it has no fields.
    """
    return _own_fields(section) | getattr(section, FURTHER_KEYS, {})


def _own_fields(section: type) -> dict[str, dataclasses.Field[Any]]:
    """Return the fields of a section that are keys of its table, by name."""
    return {field.name: field for field in dataclasses.fields(section) if is_key(field)}


def key_fields(section: type) -> list[dataclasses.Field[Any]]:
    """Return the fields of a section that are keys of its table, other than bodies' materials."""
    fields = _own_fields(section).values()
    return [field for field in fields if info_of(field).reader is None]


def keys_of(sections: Mapping[str, type]) -> list[str]:
    """Return the dotted keys of tables, given by dotted name."""
    keys: list[str] = []
    for name, section in sections.items():
        keys += [f"{name}.{field.name}" for field in key_fields(section)]
    return keys


def with_inner_tables(tables: Mapping[str, type]) -> dict[str, type]:
    """Return sections by heading, each followed by the sections of tables that are values of its
    keys.
    """
    found: dict[str, type] = {}
    for heading, section in tables.items():
        found[heading] = section
        found |= with_inner_tables(dict(_inner_tables(heading, section)))
    return found


def _inner_tables(heading: str, section: type) -> Iterator[tuple[str, type]]:
    """Yield heading and section of each table that a key of a section may be."""
    name = heading.strip("[]")
    for key, field in declared_fields(section).items():
        info = info_of(field)
        for path, inner in info.type.tables.items():
            dotted = f"{name}.{key}.{path.removeprefix('[]')}".strip(".")
            yield f"[[{dotted}]]" if path.startswith("[]") else f"[{dotted}]", inner


def read_table(
    section: type[Section], table: Any, prefix: str, errors: ErrorList
) -> Section | None:
    """Read one TOML table into ``section``; on faults, add them all to ``errors`` and return None.

    Fields that are no keys keep their defaults.

    Parameters
    ----------
    prefix
        Dotted name of the table, as in the file; empty for the top level.
    """
    if not isinstance(table, Mapping):
        errors.add(prefix, Mismatch(show(table), f"a table [{prefix}] of keys and values"))
        return None
    before = len(errors.items)
    fields = _own_fields(section)
    refuse_unknown(table, list(fields), prefix, errors)
    values = {}
    for name, field in fields.items():
        key = f"{prefix}.{name}" if prefix else name
        if name in table:
            values[name] = _read_value(info_of(field), table[name], key, errors)
        elif is_required(field):
            errors.add(key, f"missing; it is required: {info_of(field).description}")
    return section(**values) if len(errors.items) == before else None


def _read_value(info: KeyInfo, value: Any, key: str, errors: ErrorList) -> Any:
    """Read the value of a key; return None with a fault."""
    if info.reader is not None:
        return info.reader(value, errors, key)
    try:
        read = info.type.read(value)
    except ValidationError as error:
        errors.add_wrong(key, value, error)
        return None
    if not info.varies:
        errors.check_size(key, read, info.magnitudes, show(value))
    return read


@dataclasses.dataclass(frozen=True, kw_only=True)
class TableType(ValueType):
    """A table with a separate section.

    Attributes
    ----------
    section
        Dataclass of the table, whose fields are keys.
    expected
        Accepted tables, in words.
    finish
        Function that converts the section, or raises `ValidationError`.
    listed
        True if the keys of the section are listed as a separate table.
    """

    kind: ClassVar[str] = "object"
    section: type
    expected: str
    finish: Finish | None = None
    listed: bool = True

    def read(self, value: Any) -> Any:
        """Return the section, or the result of `finish`."""
        refuse_if(not isinstance(value, Mapping) or not value, self.expected)
        fields = declared_fields(self.section)
        for name in value:
            near = did_you_mean(name, fields)
            refuse_if(name not in fields, f"{self.expected}; {name} is unknown{near}")
        values = {}
        for name, field in fields.items():
            if name in value:
                values[name] = self._read_value(field, value[name])
            else:
                refuse_if(is_required(field), f"{self.expected}; {name} is missing")
        section = self.section(**values)
        return section if self.finish is None else self.finish(section)

    def _read_value(self, field: dataclasses.Field[Any], value: Any) -> Any:
        """Read the value of a key; the fault of a value that is not valid names the key."""
        info = info_of(field)
        try:
            read = info.type.read(value)
            possible = impossible(read, info.unit)
            refuse_if(possible, possible)
        except ValidationError as error:
            raise error.below(field.name, value) from None
        return read

    @property
    def json(self) -> Json:
        """A table with the keys of the section."""
        return section_json(self.section)

    @property
    def tables(self) -> dict[str, type]:
        """The section, if it is listed."""
        return {"": self.section} if self.listed else {}


def section_json(section: type) -> Json:
    """Return the JSON Schema of a table with the keys of a section."""
    fields = declared_fields(section)
    schema: Json = {"type": "object", "additionalProperties": False}
    infos = {name: info_of(field) for name, field in fields.items()}
    schema["properties"] = {
        name: {**info.type.json, "description": info.description} for name, info in infos.items()
    }
    required = [name for name, field in fields.items() if is_required(field)]
    return schema | ({"required": required} if required else {})


def refuse_unknown(
    table: Mapping[str, Any], known: Collection[str], prefix: str, errors: ErrorList
) -> None:
    """Add a fault for each key of ``table`` that is not ``known``, with a suggestion; for many
    keys, the others share a common fault.
    """
    unknown = [name for name in table if name not in known]
    keys = [f"{prefix}.{name}" if prefix else name for name in unknown]
    shown = len(keys) if len(keys) <= _MOST_UNKNOWN + 1 else _MOST_UNKNOWN
    for name, key in zip(unknown[:shown], keys, strict=False):
        hint = hint_for(name, known, prefix, errors.vocabulary)
        errors.add_unknown(key, f"unknown key; {hint}")
    if rest := keys[shown:]:
        errors.add_unknown(rest[0], f"unknown key, as are {len(rest) - 1} more after it")


def read_list(
    section: type[Entry], tables: Any, prefix: str, errors: ErrorList
) -> tuple[Entry, ...]:
    """Read an array of tables, such as ``[[replace]]``; entry n has the dotted name ``replace.n``,
    from 1.
    """
    if not isinstance(tables, list | tuple):
        errors.add(prefix, Mismatch(show(tables), f"one or more [[{prefix}]] tables"))
        return ()
    entries = numbered(prefix, tables).items()
    read = [read_table(section, table, key, errors) for key, table in entries]
    return tuple(entry for entry in read if entry is not None)


def numbered(name: str, entries: Iterable[Entry]) -> dict[str, Entry]:
    """Return the entries of an array of tables by their dotted keys, such as ``replace.1``."""
    return {f"{name}.{n}": entry for n, entry in enumerate(entries, start=1)}


def read_named(
    key: str, name: Any, expected: str, read: Callable[[Path], Content], errors: ErrorList
) -> Content | None:
    """Return the result of ``read`` for the file of a key; None with an error if there is a
    fault.
    """
    if not isinstance(name, str) or not name:
        errors.add(key, Mismatch(show(name), expected))
        return None
    try:
        return read(Path(name))
    except OSError as error:
        errors.add(key, f"{name}: cannot be read: {error.strerror or error}")
    except ValueError as error:
        errors.add(key, f"{name}: {error}")
    return None


def read_name(data: Mapping[str, Any], source: str | Path, errors: ErrorList) -> str:
    """Read the ``name`` of a case or a scan; the default is the stem of its file."""
    name = data.get("name", Path(source).stem)
    try:
        return plain_name(name)
    except ValidationError as error:
        expected = error.expected
        if "name" not in data:
            expected += ", from the name of the file: set a name in the case"
        errors.add("name", Mismatch(show(name), expected))
        return str(name)
