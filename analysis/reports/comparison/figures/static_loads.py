"""Notes on static loads below figures of a comparison."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from granwave.analysis.document.model import named
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.reports.comparison.curves import has_static_load, static_force_at_bottom
from granwave.analysis.reports.comparison.subjects import ComparedRun


def static_notes(curves: Mapping[ComparedRun, Any]) -> str:
    """Return the static forces on the bottom in a sentence; empty without a static load."""
    forces = {run.name: static_force_at_bottom(run) for run in curves}
    parts = [f"{quantity_in(force, 'N')} ({name})" for name, force in forces.items() if force]
    if not parts:
        return ""
    return f"The forces include the static force before the impact: {', '.join(parts)}."


def dynamic_notes(curves: Mapping[ComparedRun, Any]) -> str:
    """Return a sentence on forces that are drawn above the static forces; empty without a static
    load.
    """
    names = [run.name for run in curves if has_static_load(run)]
    if not names:
        return ""
    return f"Forces above the static force of each contact: {named(names, len(names))}."
