"""Peak forces among spheres of two materials, and the dissipation of two impacts in turn."""

from page_figures import save

import granwave as gw

save(gw.run("mixed.toml").figure("peak_force_principal"), "mixed")

keys = {"packing.size": [8, 8, 5], "run.end_time": 2e-4}
first = gw.run("fcc-small", keys, directory="first")
second = gw.run("fcc-small", keys | {"contact.initial_overlap": "first"}, directory="second")
save(gw.compare([first, second]).figure("energies"), "hits")
