"""The gallery: runs its scripts, and makes a page from each.

A script of ``docs/gallery`` begins with a docstring (title, blank line, text in Markdown), leaves
``picture.png`` and perhaps other pictures in its working directory, and prints a few numbers. It
runs in ``build/gallery/NAME``, and again only if the script or granwave has changed.

    python docs/_ext/studies.py [NAME ...]      # runs scripts without building the site
"""

from __future__ import annotations

import ast
import hashlib
import os
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx

ROOT = Path(__file__).parents[2]
SCRIPTS = ROOT / "docs" / "gallery"
RUNS = ROOT / "build" / "gallery"
LONGEST = 60  # s that a script may take
#: Those on the first page of the site, each with its picture and its lines.
FIRST = (
    "impact_on_fcc", "contact_law", "solitary_wave", "restitution", "velocity_and_loss", "repeated_hits",
    "tolerance", "protected_plate", "punch_on_block", "precompressed_chain", "tunable_gap", "best_row",
)  # fmt: skip
# largest number of lines of a script on the first page, without blank lines and imports
MOST_LINES = 15
_PICTURE = "picture.png"
_PRINTED = "printed.txt"
_STAMP = "stamp.txt"


def scripts() -> list[Path]:
    """Return the scripts of the gallery."""
    return sorted(SCRIPTS.glob("*.py"))


def sources() -> str:
    """Return a hash of the installed granwave, on which all pictures depend."""
    import granwave

    digest = hashlib.sha256()
    for folder, _, names in sorted(os.walk(Path(granwave.__file__).parent, followlinks=True)):
        for name in sorted(names):
            if name.endswith((".py", ".toml", ".so")):
                digest.update((Path(folder) / name).read_bytes())
    return digest.hexdigest()


def run(script: Path, version: str) -> float:
    """Run a script if needed; return the time that it took, s.

    Raises
    ------
    RuntimeError
        The script failed, took too long, or left no picture.
    """
    folder = RUNS / script.stem
    stamp = hashlib.sha256(script.read_bytes() + version.encode()).hexdigest()
    if (folder / _STAMP).is_file() and (folder / _STAMP).read_text() == stamp:
        return 0.0
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    environment = os.environ | {"OMP_NUM_THREADS": "1", "MPLBACKEND": "agg"}
    begin = time.monotonic()
    done = subprocess.run(
        [sys.executable, script],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=5 * LONGEST,
    )
    taken = time.monotonic() - begin
    if done.returncode != 0:
        raise RuntimeError(f"{script.name} failed:\n{done.stderr}")
    if not (folder / _PICTURE).is_file():
        raise RuntimeError(f"{script.name} left no {_PICTURE}")
    (folder / _PRINTED).write_text(done.stdout, encoding="utf-8")
    (folder / _STAMP).write_text(stamp)
    return taken


def run_all(names: list[str] | None = None) -> dict[str, float]:
    """Run all scripts, two at a time; return the time of each, s."""
    chosen = [script for script in scripts() if not names or script.stem in names]
    version = sources()
    with ThreadPoolExecutor(2) as pool:
        return dict(
            zip([s.stem for s in chosen], pool.map(lambda s: run(s, version), chosen), strict=True)
        )


def parts_of(script: Path) -> tuple[str, str, str]:
    """Return title, text and code of a script."""
    text = script.read_text(encoding="utf-8")
    tree = ast.parse(text)
    title, _, description = (ast.get_docstring(tree) or "").partition("\n")
    code = "\n".join(text.splitlines()[tree.body[0].end_lineno :]).strip()
    return title, description.strip(), code


def page_of(script: Path, pictures: list[str]) -> str:
    """Return the page of a script."""
    title, text, code = parts_of(script)
    printed = (RUNS / script.stem / _PRINTED).read_text(encoding="utf-8").rstrip()
    shown = [f"```{{image}} {name}\n:alt: {title}\n:class: gallery-page\n```" for name in pictures]
    return "\n\n".join(
        [
            f"# {title}",
            text,
            *shown,
            *([f"It prints\n\n```text\n{printed}\n```"] if printed else []),
            f"## The script\n\nSave it as `{script.name}` and run `python {script.name}`.\n\n```python\n{code}\n```\n",
        ]
    )


def card_of(script: Path) -> str:
    """Return the card of a script on the page of the gallery."""
    title, text, _ = parts_of(script)
    first = text.partition(". ")[0].replace("\n", " ").rstrip(".") + "."
    return "\n".join(
        [
            f":::{{grid-item-card}} {title}",
            f":img-top: studies/{script.stem}-{_PICTURE}",
            ":class-img-top: gallery-thumb",
            f":link: studies/{script.stem}",
            ":link-type: doc",
            "",
            first,
            ":::",
        ]
    )


def lines_of(script: Path) -> str:
    """Return the lines of a script without imports, drawing and printing."""
    _, _, code = parts_of(script)
    before = code.partition("\nwith gw.style()")[0].partition("\nprint(")[0]
    kept = [line for line in before.splitlines() if not line.startswith("import ")]
    return "\n".join(kept).strip()


def card_with_lines(script: Path) -> str:
    """Return the card of a script on the first page: picture, title, and its lines in a folded
    block.
    """
    title, _, _ = parts_of(script)
    return "\n".join(
        [
            "::::{grid-item-card}",
            f":img-top: gallery/studies/{script.stem}-{_PICTURE}",
            ":class-img-top: gallery-thumb",
            ":class-body: gallery-lines",
            "",
            f"[{title}](gallery/studies/{script.stem}.md)",
            "",
            ":::{dropdown} the script",
            "```python",
            lines_of(script),
            "```",
            ":::",
            "::::",
        ]
    )


def write_pages(app: Sphinx) -> None:
    """Run the scripts, and write their pages into the site's sources, in a folder that git
    ignores.
    """
    run_all()
    folder = Path(app.srcdir) / "gallery" / "studies"
    folder.mkdir(exist_ok=True)
    for script in scripts():
        pictures = sorted(
            (RUNS / script.stem).glob("*.png"), key=lambda path: (path.name != _PICTURE, path.name)
        )
        for picture in pictures:
            shutil.copyfile(picture, folder / f"{script.stem}-{picture.name}")
        text = page_of(script, [f"{script.stem}-{picture.name}" for picture in pictures])
        page = folder / f"{script.stem}.md"
        if not page.exists() or page.read_text(encoding="utf-8") != text:
            page.write_text(text, encoding="utf-8")


def fill_in(_: Sphinx, name: str, source: list[str]) -> None:
    """Put cards and table of contents into the page of the gallery, and twelve cards into the first
    page.
    """
    if name == "index":
        cards = "\n\n".join(card_with_lines(SCRIPTS / f"{script}.py") for script in FIRST)
        source[0] = source[0].replace(
            "<!-- gallery -->", f":::::{{grid}} 1 2 2 2\n:gutter: 3\n\n{cards}\n:::::"
        )
    if name == "gallery/index":
        cards = "\n\n".join(map(card_of, scripts()))
        tree = "\n".join(
            [
                "```{toctree}",
                ":hidden:",
                "",
                *(f"studies/{script.stem}" for script in scripts()),
                "```",
            ]
        )
        source[0] = source[0].replace(
            "<!-- gallery -->", f"::::{{grid}} 1 2 2 2\n:gutter: 3\n\n{cards}\n::::\n\n{tree}"
        )


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.connect("builder-inited", write_pages)
    app.connect("source-read", fill_in)
    return {"parallel_read_safe": True}


if __name__ == "__main__":
    for study, seconds in run_all(sys.argv[1:]).items():
        print(f"{study:20} {seconds:5.1f} s")
