"""Tolerances: loss of performance if spheres scatter in size, are missing, or have friction.

Runs that differ only in the imperfections of their packing belong together; their means by
imperfection are the rows of the tables and the points of the figures.
"""

from __future__ import annotations

from granwave.analysis.studies.tolerance.figures import pictures
from granwave.analysis.studies.tolerance.means import tables
from granwave.analysis.studies.tolerance.runs import select
from granwave.analysis.studies.tolerance.sentences import TEXT, missing, name, title, verdict

__all__ = ["TEXT", "missing", "name", "pictures", "select", "tables", "title", "verdict"]

NEEDS = (
    "packings that differ only in diameter scatter, vacancies or friction, in at least two settings"
)
