"""Summary of a punch on a block, without files."""

from __future__ import annotations

from granwave.workflows.finite_elements.punch import ContinuumCase
from granwave.workflows.finite_elements.punch.run import BlockRun


def values_of(changes=None, **run):
    """Summary of a case from its tables, without writing files."""
    tables = {"name": "case", "material": "brass"} | (changes or {})
    run = BlockRun(ContinuumCase.from_dict(tables | {"run": tables.get("run", {}) | run}))
    run.integrate()
    return run.summarise(1.0)
