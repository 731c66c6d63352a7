"""Reference of the keys of all files that a user writes, collected from the code that reads them.

``granwave keys`` prints it, and the site of the documents shows it. Description, unit and default
are those of the field, the accepted values are the words of its validator, and the examples stand
in `key_examples.toml`.
"""

from __future__ import annotations

import dataclasses
import difflib
import inspect
import math
import re
import sys
import tomllib
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Any

from granwave.analysis.inference.case import InferCase
from granwave.lammps_inputs.case.case import TABLES
from granwave.lammps_inputs.case.contact import Pair
from granwave.lammps_inputs.case.hints import Usual, hint_for, plain
from granwave.lammps_inputs.case.schema import REQUIRED, ValidationError, accepted, key_fields, show
from granwave.lammps_inputs.errors import InputError
from granwave.workflows.cli.arguments import FILE_KINDS
from granwave.workflows.cli.terminal import BOLD, coloured
from granwave.workflows.design.problem import DESIGN_TABLES
from granwave.workflows.finite_elements.punch.case import ContinuumCase
from granwave.workflows.finite_elements.sphere_contact.case import Sphere, SphereContactCase
from granwave.workflows.scanning.header import Header, RanksBySize
from granwave.workflows.scanning.slurm import Profile
from granwave.workflows.scanning.suite import SuiteFile

CASE, CONTINUUM, SPHERE_CONTACT, SCAN, SUITE, PROFILE, INFERENCE, DESIGN = FILES = FILE_KINDS
#: What each kind of file is, and the command that reads it.
TITLES = {
    CASE: "Case files (granwave run)",
    CONTINUUM: "Continuum cases (granwave continuum)",
    SPHERE_CONTACT: "Cases of the contact of two spheres (granwave continuum)",
    SCAN: "Scan files (granwave scan)",
    SUITE: "Suites of scans (granwave scan)",
    PROFILE: "Profiles of a cluster (granwave scan --profile)",
    INFERENCE: "Cases of inferred forces (granwave infer --case)",
    DESIGN: "Searches for a design (granwave design)",
}
_MATERIAL = "the name of a material, or a table of its values as in [material]"
_TABLE_OF_KEYS = "a table of dotted keys of the case"
_LISTS_OF_VALUES = "a list of values, {linear = [first, last, how many]} or {log = [first, last, how many]} for each key"
#: Values of all types, by which is found what a reader of its own accepts.
_PROBES: tuple[Any, ...] = (
    True, 1, 3, 0.5, "x", "z", "all", "auto", "centre", "mean", "none", "x.py", [], [1], [1, 2], [0.1, 1.0], [0, 0, 1],
    [1, 1], ["x"], [[1, 0.1]], [[0, 0], [1, 1]], [[0, 0, 1]], [{"sphere": 1}], {}, {"first": 1, "last": 2},
    {"material": "brass"},
)  # fmt: skip
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
    json
        JSON Schema of its values, as far as the code that reads them tells it.
    """

    name: str
    description: str
    accepts: str
    unit: str = ""
    default: str = ""
    required: bool = False
    usual: str = ""
    example: str = ""
    json: Mapping[str, Any] = dataclasses.field(default_factory=dict, compare=False)


@dataclasses.dataclass(frozen=True)
class Table:
    """One table of a file.

    Attributes
    ----------
    file
        Kind of the file, one of `FILES`.
    name
        Its dotted name; that of the kind of file for the keys above all tables.
    heading
        Its heading in a file; empty for the keys above all tables.
    """

    file: str
    name: str
    heading: str
    description: str
    keys: tuple[Key, ...]


@cache
def tables() -> tuple[Table, ...]:
    """Return all tables of all kinds of files."""
    return (
        _table(CASE, "", "name, material and the tables below", _TOP),
        *(_of_section(CASE, heading, section) for heading, section in TABLES.items()),
        _pair(),
        _table(CONTINUUM, "", "name, material and the tables below", _TOP),
        *(
            _of_section(CONTINUUM, f"[{name}]", section)
            for name, section in ContinuumCase.SECTIONS.items()
        ),
        _table(SPHERE_CONTACT, "", "name, material and the tables below", _TOP),
        *(
            _of_section(SPHERE_CONTACT, f"[{name}]", section)
            for name, section in SphereContactCase.SECTIONS.items()
        ),
        _of_section(
            SPHERE_CONTACT, "[partner]", Sphere, "the second sphere, if it differs from the first"
        ),
        _of_section(SCAN, "", Header, "top-level keys and the tables of what varies"),
        _of_section(SCAN, "[ranks]", RanksBySize),
        _of_section(SUITE, "", SuiteFile),
        _of_section(
            PROFILE, "[slurm]", Profile, "how the cluster is used; every key may be left out"
        ),
        *(
            _of_section(INFERENCE, f"[{name}]", section)
            for name, section in InferCase.SECTIONS.items()
        ),
        *(
            _of_section(DESIGN, heading, section, what)
            for heading, (section, what) in DESIGN_TABLES.items()
        ),
    )


def find(*words: str) -> list[Table]:
    """Return the tables of this name, or the table with one key alone; for other words the keys
    that these stand in.

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
        found = [
            dataclasses.replace(table, keys=(entry,))
            for table in tables()
            for entry in table.keys
            if entry.name == key and table.name in (table_name or table.file,)
        ]
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
    for file in FILES:
        rows = [
            f"  {table.name:{width}}  {table.description}"
            for table in tables()
            if table.file == file
        ]
        parts.append("\n".join([TITLES[file], *rows]))
    parts.append(
        "granwave keys TABLE lists the keys of a table, TABLE.KEY one of them, WORD those in which it stands."
    )
    return "\n\n".join(parts)


