"""Finished runs with their cases, as studies take them from a report."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, Self

from granwave.analysis.result_file import BALANCE_REFUSED
from granwave.lammps_inputs.case import Case, load_case
from granwave.lammps_inputs.deck import CASE_FILE
from granwave.lammps_inputs.errors import GranwaveError


@dataclasses.dataclass(frozen=True, eq=False)
class FinishedRun:
    """A finished run of spheres.

    Attributes
    ----------
    label
        What a report calls it.
    summary
        Its ``summary.json``.
    """

    label: str
    directory: Path
    case: Case
    summary: Mapping[str, Any]

    @classmethod
    def among(
        cls, found: Iterable[tuple[str, Path, Mapping[str, Any]]], suits: Callable[[Case], bool]
    ) -> tuple[Self, ...]:
        """Those whose case suits; none whose energy balance was refused or whose case cannot be read.

        Parameters
        ----------
        found
            Label, directory and summary of finished runs.
        """
        runs = []
        for label, directory, summary in found:
            if summary.get("end_reason") == BALANCE_REFUSED:
                continue
            try:
                case = load_case(directory / CASE_FILE)
            except GranwaveError:
                continue  # the report says so elsewhere
            if suits(case):
                runs.append(cls(label, directory, case, summary))
        return tuple(runs)

    def value(self, name: str) -> float:
        """A number of the summary; NaN where it does not apply."""
        found = self.summary.get(name)
        return float(found) if isinstance(found, int | float) and not isinstance(found, bool) else math.nan
