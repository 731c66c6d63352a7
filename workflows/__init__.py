"""Runs, scans and the command line.

from granwave.workflows import load_case, run_case, load_scan, run_scan

outcome = run_case(load_case("fcc-small", {"load.velocity": 10}), "my-run")
outcome.summary["dissipated_fraction"]
scan = run_scan(load_scan("restitution"), "my-scan", jobs=2)
scan.data["restitution"]                                       # numpy arrays by name; scan.data.to_xarray(), ...
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from granwave.workflows.cluster.profile import Profile, load_profile
    from granwave.workflows.library import load_case
    from granwave.workflows.run.driver import Outcome, run_case
    from granwave.workflows.scanning.driver import ScanOutcome, run_scan
    from granwave.workflows.scanning.scan_file import Scan, load_scan

_HOME = {
    "Outcome": "run.driver",
    "Profile": "cluster.profile",
    "Scan": "scanning.scan_file",
    "ScanOutcome": "scanning.driver",
    "load_case": "library",
    "load_profile": "cluster.profile",
    "load_scan": "scanning.scan_file",
    "run_case": "run.driver",
    "run_scan": "scanning.driver",
}

__all__ = [
    "Outcome",
    "Profile",
    "Scan",
    "ScanOutcome",
    "load_case",
    "load_profile",
    "load_scan",
    "run_case",
    "run_scan",
]


def __getattr__(name: str) -> Any:
    # imported on demand: the command line starts here too, and most commands need neither MPI nor
    # matplotlib
    if name in _HOME:
        import importlib

        return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
