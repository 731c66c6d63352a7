"""The compiled LAMMPS plugin: where it is and which LAMMPS it was built for.

The sources beside this file make the plugin; the installed package holds the library alone. LAMMPS's own ``lmp``
command finds it through the entry point group ``lammps.plugins``, which calls `directory`.
"""

from pathlib import Path

PAIR_STYLE = "gran/hysteretic"


def library() -> Path:
    """The shared library that ``plugin load`` takes; that of the styles lies beside it."""
    return Path(__file__).parent / "granwaveplugin.so"


def directory() -> str:
    """The folder of the library, as LAMMPS_PLUGIN_PATH takes it."""
    return str(library().parent)


def lammps_release() -> str:
    """The LAMMPS release that the plugin was built for, such as ``2025.7.22.4``."""
    from granwave._contact_laws import LAMMPS_RELEASE

    return str(LAMMPS_RELEASE)
