"""Force against overlap of probed contacts of two spheres, beside the curve of the law."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from granwave.analysis.figures.series import MARKS, label, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.chains.probed_pair import Pair

_MILLI, _KILO = 1e3, 1e-3


def loading_curves(
    pairs: Sequence[Pair], names: Mapping[str, str], unit: str, column: str, symbol: str, *, log: bool = False
) -> Drawing:
    """Loading of pairs as marks and the law as a line, forces over that of first yield.

    Parameters
    ----------
    names
        Of the pairs in the legend, by the end of the name of a column.
    unit, symbol
        Attribute of the law, of which overlaps are multiples, and its symbol.
    column
        Name of a column of overlaps.
    log
        Logarithmic axes, and many names beside them.
    """
    figure, axes = panels(3.0 if log else 2.7, width=5.2 if log else 0.0)
    data: dict[str, ArrayLike] = {}
    deepest = 0.0
    for n, (pair, (key, name)) in enumerate(zip(pairs, names.items(), strict=True)):
        overlap = pair.overlap[pair.loading] / getattr(pair.law, unit)
        force = pair.force[pair.loading] / pair.law.yield_force
        axes.plot(overlap, force, linestyle="", marker=MARKS[n % 5], markersize=4, fillstyle="none",
                  markevery=(0.01 * n, 0.06), label=name)  # fmt: skip
        data |= {f"{column}_{key}": overlap, f"force_normalised_{key}": force}
        deepest = max(deepest, overlap[-1])
    law = pairs[0].law
    x = np.geomspace(0.3, max(1.0, deepest), 400) if log else np.linspace(0, deepest, 300)
    curve = law.loading_force(x * getattr(law, unit)) / law.yield_force
    axes.plot(x, curve, color="black", linewidth=0.8, zorder=0, label="law (thesis 2.14)")
    label(axes, rf"Overlap $\alpha/{symbol}$", r"Force $F/F_\mathrm{y}$")
    if log:
        label(axes, log="xy", xlim=(0.2, None))
        figure.legend(loc="outside right center", fontsize=6.5)
    else:
        label(axes, xlim=(0, None), ylim=(0, None))
        axes.legend()
    return Drawing(figure, data | {f"law_{column}": x, "law_force_normalised": curve})


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
