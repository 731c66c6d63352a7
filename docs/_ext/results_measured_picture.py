"""Figure of the comparisons with experiments on the first page of the site: our value and the error
of the measurement, divided by the measured value. Names are above their rows, so that a telephone
shows the figure in readable size.

The figure contains the digest of its rows, so that a test detects an outdated figure.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.figure import Figure
from results_chosen import MEASURED
from results_picture import digest_of, save
from results_rows import chosen_rows, interval_of
from results_stored import ROOT

from granwave.analysis.figures.style import BLUE, GREY, ORANGE, style

PATH = ROOT / "docs" / "explanation" / "measured.webp"
_TEXT = (
    "Computed value and error of the measurement, divided by the measured value, for nine "
    "comparisons with experiments"
)
_CAPTION = (
    "*Each value is divided by the measured value. Circles: granwave; diamonds: measurement; "
    "bars: the error that the source states, where it states one.*"
)
# inches
_WIDTH = 4.8
_ROW = 0.36
_BELOW = 0.5
_ABOVE = 0.1
_EDGE = 0.15
_SMALL = 9  # points
_NAME = 0.38  # height of a name above its row, rows
_WHITE = {"color": "white", "pad": 0.5}  # background of a name, which hides the line at 1


def text() -> str:
    """Return the figure with its caption for the first page."""
    return f"![{_TEXT}](explanation/{PATH.name})\n\n{_CAPTION}\n\n"


def write_stale(stored: Mapping[str, Any]) -> None:
    """Draw the figure if it is missing or outdated."""
    if not is_stale(stored):
        return
    with style():
        save(_figure(stored), PATH, _digest(stored))


def is_stale(stored: Mapping[str, Any], path: Path = PATH) -> bool:
    """Return True for a figure that is missing or shows other values."""
    return not path.is_file() or digest_of(path) != _digest(stored)


def ratios(stored: Mapping[str, Any]) -> Iterator[tuple[str, float, float]]:
    """Iterate over name, our value, and error of the source, both divided by the measured value."""
    for name, rows in chosen_rows(stored, MEASURED):
        for row in rows:
            assert row.source is not None and row.ours is not None
            error = float(interval_of(row) or 0.0)
            yield name, row.ours / row.source, abs(error / row.source)


def _digest(stored: Mapping[str, Any]) -> str:
    shown = [f"{name} {ratio:.6g} {error:.6g}" for name, ratio, error in ratios(stored)]
    return hashlib.sha256(repr(shown).encode()).hexdigest()[:16]


def _figure(stored: Mapping[str, Any]) -> Figure:
    entries = list(ratios(stored))
    inside = _ROW * len(entries)
    height = _ABOVE + inside + _BELOW
    figure = plt.figure(figsize=(_WIDTH, height))
    width = (_WIDTH - 2 * _EDGE) / _WIDTH
    axes = figure.add_axes((_EDGE / _WIDTH, _BELOW / height, width, inside / height))
    axes.axvline(1.0, color=GREY, lw=0.8, zorder=0)
    for place, (name, ratio, error) in enumerate(entries):
        axes.text(
            0.01, place - _NAME, name, fontsize=_SMALL, va="center", bbox=_WHITE,
            transform=axes.get_yaxis_transform(),
        )  # fmt: skip
        if error:
            axes.errorbar(1.0, place, xerr=error, ecolor=ORANGE, capsize=2, lw=1)
        axes.plot(1.0, place, "D", ms=5.5, mfc="white", mec=ORANGE, mew=1.2, zorder=2)
        axes.plot(ratio, place, "o", ms=4.2, color=BLUE, zorder=3)
    axes.set_yticks([])
    axes.tick_params(axis="x", labelsize=_SMALL)
    axes.set_ylim(len(entries) - 0.6, -0.7)
    axes.set_xlabel("value / measured value", fontsize=_SMALL)
    return figure
