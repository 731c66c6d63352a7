"""Header of a scan file: its top-level keys."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from granwave.analysis.studies.registry import STUDIES
from granwave.analysis.studies.study_file import find_studies, is_study_file
from granwave.lammps_inputs.case.schema import (
    ErrorList,
    ValidationError,
    choice,
    count,
    custom,
    number,
    plain_name,
    read_table,
    text,
    whole,
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class RanksBySize:
    """``ranks = {...}``: MPI ranks of a point by the number of its spheres."""

    spheres_per_rank: float = number("spheres for each rank", at_least=1, default=100_000)
    most: int = count("most ranks", default=1)

    def of(self, n_spheres: int) -> int:
        """Return the number of ranks for a packing."""
        return max(1, min(self.most, math.ceil(n_spheres / self.spheres_per_rank)))


_ONE_RANK = RanksBySize()


def _parse_ranks(value: Any) -> RanksBySize:
    expected = "a whole number from 1 up, or {spheres_per_rank = 100000, most = 8}"
    if not isinstance(value, Mapping):
        n = whole(value, expected)
        return RanksBySize(spheres_per_rank=1, most=n)
    errors = ErrorList("")
    read = read_table(RanksBySize, value, "ranks", errors)
    if read is None:
        raise ValidationError(f"{expected} ({'; '.join(line.removeprefix(': ranks.') for line in errors.lines)})")
    return read


def parse_studies(value: Any) -> tuple[str, ...]:
    """Parse the name or path of a study, or a list of them."""
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, list) or not names or not all(isinstance(n, str) and _is_study(n) for n in names):
        raise ValidationError(f"a Python file, a study, or a list of them; studies are: {', '.join(STUDIES)}")
    return tuple(names)


def _is_study(name: str) -> bool:
    return name in STUDIES or is_study_file(name)


def studies_beside(names: tuple[str, ...], path: Path, errors: ErrorList) -> tuple[str, ...]:
    """Return studies with the absolute paths of their files, which are relative to a scan or suite file."""
    found, faults = find_studies(names, path.parent)
    for fault in faults:
        errors.add("study", fault)
    return tuple(found)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Header:
    """Top-level keys of a scan file."""

    name: str = custom("name of the scan", plain_name, default="")
    case: str = text("a built-in study or a case file")
    ranks: RanksBySize = custom("MPI ranks of a point", _parse_ranks, default=_ONE_RANK)  # noqa: RUF009
    replicates: int = count("runs of each point in which something is random, with seeds 1 to n", default=1)
    figures: bool = choice("figures of every point too", (False, True), default=False)
    study: tuple[str, ...] = custom(
        "study, or list of studies, that the report makes of the scan", parse_studies, default=()
    )
