"""Formulas in texts of figures, set once for all figures.

matplotlib remembers how formulas are set, but each renderer for itself; setting one takes some milliseconds, and labels
such as ``Peak force $F/F_\\mathrm{y}$`` stand in many figures.
"""

from __future__ import annotations

from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.mathtext import MathTextParser
from matplotlib.textpath import TextToPath

_PARSER: MathTextParser = MathTextParser("path")
_TEXT_TO_PATH = TextToPath()


def share_formulas(renderer: RendererBase) -> None:
    """Let a renderer use the formulas that others have set."""
    if isinstance(renderer, RendererAgg):
        renderer.mathtext_parser = _PARSER
    else:
        renderer._text2path = _TEXT_TO_PATH  # that of formulas in vector formats
