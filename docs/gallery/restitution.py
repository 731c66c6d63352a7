"""Restitution of a sphere on a wall, from runs and from the law

A brass sphere of 10 mm hits a rigid wall. The line is the coefficient of restitution that follows from the contact law
alone; the marks are runs.
"""

import numpy as np

from granwave.analysis.contact_law.restitution import restitution
from granwave.analysis.figures.style import BLUE, ORANGE, new_figure, style
from granwave.lammps_inputs.contact.law import rigid_wall_contact_of
from granwave.workflows import load_case, run_case

velocities = np.geomspace(0.05, 20, 6)
found = []
for velocity in velocities:
    case = load_case("sphere-on-wall", {"load.velocity": velocity})
    found.append(run_case(case, "run", force=True, figures=False).summary["restitution"])
    print(f"{velocity:6.2f} m/s   {found[-1]:.4f}")

law = rigid_wall_contact_of(case.material, case.packing.diameter / 2, "elastoplastic")
velocity, coefficient = restitution(law, case.sphere_mass)

with style():
    figure = new_figure(2.6)
    axes = figure.subplots()
    axes.semilogx(velocity, coefficient, color=BLUE, label="contact law")
    axes.semilogx(velocities, found, "o", color=ORANGE, markersize=4, label="runs")
    axes.set(xlabel="impact velocity (m/s)", ylabel="coefficient of restitution", ylim=(0, 1.02))
    axes.legend()
    figure.savefig("picture.png", dpi=150)
