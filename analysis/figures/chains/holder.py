"""Figure of composite chains in a holder that rubs: output pulse against the section's length."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from numpy.typing import ArrayLike

from granwave.analysis.figures.series import COLOURS, MARKS, column_name, label, legend_outside, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.chains.composite_section import Composite
from granwave.analysis.measures.chains.groups import columns


def against_length(series: Mapping[str, Mapping[float, Sequence[Composite]]]) -> Drawing:
    """V and lambda over those of the smallest friction, for each material of the section and each friction.

    Parameters
    ----------
    series
        Chains by material and friction, in the order of their length.
    """
    figure, left, right = panels(3.0, 2)
    data: dict[str, ArrayLike] = {}
    for (light, chains), colour in zip(series.items(), COLOURS, strict=False):
        least = {chain.n: chain for chain in chains[min(chains)]}
        for (friction, alike), marker in zip(chains.items(), MARKS, strict=False):
            shown = [chain for chain in alike if chain.n in least]
            n, speed, ratio = columns(shown, "n", "speed", "ratio")
            smooth_speed, smooth_ratio = columns([least[int(one)] for one in n], "speed", "ratio")
            name = column_name(f"{light} {friction:g}")
            data |= {f"{name}_n": n.astype(float), f"{name}_speed_m_s": speed, f"{name}_ratio": ratio}
            for axes, values in ((left, speed / smooth_speed), (right, ratio / smooth_ratio)):
                axes.plot(n, values, marker + "-", markersize=4, color=colour, label=f"{light}, friction {friction:g}")
    label(left, r"Beads in the section $N_2$", r"Speed $V$ over that at the least friction")
    label(right, r"Beads in the section $N_2$", r"$\lambda$ over that at the least friction")
    legend_outside(figure, 3, fontsize=7)
    return Drawing(figure, data)
