"""Keys of a design file, and the names of the values that limits and objectives may concern."""

from __future__ import annotations

import dataclasses
from fnmatch import fnmatchcase
from typing import Any

from granwave.analysis.quantities import ENTRIES
from granwave.lammps_inputs.case.schema import (
    ValidationError,
    choice,
    count,
    custom,
    did_you_mean,
    finite,
    number,
    plain_name,
    text,
    whole,
)

#: Values of a packing that limits may concern and that are known before a run.
KNOWN_BEFORE = ("mass_kg", "height_m", "width_m", "n_spheres", "smallest_diameter_m")
_DERIVED = ("yielded_share", "kinetic_share", "overlap_over_radius")  # values that are made of those of the summary

_NO_NUMBERS = ("name", "end_reason", "zone_cut", "versions")  # values that are words, lists or tables


@dataclasses.dataclass(frozen=True, kw_only=True)
class Header:
    """Top-level keys of a design file."""

    name: str = custom("name of the search", plain_name, default="")
    base: str = text("the case that is varied: a built-in study or a case file")


def _parse_names(value: Any) -> tuple[str, ...]:
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, list) or not 1 <= len(names) <= 2 or not all(isinstance(name, str) for name in names):
        raise ValidationError('the name of a value of summary.json, such as "target_peak_force_N", or a list of two')
    for name in names:
        if not is_value(name):
            raise ValidationError(f"the name of a number of summary.json{did_you_mean(name, value_names())}")
    return tuple(names)


def value_names() -> list[str]:
    return [*KNOWN_BEFORE, *_DERIVED, *(entry.name for entry in ENTRIES if entry.name not in _NO_NUMBERS)]


def is_value(name: str) -> bool:
    return any(fnmatchcase(name, known) for known in value_names())


@dataclasses.dataclass(frozen=True, kw_only=True)
class ObjectiveTable:
    """``[objective]``: what the best design has; two values in all make a Pareto front."""

    minimise: tuple[str, ...] = custom("values that are to be small", _parse_names, default=())
    maximise: tuple[str, ...] = custom("values that are to be large", _parse_names, default=())


def _parse_statistic(value: Any) -> str | float:
    expected = '"mean", "worst", or a share such as 0.9, of runs that are at least as good'
    if value in ("mean", "worst"):
        return str(value)
    if isinstance(value, str) or not 0 < finite(value, expected) < 1:
        raise ValidationError(expected)
    return float(value)


@dataclasses.dataclass(frozen=True, kw_only=True)
class UncertaintyTable:
    """``[uncertainty]``: several runs of each design, with other seeds, and with keys of the case drawn from ranges."""

    replicates: int = count("runs of each design", default=3, at_most=1000)
    statistic: str | float = custom("objective made of the runs", _parse_statistic, default="mean")


@dataclasses.dataclass(frozen=True, kw_only=True)
class SearchTable:
    """``[search]``: how long and how."""

    evaluations: int = count("designs that are run; refused ones do not count", default=60, at_most=100_000)
    seed: int = custom(
        "seed of the search", lambda value: whole(value, "a whole number from 0 up", at_least=0), default=1
    )
    sampler: str = choice(
        "model: a Gaussian process of the objective; random: for comparison", ("model", "random"), default="model"
    )
    guards: bool = choice(
        "checks of the best design by further runs, and moves to better designs next to it", (True, False), default=True
    )
    neighbours: int = count(
        "designs next to the best that are run after the evaluations, at most", default=40, at_least=0, at_most=100_000
    )
    tolerance: float | str = number(
        "run.energy_tolerance until the best tenth is run again with that of the case; "
        "auto: 3e-5 where a run takes seconds, else that of the case",
        above=0,
        at_most=1e-3,
        word="auto",
        default="auto",
    )


#: Tables of a design file: class and description.
DESIGN_TABLES: dict[str, tuple[type, str]] = {
    "": (Header, "top-level keys, what may vary, and limits"),
    "[objective]": (ObjectiveTable, "what the best design has; two values in all make a Pareto front"),
    "[uncertainty]": (UncertaintyTable, "several runs of each design, with other seeds and keys drawn from ranges"),
    "[search]": (SearchTable, "how long and how the search goes"),
}
