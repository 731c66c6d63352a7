"""Reference of the keys of all files that a user writes, collected from the code that reads them.

``granwave keys`` prints it, and the site of the documents shows it. Description, unit and default
are taken from the field, accepted values from its validator, and examples from `key_examples.toml`
here and in the folders of extensions.
"""

from __future__ import annotations

import dataclasses
import difflib
import inspect
import math
import re
import sys
import tomllib
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.case.hints import Usual, hint_for, plain
from granwave.lammps_inputs.case.schema import (
    REQUIRED,
    declared_fields,
    info_of,
    is_required,
    show,
)
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.extensions import extensions, load
from granwave.workflows.cli.keys.sections import CONTACT, PAIR, case_sections
from granwave.workflows.cli.terminal import BOLD, coloured
from granwave.workflows.file_kinds import file_kinds

_EXAMPLES = "key_examples.toml"
_NOT_OF_A_PAIR = ("initial_overlap",)


@dataclasses.dataclass(frozen=True)
class Key:
    """One key of a file.

    Attributes
    ----------
    unit, default
        As in a file; empty if it has none.
    accepts
        Accepted values, in words.
    usual
        Magnitudes outside which a warning is given; empty if there are none.
    example
        A value as in a file.
    words
        Allowed words, numbers or booleans, if the values are a list.
    json
        JSON Schema of its values.
    """

    name: str
    description: str
    accepts: str
    unit: str = ""
    default: str = ""
    required: bool = False
    usual: str = ""
    example: str = ""
    words: tuple[Any, ...] = ()
    json: Mapping[str, Any] = dataclasses.field(default_factory=dict, compare=False)


@dataclasses.dataclass(frozen=True)
class KeyTable:
    """One table of a file.

    Attributes
    ----------
    file
        Name of the `granwave.workflows.file_kinds.FileKind`.
    name
        Its dotted name; for the keys above all tables the name of the kind of file.
    heading
        Its heading in a file; empty for the keys above all tables.
    """

    file: str
    name: str
    heading: str
    description: str
    keys: tuple[Key, ...]


@cache
def tables() -> tuple[KeyTable, ...]:
    """Return all tables of all kinds of files."""
    found = []
    for kind in file_kinds():
        sections = load(kind.sections)()
        for heading, (section, what) in sections.items():
            table = _of_section(kind.name, heading, section, what)
            found.append(_with_contact(table) if heading == PAIR else table)
    return tuple(found)


def titles() -> dict[str, str]:
    """Return the heading of each kind of files by its name."""
    return {kind.name: kind.title for kind in file_kinds()}


def find(*words: str) -> list[KeyTable]:
    """Return the tables of this name, or the table with a single key; for other words the keys
    that contain them.

    Raises
    ------
    InputError
        There is none; the message names similar ones.
    """
    name = ".".join(words)
    wanted = name.strip("[]")
    found = [table for table in tables() if table.name == wanted]
    if not found:
        table_name, _, key = wanted.rpartition(".")
        for table in tables():
            if table.name == (table_name or table.file):
                entries = [entry for entry in table.keys if entry.name == key]
                found += [dataclasses.replace(table, keys=(entry,)) for entry in entries]
    if not found and wanted:
        patterns = [
            re.compile(rf"(?<!\w){re.escape(word)}s?(?!\w)", re.IGNORECASE) for word in words
        ]
        for table in tables():
            texts = {key: f"{key.name} {key.description} {key.accepts}" for key in table.keys}
            keys = tuple(
                key for key, text in texts.items() if all(one.search(text) for one in patterns)
            )
            found += [dataclasses.replace(table, keys=keys)] if keys else []
    if not found:
        raise InputError(f"{show(name)[1:-1] or '(empty)'}: no such table or key; {_hint(wanted)}")
    return found


def overview() -> str:
    """Return a list of all tables, by kind of file."""
    width = max(len(table.name) for table in tables())
    parts = []
    for file, title in titles().items():
        rows = [
            f"  {table.name:{width}}  {table.description}"
            for table in tables()
            if table.file == file
        ]
        parts.append("\n".join([title, *rows]))
    parts.append(
        "granwave keys TABLE lists the keys of a table, TABLE.KEY shows one key, and WORD finds "
        "the keys that contain it."
    )
    return "\n\n".join(parts)


def as_text(table: KeyTable) -> str:
    """Return a table and its keys for the terminal."""
    heading = coloured(table.heading or "top level", BOLD, sys.stdout)
    lines = [f"{heading}  {table.description}  ({titles()[table.file]})"]
    for key in table.keys:
        title = "  ".join(
            filter(None, [coloured(key.name, BOLD, sys.stdout), key.unit, state(key)])
        )
        facts = (key.description, f"expects {key.accepts}", key.usual, f"example: {key.example}")
        lines += ["", title, *(f"    {fact}" for fact in facts if fact)]
    return "\n".join(lines)


def state(key: Key) -> str:
    """Return the default of a key in words."""
    if key.required:
        return "required"
    return f"default {key.default}" if key.default else "optional"


