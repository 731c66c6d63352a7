"""Tables of a case file to the fields of `Case`, with all faults, and overrides from the command line or a scan.

Overrides are ``KEY=VALUE`` with dotted keys and TOML values. Bare words are strings: ``packing.kind=hcp``,
``material=steel``. Only the named key changes. The name of a table replaces the whole table: ``material=steel`` drops
the keys of an earlier ``[material]``. Entries of an array of tables are numbered from 1: ``replace.2.index=8``.
"""

from __future__ import annotations

import copy
import dataclasses
import re
import tomllib
from collections.abc import Callable, Collection, Iterable, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.case.added_grains import AddedGrains, with_added_grains
from granwave.lammps_inputs.case.bodies import Bar, read_body, read_list
from granwave.lammps_inputs.case.boundary import Boundary, Precompression, Tube, read_bottom
from granwave.lammps_inputs.case.case import BARS, GRAINS, KNOWN, LISTS, PRECOMPRESSION, RECORD, SECTIONS, WALL_KEYS
from granwave.lammps_inputs.case.contact import read_pairs
from granwave.lammps_inputs.case.load import Load, read_load
from granwave.lammps_inputs.case.material import (
    MATERIALS,
    Material,
    read_material,
    read_materials,
    with_named_materials,
)
from granwave.lammps_inputs.case.packing import PackingSection, read_packing
from granwave.lammps_inputs.case.run import FRAMES_OF_A_FILM
from granwave.lammps_inputs.case.schema import ErrorList, read_name, read_table, refuse_unknown, show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import with_absolute_paths
from granwave.lammps_inputs.lattices import FILE
from granwave.lammps_inputs.plane_lattices import is_plane_crystal
from granwave.lammps_inputs.run_directory import FIGURES_TABLE

_BARE_WORD = re.compile(r"""[^\s"'\[\]{}=,#][^"'\[\]{}=,#\r\n]*""")
_KEY = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*")


def parse_override(override: str) -> tuple[str, Any]:
    """Split ``KEY=VALUE`` into the dotted key and the value.

    Raises
    ------
    InputError
        There is no ``=``, the key is not a dotted path, or the value is neither TOML nor a bare word.
    """
    key, equals, written = (part.strip() for part in override.partition("="))
    if not equals or not _KEY.fullmatch(key):
        raise InputError(f"--set: found {show(override)}, expected KEY=VALUE such as load.velocity=10")
    try:
        document = tomllib.loads(f"value = {written}")
    except tomllib.TOMLDecodeError:
        document = {}
    if list(document) == ["value"]:
        return key, document["value"]
    if _BARE_WORD.fullmatch(written):
        return key, written
    hint = f"; a list is [{written}]" if "," in written and "[" not in written else ""
    raise InputError(f"--set: {key}: found {show(written)}, expected a TOML value or a bare word{hint}")


def parse_overrides(overrides: Iterable[str] | Mapping[str, Any]) -> dict[str, Any]:
    """Parse overrides into a mapping of dotted keys to values; all errors are raised at once.

    Relative paths in them start from the working directory.
    """
    if isinstance(overrides, Mapping):
        return dict(with_absolute_paths(overrides, Path()))
    if isinstance(overrides, str):
        overrides = [overrides]
    parsed: dict[str, Any] = {}
    errors: list[str] = []
    for override in overrides:
        try:
            key, value = parse_override(override)
        except InputError as error:
            errors += error.errors
        else:
            parsed.pop(key, None)  # the last override of a key counts, and is applied last
            parsed[key] = value
    if errors:
        raise InputError(errors)
    return dict(with_absolute_paths(parsed, Path()))


