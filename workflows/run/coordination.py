"""Contacts at the start: LAMMPS sees those that the lattice has."""

from __future__ import annotations

import dataclasses

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows.run.lammps_engine import Engine


@dataclasses.dataclass(frozen=True)
class Neighbours:
    """Neighbours at the start.

    Attributes
    ----------
    kind
        Kind of the packing.
    pairs
        Number of pairs of spheres at neighbouring sites.
    reach
        Distance within which LAMMPS must find them, m.
    """

    kind: str
    pairs: int
    reach: float


def expected_neighbours(case: Case) -> Neighbours | None:
    """Return the neighbours that LAMMPS must find at the start; None if no one distance tells them.

    Packings of unlike spheres hold an array of all sites for this; one rank does it for all.
    """
    packing, assembly = case.packing, assemble(case)
    sites = assembly.sites
    unlike = sites is not None and (sites.stacked is not None or packing.grains is not None)
    if assembly.strikers or assembly.bars or unlike:
        return None  # one cutoff does not tell contacts of unlike bodies
    # The sites are one diameter apart, whatever the diameters of the spheres there.
    forget_gap = case.boundary.forget_gap
    reach = packing.diameter * (1 + min(1e-6, 0.5 * forget_gap))
    if sites is not None and sites.least_reach + forget_gap * packing.diameter < reach:
        return None  # LAMMPS lists no pairs of spheres that are so small at neighbouring sites
    return Neighbours(packing.kind, assembly.n_neighbours, reach)


def check_coordination(expected: Neighbours | None, engine: Engine) -> None:
    """Check that LAMMPS sees every contact of the lattice, none lost to rounding of positions.

    Raises
    ------
    RunError
        It finds another number.
    """
    if expected is None:
        return
    engine.commands(
        f"compute start_coordination all coord/atom cutoff {expected.reach!r}\n"
        "compute start_contacts all reduce sum c_start_coordination\nrun 0 post no"
    )
    found = engine.lammps.extract_compute("start_contacts", 0, 0) / 2
    engine.commands("uncompute start_contacts\nuncompute start_coordination")
    if round(found) != expected.pairs:
        raise RunError(
            f"{expected.kind}: LAMMPS finds {found:.0f} neighbours at the start, the lattice has {expected.pairs}"
        )