def _of_section(file: str, heading: str, section: type, description: str = "") -> KeyTable:
    """Return the table of a section."""
    fields = declared_fields(section)
    listed = [_key_of(name, field) for name, field in fields.items()]
    return _table(file, heading, description or _first_line(section), listed)


def _key_of(name: str, field: dataclasses.Field[Any]) -> Key:
    """Return the declaration of a key."""
    info = info_of(field)
    return Key(
        name=name,
        description=info.description,
        accepts=info.type.accepts,
        unit=info.unit,
        default=info.default_form or _default_of(field),
        required=is_required(field),
        usual="" if info.usual is None else _usual(info.usual),
        example="" if info.example is None else _written(info.example),
        words=info.type.words,
        json=info.type.json,
    )


def _default_of(field: dataclasses.Field[Any]) -> str:
    """Return the default as in a file; empty if there is none."""
    default = field.default
    if default in (REQUIRED, None, ""):
        return ""
    if dataclasses.is_dataclass(default) and not isinstance(default, type):
        return _written(dataclasses.asdict(default))
    return _written(default)


def _table(file: str, heading: str, description: str, found: Sequence[Key]) -> KeyTable:
    """Return a table with an example of each key; where none is given it is the default."""
    name = heading.strip("[]") or file
    given = _examples().get(file, {}).get(name, {})
    shown = {key.name: key.example or key.default for key in found}
    shown |= {key.name: _written(given[key.name]) for key in found if key.name in given}
    keys = (dataclasses.replace(key, example=f"{key.name} = {shown[key.name]}") for key in found)
    return KeyTable(file, name, heading, description, tuple(keys))


def _with_contact(pair: KeyTable) -> KeyTable:
    """Return the table ``[[pair]]`` with the keys that it shares with ``[contact]``."""
    contact = _of_section(pair.file, CONTACT, case_sections()[CONTACT][0])
    of_contact = (key for key in contact.keys if key.name not in _NOT_OF_A_PAIR)
    taken = (dataclasses.replace(key, default="value of [contact]") for key in of_contact)
    return dataclasses.replace(pair, keys=(*pair.keys, *taken))


def _written(value: Any) -> str:
    """Write a value as in a TOML file, in full; a float as one would type it: 115e9, 0.01, 5.0."""
    if isinstance(value, Mapping):
        names = {name: name if name.isidentifier() else f'"{name}"' for name in value}
        return (
            "{"
            + ", ".join(f"{names[name]} = {_written(item)}" for name, item in value.items())
            + "}"
        )
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_written, value)) + "]"
    if not isinstance(value, float):
        return show(value)
    if 1e-3 <= abs(value) < 1e4 or not value:
        shown = f"{value:.10g}"
        return shown if "." in shown else f"{shown}.0"
    power = math.floor(math.log10(abs(value)))
    if power >= 10:
        power = 9
    elif power >= 8:
        power = 6
    return f"{value / 10.0**power:.10g}e{power}"


def _usual(usual: Usual) -> str:
    of_unit = f" {usual.unit}" if usual.unit else ""
    text = f"usual: {plain(usual.low)} to {plain(usual.high)}{of_unit}"
    if usual.beyond == 1:
        return f"{text}; other values give a warning"
    return (
        f"{text}; below, and above {plain(usual.high * usual.beyond)}{of_unit}, a warning is given"
    )


def _first_line(section: type) -> str:
    """Return the first line of a class's docstring, without the heading that it may begin with."""
    line = (inspect.getdoc(section) or "").partition("\n")[0].rstrip(".")
    text = (line.rpartition("``: ")[2] if line.startswith("``") else line).replace("``", "")
    return text if text[:2].isupper() else text[:1].lower() + text[1:]


@cache
def _examples() -> dict[str, dict[str, dict[str, Any]]]:
    """Return the examples by kind of file, table and key, with those of extensions."""
    # the package is always unpacked on disk: it holds a shared library
    folders = [Path(str(resources.files("granwave.workflows.cli.keys")))]
    folders += [one.folder for one in extensions() if one.folder is not None]
    examples: dict[str, dict[str, dict[str, Any]]] = {}
    for folder in reversed(folders):
        file = folder / _EXAMPLES
        found = tomllib.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
        for kind, tables_of_kind in found.items():
            known = examples.setdefault(kind, {})
            for table, keys in tables_of_kind.items():
                known[table] = known.get(table, {}) | keys
    return examples


def _hint(wanted: str) -> str:
    names = list(dict.fromkeys(table.name for table in tables()))
    vocabulary = []
    for table in tables():
        for key in table.keys:
            vocabulary.append(f"{table.name}.{key.name}")
    same = list(dict.fromkeys(key for key in vocabulary if wanted and key.endswith(f".{wanted}")))
    near = same or difflib.get_close_matches(
        wanted.lower(), [*names, *vocabulary], n=1, cutoff=0.75
    )
    if near:
        return f"did you mean {' or '.join(near)}?"
    hint = hint_for(wanted.rpartition(".")[2], names, "", list(dict.fromkeys(vocabulary)))
    return hint.replace("available here:", "available:")
