"""A filter of spheres and cylinders, and a chain in a tube, as `granwave check` draws them."""

import subprocess

from page_figures import save

for name in ("filter", "tube"):
    command = f"granwave check {name}.toml --picture {name}.png"
    subprocess.run(command.split(), check=True)
    save(f"{name}.png", name)
