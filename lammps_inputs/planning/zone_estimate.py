"""Estimate of the plastic zone of an impact before it is run, compared with the size of the packing.

For equal spheres the size of the zone in diameters depends on e = energy input / (F_y alpha_y) only, whatever material
and size. Power laws were fitted to impacts on brass spheres in packings that were larger than the zone; all data lie
within the factor `spread`:

    kind      depth / D      radius / D     spread   fitted to
    fcc, hcp  1.30 e^0.255   1.0 e^0.265    1.5      13 impacts, e from 13 to 1.35e5, one of them on 7 spheres
    bcc       1.30 e^0.32    2.2 e^0.26     1.4      4 impacts, e from 13 to 1.4e3
    sc, chain 75             0              -        6 impacts, e from 3.4 to 5.4e5

Along a line of contacts a pulse with a force just above F_y is not attenuated: 75 spheres or more yield, 240 to 350 of
600 within 8 ms. Below e = 3 little more than the struck contacts yields. Friction, disorder and precompression are not
considered. There is no estimate for a packing of one layer.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import struck_site
from granwave.lammps_inputs.planning.energy_input import expected_energy

if TYPE_CHECKING:
    pass

_LEAST = 3.0  # energy input over F_y alpha_y below which the zone is negligible


@dataclasses.dataclass(frozen=True)
class _Growth:
    """Depth and radius in diameters, each ``factor e^power``, and the factor of uncertainty ``spread``."""

    depth: tuple[float, float]
    radius: tuple[float, float]
    spread: float


_CLOSE_PACKED = _Growth((1.30, 0.255), (1.0, 0.265), 1.5)
_LINE = _Growth((75.0, 0.0), (0.0, 0.0), 1.0)
_GROWTH = {
    "fcc": _CLOSE_PACKED,
    "hcp": _CLOSE_PACKED,
    "bcc": _Growth((1.30, 0.32), (2.2, 0.26), 1.4),
    "sc": _LINE,
    "chain": _LINE,
}


@dataclasses.dataclass(frozen=True)
class ExpectedZone:
    """Expected size of the plastic zone, and the space for it.

    Attributes
    ----------
    depth, radius
        Depth below the struck sphere, and radius from the impact axis, m.
    spread
        Factor of uncertainty of both.
    room
        Distances from the struck sphere to the bottom and the sides, by name, m.
    """

    depth: float
    radius: float
    spread: float
    room: dict[str, float]

    @property
    def reaches(self) -> tuple[str, ...]:
        """Names of the boundaries that the zone is expected to reach."""
        return self._reaching(1.0)

    @property
    def may_reach(self) -> tuple[str, ...]:
        """Names of further boundaries that it reaches if it is larger than estimated by ``spread``."""
        return tuple(name for name in self._reaching(self.spread) if name not in self.reaches)

    def _reaching(self, factor: float) -> tuple[str, ...]:
        extent = {"bottom": self.depth, "sides": self.radius}
        return tuple(name for name, room in self.room.items() if factor * extent[name] >= room)


def expected_zone(assembly: Assembly) -> ExpectedZone | None:
    """Estimate the plastic zone of a case; None if nothing yields, or there is no estimate."""
    case = assembly.case
    growth, law, lattice = _GROWTH.get(case.packing.kind), sphere_contact(case), assembly.lattice
    if growth is None or not case.contact.yields or not isinstance(lattice, Lattice):
        return None
    room = _room(assembly, lattice)
    if "bottom" not in room:
        return None
    energy = expected_energy(assembly) / (law.yield_force * law.yield_overlap)
    if energy < _LEAST:
        return None
    depth, radius = (factor * energy**power * case.packing.diameter for factor, power in (growth.depth, growth.radius))
    return ExpectedZone(depth, radius, growth.spread, room)


def _room(assembly: Assembly, lattice: Lattice) -> dict[str, float]:
    """Return the distances from the struck sphere to the last layer and to the nearest end of a row, m."""
    case = assembly.case
    nx, ny, nz = lattice.shape
    sphere = struck_site(assembly) or 1
    i, j, _ = lattice.indices(sphere)
    (centre,) = lattice.positions(sphere, sphere)
    found = {}
    if nz > 1:
        (last,) = lattice.positions(lattice.n_spheres, lattice.n_spheres)
        found["bottom"] = float(last[2] - centre[2])
    if case.boundary.sides == "periodic":
        found["sides"] = min(lattice.lengths) / 2
        return found
    ends = []
    for axis, place, n, stride in ((0, i, nx, 1), (1, j, ny, nx)):
        if n > 1:
            for end in (0, n - 1):
                other = sphere + (end - place) * stride
                (position,) = lattice.positions(other, other)
                ends.append(abs(float(position[axis] - centre[axis])))
    if ends:
        found["sides"] = min(ends)
    return found