def as_text(table: Table) -> str:
    """Return a table and its keys for the terminal."""
    heading = coloured(table.heading or "top level", BOLD, sys.stdout)
    lines = [f"{heading}  {table.description}  ({TITLES[table.file]})"]
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


def _of_section(file: str, heading: str, section: type, description: str = "") -> Table:
    """Return the table of a section, with the keys that are read by code of their own."""
    name = heading.strip("[]") or file
    found = []
    for field in key_fields(section):
        given = field.metadata
        unit = field.metadata["unit"]
        usual = field.metadata["usual"]
        none = field.default in (REQUIRED, None, "")
        default = field.default
        default = dataclasses.asdict(default) if dataclasses.is_dataclass(default) else default  # type: ignore[arg-type]
        json = given["json"]
        if json is None:  # a reader of its own: the types of values that it accepts
            types = {type_of(value) for value in _PROBES if _accepts(given["parse"], value)}
            json = {"type": sorted(types)} if types else {}
        found.append(
            Key(
                name=field.name,
                description=given["description"],
                accepts=accepted(field) + _ALSO.get((file, f"{name}.{field.name}"), ""),
                unit=unit,
                default="" if none else _written(default),
                required=field.default is REQUIRED and field.default_factory is REQUIRED,
                usual="" if usual is None else _usual(usual),
                example=_written(given["example"]) if "example" in given else "",
                json=json,
            )
        )
    if any("read" in field.metadata for field in dataclasses.fields(section)):
        found.append(
            Key("material", "material of this body; that of the case by default", _MATERIAL)
        )
    return _table(
        file,
        heading,
        description or _first_line(section),
        [*found, *_FURTHER.get((file, name), ())],
    )


def _accepts(parse: Callable[[Any], Any], value: Any) -> bool:
    try:
        parse(value)
    except (ValidationError, TypeError, AttributeError, KeyError, IndexError):
        return False
    return True


def type_of(value: Any) -> str:
    """Return the name that JSON Schema has for the type of a TOML value."""
    kinds = ((bool, "boolean"), (int | float, "number"), (str, "string"), (list | tuple, "array"))
    return next((name for kind, name in kinds if isinstance(value, kind)), "object")


def _table(file: str, heading: str, description: str, found: Sequence[Key]) -> Table:
    """Return a table with an example of each key; where none is given it is the default."""
    name = heading.strip("[]") or file
    given = _examples()[file].get(name, {})
    shown = {key.name: key.example or key.default for key in found}
    shown |= {key.name: _written(given[key.name]) for key in found if key.name in given}
    keys = (dataclasses.replace(key, example=f"{key.name} = {shown[key.name]}") for key in found)
    return Table(file, name, heading, description, tuple(keys))


