"""Rows of spheres with cylinders that are pressed on them by two walls: a filter of waves (thesis 7.1)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.document.model import Table
from granwave.analysis.figures.series import COLOURS, MARKS, column_name, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.rows.beside import RowRun, errata_table
from granwave.analysis.studies.rows.filter_values import (
    APPROACHED,
    AXIS,
    COLOURS_END,
    DECAYS,
    DENSITY,
    DRAWN,
    ERRATA,
    LARGEST,
    PEAKS,
    PEAKS_OF_PRINTED_DENSITY,
    PRINTED_DENSITY,
    RATIO,
    STATIC,
    VALLEYS,
)
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.contact.law import pair_contact

TITLE = "A filter: cylinders pressed on the gaps of a row (thesis 7.1)"
TEXT = (
    "A row of steel spheres, with an aluminium cylinder on either side of every gap and a rigid wall on either side of "
    "these; sphere 20 is struck at 1 m/s. gamma and eta are the diameter and the length of the cylinders over the "
    "diameter of the spheres, a the approach of the walls over it. Contact n is that of spheres n and n + 1. The decay "
    "is that of ln(peak force) per contact, by a line through contacts 71 to 201 (61 to 111 of the short rows of the "
    "map). Contacts with the walls follow the law of a half-space, all others Hertz's. The second solver is one of "
    "symmetric motion; it counts contacts from 0."
)
_WHERE, _SOLVER = "thesis 7.1", "Against a second solver (symmetric motion)."
_FIT, _FIT_OF_SHORT, _LONG = (71, 201), (61, 111), 206  # contacts; spheres of a row that is long enough for the first
_MILLI, _MICRO, _KILO = 1e-3, 1e6, 1e3
_SPHERE = 9.525e-3
_PROBED, _NEIGHBOURS, _FOOT = 121, 60, 0.01  # contact; contacts on either side for the speed; of the peak
_NEAR = 1e-6  # relative, of gamma, eta and a
_RATTLES, _LITTLE = 1.0, 0.25  # m/s: rows that yield and are struck no faster; peaks over the force of the walls
_RATTLING = "Grains that rattle behind the front decide: with other timesteps half to twice as much."


class FilterRun(RowRun):
    """A finished run of a row with cylinders beside all gaps."""

    @property
    def gamma(self) -> float:
        """Diameter of the cylinders over that of the spheres."""
        return round(self.cylinder_diameter / self.case.packing.diameter, 9)

    @property
    def eta(self) -> float:
        """Length of the cylinders over the diameter of the spheres."""
        return round(self.cylinder_length / self.case.packing.diameter, 9)

    @property
    def approach(self) -> float:
        """Approach a of the walls to each other over the diameter of the spheres."""
        stage = self.case.precompression
        moved = 0.0 if stage is None else stage.moves.get("x", 0.0)
        return round(2 * moved / self.case.packing.diameter, 12)

    @property
    def density(self) -> float:
        """Density of the cylinders, kg/m^3."""
        return self.assembly.material_of(self.n_spheres + 1).density

    @property
    def velocity(self) -> float:
        """Velocity of the struck sphere, m/s."""
        return self.case.load.velocity

    @property
    def law(self) -> str:
        """Contact law."""
        return self.case.contact.law

    @cached_property
    def decay(self) -> float:
        """Decay of ln(peak force) per contact; NaN where the wave did not come that far."""
        first, last = _FIT if self.n_spheres > _LONG else _FIT_OF_SHORT
        contacts, peak = np.arange(first, last + 1), self.peaks[first - 1 : last]
        if len(peak) < len(contacts) or not (peak > 0).all():
            return math.nan
        return float(-np.polyfit(contacts, np.log(peak), 1)[0])

    @cached_property
    def span(self) -> float:
        """Length of the wave at a probed contact, by the time above 1 % of its peak, in spheres; NaN without probe."""
        name = f"probes/contact_{_PROBED}_{_PROBED + 1}_force"
        with Result(self.directory) as result:
            if name not in result:
                return math.nan
            time, force = result["probes/time"], result[name]
            i, j, peak = (result[f"contacts/{one}"] for one in ("i", "j", "time_peak"))
        low, passed = np.flatnonzero(force < _FOOT * force.max()), (j == i + 1) & (np.abs(i - _PROBED) < _NEIGHBOURS)
        end = int(np.searchsorted(low, force.argmax()))
        speed = float(np.polyfit(peak[passed], i[passed], 1)[0])
        return speed * float(time[low[end]] - time[low[end - 1]])

    @property
    def is_source(self) -> bool:
        """True for the row of the source, with cylinders of its density or of what its figure says."""
        return self.is_elastic_source and math.isclose(self.density, DENSITY)

    @property
    def is_elastic_source(self) -> bool:
        """True for the row of the source, with cylinders of any density."""
        steel = self.case.material
        return (
            math.isclose(self.case.packing.diameter, _SPHERE)
            and self.law == "hertz"
            and self.velocity == 1.0
            and self.n_spheres > _LONG
            and math.isclose(self.eta, 1.0)
            and (steel.youngs_modulus, steel.poisson_ratio, steel.density) == (210e9, 0.3, 7800.0)
        )

    @cached_property
    def static(self) -> Mapping[str, float]:
        """State before the wave: wall force on a cylinder, N, its wall overlap and its lateral shift, m."""
        with Result(self.directory) as result:
            force = float(result["walls/xlo/force"][0]) / (self.n_cylinders / 2)
            moved = result.frame(0, "displacement")[self.n_spheres :, 0]
        place = self._places[self._is_cylinder, 0]
        inward = float(np.mean(-moved * np.sign(place)))
        return {"force": force, "shift": inward, "overlap": self.approach * self.case.packing.diameter / 2 - inward}

    @cached_property
    def kept(self) -> float:
        """Force on a wall at the end over that at the start: what yielding leaves of the precompression."""
        with Result(self.directory) as result:
            force = result["walls/xlo/force"]
        return float(force[-1] / force[0])

    @property
    def stiffness(self) -> float:
        """K between sphere and cylinder, N/m^1.5."""
        law = pair_contact(self.assembly, 1, self.n_spheres + 1)
        return 4 / 3 * law.effective_modulus * math.sqrt(law.effective_radius)

    def at(self, gamma: float, approach: float) -> bool:
        """Return True if the run has this gamma and a."""
        return math.isclose(self.gamma, gamma, rel_tol=_NEAR) and math.isclose(
            self.approach, approach, rel_tol=_NEAR, abs_tol=1e-12
        )


@dataclasses.dataclass(frozen=True, eq=False)
class Group:
    """Rows that differ in cylinders, walls, law and velocity."""

    runs: tuple[FilterRun, ...]

    def curves(self, *, long: bool = True) -> dict[tuple[float, float], list[FilterRun]]:
        """Elastic runs at 1 m/s by approach and eta, each in rising order of gamma."""
        found: dict[tuple[float, float], dict[float, FilterRun]] = {}
        for run in self.runs:
            alike = run.law == "hertz" and run.velocity == 1.0 and math.isclose(run.density, DENSITY)
            if alike and (run.n_spheres > _LONG) == long and math.isfinite(run.decay):
                found.setdefault((run.approach, run.eta), {})[run.gamma] = run
        return {key: [runs[gamma] for gamma in sorted(runs)] for key, runs in sorted(found.items())}


def select(runs: Sequence[FinishedRun]) -> list[Group]:
    """One group of all rows with cylinders beside every gap that sphere 20 was struck of."""
    found = [run.seen_as(FilterRun) for run in runs if run.case.load.kind == "impact" and run.case.load.index == (20,)]
    found = [run for run in found if run.n_cylinders and run.n_cylinders == 2 * (run.n_spheres - 1)]
    return [Group(tuple(found))] if found else []


def rows(group: Group) -> Iterator[Row]:
    """Static states, peaks of figure 7.4, decays of figure 7.5, the map, and rows with yielding contacts."""
    for run in _source_runs(group):
        yield from _static_rows(run)
    for known, density in ((PEAKS, DENSITY), (PEAKS_OF_PRINTED_DENSITY, PRINTED_DENSITY)):
        for (gamma, approach), (said, peaks) in known.items():
            for run in group.runs:
                if run.is_elastic_source and run.at(gamma, approach) and math.isclose(run.density, density):
                    yield from _peak_rows(run, said, peaks)
                    break
    for run in _source_runs(group):
        yield from _largest_rows(run)
        yield from _decay_rows(run)
    yield from _rows_of_span(group)
    yield from _valleys(group)
    yield from _map_rows(group)
    yield from _rows_with_yield(group)


def _source_runs(group: Group) -> list[FilterRun]:
    found = {(run.approach, run.gamma): run for run in group.runs if run.is_source}
    return [found[key] for key in sorted(found)]


def _label(run: FilterRun) -> str:
    density = "" if math.isclose(run.density, DENSITY) else f", density {run.density:g} kg/m3"
    return f"gamma {run.gamma:g}, a = {run.approach:g}{density}"


def _static_rows(run: FilterRun) -> Iterator[Row]:
    for gamma, (stiffness, force, overlap, shift) in STATIC.items():
        if not run.at(gamma, 8e-4):
            continue
        for name, unit, ours, theory in (
            ("K of sphere and cylinder", "N/m^1.5", run.stiffness, stiffness),
            ("Force of a wall on a cylinder", "N", run.static["force"], force),
            ("Overlap of wall and cylinder", "um", _MICRO * run.static["overlap"], overlap),
            ("Lateral shift of a cylinder", "um", _MICRO * run.static["shift"], shift),
        ):
            yield Row(f"{name} before the wave, {_label(run)}", unit, None, ours, _WHERE,
                      "Check value of the equations of the static state.", theory, verification=True)  # fmt: skip


def _peak_rows(run: FilterRun, said: str, peaks: Mapping[int, float]) -> Iterator[Row]:
    for contact, theory in peaks.items():
        remark = f"{_SOLVER} The source says: {said}." if said else _SOLVER
        yield Row(f"Peak force at contact {contact}, {_label(run)}", "N", None, float(run.peaks[contact - 1]),
                  "thesis Fig. 7.4", remark, theory, verification=True)  # fmt: skip


def _largest_rows(run: FilterRun) -> Iterator[Row]:
    for (gamma, approach), theory in LARGEST.items():
        if run.at(gamma, approach):
            yield Row(f"Largest force of two spheres, {_label(run)}", "N", None, float(run.peaks.max()),
                      "thesis Fig. 7.4", _SOLVER, theory, verification=True)  # fmt: skip
    if any(run.at(*key) for key in PEAKS):
        yield Row(f"Largest force of two spheres, {_label(run)}, at most", "N", AXIS, float(run.peaks.max()),
                  "thesis Fig. 7.4", "By the end of the axis.", bound=True)  # fmt: skip


def _decay_rows(run: FilterRun) -> Iterator[Row]:
    for known, where in ((DRAWN, "thesis Fig. 7.4"), (DECAYS, "thesis Fig. 7.5a"), (APPROACHED, "thesis Fig. 7.5b")):
        for (gamma, approach), decay in known.items():
            if run.at(gamma, approach):
                yield Row(f"Decay per contact, {_label(run)}", "1e-3", None, _KILO * run.decay, where,
                          f"{_SOLVER} Printed there with two digits.", decay, verification=True, digits=3)  # fmt: skip


def _rows_of_span(group: Group) -> Iterator[Row]:
    """Limits of gamma, and length of the leading wave where nothing presses."""
    for run in _source_runs(group):
        if run.at(0.9, 0.0) and math.isfinite(run.span):
            yield Row(f"Beads that the leading wave spans at contact {_PROBED}, {_label(run)}", "", 10.0, run.span,
                      _WHERE, "Where its force is above 1 % of its peak.", digits=3)  # fmt: skip
    yield Row("Smallest gamma whose cylinders reach the walls", "", 0.25, None, _WHERE,
              "Theory: sqrt(gamma^2 + 2 gamma) + gamma = 1.", 0.25)  # fmt: skip


def _valleys(group: Group) -> Iterator[Row]:
    """Gamma of the fastest decay, by a parabola through three points."""
    for (approach, eta), runs in group.curves().items():
        decay = np.array([run.decay for run in runs])
        k = int(np.argmax(decay))
        if not math.isclose(eta, 1.0) or not 0 < k < len(runs) - 1:
            continue
        gamma = np.array([run.gamma for run in runs[k - 1 : k + 2]])
        a, b, _ = np.polyfit(gamma, decay[k - 1 : k + 2], 2)
        theory = VALLEYS.get(approach)
        yield Row(f"gamma of the fastest decay, a = {approach:g}", "", None, float(-b / (2 * a)), "thesis Fig. 7.5a",
                  "It moves to larger cylinders as the walls press, as the source says.", theory,
                  verification=theory is not None, digits=2)  # fmt: skip
        source = COLOURS_END.get(approach)
        yield Row(f"Decay there, a = {approach:g}{', at most' if source else ''}", "1e-3", source,
                  _KILO * float(decay[k]), "thesis Fig. 7.2", "By the end of the colours." if source else "", digits=3,
                  bound=source is not None)  # fmt: skip


def _map_rows(group: Group) -> Iterator[Row]:
    """Decay in short rows with cylinders of several lengths."""
    for (_, eta), runs in group.curves(long=False).items():
        for run in runs:
            yield Row(f"Decay per contact, eta {eta:g}, {_label(run)}", "1e-3", None, _KILO * run.decay,
                      "thesis Figs 7.2, 7.3", "Short row, contacts 61 to 111.", digits=3)  # fmt: skip
    by_place = {(run.approach, run.eta, run.gamma): run for runs in group.curves(long=False).values() for run in runs}
    for (approach, eta, gamma), run in by_place.items():
        free = by_place.get((0.0, eta, gamma))
        if approach and free is not None:
            ratio = run.decay / free.decay
            yield Row(f"Decay over that at a = 0, within, eta {eta:g}, {_label(run)}", "", math.copysign(RATIO, ratio),
                      ratio, "thesis Fig. 7.3", "By the end of the colours. Short rows.", digits=2,
                      bound=True)  # fmt: skip


def _rows_with_yield(group: Group) -> Iterator[Row]:
    """Peaks far down the row and what is left of the precompression, with yielding contacts and elastic ones."""
    pressed = [run for run in group.runs if run.approach and run.n_spheres > _LONG]
    for run in sorted(pressed, key=lambda run: (run.gamma, run.velocity, run.law)):
        twins = [one for one in pressed if one.law == "hertz" and one.velocity == run.velocity
                 and one.at(run.gamma, run.approach) and math.isclose(one.density, run.density)]  # fmt: skip
        if run.law == "hertz" or not twins:
            continue
        name = f"{_label(run)}, {run.law}, {run.velocity:g} m/s"
        for contact in (21, 31, 61, 101):
            peak, remark = float(run.peaks[contact - 1]), f"Elastic: {twins[0].peaks[contact - 1]:.4g} N."
            share = peak / run.static["force"] if run.velocity <= _RATTLES else math.inf
            rattles = share < _LITTLE
            digits = 1 if rattles else 2 if share < 1 else 4
            yield Row(f"Peak force at contact {contact}, {name}", "N", None, peak, "not in the source",
                      f"{remark} {_RATTLING}" if rattles else remark, digits=digits)  # fmt: skip
        yield Row(f"Force of a wall after the wave over that before, {name}", "", None, run.kept, "not in the source",
                  "What the wave has left of the precompression of the whole row, and with it of the filter; elastic: "
                  f"{twins[0].kept:.3g}.", digits=3)  # fmt: skip


def tables(group: Group) -> Iterator[Table]:
    """Errata of the source."""
    yield errata_table("Errata of the source, chapter 7.1", ERRATA)


def pictures(group: Group) -> Iterator[Picture]:
    """Peaks along the row, decay against the cylinders' diameter, and the map."""
    yield from _peaks(group)
    yield from _decays(group)
    yield from _map(group)


