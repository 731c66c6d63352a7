"""Scatter between twin sensors of a square packing: misaligned strikers and diameters within a tolerance."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.document.model import Note, Table
from granwave.analysis.figures.series import COLOURS, MARKS, legend_outside, one_panel
from granwave.analysis.figures.style import Drawing
from granwave.analysis.formatting.numbers import number, with_interval
from granwave.analysis.measures.twins import Difference, difference
from granwave.analysis.result.reader import Result
from granwave.analysis.statistics import Estimate, estimate, exactly
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.square.runs import PackingRun, packings
from granwave.analysis.studies.study import Picture, Row
from granwave.analysis.studies.tables import numeric, table_of
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.packing.disorder import is_random

TITLE = "Twin sensors in a square packing"
TEXT = (
    "Two sensors at places that symmetry makes equal, and impacts that are not ideal: the striker hits off the centre "
    "of the one at rest, the one at rest sits aside, the diameters scatter. On a tilted floor spheres lean on each "
    "other and all contacts are closed, without tilt they stay at the sites of the lattice, with gaps. Each setting "
    "has runs with seeds of their own; given are standard deviations from run to run of the time between the two peaks "
    "of acceleration, and of their ratio. The source had 15 impacts for each; it tells the tolerance of the "
    "diameters, 0.01 mm to either side, but no misalignment and no gap: the settings are ours. The delay for each per "
    "cent of the amplitude hardly depends on how large an imperfection is, and tells its kind."
)
_WHERE = "square packing, Wave Propagation Path"
_IMPACTS = 15  # of the source, at each place of sensors
_FEWEST = 4  # runs for a standard deviation
_MICRO = 1e6
_MECHANISMS = {  # what makes the scatter, by words of a setting
    "striker off centre": "The one at rest leaves to the side; the source does not tell by how much strikes miss.",
    "resting striker aside": "It touches one of two spheres first; the source does not tell the gap.",
}


@dataclasses.dataclass(frozen=True)
class Twins:
    """Two sensors alike by symmetry, and what the source gives of them.

    Attributes
    ----------
    delay, excess
        Mean and standard deviation: of the second's peak after the first's, us, and of the first's peak acceleration
        over the second's less 1, per cent.
    """

    first: str
    second: str
    chains: str
    delay: tuple[float, float]
    excess: tuple[float, float]

    @property
    def label(self) -> str:
        """``1A and 1B``."""
        return f"{self.first} and {self.second}"


TWINS = (
    Twins("1A", "1B", "central chains, in-plane", (-21.0, 68.0), (4.0, 10.0)),
    Twins("2A", "2B", "edge chains, in-plane", (-0.5, 6.5), (-7.0, 18.0)),
    Twins("3A", "3B", "central chains, out-of-plane", (25.0, 54.0), (1.0, 42.0)),
)


@dataclasses.dataclass(frozen=True)
class Sample:
    """All runs of one setting as two twin sensors see them.

    Attributes
    ----------
    setting
        What is not ideal, in words.
    found
        Of each run that the wave reached both sensors in.
    n
        Number of runs.
    random
        They differ from seed to seed.
    """

    twins: Twins
    setting: str
    found: tuple[Difference, ...]
    n: int
    random: bool

    @property
    def delay(self) -> Estimate:
        """Delay of the second sensor's peak after the first's, us."""
        return self._estimate([_MICRO * one.delay for one in self.found])

    @property
    def excess(self) -> Estimate:
        """Peak acceleration of the first sensor over that of the second, less 1, per cent."""
        return self._estimate([100 * one.excess for one in self.found])

    @property
    def arrival(self) -> Estimate:
        """Arrival of the peaks, us."""
        return self._estimate([_MICRO * one.arrival for one in self.found])

    @property
    def scattered(self) -> bool:
        """There are runs enough for a standard deviation."""
        return self.random and len(self.found) >= _FEWEST

    def _estimate(self, values: list[float]) -> Estimate:
        return estimate(values) if self.random else exactly(values[0])


def select(runs: Sequence[FinishedRun]) -> list[list[Sample]]:
    """One group of all settings of elastic square packings with twin sensors, in the order of the runs."""
    found: dict[tuple[Twins, str], list[PackingRun]] = {}
    for run in packings(runs):
        names = {sensor.name for sensor in run.case.sensor}
        if run.case.packing.kind != "square" or run.case.contact.law != "hertz":
            continue
        for twins in TWINS:
            if {twins.first, twins.second} <= names and twins.chains.endswith(f", {run.way}"):
                found.setdefault((twins, setting(run.case)), []).append(run)
    samples = [_sample(twins, words, members) for (twins, words), members in found.items()]
    return [samples] if any(one.scattered for one in samples) else []


def setting(case: Case) -> str:
    """Describe what is not ideal in a case; ``ideal`` if nothing is."""
    parts = []
    if case.packing.diameter_scatter:
        half = _MICRO * case.packing.diameter_scatter / 2
        parts.append(f"diameters ± {half:g} µm, {_place(case.packing.tilt)}")
    for striker in case.striker:
        for size, form in ((striker.offset, "{} by {}"), (striker.misalignment, "{} within {}")):
            if any(size):
                what = "striker off centre" if striker.moves else "resting striker aside"
                parts.append(form.format(what, _size(float(np.abs(size).max()))))
    return "; ".join(parts) or "ideal"


def rows(samples: Sequence[Sample]) -> Iterator[Row]:
    """Scatter of delay and excess in each setting, none of which is the source's; the means, zero by symmetry."""
    for one in samples:
        if one.scattered:
            where = f"{one.twins.label} ({one.twins.chains}): {one.setting}"
            for what, unit, source, ours in (
                ("delay", "µs", one.twins.delay[1], one.delay.deviation),
                ("peak acceleration", "%", one.twins.excess[1], one.excess.deviation),
            ):
                remark = f"The source: {source:g} {unit}, by what is not known. {_remark(one)}".strip()
                yield Row(f"Scatter of the {what}, {where}", unit, None, ours, _WHERE, remark)
    for twins in TWINS:
        if any(one.twins is twins and one.scattered for one in samples):
            where = f"{twins.label} ({twins.chains})"
            yield Row(f"Mean delay, {where}", "µs", twins.delay[0], None, _WHERE, _chance(*twins.delay), 0.0)
            quantity = f"Mean difference of the peak acceleration, {where}"
            yield Row(quantity, "%", twins.excess[0], None, _WHERE, _chance(*twins.excess), 0.0)


