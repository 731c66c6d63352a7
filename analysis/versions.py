"""Versions of the programs that a result depends on."""

from __future__ import annotations

import platform
from collections.abc import Iterable
from importlib import metadata

from granwave import __version__
from granwave.lammps_inputs.run_directory import FORMAT

RESULTS_FORMAT = "results_format"  # name of `FORMAT` among versions


def versions_of(packages: Iterable[str], **others: str) -> dict[str, str]:
    """Return the versions of granwave, its results, Python, ``others`` and packages, or "not
    installed".
    """
    return {
        "granwave": __version__,
        RESULTS_FORMAT: str(FORMAT),
        "python": platform.python_version(),
        **others,
        **{name: _version(name) for name in packages},
    }


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"
