"""Peak forces and forces on the bottom of two packings of different yield strength."""

from page_figures import save

import granwave as gw

CHANGES = {"packing.size": [16, 16, 10], "load.velocity": 0.3, "run.end_time": 4e-4}
STRENGTHS = {"soft": 550e6, "hard": 700e6}

runs = []
for name, strength in STRENGTHS.items():
    changes = CHANGES | {"material.yield_strength": strength}
    runs.append(gw.run("fcc-small", changes, directory=name, figures=False))
comparison = gw.compare(runs)
for name in ("peak_force_field", "bottom_force"):
    save(comparison.figure(name), name)
