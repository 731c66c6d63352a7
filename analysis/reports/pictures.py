"""Figures as pictures of a report."""

from __future__ import annotations

import io

from PIL import Image

from granwave.analysis.figure_style import Drawing

_RESOLUTION = 150  # dots per inch


def png_of(drawing: Drawing) -> tuple[bytes, tuple[int, int]]:
    """A figure as a PNG file, and its width and height in pixels."""
    stream = io.BytesIO()
    drawing.figure.savefig(stream, format="png", dpi=_RESOLUTION, metadata={"Software": None})
    with Image.open(io.BytesIO(stream.getvalue())) as image:
        return stream.getvalue(), image.size
