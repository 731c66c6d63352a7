"""Figure of how far means of random replicates can be trusted, against the number of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.figures.scales import ticks_at
from granwave.analysis.figures.series import legend_outside, one_panel
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing
from granwave.analysis.statistics import growing, half_width

_FEWEST_SHOWN = 3  # the interval of two is thirteen standard deviations wide
_LOOKS = (("black", "o"), (BLUE, "s"), (ORANGE, "^"))
_TICKS = (3, 4, 5, 6, 8, 10, 12, 16, 20, 30, 50, 100)


def convergence(title: str, quantities: Mapping[str, tuple[str, Sequence[float]]]) -> Drawing | None:
    """Half-width of the confidence interval of the first n values; None where nothing is random.

    Parameters
    ----------
    quantities
        Up to three: what each is called in the legend, and its values in the order of the seeds, by the name of its
        columns.
    """
    figure, axes = one_panel(3.0, "Seeds", "95 % half-width (% of the mean)", xscale="log", yscale="log")
    columns: dict[str, NDArray] = {}
    for (name, (words, values)), (colour, marker) in zip(quantities.items(), _LOOKS, strict=False):
        if len(values) < _FEWEST_SHOWN or not np.std(values):
            continue
        found = growing(values)[_FEWEST_SHOWN - 2 :]
        mean, seeds = found[-1].mean, np.array([one.n for one in found])
        half = np.array([one.half_width for one in found])
        expected = np.array([half_width(found[-1].deviation, int(n)) for n in seeds])
        axes.plot(seeds, 100 * half / mean, marker, color=colour, markersize=4, label=words)
        axes.plot(seeds, 100 * expected / mean, color=colour, linewidth=0.8)
        root = np.sqrt(seeds[-1] / seeds) * expected[-1]
        axes.plot(seeds, 100 * root / mean, color=colour, linewidth=0.8, linestyle=":")
        columns |= {"n": seeds, f"{name}_half_width": half, f"{name}_expected": expected}
    if not columns:
        return None
    axes.plot([], [], color=GREY, linewidth=0.8, label=r"$t_{n-1} s/\sqrt{n}$, $s$ of all seeds")
    axes.plot([], [], color=GREY, linewidth=0.8, linestyle=":", label=r"$1/\sqrt{n}$")
    most = max(len(values) for _, values in quantities.values())
    ticks_at(axes.xaxis, [n for n in _TICKS if n <= most])
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_title(title, fontsize=7)
    legend_outside(figure, 2, fontsize=6.5)
    return Drawing(figure, columns)
