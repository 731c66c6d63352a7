"""Grains along which the transmission of a load that oscillates is measured: a chain, or the first ``[[line]]``."""

from __future__ import annotations

import dataclasses

from granwave.lammps_inputs.contact.absorbing import absorbing_ids
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.lines import line_ids
from granwave.lammps_inputs.packing.motion import held_ids, struck_of


@dataclasses.dataclass(frozen=True)
class MeasuredRow:
    """Grains in their order.

    Attributes
    ----------
    group
        Group of ``result.h5`` that has their motion.
    ids
        Their ids.
    first, last
        Places in ``ids`` of the loaded grain, or of the first where none is loaded, and of the last one that moves
        and does not absorb.
    """

    group: str
    ids: tuple[int, ...]
    first: int
    last: int

    @property
    def ends(self) -> tuple[int, int]:
        """Ids of the first and the last grain."""
        return self.ids[self.first], self.ids[self.last]


def measured_row(assembly: Assembly) -> MeasuredRow | None:
    """Return the grains of a chain, or of the first line that is not of all grains; None without any."""
    case = assembly.case
    if case.packing.kind == "chain":
        group, ids = "chain", tuple(range(1, assembly.lattice.n_spheres + 1))
    else:
        line = next((one for one in case.line if one.index != "all"), None)
        if line is None:
            return None
        group, ids = f"lines/{line.name}", line_ids(assembly, line)
    if not ids:
        return None
    struck = set(struck_of(assembly))
    first = next((place for place, one in enumerate(ids) if one in struck), 0)
    still = {one for entry in case.absorb for one in absorbing_ids(assembly, entry)}
    still |= {one for hold in case.holds.values() if "z" in hold.axes for one in held_ids(case, hold)}
    if case.boundary.bottom == "fixed":
        still |= set(assembly.lattice.last_layer.tolist())
    rest = [place for place, one in enumerate(ids) if one not in still and place != first]
    return MeasuredRow(group, ids, first, rest[-1] if rest else len(ids) - 1)
