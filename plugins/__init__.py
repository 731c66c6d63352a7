"""Location of the compiled LAMMPS plugin and the LAMMPS release that it was built for.

The source tree contains the sources of the plugin in this folder; the installed package contains
the compiled libraries only. The ``lmp`` command of LAMMPS finds them by the entry point group
``lammps.plugins``, which calls `directory`.
"""

from pathlib import Path

import granwave

PAIR_STYLE = "gran/hysteretic"


def library() -> Path:
    """Path of the shared library for ``plugin load``; the library of the styles is in the same
    folder.
    """
    return Path(granwave.__file__).parent / "plugins" / "granwaveplugin.so"  # links lead elsewhere


def directory() -> str:
    """Folder of the library, as set in LAMMPS_PLUGIN_PATH."""
    return str(library().parent)


def lammps_release() -> str:
    """LAMMPS release that the plugin was built for, such as ``2025.7.22.4``."""
    from granwave._contact_laws import LAMMPS_RELEASE

    return str(LAMMPS_RELEASE)