def _peaks(group: Group) -> Iterator[Picture]:
    found = [run for gamma, approach in PEAKS for run in _source_runs(group) if run.at(gamma, approach)]
    shown = list({_label(run): run for run in found}.values())  # several scans have some of them
    if not shown:
        return
    figure, axes = panels(2.8)
    data: dict[str, Array] = {}
    for run, colour in zip(shown, COLOURS, strict=False):
        contacts = np.arange(20, 202)
        axes.semilogy(contacts, run.peaks[contacts - 1], color=colour, label=_label(run))
        data |= {"contact": contacts.astype(float), f"{column_name(_label(run))}_N": run.peaks[contacts - 1]}
    axes.set(xlabel="Contact", ylabel="Peak force (N)")
    axes.legend(fontsize=7)
    yield Picture(
        "_peaks", "Peak force along rows with cylinders between walls (source Fig. 7.4)", Drawing(figure, data)
    )


def _decays(group: Group) -> Iterator[Picture]:
    curves = {key: runs for key, runs in group.curves().items() if math.isclose(key[1], 1.0) and len(runs) > 1}
    if not curves:
        return
    figure, axes = panels(2.8)
    data: dict[str, Array] = {}
    for ((approach, _), runs), colour, mark in zip(curves.items(), COLOURS * 2, MARKS * 3, strict=False):
        gamma, decay = np.array([run.gamma for run in runs]), np.array([run.decay for run in runs])
        axes.plot(gamma, _KILO * decay, mark + "-", color=colour, markersize=3, label=f"a = {approach:g}")
        name = f"a_{approach:g}".replace(".", "_").replace("-", "m")
        data |= {f"{name}_gamma": gamma, f"{name}_decay": decay}
    axes.set(xlabel=r"Diameter of the cylinders over that of the spheres, $\gamma$", ylabel="Decay per contact (1e-3)")
    axes.legend(fontsize=7)
    caption = "Decay of the peak force per contact against the diameter of the cylinders (source Fig. 7.5)"
    yield Picture("_decay", caption, Drawing(figure, data))