def verdict(samples: Sequence[Sample]) -> Iterator[str]:
    """Say how large the delay is for a scatter of the amplitude, which the size of an imperfection hardly changes."""
    for twins in TWINS:
        own = [one for one in samples if one.twins is twins and one.scattered and one.excess.deviation > 0]
        if own:
            found = "; ".join(f"{one.setting}: {number(one.delay.deviation / one.excess.deviation)}" for one in own)
            yield (
                f"{twins.label}: the source has a scatter of {twins.delay[1]:g} µs with one of {twins.excess[1]:g} %, "
                f"{number(twins.delay[1] / twins.excess[1])} µs for each per cent. Ours: {found}."
            )


def pictures(samples: Sequence[Sample]) -> Iterator[Picture]:
    """Scatter of the delay against that of the amplitude; a mechanism has its place whatever its size."""
    labels = {"xlabel": "Scatter of the peak acceleration (%)", "ylabel": "Scatter of the delay (µs)"}
    figure, axes = one_panel(3.6, **labels, xscale="log", yscale="log", width=5.2)
    shown = [one for one in samples if one.scattered and one.delay.deviation > 0 and one.excess.deviation > 0]
    settings = list(dict.fromkeys(one.setting for one in shown))
    for one in shown:
        n = settings.index(one.setting)
        mark = MARKS[TWINS.index(one.twins)]
        colour = COLOURS[n % len(COLOURS)]
        axes.plot(
            one.excess.deviation, one.delay.deviation, mark, color=colour, markersize=4,
            markerfacecolor=colour if n < len(COLOURS) else "none",
            label=one.setting if one is next(other for other in shown if other.setting == one.setting) else None,
        )  # fmt: skip
    for twins, mark in zip(TWINS, MARKS, strict=False):
        if any(one.twins is twins for one in shown):
            axes.plot(
                twins.excess[1], twins.delay[1], mark, color="black", markersize=8, markerfacecolor="none",
                label=f"source, {twins.label}",
            )  # fmt: skip
    legend_outside(figure, 2, fontsize=6)
    columns = {
        "setting": np.array([one.setting for one in shown]),
        "sensors": np.array([one.twins.label for one in shown]),
        "delay_scatter_s": np.array([one.delay.deviation / _MICRO for one in shown]),
        "peak_scatter": np.array([one.excess.deviation / 100 for one in shown]),
    }
    yield Picture("", "Scatter between twin sensors: delay against amplitude", Drawing(figure, columns))


