"""Figures of the pages: runs ``docs/figures/PART/PAGE.py`` and keeps its figures.

    python docs/_ext/page_figures.py [PAGE ...]

PART is the folder of the page in ``docs``; PAGE is unique. It writes
``docs/figures/PART/PAGE/NAME.webp``, and the digest of the script. Each script runs in
``build/figures/PAGE``, with granwave as installed by a user, and calls `save`. The files of a
tutorial or how-to (blocks of code with a caption) are in that folder. A test compares the digests
in ``docs/figures/digests.txt`` with the scripts, so that no figure comes from an earlier script.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from PIL import Image

ROOT = Path(__file__).parents[2]
sys.path.append(str(ROOT))
from tests.documents.pages import write_files  # noqa: E402

FOLDER = ROOT / "docs" / "figures"
RUNS = ROOT / "build" / "figures"
DIGESTS = FOLDER / "digests.txt"
#: Largest width of a kept picture, pixels.
WIDTH = 1200
QUALITY = 80
#: Folders whose pages show the figures of their own cases.
TASKS = ("tutorials", "howto")


def save(figure: Axes | list[Axes] | str | Path, name: str) -> None:
    """Keep the figure of some axes, or a PNG of a run, as ``docs/figures/PART/PAGE/NAME.webp``.

    Parameters
    ----------
    figure : axes of a Matplotlib figure, as `run.figure` returns them, or the path of a PNG
    name : name of the figure on its page
    """
    folder = Path(sys.argv[0]).with_suffix("")
    folder.mkdir(exist_ok=True)
    path = folder / f"{name}.webp"
    if isinstance(figure, str | Path):
        picture = Path(figure)
    else:
        axes = np.ravel(figure)[0]
        picture = Path(f"{name}.png")
        axes.figure.savefig(picture, dpi=150)
        plt.close(axes.figure)
    with Image.open(picture) as image:
        small = image.convert("RGB")
    if small.width > WIDTH:
        height = round(small.height * WIDTH / small.width)
        small = small.resize((WIDTH, height), Image.Resampling.LANCZOS)
    small.save(path, quality=QUALITY, method=6)


def scripts() -> dict[str, Path]:
    """Return the scripts by their page, in order."""
    return {path.stem: path for path in sorted(FOLDER.glob("*/*.py"), key=lambda path: path.stem)}


def names() -> list[str]:
    """Return the pages that have a script, in order."""
    return list(scripts())


def digest(page: str) -> str:
    """Return the digest of a page's script."""
    return hashlib.sha256(scripts()[page].read_bytes()).hexdigest()[:16]


def stored_digests() -> dict[str, str]:
    """Return the digests of the scripts whose figures are kept, by page."""
    if not DIGESTS.exists():
        return {}
    return dict(line.split() for line in DIGESTS.read_text(encoding="utf-8").splitlines())


def draw(page: str) -> None:
    """Run the script of a page in an empty folder, and keep its figures."""
    script = scripts()[page]
    folder = RUNS / page
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    shutil.rmtree(script.with_suffix(""), ignore_errors=True)
    for part in TASKS:
        text = ROOT / "docs" / part / f"{page}.md"
        if text.exists():
            write_files(text, folder)
    search_path = os.pathsep.join((str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")))
    programs = os.pathsep.join((str(Path(sys.executable).parent), os.environ.get("PATH", "")))
    environment = os.environ | {"PYTHONPATH": search_path, "PATH": programs}
    command = [sys.executable, str(script)]
    subprocess.run(command, cwd=folder, env=environment, check=True)


def main(pages: list[str]) -> None:
    """Draw the figures of these pages, or of all."""
    for page in pages or names():
        draw(page)
        digests = stored_digests() | {page: digest(page)}
        lines = [f"{name} {digests[name]}\n" for name in names() if name in digests]
        DIGESTS.write_text("".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
