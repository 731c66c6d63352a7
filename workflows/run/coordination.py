"""Contacts at the start: LAMMPS sees those that the lattice has."""

from __future__ import annotations

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows.run.lammps_engine import Engine


def check_coordination(case: Case, engine: Engine) -> None:
    """Check that LAMMPS sees every contact of the lattice, none lost to rounding of positions.

    Raises
    ------
    RunError
        It finds another number.
    """
    packing, assembly = case.packing, assemble(case)
    sites = assembly.sites
    unlike = sites is not None and (sites.stacked is not None or packing.grains is not None)
    if assembly.strikers or assembly.bars or unlike:
        return  # one cutoff does not tell contacts of unlike bodies
    # The sites are one diameter apart, whatever the diameters of the spheres there.
    expected, forget_gap = assembly.n_neighbours, case.boundary.forget_gap
    reach = packing.diameter * (1 + min(1e-6, 0.5 * forget_gap))
    if sites is not None and sites.least_reach + forget_gap * packing.diameter < reach:
        return  # LAMMPS lists no pairs of spheres that are so small at neighbouring sites
    engine.commands(
        f"compute start_coordination all coord/atom cutoff {reach!r}\n"
        "compute start_contacts all reduce sum c_start_coordination\nrun 0 post no"
    )
    found = engine.lammps.extract_compute("start_contacts", 0, 0) / 2
    engine.commands("uncompute start_contacts\nuncompute start_coordination")
    if round(found) != expected:
        raise RunError(f"{packing.kind}: LAMMPS finds {found:.0f} neighbours at the start, the lattice has {expected}")
