"""A frame of the animation of an impact."""

import subprocess

from page_figures import save
from PIL import Image

import granwave as gw

CHANGES = {"packing.size": [12, 12, 6], "run.frames": 12, "run.end_time": 1.2e-4}
FRAME = 4

gw.run("fcc-small", CHANGES, directory="hit", figures=False)
subprocess.run(["granwave", "film", "hit", "-o", "wave.gif", "--width", "900"], check=True)
with Image.open("wave.gif") as film:
    film.seek(FRAME)
    film.convert("RGB").save("wave.png")
save("wave.png", "wave")
