"""Influence of friction on the waves of a square packing struck in its plane: why do the edge chains lose more?"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.figures.series import MARKS, one_panel
from granwave.analysis.figures.style import BLUE, ORANGE, Drawing
from granwave.analysis.measures.impact.regions import groups
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.waves.pulses import peaks
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun, all_but
from granwave.analysis.studies.square.runs import PackingRun, packings
from granwave.analysis.studies.study import Picture, Row

TITLE = "Square packing with friction"
TEXT = (
    "The spheres lie on the floor with their weight; friction between spheres, with walls and floor, and both. Loss of "
    "the peak velocity against the same impact without friction, at the places of sensors: spheres 6 and 15 of a "
    "central chain, 5 and 8 of an edge chain, from the struck one as 1. The source finds more loss in the edge chains "
    "and suggests their second wall; it gives no number, and no coefficient of friction."
)
_WHERE = "square packing, Wave Propagation Path"
_PLACES = {"central chains": (6, 15), "edge chains": (5, 8)}
_FRICTIONS = ("contact.friction", "boundary.friction")


class RubbingRun(PackingRun):
    """A run of a square packing, with or without friction."""

    @property
    def frictions(self) -> tuple[float, float]:
        """Coefficients between spheres, and with walls."""
        own, walls = self.case.contact.friction, self.case.boundary.friction
        return own, own if walls is None else walls

    @cached_property
    def largest(self) -> dict[tuple[str, int], float]:
        """Largest velocity at the places of sensors, by group of chains and sphere, m/s."""
        seen, found = self.snapshots, {}
        for group, members in groups(seen).items():
            passed = peaks(seen.time, members[0].speeds(seen), self.case.packing.diameter)
            for place in _PLACES[group]:
                if place <= len(passed.velocity):
                    found[group, place] = float(passed.velocity[place - 1])
        return found

    @cached_property
    def lost_at_struck(self) -> float:
        """Share of the friction between spheres, strikers too, at contacts of the struck spheres; NaN without any."""
        with Result(self.directory) as result:
            struck = result["spheres/id"][self.snapshots.struck]
            i, j, lost = (result[f"contacts/{name}"] for name in ("i", "j", "friction_energy"))
        at = np.isin(i, struck) | np.isin(j, struck)
        return float(lost[at].sum() / lost.sum()) if lost.sum() > 0 else np.nan

    @cached_property
    def floor_work(self) -> float:
        """Coefficient of the floor times the weight of every sphere times its way, over the input."""
        case, n = self.case, self.assembly.lattice.n_spheres
        with Result(self.directory) as result:
            places = np.stack([result.frame(k, "displacement")[:n, :2] for k in range(result.n_frames)])
        way = float(np.linalg.norm(np.diff(places, axis=0), axis=2).sum())
        assert case.precompression is not None
        weight = case.sphere_mass * case.precompression.acceleration
        return self.frictions[1] * weight * way / self.value("energy_input_J")


@dataclasses.dataclass(frozen=True, eq=False)
class Rubbed:
    """Runs with friction, in rising order, beside the same without."""

    smooth: RubbingRun
    runs: list[RubbingRun]

    def losses(self, run: RubbingRun) -> dict[tuple[str, int], float]:
        """Loss of the largest velocity by group of chains and sphere, per cent."""
        return {
            place: 100 * (1 - run.largest[place] / value)
            for place, value in self.smooth.largest.items()
            if place in run.largest
        }


def select(runs: Sequence[FinishedRun]) -> list[Rubbed]:
    """Elastic square packings of like spheres struck in their plane under their weight, by all but friction."""
    series: dict[str, list[RubbingRun]] = {}
    for run in packings(runs):
        stage, case = run.case.precompression, run.case
        if case.packing.kind != "square" or run.way != "in-plane" or not run.alike or case.contact.law != "hertz":
            continue
        if stage is not None and stage.kind == "gravity" and case.boundary.bottom == "wall":
            series.setdefault(all_but(case, *_FRICTIONS), []).append(run.seen_as(RubbingRun))
    found = []
    for group in series.values():
        group.sort(key=lambda run: run.frictions)
        if not any(group[0].frictions) and len(group) > 1:
            found.append(Rubbed(group[0], group[1:]))
    return found


def rows(group: Rubbed) -> Iterator[Row]:
    """Losses of each run, where they are, and the work of the floor's friction."""
    for run in group.runs:
        said = _said(run)
        for (chain, place), lost in group.losses(run).items():
            yield Row(f"Loss of peak velocity, {chain}, sphere {place}: {said}", "%", None, lost, _WHERE)
        if np.isfinite(run.lost_at_struck):
            quantity = f"Share of the friction between spheres at contacts of the two struck ones: {said}"
            remark = "The striker and the next spheres of the central chains hold them back when they part sideways."
            yield Row(quantity, "%", None, 100 * run.lost_at_struck, _WHERE, remark)
        own, floor = run.frictions
        if floor and not own:
            quantity, ours = f"Lost to the floor: {said}", 100 * run.value("friction_fraction")
            remark = (
                "Theory: weight times coefficient times the way of every sphere; less where a sphere begins to roll."
            )
            yield Row(quantity, "% of input", None, ours, _WHERE, remark, 100 * run.floor_work)


def pictures(group: Rubbed) -> Iterator[Picture]:
    """Losses at the first of the sensors of both groups of chains, by coefficient and place of friction."""
    figure, axes = one_panel(2.6, "Coefficient of friction", "Loss of peak velocity (%)")
    columns: dict[str, Array] = {name: np.array(part) for name, part in zip(
        ("contact_friction", "boundary_friction"), zip(*(run.frictions for run in group.runs), strict=True),
        strict=True)}  # fmt: skip
    for (chain, place), colour in zip(group.smooth.largest, (BLUE, BLUE, ORANGE, ORANGE), strict=False):
        lost = np.array([group.losses(run).get((chain, place), np.nan) for run in group.runs])
        columns[f"{chain.split()[0]}_sphere_{place}_loss_percent"] = lost
        if place != _PLACES[chain][0]:
            continue
        kinds = {
            "between spheres": [run.frictions[0] > 0 and not run.frictions[1] for run in group.runs],
            "walls and floor": [run.frictions[1] > 0 and not run.frictions[0] for run in group.runs],
        }
        for (kind, chosen), mark, line in zip(kinds.items(), MARKS, ("-", "--"), strict=False):
            x = np.array([max(run.frictions) for run in group.runs])[chosen]
            label = f"{chain.split()[0]}, {kind}"
            axes.plot([0, *x], [0, *lost[chosen]], line, color=colour, marker=mark, markersize=3, label=label)
    axes.set(xlim=(0, None), ylim=(0, None))
    axes.legend()
    yield Picture("", "Loss of the waves by friction", Drawing(figure, columns))


def _said(run: RubbingRun) -> str:
    own, walls = run.frictions
    parts = [f"friction {own:g} between spheres"] if own else []
    return " and ".join([*parts, *([f"{walls:g} with walls"] if walls else [])])
