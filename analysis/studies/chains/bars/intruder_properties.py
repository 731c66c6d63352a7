"""A bead of another kind in a chain on a bar: transmitted energy by its properties (thesis Fig. 3.8).

A bead of mass m in contacts of slope k ~ sigma_y R* answers in tau* = D sqrt(rho/sigma_y) if R* goes with its own
radius; beside beads of another radius it does so less, and sqrt(m/sigma_y) ~ R^1.5 is closer.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from granwave.analysis.figures.series import MARKS, label, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.chains.odd_bead import OddBead
from granwave.analysis.measures.signals import Array
from granwave.analysis.studies.chains.bars.odd_beads import FEWEST, lines, name_of, remarks
from granwave.analysis.studies.runs import FinishedRun, rising
from granwave.analysis.studies.study import Picture, Row

_WHERE = "thesis Fig. 3.8"
_RATIO = 3.0  # of the normalised times at which the collapse is judged
_SLIGHT = 0.1  # change of transmitted energy
#: Powers of the ratio of each property in tau* = D sqrt(rho/sigma_y), and in sqrt(m/sigma_y).
_POWERS = {"yield strength": (-0.5, -0.5), "density": (0.5, 0.5), "radius": (1.0, 1.5), "modulus": (0.0, 0.0)}


@dataclasses.dataclass(frozen=True)
class Properties:
    """Chains with an intruder at one place, of which one property is varied.

    Attributes
    ----------
    suffix
        End of names.
    base
        Chain of like beads.
    curves
        Chains by property, that of like beads among them.
    """

    suffix: str
    base: OddBead
    place: int
    curves: dict[str, list[OddBead]]

    def ratios(self, one: str) -> tuple[Array, Array]:
        """A property and the transmitted energy, over those of the chain of like beads."""
        x = np.array([chain.properties[one] / self.base.properties[one] for chain in self.curves[one]])
        return x, np.array([chain.energy / self.base.energy for chain in self.curves[one]])


def select(runs: Sequence[FinishedRun]) -> list[Properties]:
    """Places at which a property of the intruder was given three values and more."""
    groups = []
    for suffix, chains in lines(runs):
        for base in [chain for chain in chains if chain.place is None][:1]:
            for place in sorted({chain.place for chain in chains if chain.place is not None}):
                there = [chain for chain in chains if chain.place == place]
                curves = {one: _varied(one, base, there) for one in _POWERS}
                curves = {one: curve for one, curve in curves.items() if len(curve) >= FEWEST}
                if curves:
                    groups.append(Properties(suffix, base, place, curves))
    return groups


def name(group: Properties) -> str:
    """For links."""
    return f"intruder-properties-{group.place}{group.suffix}"


def title(group: Properties) -> str:
    """With material and place."""
    return f"Intruder in {name_of(group.base.base)} at place {group.place}, by its properties"


def text(group: Properties) -> str:
    """Describe the runs."""
    used = [chain for curve in group.curves.values() for chain in curve]
    return (
        f"{group.base.run.assembly.lattice.n_spheres} beads of {name_of(group.base.base)}; one property of that at "
        f"place {group.place} differs. Ratios e_T/e_0T are to the chain of like beads. {remarks(used)}"
    )


def rows(group: Properties) -> Iterator[Row]:
    """Energies at the ends of all curves, and how far apart these are in the scaled property."""
    for one in group.curves:
        x, y = group.ratios(one)
        for ratio, energy in ((x[0], y[0]), (x[-1], y[-1])):
            remark = ""
            if one == "yield strength" and ratio > 1:
                remark = "The weaker bead of a contact yields: a stronger intruder changes nothing."
            if one == "modulus" and abs(energy - 1) < _SLIGHT:
                remark = "Hardly any effect, as the source says."
            yield Row(f"e_T/e_0T at {ratio:.3g} times the {one}", "", None, float(energy), _WHERE, remark)
    kept = "The contacts of a large bead keep the R* of its neighbours: no full collapse."
    closer = "For radii R^1.5 in place of R: closer."
    for k, (what, remark) in enumerate((("D sqrt(rho/sigma_y)", kept), ("sqrt(m/sigma_y)", closer))):
        there = []
        for one in (one for one in group.curves if _POWERS[one][k]):
            x, y = group.ratios(one)
            scaled, energy = _sorted(np.log(x) * _POWERS[one][k], y)
            if scaled[0] <= math.log(_RATIO) <= scaled[-1]:
                there.append(float(np.interp(math.log(_RATIO), scaled, energy)))
        if len(there) > 1:
            spread = max(there) - min(there)
            yield Row(f"Spread of e_T/e_0T at {_RATIO:g} times {what}", "", None, spread, _WHERE, remark)


def pictures(group: Properties) -> Iterator[Picture]:
    """Energy against both scaled properties."""
    figure, left, right = panels(2.8, 2, sharey=True)
    data: dict[str, Any] = {}
    for one, mark in zip(group.curves, MARKS, strict=False):
        x, y = group.ratios(one)
        slug, (to_time, to_mass) = one.replace(" ", "_"), _POWERS[one]
        data |= {f"{slug}_ratio": x, f"energy_ratio_by_{slug}": y}
        (line,) = left.plot(*_sorted(x ** (to_time or 1.0), y), marker=mark, markersize=4, label=one)
        if not to_time:
            line.set_linestyle(":")
        if to_mass:
            right.plot(*_sorted(x**to_mass, y), color=line.get_color(), marker=mark, markersize=4)
    for axes in (left, right):
        axes.axvline(1, color="black", linewidth=0.5)
    label(left, r"$\tau^*_i/\tau^*_0$,  $\tau^* = D\sqrt{\rho/\sigma_y}$;  modulus: $E_i/E_0$",
          "Transmitted energy $e_T/e_{0T}$", log="x")  # fmt: skip
    label(right, r"$\sqrt{m_i\sigma_0/(m_0\sigma_i)}$", log="x")
    left.legend(loc="lower left")
    caption = "Transmitted energy against the properties of the intruder (thesis Fig. 3.8)"
    yield Picture(f"intruder_properties_{group.place}{group.suffix}", caption, Drawing(figure, data))


def _sorted(x: Array, y: Array) -> tuple[Array, Array]:
    """Points in rising order of x."""
    order = np.argsort(x)
    return x[order], y[order]


def _varied(one: str, base: OddBead, chains: Sequence[OddBead]) -> list[OddBead]:
    """Chains whose intruder differs from the rest in one property alone, and that of like beads, by that property."""
    fixed = {key: value for key, value in base.properties.items() if key != one}
    alike = [chain for chain in chains if all(math.isclose(chain.properties[key], fixed[key]) for key in fixed)]
    return rising([base, *alike], lambda chain: chain.properties[one])
