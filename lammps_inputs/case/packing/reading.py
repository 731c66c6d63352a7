"""``[packing]`` from the table of a case file: a lattice, the grains of a file, or the spheres of a
LAMMPS restart file.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from granwave.lammps_inputs.case import hints, schema
from granwave.lammps_inputs.case.hints import DIAMETER
from granwave.lammps_inputs.case.material import (
    check_shape,
)
from granwave.lammps_inputs.case.packing.contact_ways import (
    CONTACTS,
    KEEP,
    SPRINGS,
)
from granwave.lammps_inputs.case.packing.grain_file import (
    FILE_FIELDS,
    FORM_OF_FILE,
    TYPES,
    GrainFileSection,
    read_grain_file,
)
from granwave.lammps_inputs.case.packing.grains import Grains
from granwave.lammps_inputs.case.packing.made_packing import NOT_MADE
from granwave.lammps_inputs.case.packing.packing import PackingSection
from granwave.lammps_inputs.case.schema import ErrorList, read_table, show
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.lattices import (
    FILE,
    RESTART,
    lattice_kinds,
)
from granwave.lammps_inputs.restart_file import RestartSpheres, read_restart
from granwave.lammps_inputs.tables.units import LENGTH_UNITS

_ACROSS = 1e-9  # cosine of the largest angle to the normal direction
_FORM_OF_RESTART = "the path of a LAMMPS restart file (write_restart) of spheres in SI units"
_NOT_OF_FILE = (
    "size",
    "top_row",
    "gaps",
    "diameter_scatter",
    "scatter_distribution",
    "vacancies",
    "tilt",
    "seed",
)
_OF_FILE = (*FILE_FIELDS, "grains", "source", "period", "enclosure", RESTART, SPRINGS)
_OF_SHAPE = ("shape", "length", "axis")


def read_packing(table: Any, errors: ErrorList) -> PackingSection | None:
    """Read ``[packing]``; missing and wrong values are added to ``errors``.

    The grains of ``packing.file`` become ``packing.grains``, so that the case is complete without
    the file.
    """
    if table is NOT_MADE:
        return None
    if not isinstance(table, Mapping):
        return read_table(PackingSection, table, "packing", errors)
    before = len(errors.items)
    foreign = _foreign_keys(table.get("kind"))
    for name, text in foreign.items():
        if name in table:
            errors.add(f"packing.{name}", text)
    if table.get("kind") == RESTART:
        table = _of_restart(table, errors)
    own = {name: value for name, value in table.items() if name not in (*foreign, *FILE_FIELDS)}
    if table.get("kind") != FILE:
        return _read_lattice(own, errors)
    given = _given_grains(table, errors)
    if len(errors.items) > before:
        return None
    # the remaining keys are read with placeholders for values that follow from the grains
    rest = {"diameter": 1e-3, **given, **own, "size": 1}
    section = read_table(PackingSection, rest, "packing", errors)
    if section is None or section.grains is None:
        return None
    diameter = section.diameter if "diameter" in table else section.grains.usual_diameter
    return dataclasses.replace(section, size=(len(section.grains),), diameter=diameter)


def _foreign_keys(kind: Any) -> dict[str, str]:
    """Return the keys that a kind of packing does not have, each with the fault."""
    if kind in (FILE, RESTART):
        text = f'cannot be used with packing.kind = "{kind}", whose grains are all in the file'
        return dict.fromkeys((*_NOT_OF_FILE, *_OF_SHAPE), text)
    # a cell may be combined with [[grains]]: see `parse_case`
    found = show("" if kind is None else kind)
    foreign = dict.fromkeys(_OF_FILE, f'applies only to packing.kind = "file"; found {found}')
    rule = lattice_kinds().get(kind) if isinstance(kind, str) else None
    if rule is not None and not rule.is_plane_crystal:
        plane = [name for name, other in lattice_kinds().items() if other.is_plane_crystal]
        able = " or ".join(map(show, plane))
        foreign["top_row"] = f"belongs to packing.kind = {able}; found {show(kind)}"
    return foreign


_OF_READING = tuple(name for name in FILE_FIELDS if name not in ("file", TYPES))
_OF_GRAIN_FILES = (
    'applies only to packing.kind = "file"; found "restart", whose file contains this information'
)
_NOT_OF_RESTART = {
    "up": (
        'applies only to packing.kind = "file"; found "restart", whose bed is not rotated: '
        "gravity must act along +z in the script that settles it"
    ),
}


def _of_restart(table: Mapping[str, Any], errors: ErrorList) -> dict[str, Any]:
    """Return the packing of a restart file as grains of a file that start unchanged."""
    file = table.get("file")
    kept = {name: value for name, value in table.items() if name not in ("file", TYPES)}
    kept |= {"kind": FILE, "grains": None}
    for name, allowed in ((CONTACTS, KEEP.name), ("diameter", None), ("grains", None)):
        if name in table and table[name] != allowed:
            fault = Mismatch(show(table[name]), remedy="remove it (the restart file contains it)")
            errors.add(f"packing.{name}", fault)
    for name in _OF_READING:
        if name in kept:
            errors.add(f"packing.{name}", _NOT_OF_RESTART.get(name, _OF_GRAIN_FILES))
            kept.pop(name)
    if file is None:
        errors.add("packing.file", f'missing; packing.kind = "restart" requires {_FORM_OF_RESTART}')
        return kept
    spheres = schema.read_named("packing.file", file, _FORM_OF_RESTART, read_restart, errors)
    if spheres is None:
        return kept
    materials = _materials_of(spheres, table.get(TYPES), errors)
    n = len(spheres.radius)
    still = np.zeros((n, 3))  # their velocities stay in the file
    grains = Grains(
        spheres.position, 2 * spheres.radius, materials, [""] * n, still, clump=spheres.bodies
    )
    source = {"source": Path(file).name}
    return source | kept | {"grains": grains, CONTACTS: KEEP.name, RESTART: file}


def _materials_of(spheres: RestartSpheres, types: Any, errors: ErrorList) -> list[str]:
    """Return the names of the materials of the spheres of a restart file, by their types."""
    none = [""] * len(spheres.kind)
    section = read_table(
        GrainFileSection, {} if types is None else {TYPES: types}, "packing", errors
    )
    if section is None:
        return none
    there = [str(kind) for kind in np.unique(spheres.kind).tolist()]
    names = section.types or {}
    if not names and len(there) == 1:
        return none
    missing = [name for name in there if name not in names]
    unused = [name for name in names if name not in there]
    if missing or unused:
        what = f"no material of the type {missing[0]}" if missing else f"no type {unused[0]}"
        expected = f"a material for each of the types {', '.join(there)}"
        errors.add(f"packing.{TYPES}", Mismatch(what, expected))
        return none
    return [names[str(kind)] for kind in spheres.kind.tolist()]


def _read_lattice(table: Mapping[str, Any], errors: ErrorList) -> PackingSection | None:
    """Read the packing of a lattice."""
    packing = read_table(PackingSection, table, "packing", errors)
    before = len(errors.items)
    if packing is not None:
        _check_cylinders(packing, errors)
    return packing if len(errors.items) == before else None


def _given_grains(table: Mapping[str, Any], errors: ErrorList) -> dict[str, Any]:
    """Return grains, periods and cell of the file that a packing names, as values of its keys."""
    given: dict[str, Any] = {}
    if "grains" in table:
        for name in FILE_FIELDS:
            if name in table:
                beside = Mismatch("together with packing.grains", remedy="specify only one of them")
                errors.add(f"packing.{name}", beside)
        return given
    grains = _from_file(table, errors)
    given["grains"] = grains
    if grains is not None:
        given["source"] = Path(table["file"]).name
    if grains is not None and grains.period is not None:
        given["period"] = grains.period
    if grains is not None and "cell" not in table and grains.cell:
        given["cell"] = grains.cell
    return given


def _check_cylinders(packing: PackingSection, errors: ErrorList) -> None:
    """Check the shape of the grains of a lattice: cylinders lie in a plane, with contacts across
    their axes.
    """
    check_shape(packing, "packing", errors)
    if (shape := packing.of_grain) is None:
        return
    along = np.abs(packing.rule.contact_directions @ shape.vector).max()
    flat = [name for name, kind in lattice_kinds().items() if kind.dimension < len("xyz")]
    errors.check_first(
        (
            packing.kind not in flat,
            "packing.shape",
            Mismatch(f'"cylinder" for {packing.kind}', f"a packing in a plane: {', '.join(flat)}"),
        ),
        (
            along > _ACROSS,
            "packing.axis",
            Mismatch(
                show(list(shape.axis)),
                f"a direction perpendicular to all contacts of {packing.kind}",
            ),
        ),
    )


def _from_file(table: Mapping[str, Any], errors: ErrorList) -> Grains | None:
    diameter = table.get("diameter")
    if "file" not in table:
        errors.add("packing.file", f'missing; packing.kind = "file" requires {FORM_OF_FILE}')
        return None
    if isinstance(diameter, bool) or not isinstance(diameter, int | float) or not diameter > 0:
        diameter = None
    name = table["file"]
    grains = read_grain_file(table, diameter, errors)
    if grains is None:
        return None
    ends = [float(grains.diameter.max()), float(grains.diameter.min())]
    if odd := hints.unusual(ends, DIAMETER):
        fault = odd.partition(";")[0]
        remedy = units_of_file(ends[0], DIAMETER) if "units" not in table else ""
        errors.notes.append(f"packing.file: {name}: diameter: {fault}{remedy}")
    return grains


def units_of_file(length: float, usual: hints.Usual) -> str:
    """Return the remedy for a length of a file that is usual in another unit, with a semicolon
    before it; empty if there is none.

    Parameters
    ----------
    length
        Length as it was read, m.
    """
    for unit in usual.units:
        if usual.low <= length * 10.0 ** LENGTH_UNITS[unit] <= usual.high:
            return f'; if the lengths of the file are in {unit}, set packing.units = "{unit}"'
    return ""
