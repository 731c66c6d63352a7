"""Force against overlap of probed contacts of two spheres, beside the curve of the law."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from granwave.analysis.figures.series import MARKS, label, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.chains.probed_pair import Pair
from granwave.analysis.measures.signals import Array

_MILLI, _KILO = 1e3, 1e-3


def loading_curves(axes: Axes, pairs: Sequence[Pair], names: Mapping[str, str], unit: str, column: str,
                   grid: Callable[[float], Array]) -> dict[str, ArrayLike]:  # fmt: skip
    """Draw the loading of pairs and the curve of the law, forces over that of first yield; return the data.

    Parameters
    ----------
    names
        In the legend, by the end of the name of a column.
    unit
        Attribute of the law, of which overlaps are multiples.
    column
        Name of a column of overlaps.
    grid
        Overlaps of the curve, from the deepest.
    """
    data: dict[str, ArrayLike] = {}
    for n, (pair, (key, name)) in enumerate(zip(pairs, names.items(), strict=True)):
        overlap = pair.overlap[pair.loading] / getattr(pair.law, unit)
        force = pair.force[pair.loading] / pair.law.yield_force
        axes.plot(overlap, force, linestyle="", marker=MARKS[n % 5], markersize=4, fillstyle="none",
                  markevery=(0.01 * n, 0.06), label=name)  # fmt: skip
        data |= {f"{column}_{key}": overlap, f"force_normalised_{key}": force}
    law = pairs[0].law
    x = grid(max(pair.overlap[pair.loading][-1] / getattr(pair.law, unit) for pair in pairs))
    curve = law.loading_force(x * getattr(law, unit)) / law.yield_force
    axes.plot(x, curve, color="black", linewidth=0.8, zorder=0, label="law (thesis 2.14)")
    return data | {f"law_{column}": x, "law_force_normalised": curve}


def contact_curves(pairs: Sequence[Pair], names: Sequence[str]) -> Drawing:
    """Loading and unloading in kN and mm: the law's curve as a line, the run's records as marks."""
    figure, axes = panels(2.7)
    data: dict[str, ArrayLike] = {}
    for pair, name in zip(pairs, names, strict=True):
        overlap, force = pair.overlap[pair.force > 0], pair.force[pair.force > 0]
        alpha, law = pair.law_curve
        (line,) = axes.plot(alpha * _MILLI, law * _KILO, linewidth=0.9, label=name)
        axes.plot(overlap * _MILLI, force * _KILO, "o", color=line.get_color(), markersize=2.5, fillstyle="none",
                  markevery=0.05)  # fmt: skip
        slug = name.replace(" ", "_")
        data |= {f"{slug}_overlap_m": overlap, f"{slug}_force_N": force}
    label(axes, "Overlap (mm)", "Force (kN)", xlim=(0, None), ylim=(0, None))
    axes.legend(fontsize=7, title="lines: law; marks: run", title_fontsize=7)
    return Drawing(figure, data)
