"""A bead of another kind in a chain on a bar: transmitted energy and force by its place (thesis Fig. 3.7)."""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Iterator, Sequence
from typing import Any

import numpy as np

from granwave.analysis.figures.series import MARKS, label, panels
from granwave.analysis.figures.style import GREY, Drawing
from granwave.analysis.measures.chains.groups import columns
from granwave.analysis.measures.chains.odd_bead import OddBead, constants
from granwave.analysis.studies.chains.bars.odd_beads import FEWEST, lines, name_of, remarks
from granwave.analysis.studies.runs import FinishedRun, rising
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.case.material import Material

_WHERE = "thesis Fig. 3.7"
_QUANTITIES = (("Transmitted energy", "J", "energy"), ("Peak transmitted force over the load", "", "peak"))


@dataclasses.dataclass(frozen=True)
class Places:
    """Chains of one material but for the intruder.

    Attributes
    ----------
    suffix
        End of names.
    base
        Of the other beads.
    curves
        Chains with one kind of intruder, by place.
    alike
        Chains of like beads of all materials concerned, under the same load, on the same bar.
    """

    suffix: str
    base: Material
    curves: list[list[OddBead]]
    alike: list[OddBead]


def select(runs: Sequence[FinishedRun]) -> list[Places]:
    """Lines of chains with an intruder at three places and more."""
    found = lines(runs)
    every = [chain for _, line in found for chain in line]
    groups = []
    for suffix, line in found:
        curves = [curve for curve in _curves(line) if len(curve) >= FEWEST]
        if curves:
            others = [chain for chain in every if chain.line == line[0].line and chain.place is None]
            alike = {constants(chain.base): chain for chain in reversed(others)}
            wanted = dict.fromkeys(constants(one) for one in [line[0].base, *(curve[0].material for curve in curves)])
            groups.append(Places(suffix, line[0].base, curves, [alike[one] for one in wanted if one in alike]))
    return groups


def name(places: Places) -> str:
    """For links."""
    return f"intruder-place{places.suffix}"


def title(places: Places) -> str:
    """With the material."""
    return f"Intruder in {name_of(places.base)}, by place"


def text(places: Places) -> str:
    """Describe the runs."""
    run = places.curves[0][0].run
    used = [*places.alike, *(chain for curve in places.curves for chain in curve)]
    return (
        f"{run.assembly.lattice.n_spheres - 1} beads of {name_of(places.base)} and one of another kind; "
        f"{run.load.shape} of {run.load.largest:g} N for {1e6 * run.load.lasts:g} µs on the first. {remarks(used)}"
    )


def rows(places: Places) -> Iterator[Row]:
    """Chains of like beads; the least, the most and the largest change by an intruder."""
    for chain in places.alike:
        for what, unit, key in _QUANTITIES:
            yield Row(f"{what}, all {name_of(chain.base)}", unit, None, getattr(chain, key), _WHERE)
    same = [chain for chain in places.alike if constants(chain.base) == constants(places.base)]
    for curve in places.curves:
        for what, unit, key in _QUANTITIES:
            of, (values,) = f"{what}, {name_of(curve[0].material)}", columns(curve, key)
            for which, k in (("least", values.argmin()), ("most", values.argmax())):
                yield Row(f"{of}: {which}, at place {curve[k].place}", unit, None, float(values[k]), _WHERE)
            for reference in same[:1]:
                change = float(np.abs(values / getattr(reference, key) - 1).max())
                yield Row(f"{of}: largest change from all {name_of(places.base)}", "", None, change, _WHERE)


def verdict(places: Places) -> Iterator[str]:
    """Between which values the energy in the bar lies with each kind of intruder, and what it is without one."""
    alike = [chain for chain in places.alike if constants(chain.base) == constants(places.base)]
    without = "".join(f", without it {chain.energy:.3g} J" for chain in alike[:1])
    parts = []
    for curve in places.curves:
        (energy,) = columns(curve, "energy")
        least, most = (
            f"{energy[k]:.3g} J with it at place {curve[k].place}" for k in (energy.argmin(), energy.argmax())
        )
        parts.append(f"of {name_of(curve[0].material)} from {least} to {most}")
    yield f"Energy in the bar with one other bead in {name_of(places.base)}: {'; '.join(parts)}{without}."


def pictures(places: Places) -> Iterator[Picture]:
    """Energy above, force below."""
    figure, upper, lower = panels(4.2, rows=2, sharex=True)
    colours: dict[Hashable, Any] = {}
    data: dict[str, Any] = {}
    for curve, mark in zip(places.curves, MARKS, strict=False):
        place, own = [chain.place for chain in curve], name_of(curve[0].material)
        energy, peak = columns(curve, "energy", "peak")
        (line,) = upper.plot(place, energy, marker=mark, markersize=3, label=f"one of {own}")
        lower.plot(place, peak, "--", marker=mark, markersize=3)
        colours[curve[0].substance] = line.get_color()
        data |= {f"place_of_{own}": place, f"{own}_energy_J": energy, f"{own}_peak_force_over_load": peak}
    for chain in places.alike:
        own, colour = name_of(chain.base), colours.get(chain.substance, GREY)
        upper.axhline(chain.energy, color=colour, linestyle=":", label=f"all {own}")
        lower.axhline(chain.peak, color=colour, linestyle=":")
        data |= {f"all_{own}_energy_J": [chain.energy], f"all_{own}_peak_force_over_load": [chain.peak]}
    label(lower, "Place of the intruder, from the struck end", "Peak transmitted force / load")
    label(upper, y="Energy in the bar (J)", ylim=(None, upper.get_ylim()[1] + 0.38 * np.ptp(upper.get_ylim())))
    upper.legend(ncols=2)
    caption = "Transmitted energy and peak force against the place of the intruder (thesis Fig. 3.7)"
    yield Picture(f"intruder_place{places.suffix}", caption, Drawing(figure, data))


def _curves(chains: Sequence[OddBead]) -> list[list[OddBead]]:
    """Chains with one kind of intruder, by place."""
    curves: dict[Hashable, list[OddBead]] = {}
    for chain in chains:
        if chain.place is not None:
            curves.setdefault(chain.substance, []).append(chain)
    return [rising(curve, lambda chain: chain.place or 0) for curve in curves.values()]
