"""Expected arrival of the wave of the load at the bottom, before a run.

A solitary wave in a chain of equal beads of mass m takes 1.355 sqrt(m/k) from bead to bead, with
the stiffness k = 3/2 F/alpha of a Hertz contact at the largest force F. If a sphere of a layer
rests on the next layer by several contacts, their stiffnesses along the direction of the wave add
up. The force falls with the depth as a wave spreads, F ~ n^-p over n layers, and the stiffness with
its cube root: p is 0 for a plane wave and for a wave guided by lines of contacts; for packings with
one (in a plane) or two lateral dimensions it was determined from runs. Compared with runs on brass
at 1 to 5 m/s the estimate is within 10 % in chains, 13 to 18 % late in sc, fcc and hcp, and 37 %
late in bcc.

Under a static load small waves travel at the speed of long waves, see
`granwave.lammps_inputs.contact.travel_time`.

In a chain in front of a bar, a wave is at most as fast as a solitary wave of the largest overlap
that the load can cause between any two beads, and under a static load at most as fast as a long
wave of this overlap; its front is two beads ahead of its peak.
"""

from __future__ import annotations

import math

import numpy as np

from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.contact.travel_time import row_of
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import impacted_of, struck_site, velocities_of
from granwave.lammps_inputs.packing.places import Places
from granwave.lammps_inputs.planning.encounters import encounters
from granwave.lammps_inputs.planning.timestep import expected_peak_overlap

_PER_BEAD = 1.355  # time of a solitary wave from bead to bead over sqrt(m/k)
_DECAY = (0.0, 0.8, 1.7)  # p, by the number of lateral dimensions in which a wave spreads
_RANDOM = math.sqrt(2 / 3)  # layers of grains of a file that are no chain, diameters
# stiffness between layers over the stiffness of a contact; the same for files
_STIFFNESS = (1.0, 1.5, 2.0)
_AHEAD = 2  # beads: the front of a solitary wave, of five beads, is ahead of its peak
_FEWEST_STEPS = 3  # steps from layer to layer


def expected_arrival(assembly: Assembly) -> float | None:
    """Return the expected time of arrival of the wave at the bottom, s; None if it is not known:
    for bars, loads that oscillate or do not push down, horizontal packings, and cylinders.
    """
    case = assembly.case
    load = case.load
    down = load.way[2] > 0 or any(one.velocity[2] > 0 for one in case.striker if one.moves)
    if not down or load.oscillates or assembly.bars or assembly.has_cylinders:
        return None
    sphere = struck_site(assembly)
    low, high = assembly.lattice_bounds()
    top = float(low[2] if sphere is None else assembly.centre_of(sphere)[2])
    beside = sum(high[:2] - low[:2] > assembly.lattice.diameter / 2)
    step, stiffness = _layer(assembly, beside)
    n_steps = round((float(high[2]) - top) / step)
    if n_steps < _FEWEST_STEPS:
        return None
    if case.precompression is not None:
        row = row_of(assembly)
        return None if row is None else n_steps * row.of_long_wave
    overlap = expected_peak_overlap(assembly)
    if not overlap > 0:
        return None
    force = sphere_contact(case).loading_force(overlap)
    per_layer = _PER_BEAD * math.sqrt(case.sphere_mass * overlap / (1.5 * force * stiffness))
    lines = not (isinstance(assembly.lattice, Places) or assembly.lattice.rule.set_back)
    spreads = 0 if lines or load.plate is not None else beside
    power = _DECAY[spreads] / 6
    # sum of n^power over the layers, by the trapezoidal rule
    layers = (n_steps ** (power + 1) - 1) / (power + 1) + (n_steps**power + 1) / 2
    return per_layer * layers


def earliest_passage(assembly: Assembly) -> float:
    """Return a lower bound on the time from the load on a chain to the front of the wave at its
    last bead, s; 0 if it is not known.
    """
    lattice = assembly.lattice
    if not lattice.rule.is_chain or assembly.has_cylinders:
        return 0.0
    moved = [*impacted_of(assembly), *velocities_of(assembly)]
    n_steps = lattice.n_spheres - max([k for k in moved if k <= lattice.n_spheres], default=1)
    slowest = 1.0 if assembly.case.precompression is not None else _PER_BEAD
    per_bead = [
        slowest * math.sqrt(one.mass * one.overlap / (1.5 * one.law.loading_force(one.overlap)))
        for one in encounters(assembly)
        if not one.against_wall
    ]
    return max(0, n_steps - _AHEAD) * min(per_bead, default=0.0)


def _layer(assembly: Assembly, beside: int) -> tuple[float, float]:
    """Return the distance of layers, m, and the stiffness between layers divided by the stiffness
    of a contact.

    Parameters
    ----------
    beside
        Number of lateral dimensions of the packing.
    """
    lattice = assembly.lattice
    if isinstance(lattice, Places):
        return (_RANDOM if beside else 1.0) * lattice.diameter, _STIFFNESS[beside]
    supports = lattice.rule.supports
    stiffness = float(np.sum(supports[:, 2] ** 2)) if len(supports) else 1.0
    return lattice.rule.layer_spacing * lattice.diameter, stiffness
