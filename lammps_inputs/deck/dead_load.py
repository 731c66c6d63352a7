"""Dead loads of a static stage: their commands, their energy, and the tables of their files."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.contact.static_load import dead_loads, directions, striker_loads
from granwave.lammps_inputs.deck.commands import id_ranges
from granwave.lammps_inputs.deck.motion import FALL, POTENTIAL
from granwave.lammps_inputs.deck.output import displacements
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.run_directory import DEAD_LOAD_FILE, START_FILE
from granwave.lammps_inputs.script_words import joined
from granwave.lammps_inputs.statics.balance import balanced_displacements


def dead_load_commands(assembly: Assembly) -> list[str]:
    """Return the commands of dead loads; the compute ``potential`` is their energy, zero in the
    data file.
    """
    case = assembly.case
    axes = directions(assembly)
    if not axes:
        return [
            "# The walls are in their final positions; there are no other loads. Displacements "
            "are relative to the data file.",
            *displacements(case),
            "variable        work atom 0.0",
            f"compute         {POTENTIAL.removeprefix('c_')} all reduce sum v_work",
        ]
    words = joined(f"v_dead_{axis}" if axis in axes else "0.0" for axis in "xyz")
    work = "+".join(f"v_dead_{axis}*c_displacement[{'xyz'.index(axis) + 1}]" for axis in axes)
    return [
        "# Dead loads: constant forces on spheres, N. Displacements are relative to the data "
        "file, before any load.",
        *displacements(case),
        *(f"variable        dead_{axis} atomfile {DEAD_LOAD_FILE.format(axis)}" for axis in axes),
        f"variable        dead atom {'||'.join(f'(v_dead_{axis}!=0)' for axis in axes)}",
        "group           dead variable dead",
        # required by LAMMPS; unused
        f"fix             dead dead addforce {words} energy v_dead_{axes[-1]}",
        f"variable        work atom -({work})",
        f"compute         {POTENTIAL.removeprefix('c_')} dead reduce sum v_work",
        *_fall(assembly),
    ]


def _fall(assembly: Assembly) -> list[str]:
    """Return the commands of the potential energy of strikers that gravity acts on."""
    if not assembly.case.strikers_fall:
        return []
    ids, _ = striker_loads(assembly)
    return [
        f"group           falling id {id_ranges(ids)}",
        f"compute         {FALL.removeprefix('c_')} falling reduce sum v_work",
    ]


def load_tables(assembly: Assembly) -> dict[str, str]:
    """Return the texts of the files of dead loads and of displacements to equilibrium by name, one
    for each direction.
    """
    each = (dead_loads(assembly), striker_loads(assembly))
    ids = np.concatenate([numbers for numbers, _ in each])
    forces = np.concatenate([loads for _, loads in each])
    tables = {}
    for axis in directions(assembly):
        along = forces[:, "xyz".index(axis)]
        tables[DEAD_LOAD_FILE.format(axis)] = _table("dead loads: id, force (N)", ids, along)
    moved = balanced_displacements(assembly)
    if moved is not None:
        for axis, along in zip("xyz", moved.T, strict=True):
            title = "displacements: id, displacement (m)"
            tables[START_FILE.format(axis)] = _table(title, assembly.ids, along)
    return tables


def _table(title: str, ids: NDArray[np.int64], values: NDArray[np.float64]) -> str:
    """Return the text of a file of an atomfile variable; spheres that it lacks have 0."""
    each = zip(ids.tolist(), values.tolist(), strict=True)
    rows = [f"{sphere} {value:.17g}\n" for sphere, value in each if value]
    rows = rows or [f"{ids[0]} 0\n"]  # LAMMPS reads no empty table
    return f"# {title}; number of rows\n{len(rows)}\n{''.join(rows)}"
