"""Analysis of the output of LAMMPS: result.h5, summary.json and figures. Names are imported on
first use.
"""

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
    "errors": ("MissingOutputError", "OutputFormatError"), "result.reader": ("Result",),
    "scans.result": ("ScanResult",), "pipeline": ("analyse",), "figures.run_figures": ("draw_figures",),
    "contact_law.curves": ("law_drawing", "law_table", "write_law"), "scans.table": ("read_scan",),
    "summary": ("summarise", "velocity_normalised"), "result.universe": ("universe",),
    "reports.report": ("write_report",), "result.writer": ("write_result",),
}  # fmt: skip
__all__ = [
    "MissingOutputError", "OutputFormatError", "Result", "ScanResult", "analyse", "draw_figures", "law_drawing",
    "law_table", "read_scan", "summarise", "universe", "velocity_normalised", "write_law", "write_report",
    "write_result",
]  # fmt: skip


def __getattr__(name: str) -> object:
    """Import a public name from its module."""
    home = next((module for module, names in _HOME.items() if name in names), None)
    if home is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{home}"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
