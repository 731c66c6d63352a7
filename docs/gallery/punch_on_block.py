"""The same blow on a solid block

The continuum beside the packing: a rigid punch of 10 mm hits a solid block of brass at 10 m/s. The mesh is coarse here,
so that it takes seconds. What yields most lies at the edge of the punch, and a bowl below it.
"""

import shutil

from granwave.workflows import library
from granwave.workflows.finite_elements.punch import ContinuumCase, run_continuum
from granwave.workflows.finite_elements.punch.figures import draw_figures

changes = {"run.elements": 4000, "run.end_time": 6e-5}
case = ContinuumCase.load(library.find("half-space"), changes)
summary = run_continuum(case, "run", force=True, figures=False)
draw_figures("run")
shutil.copy("run/figures/plastic_strain.png", "picture.png")
shutil.copy("run/figures/energies.png", "energies.png")

print(f"elements     {summary['n_elements']}")
print(f"dissipated   {summary['dissipated_fraction']:.3f} of the energy put in")
