"""The font of the equations: brackets and braces grow around a formula only in a font with a table
of mathematical glyphs, and few systems have one.

The build copies STIX Two Math from the installed package ziamath into the site, next to the text of
its licence (SIL Open Font License); `granwave.css` names it.
"""

from __future__ import annotations

import shutil
from importlib.resources import as_file, files
from pathlib import Path

from sphinx.application import Sphinx

FONT = "STIXTwoMath-Regular.ttf"


def copy_font(app: Sphinx, error: Exception | None) -> None:
    """Copy the font into the static files of a site that was built."""
    if error is not None or app.builder.format != "html":
        return
    with as_file(files("ziamath") / "fonts" / FONT) as font:
        shutil.copyfile(font, Path(app.outdir) / "_static" / FONT)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the extension."""
    app.connect("build-finished", copy_font)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
