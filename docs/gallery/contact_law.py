"""The contact law: loading, unloading, and the dent that stays

Two brass spheres of 10 mm are pressed together to four overlaps and let go. Each branch of unloading ends at an overlap
above zero: the dent. When the spheres meet again, they find it there, and come back up on the same branch.

This needs no simulation: the law is the one that the LAMMPS style uses, called from Python.
"""

import numpy as np

from granwave.analysis.figures.style import BLUE, GREY, new_figure, style
from granwave.lammps_inputs import sphere_contact
from granwave.workflows import load_case

law = sphere_contact(load_case("fcc-small"))
unit = law.yield_overlap

with style():
    figure = new_figure(2.8)
    axes = figure.subplots()
    overlap = np.linspace(0, 100 * unit, 400)
    axes.plot(overlap * 1e6, law.loading_force(overlap), color=GREY, label="loading")
    for largest in (20 * unit, 40 * unit, 70 * unit, 100 * unit):
        back = np.linspace(law.residual_overlap(largest), largest, 200)
        force = law.force(back, np.full_like(back, largest))
        axes.plot(back * 1e6, force, color=BLUE, label="unloading and reloading" if largest == 20 * unit else None)
    axes.set(xlabel="overlap (um)", ylabel="force (N)", xlim=(0, None), ylim=(0, None))
    axes.legend()
    figure.savefig("picture.png", dpi=150)

print(f"first yield at an overlap of {unit * 1e6:.3f} um and a force of {law.yield_force:.3f} N")
