"""Impact on an FCC packing: where the largest forces were

A sphere of the top layer hits 16 x 16 x 8 brass spheres of 10 mm at 5 m/s. The colour tells the largest contact force
that each sphere ever felt. The force runs along the rows in which the spheres touch, the <110> directions of the
lattice.

The pictures are two of those that `granwave run` draws by itself.
"""

import shutil

from granwave.analysis import draw_figures
from granwave.workflows import load_case, run_case

case = load_case("fcc-small", {"packing.size": [16, 16, 8], "run.end_time": 4e-4})
outcome = run_case(case, "run", force=True, figures=False)
draw_figures("run", names=("packing_3d", "peak_force_principal"))
shutil.copy("run/figures/packing_3d.png", "picture.png")
shutil.copy("run/figures/peak_force_principal.png", "section.png")

summary = outcome.summary
print(f"spheres                 {summary['n_spheres']}")
print(f"largest contact force   {summary['peak_force_N']:.1f} N")
print(f"dissipated              {summary['dissipated_fraction']:.3f} of the energy put in")
print(f"contacts that yielded   {summary['n_plastic_contacts']}")
