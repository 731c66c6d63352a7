"""Analysis of the output of LAMMPS: result.h5, summary.json and figures. Names are imported on first use."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from granwave.analysis.contact_law.curves import law_drawing, law_table, write_law
    from granwave.analysis.errors import MissingOutputError, OutputFormatError
    from granwave.analysis.figures.run_figures import draw_figures
    from granwave.analysis.pipeline import analyse
    from granwave.analysis.reports.report import write_report
    from granwave.analysis.result.reader import Result
    from granwave.analysis.result.universe import universe
    from granwave.analysis.result.writer import write_result
    from granwave.analysis.scans.result import ScanResult
    from granwave.analysis.scans.table import read_scan
    from granwave.analysis.summary import summarise
    from granwave.lammps_inputs.contact.law import velocity_normalised

_HOME = {
    "MissingOutputError": "errors",
    "OutputFormatError": "errors",
    "Result": "result.reader",
    "ScanResult": "scans.result",
    "analyse": "pipeline",
    "draw_figures": "figures.run_figures",
    "law_drawing": "contact_law.curves",
    "law_table": "contact_law.curves",
    "read_scan": "scans.table",
    "summarise": "summary",
    "universe": "result.universe",
    "velocity_normalised": "summary",
    "write_law": "contact_law.curves",
    "write_report": "reports.report",
    "write_result": "result.writer",
}

__all__ = [
    "MissingOutputError",
    "OutputFormatError",
    "Result",
    "ScanResult",
    "analyse",
    "draw_figures",
    "law_drawing",
    "law_table",
    "read_scan",
    "summarise",
    "universe",
    "velocity_normalised",
    "write_law",
    "write_report",
    "write_result",
]


def __getattr__(name: str) -> object:
    """Import a public name from its module."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
