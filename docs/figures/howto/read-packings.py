"""The packing of the dump, as `granwave check` draws it."""

import subprocess

from page_figures import save

command = "granwave check bed.toml --picture bed.png"
subprocess.run(command.split(), check=True)
save("bed.png", "bed")
