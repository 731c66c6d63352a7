"""All studies of protected targets, in the order of the report."""

from __future__ import annotations

from collections.abc import Sequence

from granwave.analysis.figures.style import style
from granwave.analysis.studies.protection.bottoms import bottoms
from granwave.analysis.studies.protection.checks import checks
from granwave.analysis.studies.protection.heights import heights
from granwave.analysis.studies.protection.runs import TargetRun
from granwave.analysis.studies.protection.spectrum import spectrum
from granwave.analysis.studies.study import Study


def studies(groups: Sequence[Sequence[TargetRun]]) -> list[Study]:
    """What the groups of `granwave.analysis.studies.protection.runs.collect` show."""
    found: list[Study] = []
    with style():
        for number, runs in enumerate(groups, start=1):
            suffix = f"-{number}" if number > 1 else ""
            for find in (heights, bottoms, spectrum, checks):
                found += find(runs, suffix)
    return found
