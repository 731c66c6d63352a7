"""Figures as pictures of a report."""

from __future__ import annotations

import io

from PIL import Image

from granwave.analysis.document.model import Figure, Link
from granwave.analysis.figures.style import Drawing, lay_out

#: Dots per inch at which a page shows figures that take a whole row: their letters are as large as the page's.
RESOLUTION = 150


def picture_of(drawing: Drawing, name: str, caption: str, data: Link | None = None) -> Figure:
    """A figure as a picture; its caption is its alternative text too."""
    lay_out(drawing.figure, RESOLUTION)
    stream = io.BytesIO()
    drawing.figure.savefig(stream, format="png", dpi=RESOLUTION, metadata={"Software": None})
    with Image.open(io.BytesIO(stream.getvalue())) as image:
        size = image.size
    return Figure(name, caption, caption, stream.getvalue(), size, data, drawing.figure.get_figwidth())
