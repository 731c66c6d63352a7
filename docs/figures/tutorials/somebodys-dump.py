"""A crystal of two materials as it was read, and its peak forces after the impact."""

import subprocess

from page_figures import save

import granwave as gw

command = "granwave check struck.toml --picture crystal.png"
subprocess.run(command.split(), check=True)
save("crystal.png", "crystal")
save(gw.run("struck.toml").figure("peak_force_principal"), "peak_force_principal")
