"""Tables of a case file to the fields of `Case`, with all faults, and overrides from the command
line or a scan.

Overrides are ``KEY=VALUE`` with dotted keys and TOML values. Bare words are strings:
``packing.kind=hcp``, ``material=steel``. Only the named key changes. The name of a table replaces
the complete table: ``material=steel`` drops the keys of an earlier ``[material]``. Entries of an
array of tables are numbered from 1: ``replace.2.index=8``.
"""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Callable, Collection, Iterable, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.case.added_grains import with_added_grains
from granwave.lammps_inputs.case.boundary import Boundary, read_boundary
from granwave.lammps_inputs.case.case import (
    KNOWN,
    LISTS,
    OPTIONAL,
    RECORD,
    case_sections,
)
from granwave.lammps_inputs.case.contact.contact import read_pairs
from granwave.lammps_inputs.case.contact.law_file import with_law_of_file
from granwave.lammps_inputs.case.loads.grains import GrainsLoad
from granwave.lammps_inputs.case.loads.registry import read_load
from granwave.lammps_inputs.case.loads.striker import StrikerLoad
from granwave.lammps_inputs.case.material import (
    MATERIALS,
    Material,
    read_material,
    read_materials,
    with_named_materials,
)
from granwave.lammps_inputs.case.packing.contact_ways import (
    CONTACTS,
    RELAXATION,
    SPRINGS,
    TOLERANCE,
)
from granwave.lammps_inputs.case.packing.made_packing import with_made_grains
from granwave.lammps_inputs.case.packing.packing import PackingSection
from granwave.lammps_inputs.case.packing.reading import read_packing
from granwave.lammps_inputs.case.precompression import PRECOMPRESSION, MovedWalls, Precompression
from granwave.lammps_inputs.case.schema import (
    ErrorList,
    numbered,
    read_list,
    read_name,
    read_table,
    refuse_unknown,
    show,
)
from granwave.lammps_inputs.case.stl_walls import check_triangles, with_triangles
from granwave.lammps_inputs.errors import InputError, InputFault, Mismatch, fault_of
from granwave.lammps_inputs.files import with_absolute_paths
from granwave.lammps_inputs.lattices import RESTART, lattice_kinds

_BARE_WORD = re.compile(r"""[^\s"'\[\]{}=,#][^"'\[\]{}=,#\r\n]*""")
_KEY = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*")


def parse_override(override: str) -> tuple[str, Any]:
    """Split ``KEY=VALUE`` into the dotted key and the value.

    Raises
    ------
    InputError
        There is no ``=``, the key is not a dotted path, or the value is neither TOML nor a bare
        word.
    """
    key, equals, written = (part.strip() for part in override.partition("="))
    if not equals or not _KEY.fullmatch(key):
        form = Mismatch(show(override), "KEY=VALUE such as load.velocity=10")
        raise InputError(fault_of(form, changed=True))
    try:
        document = tomllib.loads(f"value = {written}")
    except tomllib.TOMLDecodeError:
        document = {}
    if list(document) == ["value"]:
        return key, document["value"]
    if _BARE_WORD.fullmatch(written):
        return key, written
    hint = f"a list is [{written}]" if "," in written and "[" not in written else ""
    value = Mismatch(show(written), "a TOML value or a bare word", hint)
    raise InputError(fault_of(value, key=key, changed=True))


def parse_overrides(overrides: Iterable[str] | Mapping[str, Any]) -> dict[str, Any]:
    """Parse overrides into a mapping of dotted keys to values; all errors are raised at once.

    Relative paths in them start from the working directory.
    """
    if isinstance(overrides, Mapping):
        return dict(with_absolute_paths(overrides, Path()))
    if isinstance(overrides, str):
        overrides = [overrides]
    parsed: dict[str, Any] = {}
    faults: list[InputFault] = []
    for override in overrides:
        try:
            key, value = parse_override(override)
        except InputError as error:
            faults += error.items
        else:
            parsed.pop(key, None)  # the last override of a key counts, and is applied last
            parsed[key] = value
    if faults:
        raise InputError(faults)
    return dict(with_absolute_paths(parsed, Path()))


