"""A solitary wave, and a chain with one bead of another material."""

from page_figures import save

import granwave as gw

save(gw.run("elastic-impact").figure("force_map"), "solitary_wave")
save(gw.run("intruder.toml").figure("force_map"), "intruder")
