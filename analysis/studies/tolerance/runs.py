"""Runs that differ in nothing but how imperfect their packing is, put together by imperfection."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from granwave.analysis.studies.runs import FinishedRun, all_but
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.packing.disorder import DEFAULT_SEED, is_random

_DIGITS = 12  # in which settings are the same
_MOST_PAIRS = 3  # packings run twice alone; more are a scan of something else, that would drown in verdicts


class Setting(NamedTuple):
    """How imperfect a packing is.

    Attributes
    ----------
    scatter
        Of the diameters, m.
    friction
        Coefficient of Coulomb friction.
    vacancies
        Share of the spheres that are left out at random.
    """

    scatter: float = 0.0
    friction: float = 0.0
    vacancies: float = 0.0


IDEAL = Setting()
_KEYS = {"scatter": "packing.diameter_scatter", "friction": "contact.friction", "vacancies": "packing.vacancies"}


class Replicate(FinishedRun):
    """A finished run of one setting."""

    @property
    def seed(self) -> int:
        """Seed of the random part of its packing."""
        seed = self.case.packing.seed
        return DEFAULT_SEED if seed is None else seed


@dataclasses.dataclass(frozen=True, eq=False)
class Packing:
    """All runs of one impact on one packing, ideal and not.

    Attributes
    ----------
    runs
        By setting, in rising order; of each the replicates in the order of their seeds, of what is not random one.
    """

    runs: dict[Setting, tuple[Replicate, ...]]

    @cached_property
    def case(self) -> Case:
        """Case of its least imperfect run."""
        return next(iter(self.runs.values()))[0].case

    @property
    def settings(self) -> list[Setting]:
        """In rising order."""
        return list(self.runs)

    def values(self, name: str) -> list[float]:
        """Values of a field of `Setting`, in rising order."""
        return sorted({getattr(setting, name) for setting in self.runs})


def collect(found: Iterable[tuple[str, Path, Mapping[str, Any]]]) -> list[Packing]:
    """Packings of which there are runs of two settings at least, one of them imperfect.

    Where many packings were run twice alone, say with friction and without, they are left out: what differs
    between the packings is the study.

    Parameters
    ----------
    found
        Label, directory and summary of finished runs.
    """
    groups: dict[str, dict[Setting, dict[int, Replicate]]] = {}
    for run in Replicate.among(found, lambda case: case.load.kind == "impact" and case.packing.kind != "chain"):
        same = groups.setdefault(_what_is_hit(run.case), {}).setdefault(setting_of(run.case), {})
        seed = run.seed if is_random(run.case) else 0
        if run.value("end_time_s") > same.setdefault(seed, run).value("end_time_s"):
            same[seed] = run
    packings = [
        Packing({setting: _in_order(runs) for setting, runs in sorted(group.items())})
        for group in groups.values()
        if len(group) > 1
    ]
    more = [packing for packing in packings if sum(map(len, packing.runs.values())) > 2]
    return packings if len(packings) - len(more) <= _MOST_PAIRS else more


def setting_of(case: Case) -> Setting:
    """How imperfect the packing of a case is."""
    packing, left_out = case.packing, case.packing.vacancies
    values = packing.diameter_scatter, case.contact.friction, left_out if isinstance(left_out, float) else 0.0
    return Setting(*(float(f"{value:.{_DIGITS}g}") for value in values))


def is_ideal(labels: Mapping[str, Any], packing: Packing) -> bool:
    """A point of a scan is the ideal packing, where what does not vary in the scan is that of ``packing``.

    Parameters
    ----------
    labels
        Values of the keys that vary.
    """
    fixed = setting_of(packing.case)._asdict()
    return not any(labels.get(key, fixed[name]) for name, key in _KEYS.items())


def _what_is_hit(case: Case) -> str:
    """Everything that is not an imperfection."""
    left_out = ["packing.diameter_scatter", "packing.seed", "contact.friction"]
    if not isinstance(case.packing.vacancies, tuple):
        left_out.append("packing.vacancies")
    if case.boundary.friction == case.contact.friction:  # as where it is left out
        left_out.append("boundary.friction")
    return all_but(case, *left_out)


def _in_order(runs: Mapping[int, Replicate]) -> tuple[Replicate, ...]:
    return tuple(runs[seed] for seed in sorted(runs))