def apply_overrides(data: Mapping[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of the case ``data`` with ``overrides`` (dotted key to value) applied.

    Raises
    ------
    InputError
        Part of a dotted key names a value that is not a table.
    """
    result = copy.deepcopy(dict(data))
    faults = []
    for key, value in overrides.items():
        fault = _set(result, key.split("."), copy.deepcopy(value))
        if fault is not None:
            faults.append(fault_of(fault, key=key, changed=True))
    if faults:
        raise InputError(faults)
    return result


def _set(table: Any, path: list[str], value: Any) -> Mismatch | None:
    """Set a value of a table, or of an array of tables, whose numbers count from 1; return the
    fault if there is no such place.
    """
    for name, following in pairwise(path):
        if following.isdigit() and isinstance(table, dict) and name not in table:
            return Mismatch(
                f"no [[{name}]] tables", f"{following} or more", "specify the complete tables"
            )
        inner = _inner(table, name)
        if isinstance(inner, list) and following.isdigit():
            if not 1 <= int(following) <= len(inner):
                return Mismatch(f"{len(inner)} [[{name}]] tables", f"{following} or more")
        elif not isinstance(inner, dict):
            return Mismatch(f"{name} = {show(inner)}", f"a table [{name}]")
        table = inner
    table[int(path[-1]) - 1 if isinstance(table, list) else path[-1]] = value
    return None


def _inner(table: Any, name: str) -> Any:
    """Return a value of a table, by default a new table, or of an array of tables; a material that
    is a name becomes a table.
    """
    if isinstance(table, list):
        return table[int(name) - 1]
    inner = table.setdefault(name, {})
    if name == "material" and isinstance(inner, str):
        inner = {"preset": inner}
        table[name] = inner
    return inner


_READERS: dict[str, Callable[[Any, ErrorList], Any]] = {
    "load": read_load,
    "packing": read_packing,
    "boundary": read_boundary,
}
_OF_OTHERS = {  # tables of other files
    **dict.fromkeys(
        ("block", "punch", "sphere", "partner"),
        "is a key of continuum cases; use granwave continuum",
    ),
    **dict.fromkeys(
        ("replicates", "ranks", "case", "set", "grid", "zip", "points"),
        "is a key of scan files; use granwave scan",
    ),
}


def parse_case(
    data: Mapping[str, Any], source: str | Path, errors: ErrorList, *, stored: bool = False
) -> dict[str, Any]:
    """Read the nested mapping of a case file, table by table; faults are added to ``errors``.

    Parameters
    ----------
    source
        File of the case; its stem is the default name of the case.
    stored
        True for the case of an existing run, for which the memory of this machine does not matter.

    Returns
    -------
    dict
        Fields of `Case` by name; None for invalid fields.
    """
    _refuse_other_tables(data, errors)
    data = _with_implied(with_absolute_paths(data, Path()))
    data = with_triangles(data, errors)
    data = with_law_of_file(data, errors)
    materials = read_materials(data.get(MATERIALS, {}), errors)
    data = with_named_materials(data, materials)
    data = with_made_grains(data, source, errors)
    parts = read_parts(
        data,
        source,
        errors,
        sections=case_sections(),
        required=("packing", "material"),
        optional=OPTIONAL,
        readers=_READERS,
    )
    parts[PRECOMPRESSION] = _pressed(parts, errors)
    parts["pair"] = read_pairs(data.get("pair", ()), data.get("contact", {}), errors)
    for name, section in LISTS.items():
        parts[name] = read_list(section, data.get(name, ()), name, errors)
    for key, wall in numbered("wall", parts["wall"]).items():
        check_triangles(wall, key, errors)
    _add_grains(parts, materials, errors, stored=stored)
    parts[MATERIALS] = tuple(materials.values())
    packing: PackingSection | None = parts.get("packing")
    if packing is not None:
        _check_of_grains(packing, errors)
        if "load" not in data and _moves(packing):
            parts["load"] = GrainsLoad()
    return parts


def _refuse_other_tables(data: Mapping[str, Any], errors: ErrorList) -> None:
    """Add faults of unknown tables, and of tables of other kinds of files."""
    for name, where in _OF_OTHERS.items():
        if name in data:
            errors.add_unknown(name, where)
    own = {name: table for name, table in data.items() if name not in (*_OF_OTHERS, RECORD)}
    refuse_unknown(own, KNOWN, "", errors)


def _add_grains(
    parts: dict[str, Any], materials: dict[str, Material], errors: ErrorList, *, stored: bool
) -> None:
    """Add the ``[[grains]]`` and the gaps of a chain to the packing, and their materials to the
    further materials.
    """
    added = parts.pop("grains")
    packing: PackingSection | None = parts.get("packing")
    boundary: Boundary | None = parts["boundary"]
    if packing is None or not (added or packing.gaps):
        return
    periodic = boundary is not None and boundary.periodic
    parts["packing"] = with_added_grains(
        packing, added, materials, errors, periodic=periodic, stored=stored
    )


def _check_of_grains(packing: PackingSection, errors: ErrorList) -> None:
    """Check that a lattice has no keys of grains at user-defined positions."""
    if not packing.rule.is_lattice:
        return
    for name in ("cell", CONTACTS, TOLERANCE, SPRINGS, RELAXATION, RESTART):
        if getattr(packing, name) is not None:
            found = f"found only {show(packing.kind)}"
            text = f'belongs to packing.kind = "file", or to [[grains]]; {found}'
            errors.add(f"packing.{name}", text)


def _moves(packing: PackingSection) -> bool:
    """Return True if grains of a file have a velocity."""
    return packing.grains is not None and bool(packing.grains.velocity.any())


def _pressed(parts: Mapping[str, Any], errors: ErrorList) -> Precompression | None:
    """Return the precompression, which may be implied by a negative gap at the sides."""
    given: Precompression | None = parts.get(PRECOMPRESSION)
    boundary = parts.get("boundary")
    packing = parts.get("packing")
    if boundary is None or boundary.gap >= 0:
        return given
    flat = packing is not None and packing.rule.is_plane_crystal and boundary.y is None
    moves = {axis: -boundary.gap for axis in ("x" if flat else "xy") if boundary.has_planes(axis)}
    implied = Precompression(kind=MovedWalls.name, **moves)
    both = f"{boundary.gap:g} m, which presses the packing, together with [{PRECOMPRESSION}]"
    found = Mismatch(both, remedy="remove one of them")
    errors.check((given is not None and given != implied, "boundary.side_gap", found))
    return implied if moves else given


def read_parts(
    data: Mapping[str, Any],
    source: str | Path,
    errors: ErrorList,
    *,
    sections: Mapping[str, type],
    required: Collection[str] = ("material",),
    optional: Collection[str] = (),
    readers: Mapping[str, Callable[[Any, ErrorList], Any]] | None = None,
) -> dict[str, Any]:
    """Read name, material and sections of a case of any kind; faults are added to ``errors``.

    Parameters
    ----------
    source
        As in `parse_case`.
    sections
        Dataclass of each table. A table that ``data`` lacks takes its defaults, unless it is
        required or optional.
    required
        Names of the required tables.
    optional
        Names of the optional tables.
    readers
        Functions that read tables other than by `read_table`, by name.

    Returns
    -------
    dict
        Parts by name; None for invalid parts.
    """
    parts: dict[str, Any] = {"name": read_name(data, source, errors)}
    for name in required:
        if name not in data:
            or_name = ', or material = "steel"' if name == "material" else ""
            errors.add(name, f"missing; a case requires [{name}]{or_name}")
    if "material" in data:
        parts["material"] = read_material(data["material"], errors)
    for name, section in sections.items():
        if name not in data and name in (*required, *optional):
            continue
        read = (readers or {}).get(name)
        table = data.get(name, {})
        if read is None:
            parts[name] = read_table(section, table, name, errors)
        else:
            parts[name] = read(table, errors)
    return parts


def _usual_axis(packing: Mapping[str, Any]) -> dict[str, str]:
    """Return the axis of the cylinders of a packing as value of a key, if it is not
    the default y.
    """
    kind = packing.get("kind")
    rule = lattice_kinds().get(kind) if isinstance(kind, str) else None
    return {"axis": "z"} if rule is not None and rule.cylinder_axis[2] else {}


def _with_implied(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a case with implied values: strikers as the load, the axis of strikers,
    and a bar as the bottom.
    """
    data = dict(data)
    if "striker" in data:
        data.setdefault("load", {"kind": StrikerLoad.kind})
        data["striker"] = _with_axes(data["striker"], data.get("packing"))
    boundary = data.get("boundary", {})
    if "bar" in data and isinstance(boundary, Mapping):
        data["boundary"] = {"bottom": "free", **boundary}
    return data


def _with_axes(strikers: Any, packing: Any) -> Any:
    """Return strikers; cylinders among them have the axis of the cylinders of the packing."""
    in_packing = isinstance(packing, Mapping) and packing.get("shape") == "cylinder"
    if not in_packing or not isinstance(strikers, list | tuple):
        return strikers
    implied = {"axis": packing["axis"]} if "axis" in packing else _usual_axis(packing)
    return [
        {**implied, **one} if isinstance(one, Mapping) and one.get("shape") == "cylinder" else one
        for one in strikers
    ]
