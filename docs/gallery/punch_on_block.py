"""The same impact on a solid block

A rigid punch of 10 mm hits a solid block of brass at 10 m/s, as the continuum reference of a
packing. The mesh is coarse, so that the run takes seconds. Most plastic deformation is at the edge
of the punch and in a bowl below it.
"""

import shutil

import granwave as gw

changes = {"run.elements": 4000, "run.end_time": 6e-5}
run = gw.run("half-space", changes, directory="run", force=True, figures=True)
shutil.copy("run/figures/plastic_strain.png", "picture.png")
shutil.copy("run/figures/energies.png", "energies.png")

print(f"elements     {run['n_elements']}")
print(f"dissipated   {run['dissipated_fraction']:.3f} of the input energy")
