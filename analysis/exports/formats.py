"""Format of ``granwave export``: a description of its files, and the functions that write them.

Files are written to a scratch directory, and moved to their final location when all are complete.
"""

from __future__ import annotations

import dataclasses
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.exports.selection import Selection
from granwave.analysis.result.reader import Result
from granwave.analysis.result.values import wrong_value
from granwave.analysis.scans.table import ScanData
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import discard, naming
from granwave.lammps_inputs.result_directory import ResultDirectory

NOTHING = r"(?!)"  # pattern that matches no file

PathOf = Callable[[str], Path]


@dataclasses.dataclass(frozen=True)
class ExportFormat:
    """Format of ``granwave export``.

    Attributes
    ----------
    files
        Its files, and the programs that read them.
    run
        Function of the directory of a run and of the output directory that writes the files there
        and returns their paths; see `of_result` and `staged`.
    scan
        Function of the table of a scan and of a function that returns the path for a file of a
        name; it writes the files. None: only runs are exported.
    parts
        Names of the parts of a run that can be exported without the others.
    some
        As ``run``, with the names of the parts to export as further argument.
    select
        Function of a selection of rows, and of the names of the parts to export, that returns a
        function like ``run``. None: a run is exported as a whole.
    """

    files: str
    run: Callable[[Path, Path], list[Path]]
    scan: Callable[[ScanData, PathOf], None] | None = None
    parts: tuple[str, ...] = ()
    some: Callable[[Path, Path, tuple[str, ...]], list[Path]] | None = None
    select: Callable[[Selection, tuple[str, ...]], Callable[[Path, Path], list[Path]]] | None = None


def of_result(
    write: Callable[[Result, PathOf], None], outdated: str = NOTHING
) -> Callable[[Path, Path], list[Path]]:
    """Return the function ``run`` of a format that is written from ``result.h5``.

    Parameters
    ----------
    write
        Function of a result and of a function that returns the path for a file of a name.
    outdated
        As of `staged`.
    """

    def run(directory: Path, output: Path) -> list[Path]:
        try:
            result = Result(directory)
        except (MissingOutputError, OutputFormatError) as error:
            raise InputError(str(error)) from None
        _refuse_wrong_values(result)
        with result, staged(output, outdated) as (path_of, placed):
            try:
                write(result, path_of)
            except OSError as error:
                if error.errno is not None or "errno" in str(error):  # error while writing
                    raise
                raise InputError(result.damaged(error)) from None
        return placed

    return run


def _refuse_wrong_values(result: Result) -> None:
    """Close a result and raise InputError if it holds impossible values."""
    try:
        fault = wrong_value(result.file)
    except (KeyError, OSError, RuntimeError) as error:  # checksums of HDF5
        fault = " ".join(str(error).split())
    if fault:
        message = result.damaged(fault)
        result.close()
        raise InputError(message)


@contextmanager
def staged(output: Path, outdated: str = NOTHING) -> Iterator[tuple[PathOf, list[Path]]]:
    """Provide a scratch directory whose files are moved to ``output`` in order at the end; none is
    moved on an error.

    Parameters
    ----------
    output
        Output directory; created if necessary, and removed again on failure if created here.
    outdated
        Regular expression; files of earlier exports whose full names match, and that were not
        written now, are removed.

    Yields
    ------
    function, list
        Function that returns the scratch path for the name of a file; and the final paths of the
        files, filled in at the end.

    Raises
    ------
    InputError
        The directory cannot be written to, or a file exists that granwave did not write; no file
        was moved.
    """
    made = [path for path in (output, *output.parents) if not path.exists()]
    names: list[str] = []
    placed: list[Path] = []
    results = ResultDirectory(output)
    try:
        output.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=".granwave-export-", dir=output))
    except OSError as error:
        _remove_empty(made)
        raise InputError(
            f"{output}: cannot be written to ({error.strerror}); "
            "choose another directory with directory=..."
        ) from None

    def path_of(name: str) -> Path:
        names.append(name)
        return scratch / name

    try:
        with naming(output):
            yield path_of, placed
            results.claim(names)
            for name in names:
                os.replace(scratch / name, output / name)
                placed.append(output / name)
            own = [name for name in results.marker.files if name not in names]
            results.clear([name for name in own if re.fullmatch(outdated, name)])
    except OSError as error:  # an error without a file name belongs to the last file begun
        if error.filename == str(output) and names:
            error.filename = str(output / names[-1])
        elif error.filename is not None:
            error.filename = str(error.filename).replace(str(scratch), str(output))
        raise
    finally:
        for path in scratch.iterdir():
            discard(path)
        shutil.rmtree(scratch, ignore_errors=True)
        if not placed:
            _remove_empty(made)


def _remove_empty(directories: list[Path]) -> None:
    for directory in directories:
        try:
            directory.rmdir()
        except OSError:
            return