def tables(samples: Sequence[Sample]) -> Iterator[Table | Note]:
    """All settings with means and their confidence."""
    heads = (*numeric("Sensors", "Not ideal", key=True), *numeric(
        "Runs", "Without a wave at one of both", ("Delay", "µs"), ("its scatter", "µs"), ("Peak acceleration", "%"),
        ("its scatter", "%"), ("Scatter of delay over that of acceleration", "µs/%"), ("Arrival", "µs")))  # fmt: skip
    yield table_of("Twin sensors: means with 95 % confidence, and scatter", heads, [_cells(one) for one in samples])


def _cells(one: Sample) -> tuple[object, ...]:
    delay, excess = one.delay, one.excess
    ratio = delay.deviation / excess.deviation if one.scattered and excess.deviation > 0 else None
    scatter = (delay.deviation, excess.deviation) if one.scattered else (None, None)
    means = [with_interval(value) for value in (delay, excess, one.arrival)]
    lost = one.n - len(one.found)
    return one.twins.label, one.setting, one.n, lost, means[0], scatter[0], means[1], scatter[1], ratio, means[2]


def _sample(twins: Twins, words: str, members: Sequence[PackingRun]) -> Sample:
    found = []
    for run in members:
        with Result(run.directory) as result:
            found.append(difference(result, twins.first, twins.second))
    reached = tuple(one for one in found if one is not None)
    return Sample(twins, words, reached, len(members), is_random(members[0].case))


def _chance(mean: float, scatter: float) -> str:
    errors = abs(mean) / (scatter / math.sqrt(_IMPACTS))
    return (
        f"Symmetry makes it 0; the source's is {errors:.1f} standard errors of its {_IMPACTS} impacts from it: chance."
    )


def _remark(one: Sample) -> str:
    """Say what makes the scatter in a setting, and which runs do not count."""
    said = [words for key, words in _MECHANISMS.items() if key in one.setting]
    if "leaning" in one.setting:
        four = "the one at rest sits on three of its four spheres and leaves a gap to the last"
        said.append(f"Contacts are closed; {four}." if "out-of-plane" in one.twins.chains else "Contacts are closed.")
    if "at the sites" in one.setting:
        said.append(f"Gaps delay the wave, which arrives after {number(one.arrival.mean)} µs.")
    lost = one.n - len(one.found)
    return " ".join(
        [*said, *([f"In {lost} of {one.n} runs the wave misses one of both; they do not count."] * (lost > 0))]
    )


def _place(tilt: tuple[int, int] | None) -> str:
    if tilt is None:
        return "at the sites"
    return "leaning to " + ", ".join(f"{'+' if sign > 0 else '-'}{axis}" for sign, axis in zip(tilt, "xy", strict=True))


def _size(value: float) -> str:
    return f"{1e3 * value:g} mm" if value >= 1e-4 else f"{_MICRO * value:g} µm"
