"""Impact on an FCC packing: peak forces

A sphere of the top layer hits 16 x 16 x 8 brass spheres of 10 mm at 5 m/s. The colour shows the
largest contact force of each sphere. The force propagates along the lines of touching spheres, the
<110> directions of the lattice.

`granwave run` draws both pictures by default.
"""

import granwave as gw

run = gw.run(
    "fcc-small", {"packing.size": [16, 16, 8], "run.end_time": 4e-4}, directory="run", force=True
)
for name, file in (("packing_3d", "picture.png"), ("peak_force_principal", "section.png")):
    run.figure(name).figure.savefig(file, dpi=300)

print(f"spheres                 {run['n_spheres']}")
print(f"largest contact force   {run['peak_force_N']:.1f} N")
print(f"dissipated              {run['dissipated_fraction']:.3f} of the input energy")
print(f"contacts that yielded   {run['n_plastic_contacts']}")
