"""Rows of spheres whose gaps cylinders between two plates open or close: a switch (thesis chapter 8)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.document.model import Table
from granwave.analysis.figures.series import COLOURS, MARKS, column_name, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.measures.signals import Array, first_peak
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.rows.beside import RowRun, errata_table
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

TITLE = "A switch: cylinders that open the gaps of a row (thesis 8)"
TEXT = (
    "27 steel spheres on an aluminium block, the first struck at 0.8 m/s, and 0 to 10 aluminium cylinders between two "
    "aluminium plates. Plates 15.975 mm apart: the cylinders open gaps behind spheres 14 to 18, and carry the wave "
    "across. Plates 16.5 mm apart: the gaps are closed, and the cylinders lie loose on the sphere before (upstream) or "
    "behind them. A sensor in a sphere reads the mean of its two contact forces. Plates rub with 0.185, the source's "
    "fit; here by Mindlin's spring and Coulomb's limit, in the second solver by the sign of the velocity: that is the "
    "difference of up to 0.5 % in these rows. Cylinders do not turn."
)
_WHERE, _SOLVER = "thesis 8", "Against a second solver (symmetric motion)."
_MICRO = 1e6
_SENSORS = (6, 21)
_STATES = ("no cylinders", "open gaps", "loose, upstream", "loose, downstream")
_SHEARED = "Mindlin's spring here, the sign of the velocity there."
_FRICTION = 0.185

#: First peak at sphere 21, N, and its time, us, of the second solver; by state, friction and number of cylinders.
_FIRST: Mapping[tuple[str, float], Mapping[int, tuple[float, float | None]]] = {
    ("no cylinders", 0.0): {0: (103.69, 300.2)},
    ("open gaps", 0.0): {2: (85.73, 323.4), 4: (79.56, 347.2), 6: (75.30, 371.0), 8: (76.22, 394.6),
                         10: (74.33, 418.2)},
    ("open gaps", _FRICTION): {2: (66.72, 327.8), 4: (47.04, 356.2), 6: (34.29, 383.2), 8: (26.46, 414.6),
                               10: (19.81, 444.2)},
    ("loose, upstream", 0.0): {2: (87.77, None), 4: (74.19, None), 6: (62.58, None), 8: (52.69, None),
                               10: (44.29, None)},
    ("loose, upstream", _FRICTION): {2: (86.40, None), 4: (71.93, None), 6: (59.73, None), 8: (49.50, None),
                                     10: (40.95, None)},
    ("loose, downstream", 0.0): dict.fromkeys((2, 4, 6, 8, 10), (103.69, None)),
    ("loose, downstream", _FRICTION): dict.fromkeys((2, 4, 6, 8, 10), (103.69, None)),
}  # fmt: skip
_LARGEST = {2: 67.57, 4: 59.34, 6: 42.54, 8: 37.01, 10: 26.92}  # until 0.8 ms, open gaps, friction 0.185, N
#: Axis that the source's curves do not leave, N, by number of cylinders (open gaps, friction 0.185), and its figure.
_AXES = {0: (120.0, "8.6"), 2: (70.0, "8.7a"), 4: (60.0, "8.7b"), 8: (30.0, "8.8b"), 10: (30.0, "8.8c")}
_AXIS_OF_FALLS = 120.0  # N, of Fig. 8.4
_MASS = 3.0  # g, of a sphere: about
_DROPS = {0.907766: ("42 mm", 120.7), 0.804649: ("33 mm", 104.4)}  # m/s: height of the fall, N
_AT_REST, _REST_OF = 13.12, 10  # um, sphere
_SPHERE, _CYLINDER, _SPEED = 9.5e-3, 5.14e-3, 0.8
_HEIGHT, _NEAR_HEIGHT = 15.975e-3, 1e-6  # m: distance of the plates that open the gaps
_CONTACT, _CONTACT_FORCE = 13, 146.6  # a contact far from both ends, and the wave's force there, N
_CLOSED = 16.279  # mm: distance of the plates at which all just touches

ERRATA = (
    ("8.2, 8.3", "k u max(u, 0)", "k max(u, 0), by its dimension; and the sign of the axial velocity, not of w"),
    ("8.3, text", "uc, wc axial, lateral", "uc is lateral, wc axial"),
    (
        "8.4, text, and Fig. 8.9",
        "first state, tilted downward: cylinders on the sphere downstream, decays",
        "exchanged: cylinders on the sphere upstream take from the wave (as the caption of 8.10 says), those "
        "downstream do nothing (rows above)",
    ),
    ("H0", "not given", "16.279 mm; 15.95 to 16 mm opens the gaps, 16.5 mm closes them: consistent"),
)


class SwitchRun(RowRun):
    """A finished run of a row on a block, with cylinders beside some of its gaps."""

    @cached_property
    def state(self) -> str:
        """One of the states."""
        if not self.n_cylinders:
            return _STATES[0]
        spheres, cylinders = self.sphere_places, self.cylinder_places
        gap = np.searchsorted(spheres, cylinders) - 1
        to_previous, to_next = cylinders - spheres[gap], spheres[gap + 1] - cylinders
        if np.allclose(to_previous, to_next, rtol=1e-3):
            return _STATES[1]
        return _STATES[2] if (to_previous < to_next).all() else _STATES[3]

    @cached_property
    def _probes(self) -> dict[str, Array]:
        with Result(self.directory) as result:
            names = [f"contact_{i}_{j}_force" for n in _SENSORS for i, j in ((n - 1, n), (n, n + 1))]
            return {name: result[f"probes/{name}"] for name in ("time", *names)}

    def sensor(self, sphere: int) -> tuple[Array, Array]:
        """Instants, s, and the mean of the two contact forces of a sphere, N."""
        before, behind = (
            self._probes[f"contact_{i}_{j}_force"] for i, j in ((sphere - 1, sphere), (sphere, sphere + 1))
        )
        return self._probes["time"], (before + behind) / 2

    @property
    def first(self) -> tuple[float, float]:
        """Time, s, and height, N, of the first peak at sphere 21."""
        return first_peak(*self.sensor(_SENSORS[1]), floor=0.05)

    @property
    def largest(self) -> float:
        """Largest force at sphere 21, N."""
        return float(self.sensor(_SENSORS[1])[1].max())

    @property
    def is_source(self) -> bool:
        """True for the row of the source."""
        case = self.case
        return (
            self.n_spheres == 27
            and math.isclose(case.packing.diameter, _SPHERE)
            and case.contact.law == "hertz"
            and (not self.n_cylinders or math.isclose(self.cylinder_diameter, _CYLINDER))
        )

    @property
    def height(self) -> float:
        """Distance of the plates, m."""
        return 2 * float(self.cylinder_across.max()) + self.cylinder_diameter

    @cached_property
    def variant(self) -> str:
        """Difference from the row of the source; empty for this row."""
        if not self.n_cylinders:
            return ""
        found = []
        if not math.isclose(self.cylinder_length, _SPHERE):
            found.append(f"cylinders {1e3 * self.cylinder_length:g} mm long")
        if self.case.boundary.sides_material is None:
            found.append("rigid plates")
        if self.state == _STATES[1] and abs(self.height - _HEIGHT) > _NEAR_HEIGHT:
            found.append(f"plates {1e3 * self.height:.4g} mm apart")
        return ", ".join(found)

    @property
    def loose(self) -> tuple[float, float]:
        """Place of the first cylinder: distance along the row from the nearer sphere, and gap to the other one, m."""
        z, across = float(self.cylinder_places[0]), float(self.cylinder_across[0])
        apart = np.sort(np.abs(self.sphere_places - z))
        return float(apart[0]), float(np.hypot(apart[1], across)) - (_SPHERE + self.cylinder_diameter) / 2

    @cached_property
    def at_rest(self) -> float:
        """Displacement of sphere 10 at the end, m; NaN if it has no probe."""
        with Result(self.directory) as result:
            name = f"probes/sphere_{_REST_OF}_uz"
            return float(result[name][-1]) if name in result else math.nan


@dataclasses.dataclass(frozen=True, eq=False)
class Group:
    """Rows with and without cylinders."""

    runs: tuple[SwitchRun, ...]

    def of(self, state: str, friction: float, *, law: str = "hertz", velocity: float = _SPEED) -> list[SwitchRun]:
        """Runs of a state, by the number of cylinders."""
        found = {run.n_cylinders: run for run in self.runs
                 if run.state == state and math.isclose(run.friction, friction, abs_tol=1e-12) and run.n_spheres == 27
                 and run.case.contact.law == law and math.isclose(run.case.load.velocity, velocity)
                 and not run.variant}  # fmt: skip
        return [found[n] for n in sorted(found)]


def select(runs: Sequence[FinishedRun]) -> list[Group]:
    """One group of all rows of the switch."""
    found = [run.seen_as(SwitchRun) for run in runs if _suits(run)]
    return [Group(tuple(found))] if any(run.n_cylinders for run in found) else []


def _suits(run: FinishedRun) -> bool:
    probed = {probe.contact for probe in run.case.output.probes}
    wanted = {(n + k - 1, n + k) for n in _SENSORS for k in (0, 1)}
    return wanted <= probed and run.case.load.kind == "impact" and run.case.precompression is None


def rows(group: Group) -> Iterator[Row]:
    """Peaks and arrivals of every state, the drop test, and rows with yielding contacts."""
    for (state, friction), known in _FIRST.items():
        for run in group.of(state, friction):
            yield from _rows_of_run(run, known.get(run.n_cylinders) if run.is_source else None)
    for run in group.of("open gaps", _FRICTION):
        theory = _LARGEST.get(run.n_cylinders) if run.is_source else None
        yield _checked(f"Largest force at sphere 21, {_label(run)}", "N", run.largest, theory, _SHEARED)
    yield from _rows_of_falls(group)
    yield from _rows_of_geometry(group)
    yield from _rows_of_variants(group)
    yield from _rows_with_yield(group)


def _label(run: SwitchRun) -> str:
    friction = f", friction {run.friction:g}" if run.n_cylinders else ""
    return f"{run.state}, {run.n_cylinders} cylinders{friction}" if run.n_cylinders else run.state


def _checked(quantity: str, unit: str, ours: float, theory: float | None, remark: str = "") -> Row:
    text = f"{_SOLVER} {remark}".strip() if theory is not None else remark
    return Row(quantity, unit, None, ours, _WHERE, text, theory, verification=theory is not None)


def _rows_of_run(run: SwitchRun, known: tuple[float, float | None] | None) -> Iterator[Row]:
    time, force = run.first
    peak, arrival = known or (None, None)
    remark = _SHEARED if run.friction else ""
    if known and ((run.state == "open gaps" and run.friction == _FRICTION) or not run.n_cylinders):
        end, figure = _AXES.get(run.n_cylinders, (None, ""))
        if end:
            yield Row(f"First peak at sphere 21, {_label(run)}, at most", "N", end, force, f"thesis Fig. {figure}",
                      "By the end of the axis.", bound=True)  # fmt: skip
    yield _checked(f"First peak at sphere 21, {_label(run)}", "N", force, peak, remark)
    if arrival is not None:
        yield _checked(f"Its time, {_label(run)}", "us", _MICRO * time, arrival)
    if not run.n_cylinders:
        _, at_first = first_peak(*run.sensor(_SENSORS[0]), floor=0.05)
        theory = 103.71 if run.is_source else None
        yield _checked(f"First peak at sphere 6, {_label(run)}", "N", at_first, theory)
        name = f"Force of contact {_CONTACT} in the wave, {_label(run)}"
        remark = "A sensor's mean of two contacts is less."
        yield _checked(name, "N", float(run.peaks[_CONTACT - 1]), _CONTACT_FORCE if run.is_source else None, remark)


def _rows_of_falls(group: Group) -> Iterator[Row]:
    for velocity, (height, theory) in _DROPS.items():
        for run in group.of("no cylinders", 0.0, velocity=velocity):
            name = f"Peak at sphere 6 of a sphere that fell {height} ({velocity:.3f} m/s)"
            peak = first_peak(*run.sensor(_SENSORS[0]), floor=0.05)[1]
            yield _checked(name, "N", peak, theory)
            yield Row(f"{name}, at most", "N", _AXIS_OF_FALLS, peak, "thesis Fig. 8.4",
                      "By the end of the axis. Ours falls freely, the source's along rails.", bound=True)  # fmt: skip


def _rows_of_geometry(group: Group) -> Iterator[Row]:
    for run in group.runs:
        if run.n_spheres > 27 and not run.n_cylinders:
            remark = (
                "The source says about 13. The wave itself moves spheres by 13.24 um; those near the struck one less."
            )
            yield Row("Displacement of sphere 10 in a long row, at rest again", "um", 13.0, _MICRO * run.at_rest,
                      _WHERE, remark, _AT_REST)  # fmt: skip
    for run in group.of("no cylinders", 0.0):
        yield Row("Mass of a sphere", "g", _MASS, 1e3 * run.case.sphere_mass, "thesis 8.4", "The source: around 3 g.")
    if loose := [run.first[1] for run in group.of("loose, downstream", 0.0)]:
        yield Row("First peak at sphere 21, loose, downstream: spread over the numbers of cylinders", "N", 0.0,
                  max(loose) - min(loose), "thesis 8.4, Fig. 8.10b", "The source: independent of it.")  # fmt: skip
    opened = {round(run.height, 6): run for run in group.runs if run.state == "open gaps" and run.is_source}
    for run in (opened[height] for height in sorted(opened)):
        width = float(np.diff(run.sphere_places).max() - _SPHERE)
        formula = math.sqrt((_SPHERE + _CYLINDER) ** 2 - (run.height - _CYLINDER) ** 2) - _SPHERE
        yield Row(f"Width of the open gaps, plates {1e3 * run.height:.5g} mm apart", "mm", None, 1e3 * width,
                  "thesis 8.1", "Formula 8.1, which is right.", 1e3 * formula, verification=True)  # fmt: skip
    for run in group.of("loose, upstream", 0.0)[:1]:
        touching, across = (_SPHERE + run.cylinder_diameter) / 2, (run.height - run.cylinder_diameter) / 2
        along = math.sqrt(touching**2 - across**2)
        formulas = (along, math.hypot(_SPHERE - along, across) - touching)
        names = ("Distance of a loose cylinder from its sphere, along the row", "Gap of it to the other sphere")
        for what, ours, theory in zip(names, run.loose, formulas, strict=True):
            yield Row(f"{what}, plates 16.5 mm apart", "mm", None, 1e3 * ours, "thesis 8.4", "By its geometry.",
                      1e3 * theory, verification=True)  # fmt: skip
        closed = math.sqrt((_SPHERE + run.cylinder_diameter) ** 2 - _SPHERE**2) + run.cylinder_diameter
        yield Row("Distance H0 of the plates at which all just touches", "mm", None, 1e3 * closed, "thesis 8.1",
                  "From the packing's diameters; not given in the source.", _CLOSED, verification=True)  # fmt: skip


def _rows_of_variants(group: Group) -> Iterator[Row]:
    """First peaks with what the source does not state taken otherwise."""
    for run in group.runs:
        if not run.variant or run.case.contact.law != "hertz":
            continue
        twin = [one for one in group.of(run.state, run.friction) if one.n_cylinders == run.n_cylinders]
        name = f"First peak at sphere 21, {_label(run)}, {run.variant}"
        yield Row(name, "N", None, run.first[1], _WHERE, "Not stated in the source.")
        if twin:
            ratio = run.first[1] / twin[0].first[1]
            yield Row(f"The same over that of the other rows, {_label(run)}, {run.variant}", "", None, ratio, _WHERE,
                      "Those: cylinders 9.5 mm long, plates of aluminium, 15.975 mm apart.")  # fmt: skip


def _rows_with_yield(group: Group) -> Iterator[Row]:
    """Peaks with yielding contacts over those of elastic ones."""
    for law in sorted({run.case.contact.law for run in group.runs} - {"hertz"}):
        for velocity in sorted({run.case.load.velocity for run in group.runs}):
            elastic = {run.n_cylinders: run for run in group.of("open gaps", 0.0, velocity=velocity)}
            for run in group.of("open gaps", 0.0, law=law, velocity=velocity):
                name = f"{run.n_cylinders} cylinders, open gaps, {law}, {velocity:g} m/s"
                yield Row(f"First peak at sphere 21, {name}", "N", None, run.first[1], "not in the source")
                if run.n_cylinders in elastic:
                    ratio = run.first[1] / elastic[run.n_cylinders].first[1]
                    yield Row(f"The same over that of elastic contacts, {name}", "", None, ratio, "not in the source")


def tables(group: Group) -> Iterator[Table]:
    """Errata of the source."""
    yield errata_table("Errata of the source, chapter 8", ERRATA)


def verdict(group: Group) -> Iterator[str]:
    """Statements of the source that hold."""
    rubbed, smooth = group.of("open gaps", _FRICTION), group.of("open gaps", 0.0)
    if len(rubbed) > 1 and len(smooth) > 1:
        yield (
            f"Open gaps with friction: the first peak falls from {rubbed[0].first[1]:.1f} N ({rubbed[0].n_cylinders} "
            f"cylinders) to {rubbed[-1].first[1]:.1f} N ({rubbed[-1].n_cylinders}), without it to "
            f"{smooth[-1].first[1]:.1f} N only: the source's fit of the friction is what makes its decay."
        )
    loose = [run.first[1] for f in (0.0, _FRICTION) for run in group.of("loose, downstream", f)]
    if loose:
        yield (
            f"Loose cylinders downstream change nothing ({min(loose):.2f} to {max(loose):.2f} N, whatever their "
            "number); upstream each pair takes its share. The source has the two states exchanged."
        )


def pictures(group: Group) -> Iterator[Picture]:
    """First peak against the number of cylinders, and forces at sphere 21."""
    figure, left, right = panels(2.8, 2)
    data: dict[str, Array] = {}
    shown = [(state, friction) for state, friction in _FIRST if state != "no cylinders"]
    none = group.of("no cylinders", 0.0)
    for (state, friction), colour, mark in zip(shown, COLOURS, MARKS * 2, strict=False):
        runs = [*none, *group.of(state, friction)]
        if len(runs) <= len(none):
            continue
        n, peak = np.array([run.n_cylinders for run in runs]), np.array([run.first[1] for run in runs])
        label = f"{state}, friction {friction:g}"
        left.plot(n, peak, mark + ("--" if friction else "-"), color=colour, markersize=3.5, label=label)
        name = column_name(label)
        data |= {f"{name}_n": n.astype(float), f"{name}_N": peak}
    for run, colour in zip([*none, *group.of("open gaps", _FRICTION)], COLOURS, strict=False):
        time, force = run.sensor(_SENSORS[1])
        right.plot(1e3 * time, force, color=colour, label=f"{run.n_cylinders} cylinders")
        data |= {f"open_{run.n_cylinders}_time_s": time, f"open_{run.n_cylinders}_N": force}
    left.set(xlabel="Cylinders", ylabel="First peak at sphere 21 (N)", ylim=(0, None))
    right.set(xlabel="Time (ms)", ylabel="Force at sphere 21 (N)", ylim=(0, None))
    for axes in (left, right):
        if axes.lines:
            axes.legend(fontsize=6)
    caption = "First peak behind the cylinders, and forces there with open gaps and friction (source Figs 8.6 to 8.10)"
    yield Picture("_peaks", caption, Drawing(figure, data))