def _map(group: Group) -> Iterator[Picture]:
    curves = group.curves(long=False)
    approaches = sorted({approach for approach, _ in curves})
    if not approaches:
        return
    figure, *row = panels(2.8, len(approaches), sharey=True)
    data: dict[str, Array] = {}
    for axes, approach in zip(row, approaches, strict=True):
        runs = [run for (a, _), some in curves.items() if a == approach for run in some]
        mass = np.array([run.gamma**2 * run.eta for run in runs])
        for eta, colour, mark in zip(sorted({run.eta for run in runs}), COLOURS, MARKS, strict=False):
            rows_ = [k for k, run in enumerate(runs) if run.eta == eta]
            decay = np.array([runs[k].decay for k in rows_])
            axes.plot(mass[rows_], _KILO * decay, mark + "-", color=colour, markersize=4, label=rf"$\eta$ = {eta:g}")
            name = f"a_{approach:g}_eta_{eta:g}".replace(".", "_").replace("-", "m")
            data |= {f"{name}_mass": mass[rows_], f"{name}_decay": decay}
        axes.set(xlabel=r"$\gamma^2 \eta$, as the mass of a cylinder", title=f"a = {approach:g}")
        axes.legend(fontsize=7)
    row[0].set(ylabel="Decay per contact (1e-3)")
    caption = "Decay against the mass of the cylinders, for three lengths of these: the map of source Figs 7.2, 7.3"
    yield Picture("_map", caption, Drawing(figure, data))
