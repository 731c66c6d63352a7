"""Peak force on the bottom against velocity, drawn by the study of the page."""

from page_figures import save

import granwave as gw

scan = {
    "name": "speeds",
    "case": "elastic-impact",
    "study": "force_power.py",
    "set": {"packing.size": 20, "boundary.bottom": "wall", "run.end_time": 6e-4},
    "grid": {"load.velocity": [0.3, 1.0, 3.0]},
}
gw.scan(scan, jobs=2)
save("speeds/figures/force_power.png", "force_power")
