"""Peak forces of two small packings on one colour scale."""

from page_figures import save

import granwave as gw

CHANGES = {"packing.size": [8, 8, 5], "run.end_time": 2e-4}

runs = []
for name in ("fcc-small", "hcp-small"):
    runs.append(gw.run(name, CHANGES, directory=name, figures=False))
comparison = gw.compare(runs)
for name in ("peak_force_field", "bottom_force"):
    save(comparison.figure(name), name)
