"""Lines of grains, ``[[line]]``: their ids in order, and what a line needs of the packing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import struck_site

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.bodies import Line

_BESIDE = 0.25  # diameters; grains of a line are no further from it
_HELD = 3.0  # diameters above a floor that does not move: grains there cannot reach the speed of the wave


def line_ids(assembly: Assembly, line: Line) -> tuple[int, ...]:
    """Return the ids of the grains of a line in their order: those given, or those along a direction."""
    ids = assembly.ids
    own = ids <= assembly.lattice.n_spheres
    if isinstance(line.index, str):
        return tuple(ids[own].tolist())
    if line.index is not None:
        return line.index
    ids, positions = ids[own], assembly.positions()[own]
    start = line.start or struck_site(assembly) or int(ids[0])
    row = int(np.searchsorted(ids, start))
    if row == len(ids) or ids[row] != start:
        return ()
    way = np.array(line.direction) / np.linalg.norm(line.direction)
    offset = positions - positions[row]
    along = offset @ way
    beside = np.linalg.norm(offset - along[:, None] * way, axis=1)
    diameter = assembly.case.packing.diameter
    on = np.flatnonzero((beside <= _BESIDE * diameter) & (along >= -1e-6 * diameter))
    return tuple(ids[on[np.argsort(along[on], kind="stable")]].tolist())


def all_line_ids(assembly: Assembly) -> tuple[int, ...]:
    """Return the ids of the grains of all lines, each once, in rising order."""
    return tuple(sorted({one for line in assembly.case.line for one in line_ids(assembly, line)}))


def left_out(assembly: Assembly, line: Line) -> int:
    """Return how many grains at the end of a line the fit of its decay leaves out: those that the floor holds."""
    if not isinstance(line.leave_out, str):
        return line.leave_out
    boundary = assembly.case.boundary
    if boundary.bottom == "free" or boundary.bottom_support is not None:
        return 0
    depth = [assembly.bottom() - float(assembly.centre_of(one)[2]) for one in line_ids(assembly, line)]
    near = [one < _HELD * assembly.case.packing.diameter for one in depth]
    return next((n for n, held in enumerate(reversed(near)) if not held), len(near))
