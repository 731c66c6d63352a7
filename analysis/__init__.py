"""From what LAMMPS left to result.h5, summary.json and figures. Names are imported when first used."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from granwave.analysis.errors import MissingOutputError, OutputFormatError
    from granwave.analysis.figures import draw_figures
    from granwave.analysis.law import law_drawing, law_table, write_law
    from granwave.analysis.pipeline import analyse
    from granwave.analysis.reports.report import write_report
    from granwave.analysis.result import Result
    from granwave.analysis.result_file import write_result
    from granwave.analysis.scan_result import ScanResult
    from granwave.analysis.scan_table import read_scan
    from granwave.analysis.summary import summarise, velocity_normalised
    from granwave.analysis.trajectory import universe

_HOME = {
    "MissingOutputError": "errors",
    "OutputFormatError": "errors",
    "Result": "result",
    "ScanResult": "scan_result",
    "analyse": "pipeline",
    "draw_figures": "figures",
    "law_drawing": "law",
    "law_table": "law",
    "read_scan": "scan_table",
    "summarise": "summary",
    "universe": "trajectory",
    "velocity_normalised": "summary",
    "write_law": "law",
    "write_report": "reports.report",
    "write_result": "result_file",
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
