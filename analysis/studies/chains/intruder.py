"""A bead of another kind in a chain that ends on an elastic bar (thesis 3.2.3, 3.2.4).

Transmitted energy is what the bar holds at the end of the run, strain and kinetic; transmitted force is the largest
contact force on the bar, which is that of a section of a bar in which nothing comes back. A bead of mass m in contacts
of slope k ~ sigma_y R* answers in tau* = D sqrt(rho/sigma_y) if R* goes with its own radius; beside beads of another
radius it does so less, and sqrt(m/sigma_y) ~ R^1.5 is closer.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Hashable, Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing, new_figure
from granwave.analysis.studies.chains.bar import impedance
from granwave.analysis.studies.chains.runs import ChainRun, by
from granwave.analysis.studies.study import Picture, Row, Study
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.packing.assembly import assemble

Array = NDArray[np.float64]
Substance = tuple[float, float, float, float | None]

_COLOURS = (ORANGE, BLUE, GREEN, PURPLE, SKY)
_MARKS = "os^Dv"
_FEWEST = 3  # runs of a curve
_RATIO = 3.0  # of the normalised times at which the collapse is judged
_LAST, _SETTLED = 0.05, 1e-3  # of the run, in which the energy in the bar changes by less than this share of it
_SLIGHT = 0.1  # change of transmitted energy
_MICRO, _KILO = 1e6, 1e-3
_CAPTION_PLACE = "Transmitted energy and peak force against the place of the intruder (thesis Fig. 3.7)"
_CAPTION_PROPERTY = "Transmitted energy against the properties of the intruder (thesis Fig. 3.8)"
_BEYOND = (
    "{n} of {all} runs press contacts beyond 0.2 R*, where the fit of the contact law ends: it is extrapolated there, "
    "as it is in the source."
)


@dataclasses.dataclass(frozen=True, eq=False)
class _Chain:
    """A chain on a bar with at most one odd bead.

    Attributes
    ----------
    place
        Of the odd bead, from the struck end; None in a chain of like beads.
    material, diameter
        Of the odd bead, or of all.
    """

    run: ChainRun
    place: int | None
    material: Material
    diameter: float

    @property
    def energy(self) -> float:
        """Transmitted, J."""
        return float(self.run.transmitted or 0.0)

    @property
    def peak(self) -> float:
        """Largest force on the bar over that of the load."""
        return float(self.run.summary["wall_peak_force_N"]) / self.run.load.largest

    @property
    def base(self) -> Material:
        """Of the other beads."""
        return self.run.case.material

    @property
    def substance(self) -> Hashable:
        """Constants and size of the odd bead."""
        return _constants(self.material), self.diameter

    @property
    def unfinished(self) -> bool:
        """The energy in the bar still changed at the end of the run."""
        energy = self.run.array("energy/bar")
        last = energy[-max(2, int(_LAST * len(energy))) :]
        return bool(np.ptp(last) > _SETTLED * energy[-1])


def intruder(runs: Sequence[ChainRun]) -> Iterator[Study]:
    """Chains under a force, on a bar, with at most one odd bead: by its place, and by its properties."""
    lines: dict[Hashable, list[_Chain]] = {}
    for run in runs:
        chain = _chain(run)
        if chain is not None:
            lines.setdefault((_line(run), _constants(chain.base)), []).append(chain)
    everything = [chain for chains in lines.values() for chain in chains]
    for n, chains in enumerate(lines.values()):
        suffix = f"_{n + 1}" if n else ""
        yield from _by_place(
            chains, [chain for chain in everything if _line(chain.run) == _line(chains[0].run)], suffix
        )
        yield from _by_property(chains, suffix)


# ---------------------------------------------------------------------- by place


def _by_place(chains: Sequence[_Chain], others: Sequence[_Chain], suffix: str) -> Iterator[Study]:
    """Chains of one material but for the intruder; others under the same load, on the same bar, for comparison."""
    curves = [curve for curve in _curves(chains) if len(curve) >= _FEWEST]
    if not curves:
        return
    base = chains[0].base
    alike = _homogeneous(others, [base, *(curve[0].material for curve in curves)])
    reference = next((chain for chain in alike if _constants(chain.base) == _constants(base)), None)
    rows = [row for chain in alike for row in _rows_of_alike(chain)]
    rows += [row for curve in curves for row in _rows_of_curve(curve, reference)]
    load, n = chains[0].run.load, chains[0].run.assembly.lattice.n_spheres
    used = [*alike, *(chain for curve in curves for chain in curve)]
    yield Study(
        f"intruder-place{suffix}",
        f"Intruder in {_name(base)}, by place",
        f"{n - 1} beads of {_name(base)} and one of another kind; {load.shape} of {load.largest:g} N for "
        f"{load.lasts * _MICRO:g} µs on the first. " + _remarks(used),
        tuple(rows),
        (Picture(f"intruder_place{suffix}", _CAPTION_PLACE, _draw_places(curves, alike)),),
    )


def _curves(chains: Sequence[_Chain]) -> list[list[_Chain]]:
    """Chains with one kind of intruder, by place."""
    curves: dict[Hashable, dict[int, _Chain]] = {}
    for chain in chains:
        if chain.place is not None:
            curves.setdefault(chain.substance, {}).setdefault(chain.place, chain)
    return [[curve[place] for place in sorted(curve)] for curve in curves.values()]


def _homogeneous(chains: Sequence[_Chain], materials: Sequence[Material]) -> list[_Chain]:
    """Chains of like beads of given materials."""
    alike = {_constants(chain.base): chain for chain in reversed(chains) if chain.place is None}
    wanted = dict.fromkeys(_constants(material) for material in materials)
    return [alike[constants] for constants in wanted if constants in alike]


def _rows_of_alike(chain: _Chain) -> list[Row]:
    name, where = _name(chain.base), "thesis Fig. 3.7"
    return [
        Row(f"Transmitted energy, all {name}", "J", None, chain.energy, where),
        Row(f"Peak transmitted force over the load, all {name}", "", None, chain.peak, where),
    ]


def _rows_of_curve(curve: Sequence[_Chain], reference: _Chain | None) -> list[Row]:
    name, where = _name(curve[0].material), "thesis Fig. 3.7"
    quantities: list[tuple[str, str, Callable[[_Chain], float]]] = [
        ("Transmitted energy", "J", lambda chain: chain.energy),
        ("Peak transmitted force over the load", "", lambda chain: chain.peak),
    ]
    rows = []
    for what, unit, value in quantities:
        least, most = min(curve, key=value), max(curve, key=value)
        rows.append(Row(f"{what}, {name}: least, at place {least.place}", unit, None, value(least), where))
        rows.append(Row(f"{what}, {name}: most, at place {most.place}", unit, None, value(most), where))
        if reference is not None:
            change = max(abs(value(chain) / value(reference) - 1) for chain in curve)
            rows.append(
                Row(f"{what}, {name}: largest change from all {_name(reference.base)}", "", None, change, where)
            )
    return rows


def _draw_places(curves: Sequence[Sequence[_Chain]], alike: Sequence[_Chain]) -> Drawing:
    figure = new_figure(4.2)
    upper, lower = figure.subplots(2, 1, sharex=True)
    colours = {curve[0].substance: colour for curve, colour in zip(curves, _COLOURS, strict=False)}
    columns: dict[str, Any] = {}
    for curve, mark in zip(curves, _MARKS, strict=False):
        place, name = [chain.place for chain in curve], _name(curve[0].material)
        style: dict[str, Any] = {"color": colours[curve[0].substance], "marker": mark, "markersize": 3}
        upper.plot(place, [chain.energy for chain in curve], label=f"one of {name}", **style)
        lower.plot(place, [chain.peak for chain in curve], linestyle="--", **style)
        columns |= {
            f"place_of_{name}": place,
            f"{name}_energy_J": [chain.energy for chain in curve],
            f"{name}_peak_force_over_load": [chain.peak for chain in curve],
        }
    for chain in alike:
        name, colour = _name(chain.base), colours.get(chain.substance, GREY)
        upper.axhline(chain.energy, color=colour, linestyle=":", linewidth=1.0, label=f"all {name}")
        lower.axhline(chain.peak, color=colour, linestyle=":", linewidth=1.0)
        columns |= {f"all_{name}_energy_J": [chain.energy], f"all_{name}_peak_force_over_load": [chain.peak]}
    upper.set_ylabel("Energy in the bar (J)")
    lower.set_ylabel("Peak transmitted force / load")
    lower.set_xlabel("Place of the intruder, from the struck end")
    lower.xaxis.set_major_locator(MaxNLocator(integer=True))
    upper.set_ylim(top=upper.get_ylim()[1] + 0.38 * np.ptp(upper.get_ylim()))
    upper.legend(ncols=2, fontsize=7)
    return Drawing(figure, columns)


# ---------------------------------------------------------------------- by property


@dataclasses.dataclass(frozen=True)
class _Property:
    """What of the intruder is varied.

    Attributes
    ----------
    value
        Of a chain.
    to_time, to_mass
        Powers of the ratio in tau* = D sqrt(rho/sigma_y), and in sqrt(m/sigma_y).
    """

    name: str
    value: Callable[[_Chain], float]
    to_time: float
    to_mass: float


_PROPERTIES = (
    _Property("yield strength", lambda chain: chain.material.yield_strength or math.inf, -0.5, -0.5),
    _Property("density", lambda chain: chain.material.density, 0.5, 0.5),
    _Property("radius", lambda chain: chain.diameter, 1.0, 1.5),
    _Property("modulus", lambda chain: chain.material.youngs_modulus, 0.0, 0.0),
)


def _by_property(chains: Sequence[_Chain], suffix: str) -> Iterator[Study]:
    base = next((chain for chain in chains if chain.place is None), None)
    if base is None:
        return
    for place in sorted({chain.place for chain in chains if chain.place is not None}):
        there = [chain for chain in chains if chain.place == place]
        curves = {one: _varied(one, base, there) for one in _PROPERTIES}
        curves = {one: curve for one, curve in curves.items() if len(curve) >= _FEWEST}
        if not curves:
            continue
        yield Study(
            f"intruder-properties-{place}{suffix}",
            f"Intruder in {_name(base.base)} at place {place}, by its properties",
            f"{base.run.assembly.lattice.n_spheres} beads of {_name(base.base)}; one property of that at place {place} "
            "differs. Ratios e_T/e_0T are to the chain of like beads. "
            + _remarks([chain for curve in curves.values() for chain in curve]),
            tuple(_rows_of_properties(curves, base)),
            (Picture(f"intruder_properties_{place}{suffix}", _CAPTION_PROPERTY, _draw_properties(curves, base)),),
        )


def _varied(one: _Property, base: _Chain, chains: Sequence[_Chain]) -> list[_Chain]:
    """Chains whose intruder differs from the rest in one property alone, and that of like beads, by that property."""
    others = [other for other in _PROPERTIES if other is not one]

    def fits(chain: _Chain) -> bool:
        same = all(math.isclose(other.value(chain), other.value(base)) for other in others)
        return same and chain.material.poisson_ratio == base.material.poisson_ratio

    values = {one.value(chain): chain for chain in [*(chain for chain in chains if fits(chain)), base]}
    return [values[value] for value in sorted(values)]


def _ratios(one: _Property, curve: Sequence[_Chain], base: _Chain) -> tuple[Array, Array]:
    """The property and the transmitted energy, over those of the chain of like beads."""
    x = np.array([one.value(chain) / one.value(base) for chain in curve])
    return x, np.array([chain.energy / base.energy for chain in curve])


def _rows_of_properties(curves: dict[_Property, list[_Chain]], base: _Chain) -> list[Row]:
    where = "thesis Fig. 3.8"
    rows = []
    for one, curve in curves.items():
        x, y = _ratios(one, curve, base)
        for ratio, energy in ((x[0], y[0]), (x[-1], y[-1])):
            remark = ""
            if one.name == "yield strength" and ratio > 1:
                remark = "The weaker bead of a contact yields: a stronger intruder changes nothing."
            if one.name == "modulus" and abs(energy - 1) < _SLIGHT:
                remark = "Hardly any effect, as the source says."
            rows.append(Row(f"e_T/e_0T at {ratio:.3g} times the {one.name}", "", None, float(energy), where, remark))
    for power, name, remark in (
        (
            "to_time",
            "D sqrt(rho/sigma_y)",
            "The contacts of a large bead keep the R* of its neighbours: no full collapse.",
        ),
        ("to_mass", "sqrt(m/sigma_y)", "For radii R^1.5 in place of R: closer."),
    ):
        there = []
        for one, curve in curves.items():
            if getattr(one, power):
                x, y = _ratios(one, curve, base)
                scaled = np.log(x) * getattr(one, power)
                order = np.argsort(scaled)
                if scaled.min() <= math.log(_RATIO) <= scaled.max():
                    there.append(float(np.interp(math.log(_RATIO), scaled[order], y[order])))
        if len(there) > 1:
            spread = max(there) - min(there)
            rows.append(Row(f"Spread of e_T/e_0T at {_RATIO:g} times {name}", "", None, spread, where, remark))
    return rows


def _draw_properties(curves: dict[_Property, list[_Chain]], base: _Chain) -> Drawing:
    figure = new_figure(2.8, 6.8)
    left, right = figure.subplots(1, 2, sharey=True)
    columns: dict[str, Any] = {}
    for (one, curve), colour, mark in zip(curves.items(), _COLOURS, _MARKS, strict=False):
        x, y = _ratios(one, curve, base)
        style: dict[str, Any] = {"color": colour, "marker": mark, "markersize": 4, "label": one.name}
        name = one.name.replace(" ", "_")
        columns |= {f"{name}_ratio": x, f"energy_ratio_by_{name}": y}
        _curve(left, x ** (one.to_time or 1.0), y, faint=not one.to_time, **style)
        if one.to_mass:
            _curve(right, x**one.to_mass, y, **style)
    for axes in (left, right):
        axes.set_xscale("log")
        axes.axvline(1, color="black", linewidth=0.5)
    left.set_ylabel("Transmitted energy $e_T/e_{0T}$")
    left.set_xlabel(r"$\tau^*_i/\tau^*_0$,  $\tau^* = D\sqrt{\rho/\sigma_y}$;  modulus: $E_i/E_0$")
    right.set_xlabel(r"$\sqrt{m_i\sigma_0/(m_0\sigma_i)}$")
    left.legend(loc="lower left")
    return Drawing(figure, columns)


def _curve(axes: Axes, x: Array, y: Array, *, faint: bool = False, **style: Any) -> None:
    order = np.argsort(x)
    axes.plot(x[order], y[order], linestyle=":" if faint else "-", **style)


# ---------------------------------------------------------------------- split-Hopkinson


# ---------------------------------------------------------------------- which run is what


def _chain(run: ChainRun) -> _Chain | None:
    """A run as a chain on a bar, under a force, with at most one odd bead; None if it is something else."""
    case, assembly = run.case, run.assembly
    odd = {*assembly.diameters, *assembly.materials}
    if case.bar is None or case.incident_bar is not None or assembly.strikers or case.load.kind != "force":
        return None
    if len(odd) > 1 or case.load.shape == "harmonic":
        return None
    place = next(iter(odd), None)
    bead = place or 1
    return _Chain(run, place, assembly.material_of(bead), assembly.diameter_of(bead))


def _line(run: ChainRun) -> Hashable:
    """What the chains of a study share, whatever their beads are of."""
    case = run.case
    assert case.bar is not None
    (bar,) = assemble(case).bars
    return case.packing, case.load, case.contact, case.bar.area, impedance(bar)


def _constants(material: Material) -> Substance:
    return material.youngs_modulus, material.poisson_ratio, material.density, material.yield_strength


def _name(material: Material) -> str:
    return material.name or f"E {material.youngs_modulus:.3g} Pa"


def _remarks(chains: Sequence[_Chain]) -> str:
    """What readers must know of the runs."""
    unique = by([chain.run for chain in chains], lambda run: float(hash(run.directory)))
    text = []
    beyond = sum(bool(run.summary.get("contacts_beyond_law")) for run in unique)
    if beyond:
        text.append(_BEYOND.format(n=beyond, all=len(unique)))
    unfinished = len({chain.run.directory for chain in chains if chain.unfinished})
    if unfinished:
        text.append(f"In {unfinished} of the runs the bar was still given energy at the end: let them run longer.")
    return " ".join(text)
