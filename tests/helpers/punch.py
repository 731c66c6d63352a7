"""Summary of a punch on a block, without files."""

from __future__ import annotations

from granwave.workflows.finite_elements.punch import ContinuumCase
from granwave.workflows.finite_elements.punch.run import History, integrate, make_solver, summarise


def values_of(changes=None, **run):
    """Summary of a case from its tables, without writing files."""
    tables = {"name": "case", "material": "brass"} | (changes or {})
    case = ContinuumCase.from_dict(tables | {"run": tables.get("run", {}) | run})
    solver, history = make_solver(case), History()
    integrate(case, solver, history)
    return summarise(case, solver, history, 1.0)