def apply_overrides(data: Mapping[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of the case ``data`` with ``overrides`` (dotted key to value) applied.

    Raises
    ------
    InputError
        Part of a dotted key names a value that is not a table.
    """
    result = copy.deepcopy(dict(data))
    errors: list[str] = []
    for key, value in overrides.items():
        *path, last = key.split(".")
        table = result
        for name, following in pairwise([*path, last]):
            if following.isdigit() and name not in table:
                errors.append(
                    f"--set: {key}: found no [[{name}]] tables, expected {following} or more; give them whole"
                )
                break
            inner = table.setdefault(name, {})
            if name == "material" and isinstance(inner, str):
                inner = table[name] = {"preset": inner}
            if isinstance(inner, list) and following.isdigit():
                inner = table[name] = _Numbered(inner)
            if not isinstance(inner, dict):
                errors.append(f"--set: {key}: found {name} = {show(inner)}, expected a table [{name}]")
                break
            if isinstance(inner, _Numbered) and following not in inner:
                errors.append(f"--set: {key}: found {len(inner)} [[{name}]] tables, expected {following} or more")
                break
            table = inner
        else:
            table[last] = copy.deepcopy(value)
    if errors:
        raise InputError(errors)
    return _with_lists(result)


class _Numbered(dict[str, Any]):
    """An array of tables as a mapping from the number of an entry, from 1, as in dotted keys."""

    def __init__(self, entries: list[Any]) -> None:
        super().__init__({str(n): entry for n, entry in enumerate(entries, start=1)})


def _with_lists(value: Any) -> Any:
    if isinstance(value, _Numbered):
        return [_with_lists(item) for item in value.values()]
    if isinstance(value, dict):
        return {name: _with_lists(item) for name, item in value.items()}
    return value


_REQUIRED = ("packing", "material")

_OF_OTHERS = {  # tables of other files
    **dict.fromkeys(("block", "punch", "sphere", "partner"), "belongs to a continuum case: granwave continuum runs it"),
    **dict.fromkeys(
        ("replicates", "ranks", "case", "set", "grid", "zip", "points"), "belongs in a scan file: granwave scan runs it"
    ),
}


def parse_case(data: Mapping[str, Any], source: str | Path, errors: ErrorList) -> dict[str, Any]:
    """Read the nested mapping of a case file, table by table; faults are added to ``errors``.

    Parameters
    ----------
    source
        File that the case comes from; its stem is the default name of the case.

    Returns
    -------
    dict
        Fields of `Case` by name; None for those that are wrong.
    """
    for name in (one for one in _OF_OTHERS if one in data):
        errors.add_unknown(name, _OF_OTHERS[name])
    refuse_unknown(
        {name: value for name, value in data.items() if name not in (*_OF_OTHERS, RECORD)}, KNOWN, "", errors
    )
    data = _with_implied(with_absolute_paths(data, Path()))
    materials = read_materials(data.get(MATERIALS, {}), errors)
    data = with_named_materials(data, materials)
    parts = read_parts(data, source, errors, sections=SECTIONS, required=_REQUIRED, read=_read_section)
    if PRECOMPRESSION in data:
        parts[PRECOMPRESSION] = read_table(Precompression, data[PRECOMPRESSION], PRECOMPRESSION, errors)
    parts[PRECOMPRESSION] = _pressed(parts, errors)
    parts["pair"] = read_pairs(data.get("pair", ()), data.get("contact", {}), errors)
    parts[MATERIALS] = tuple(materials.values())
    for name, section in LISTS.items():
        parts[name] = read_list(section, data.get(name, ()), name, errors)
    for name in BARS:
        parts[name] = read_body(Bar, data[name], name, errors) if name in data else None
    packing: PackingSection | None = parts["packing"] if "packing" in data else None
    added = read_list(AddedGrains, data.get(GRAINS, ()), GRAINS, errors)
    if packing is not None and (added or packing.gaps):
        boundary: Boundary | None = parts["boundary"]
        periodic = boundary is not None and boundary.sides == "periodic"
        packing = parts["packing"] = with_added_grains(packing, added, materials, errors, periodic=periodic)
        parts[MATERIALS] = tuple(materials.values())
    if packing is not None and packing.cell is not None and packing.kind != FILE:  # a lattice has its own
        found = f"found {show(packing.kind)} alone"
        errors.add("packing.cell", f'belongs to packing.kind = "file", or to [[grains]]; {found}')
    if "load" not in data and packing is not None and packing.grains is not None and packing.grains.velocity.any():
        parts["load"] = Load(kind="grains")
    return parts


def _pressed(parts: Mapping[str, Any], errors: ErrorList) -> Precompression | None:
    """Return the precompression, which a negative gap at the sides implies."""
    given: Precompression | None = parts.get(PRECOMPRESSION)
    boundary: Boundary | None = parts.get("boundary")
    if boundary is None or boundary.gap >= 0:
        return given
    axes = [axis for axis in "xy" if boundary.has_planes(axis)]
    if (packing := parts.get("packing")) is not None and is_plane_crystal(packing.kind) and boundary.y is None:
        axes = [axis for axis in axes if axis != "y"]
    moves = {axis: -boundary.gap for axis in axes}
    implied = Precompression(kind="walls", x=moves.get("x"), y=moves.get("y"))
    if given is not None and given != implied:
        errors.add(
            "boundary.side_gap",
            f"found {boundary.gap:g} m, which presses, beside [{PRECOMPRESSION}]; take one of them out",
        )
    return implied if axes else given


def read_parts(
    data: Mapping[str, Any],
    source: str | Path,
    errors: ErrorList,
    *,
    sections: Mapping[str, type],
    required: Collection[str] = ("material",),
    read: Callable[[type, Any, str, ErrorList], Any] = read_table,
) -> dict[str, Any]:
    """Read name, material and sections of a case of any kind; faults are added to ``errors``.

    Parameters
    ----------
    source
        As in `parse_case`.
    sections
        Dataclass of each table. A table that ``data`` lacks takes its defaults, unless it is required.
    required
        Names of the tables that must be there.
    read
        Function that reads one section.

    Returns
    -------
    dict
        Parts by name; None for those that are wrong.
    """
    parts: dict[str, Any] = {"name": read_name(data, source, errors)}
    for name in required:
        if name not in data:
            errors.add(name, f"missing; a case needs [{name}]")
    if "material" in data:
        parts["material"] = read_material(data["material"], errors)
    for name, section in sections.items():
        if name in data or name not in required:
            parts[name] = read(section, data.get(name, {}), name, errors)
    return parts


def _read_section(section: type, table: Any, name: str, errors: ErrorList) -> Any:
    if section is Load:
        return read_load(table, errors)
    if section is PackingSection:
        return read_packing(table, errors)
    if section is not Boundary or not isinstance(table, Mapping):
        return read_table(section, table, name, errors)
    before = len(errors.lines)
    read: dict[str, Any] = {}
    readers: dict[str, tuple[Callable[..., Any], str]] = {
        "bottom": (read_bottom, "support"),
        "sides": (_read_sides, "tube"),
    }
    walls = {key: table[key] for key in WALL_KEYS if isinstance(table.get(key), Mapping)}
    for key, wall in walls.items():
        reader, what = readers[key]
        read[f"{key}_material"], read[f"{key}_{what}"] = reader(wall, f"boundary.{key}", errors)
    boundary = read_table(Boundary, {**table, **dict.fromkeys(walls, "wall")}, name, errors)
    if boundary is None or len(errors.lines) > before:
        return None
    return dataclasses.replace(boundary, **read)


def _read_sides(table: Mapping[str, Any], key: str, errors: ErrorList) -> tuple[Material | None, float | None]:
    """Read the material of the sides, and the radius of a tube."""
    refuse_unknown(table, ("material", "tube"), key, errors)
    if not table:
        errors.add(key, f'found {show(table)}, expected a word, or {{material = "..."}} for a wall')
    material = read_material(table["material"], errors, f"{key}.material") if "material" in table else None
    tube = read_table(Tube, table["tube"], f"{key}.tube", errors) if "tube" in table else None
    return material, None if tube is None else tube.radius


def _with_implied(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a case with implied values.

    These are strikers as the load, the axis of strikers, a bar for a bottom, and frames of a film.
    """
    data = dict(data)
    if "striker" in data and "load" not in data:
        data["load"] = {"kind": "striker"}
    packing, strikers = data.get("packing"), data.get("striker")
    if isinstance(packing, Mapping) and isinstance(strikers, list | tuple) and packing.get("shape") == "cylinder":
        axis = packing.get("axis", "z" if packing.get("kind") == "square" else None)  # rows of a square are along y
        implied = {} if axis is None else {"axis": axis}
        data["striker"] = [
            implied | dict(one) if isinstance(one, Mapping) and one.get("shape") == "cylinder" else one
            for one in strikers
        ]
    boundary = data.get("boundary", {})
    if "bar" in data and isinstance(boundary, Mapping) and "bottom" not in boundary:
        data["boundary"] = {**boundary, "bottom": "free"}
    figures, run = data.get(FIGURES_TABLE, {}), data.get("run", {})
    if isinstance(figures, Mapping) and isinstance(run, Mapping) and figures.get("film", "none") != "none":
        data["run"] = {"frames": FRAMES_OF_A_FILM, **run}
    return data
