"""Amplitudes along a driven row, and the spectrum of a sweep."""

from page_figures import save

import granwave as gw

save(gw.run("driven.toml").figure("transmission"), "harmonic")
sweep = {
    "kind": "force",
    "shape": "sweep",
    "amplitude": 0.1,
    "frequency": 1e3,
    "last_frequency": 20e3,
    "duration": 8e-3,
    "ramp": 1e-3,
}
run = gw.run("driven.toml", load=sweep, run__end_time=1.6e-2, directory="sweep")
save(run.figure("transmission"), "sweep")
