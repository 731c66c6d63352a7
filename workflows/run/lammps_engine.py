"""LAMMPS instance with the granwave plugin."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterator
from ctypes import c_double, c_int, c_int64, c_void_p, string_at
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from granwave import plugins
from granwave.lammps_inputs.deck.script import with_absolute_files
from granwave.lammps_inputs.errors import RunError
from granwave.workflows.run.launchers import starting
from granwave.workflows.run.progress import not_enough_memory
from granwave.workflows.run.turns import turn

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm


# characters of paths that LAMMPS does not change; it replaces % and *, and some characters beyond
# ASCII
_PLAIN_PATH = re.compile(r"[A-Za-z0-9_./+=@,:~ -]*")
_DOUBLE = 2  # type of values in the interface of LAMMPS
_OPEN_DIRECTORY = "/proc/self/fd/{}"  # path of an open directory under Linux


class SingleRankError(RunError):
    """Error of LAMMPS on one rank only; the other ranks wait for this rank and must be aborted."""


class Engine:
    """LAMMPS instance whose errors are raised as `RunError`.

    Parameters
    ----------
    directory
        Absolute path of the directory with the files of the run; empty: the working directory.
    """

    def __init__(self, lammps: Any, directory: str = "") -> None:
        self.lammps = lammps
        self._directory = directory

    def commands(self, text: str) -> None:
        """Execute LAMMPS commands, one per line, with `&` at the end of continued lines."""
        with _translated():
            self.lammps.commands_string(with_absolute_files(text, self._directory))

    def end_command(self) -> None:
        """End a running command at its next step; called from another thread, on one rank only."""
        self.lammps.force_timeout()

    def last_thermo(self) -> dict[str, float]:
        """Return the last line of thermodynamic output by column; may be called from another thread
        during a run.
        """
        # lammps.last_thermo() would discard errors of the thread that runs LAMMPS
        read = self.lammps.lib.lammps_last_thermo

        def word(what: bytes, index: int = 0) -> int | None:
            return cast("int | None", read(self.lammps.lmp, what, index))

        word(b"lock")
        try:
            step = word(b"step")
            count = word(b"num")
            if not step or not count:
                return {}
            values = {"Step": float(c_int64.from_address(step).value)}
            for column in range(c_int.from_address(count).value):
                kind, name, data = (word(what, column) for what in (b"type", b"keyword", b"data"))
                if kind and name and data and c_int.from_address(kind).value == _DOUBLE:
                    values[string_at(name).decode()] = c_double.from_address(data).value
            return values
        finally:
            word(b"unlock")

    def own_box(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the lowest and highest x, y, z of the part of the box that this rank owns, (3,)
        each, m.
        """
        return np.array(self.lammps.extract_global("sublo")), np.array(
            self.lammps.extract_global("subhi")
        )

    def create_atoms(
        self,
        ids: NDArray[np.int64],
        types: NDArray[np.integer],
        positions: NDArray[np.float64],
        velocities: NDArray[np.float64],
        images: NDArray[np.int64] | None = None,
        *,
        n_atoms: int,
    ) -> None:
        """Create the given atoms in this rank's part of the box; collective.

        Parameters
        ----------
        ids, types
            Ids and types, (n,).
        positions, velocities
            Centres, m, and velocities, m/s: (n, 3).
        images
            Periods that centres are beyond the box, (n, 3); None: they are in it.
        n_atoms
            Number of atoms that all ranks together must have afterwards.

        Raises
        ------
        RunError
            The number of atoms differs.
        """
        from lammps.core import ExceptionCheck

        make = self.lammps.lib.lammps_create_atoms
        make.argtypes = [c_void_p, c_int, *[c_void_p] * 5, c_int]
        bits = (
            10 if (size := self.lammps.extract_setting("imageint")) == 4 else 21
        )  # IMGBITS of LAMMPS
        shifts = np.zeros((len(ids), 3), dtype=np.int64) if images is None else images
        flags = (shifts + (1 << bits - 1)) @ [1, 1 << bits, 1 << 2 * bits]
        forms = (self.id_form, "i4", "f8", "f8", f"i{size}")
        values = (ids, types, positions, velocities, flags)
        arrays = [np.ascontiguousarray(*one) for one in zip(values, forms, strict=True)]
        places = [one.ctypes.data_as(c_void_p) for one in arrays]
        with _translated(), ExceptionCheck(self.lammps):
            make(self.lammps.lmp, len(ids), *places, 0)
        found = int(self.lammps.extract_global("natoms"))
        if found != n_atoms:
            raise RunError(f"the ranks created {found} of {n_atoms} spheres; please report this")

    @property
    def id_form(self) -> str:
        """Type of ids: ``i4``, or ``i8`` if LAMMPS was built with -D LAMMPS_SIZES=bigbig."""
        return f"i{self.lammps.extract_setting('tagint')}"

    def per_atom(self, name: str) -> NDArray[Any]:
        """Return values of this rank's own atoms, in the memory of LAMMPS: writing to the array
        changes them.
        """
        return np.asarray(self.lammps.numpy.extract_atom(name))

    @property
    def step(self) -> int:
        """Current timestep."""
        return int(self.lammps.extract_global("ntimestep"))