def _pair() -> Table:
    """Return the table ``[[pair]]``: materials and keys of ``[contact]``."""
    contact = _of_section(CASE, "[contact]", TABLES["[contact]"])
    accepts = 'two names of materials; "rigid" for a rigid wall'
    materials = Key("materials", "materials of the two bodies", accepts, required=True)
    made = _table(CASE, "[[pair]]", _first_line(Pair), [materials])
    of_contact = (key for key in contact.keys if key.name not in _NOT_OF_A_PAIR)
    own = (dataclasses.replace(key, default="that of [contact]") for key in of_contact)
    return dataclasses.replace(made, keys=(*made.keys, *own))


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
    power = (
        9 if abs(value) >= 1e10 else 6 if abs(value) >= 1e8 else math.floor(math.log10(abs(value)))
    )
    return f"{value / 10.0**power:.10g}e{power}"


def _usual(usual: Usual) -> str:
    of_unit = f" {usual.unit}" if usual.unit else ""
    text = f"usual: {plain(usual.low)} to {plain(usual.high)}{of_unit}"
    if usual.beyond == 1:
        return f"{text}; others give a warning"
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
    file = resources.files("granwave.workflows.cli") / "key_examples.toml"
    return tomllib.loads(file.read_text(encoding="utf-8"))


def _hint(wanted: str) -> str:
    names = list(dict.fromkeys(table.name for table in tables()))
    vocabulary = [f"{table.name}.{key.name}" for table in tables() for key in table.keys]
    same = list(dict.fromkeys(key for key in vocabulary if wanted and key.endswith(f".{wanted}")))
    near = same or difflib.get_close_matches(
        wanted.lower(), [*names, *vocabulary], n=1, cutoff=0.75
    )
    if near:
        return f"did you mean {' or '.join(near)}?"
    hint = hint_for(wanted.rpartition(".")[2], names, "", list(dict.fromkeys(vocabulary)))
    return hint.replace("known here:", "known:")


_TOP = (
    Key("name", "name of the case, and of the directory of its results", "a plain name, as of a directory",
        default="that of the file"),
    Key("material", "material of all bodies that have none of their own", _MATERIAL, required=True),
)  # fmt: skip
#: Values that a key accepts besides those of its validator, read by code of their own.
_ALSO = {
    (CASE, "boundary.bottom"): (
        "; or {material = ...} for a wall of a material; or {plate = ...}, {damper = ...}, {half_space = ...} or "
        "{bar = ...} for one that moves: tables [boundary.bottom.plate] and so on"
    ),
    (CASE, "boundary.sides"): (
        "; or {material = ...} for walls of a material, {tube = {radius = ...}} for a tube, or both"
    ),
}
#: Keys that are read by code of their own, without a field.
_FURTHER: dict[tuple[str, str], tuple[Key, ...]] = {
    (CASE, "packing"): (
        Key("file", "grains of a packing of kind file: a table (x, y, z, diameter ...), or what ASE reads", "a path"),
    ),
    (CASE, "load"): (
        Key("file", "the table as a file: two columns, time (s) and force (N) or displacement (m)", "a path"),
    ),
    (CASE, "material"): (
        Key("preset", "material whose values hold where the table gives none", "the name of a material"),
        Key("file", "TOML file that the preset is taken from; without it, those of the package", "a path"),
    ),
    (SPHERE_CONTACT, "partner"): (
        Key("material", "material of the second sphere; that of the case by default", _MATERIAL),
    ),
    (SCAN, "scan"): (
        Key("set", "values that hold for all points", _TABLE_OF_KEYS),
        Key("grid", "values of which every combination is a point", _LISTS_OF_VALUES),
        Key("zip", "tables [[zip]] of values that vary together, beside the grid", _LISTS_OF_VALUES + ", equally long"),
        Key("points", "tables [[points]], each a single point", _TABLE_OF_KEYS),
    ),
    (DESIGN, "design"): (
        Key("set", "values that hold for all designs", _TABLE_OF_KEYS),
        Key("variables", "what may vary: places in lists from 0, replace.ID.KEY of grains, layers",
            "for each key a list of choices, or {low = ..., high = ...} with log, integer or step", required=True),
        Key("limits", "what a design must keep to: mass_kg, height_m, width_m, n_spheres, smallest_diameter_m, "
            "yielded_share, kinetic_share, overlap_over_radius, or a value of summary.json",
            "for each value the largest allowed one, or {low = ..., high = ...}"),
    ),
    (DESIGN, "uncertainty"): (
        Key("velocity", "range of load.velocity; any key of a case likewise", "[smallest, largest], or one number"),
        Key("tolerance", "the same of packing.diameter_scatter, m", "[smallest, largest], or one number"),
    ),
}  # fmt: skip