@contextlib.contextmanager
def open_engine(
    comm: Intracomm, log: str = "log.lammps", directory: Path | None = None
) -> Iterator[Engine]:
    """Open LAMMPS on all ranks of ``comm``, and load the plugin; one at a time in a process.

    Parameters
    ----------
    log
        Name of the log, or "none".
    directory
        Directory of the log and of the files of a run that commands name; None: the working
        directory, which is never changed.

    Raises
    ------
    RunError
        LAMMPS cannot be loaded, is not the release that the plugin was built for, or lacks the pair
        style.
    """
    if wrong := check_release():
        raise RunError(wrong)
    try:
        from lammps import lammps

        with starting():
            from mpi4py import MPI  # noqa: F401 (loads the libmpi that the LAMMPS library needs)
    except (ImportError, OSError, RuntimeError) as error:
        raise RunError(
            f"LAMMPS cannot be loaded: {error}; run granwave doctor to find the cause"
        ) from error
    with turn(directory), _path_for_lammps(directory) as place:
        log = f"{place}/{log}" if place and log != "none" else log
        with _translated():
            instance = lammps(comm=comm, cmdargs=["-log", log, "-screen", "none", "-nocite"])
        try:
            with _translated():
                instance.command(f'plugin load "{plugins.library()}"')
            if not instance.has_style("pair", plugins.PAIR_STYLE):
                raise RunError(
                    f"LAMMPS of {instance.version()} did not load {plugins.library()}, which was "
                    f"built for LAMMPS {plugins.lammps_release()}; install this release, or "
                    "rebuild granwave for your LAMMPS"
                )
            yield Engine(instance, place)
        finally:
            instance.close()


@contextlib.contextmanager
def _path_for_lammps(directory: Path | None) -> Iterator[str]:
    """Return the path of a directory in a form that LAMMPS accepts within a file name; empty for
    None.

    If LAMMPS would replace characters of the path, the result is the path of an open descriptor, on
    systems that have such paths.
    """
    path = "" if directory is None else str(directory.absolute())
    if _PLAIN_PATH.fullmatch(path):
        yield path
        return
    opened = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
    try:
        short = _OPEN_DIRECTORY.format(opened)
        yield short if os.path.isdir(short) else path
    finally:
        os.close(opened)


def check_release() -> str | None:
    """Describe the fault of the installed LAMMPS release; None if there is none.

    LAMMPS does not guarantee binary compatibility between releases, nor between updates of a
    release.
    """
    wanted = plugins.lammps_release()
    try:
        found = metadata.version("lammps")
    except metadata.PackageNotFoundError:
        return None  # LAMMPS from another source: the plugin checks it when it is loaded
    if found == wanted or found.startswith(wanted + "."):
        return None
    return (
        f"LAMMPS {found} is installed, but the plugin was built for {wanted}; pip install "
        f"'lammps[mpi]=={wanted}.*', or rebuild granwave for your LAMMPS"
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
