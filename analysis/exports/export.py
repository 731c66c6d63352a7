"""Export of a run or a scan to the formats of ParaView, pandas, xarray and OVITO.

Files are written to a scratch directory, and moved into place when all are complete.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from granwave.analysis.errors import MissingOutputError, OutputFormatError, did_you_mean
from granwave.analysis.exports.to_tables import (
    OUTDATED_CSV,
    write_run_csv,
    write_run_netcdf,
    write_scan_csv,
    write_scan_netcdf,
)
from granwave.analysis.result.not_a_run import around, similar
from granwave.analysis.result.reader import Result
from granwave.analysis.result.values import wrong_value
from granwave.analysis.scans.table import read_scan
from granwave.extensions.pictures import ovito_scene, to_vtp
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import discard, naming
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import EXPORT_DIRECTORY, is_scan

OVITO_SCRIPT = "open_in_ovito.py"

#: Formats, as given by --to, and their files and programs.
FORMATS = {
    "csv": "tables with units in their headers (pandas, spreadsheets)",
    "netcdf": "result.nc (xarray)",
    "ovito": f"{OVITO_SCRIPT}, which opens spheres and contacts together",
    "vtp": "spheres.pvd and contacts.pvd (ParaView)",
}
_RUN_WRITERS = {"csv": write_run_csv, "netcdf": write_run_netcdf, "vtp": to_vtp.export_run}
_SCAN_WRITERS = {"csv": write_scan_csv, "netcdf": write_scan_netcdf}
_OUTDATED = {"csv": OUTDATED_CSV, "vtp": to_vtp.OUTDATED}
_NOTHING = r"(?!)"


def export(directory: str | Path, to: str, output: str | Path | None = None) -> list[Path]:
    """Export a run or a scan; files of an earlier export to the same format are replaced.

    Files are moved into place after all of them are complete.

    Parameters
    ----------
    directory
        Directory of a run or, for csv and netcdf, of a scan, whose table is exported.
    to
        One of `FORMATS`.
    output
        Directory to write to; by default ``directory/export``.

    Returns
    -------
    list of Path
        Paths of the files.

    Raises
    ------
    InputError
        There is no such format or directory, the directory holds no result or a damaged one, a
        library is missing, or the output cannot be written; nothing was written.
    """
    directory = Path(directory)
    if to not in FORMATS:
        hint = did_you_mean(to.lower(), FORMATS, 0.4) or f"expected one of {', '.join(FORMATS)}"
        raise InputError(f"--to {to}: no such form; {hint}")
    if not directory.exists():
        raise InputError(
            f"{directory}: no such directory{similar(directory)}; expected that of a run or a scan"
        )
    if not directory.is_dir():
        raise InputError(
            f"{directory}: is a file, expected the directory of a run or of a scan{around(directory)}"
        )
    if output is not None:
        results_directory(output)
        return _export(directory, to, Path(output))
    placed = _export(directory, to, directory / EXPORT_DIRECTORY)
    # so that --force moves it with the results
    ResultDirectory(directory).claim([f"{EXPORT_DIRECTORY}/"])
    return placed


def _export(directory: Path, to: str, output: Path) -> list[Path]:
    outdated = _OUTDATED.get(to, _NOTHING)
    if is_scan(directory):
        if to not in _SCAN_WRITERS:
            raise InputError(
                f"{directory}: is a scan, and --to {to} shows a single run; give the directory of a point, "
                f"{directory / 'points'}/ID (scan.csv tells which), or use --to {' or '.join(_SCAN_WRITERS)}"
            )
        try:
            scan = read_scan(directory)
        except OutputFormatError as error:
            raise InputError(str(error)) from None
        with staged(output) as (path_of, placed):
            _SCAN_WRITERS[to](scan, path_of)
        return placed
    if to == "ovito":
        return _export_recipe(directory, output)
    try:
        result = Result(directory)
    except (MissingOutputError, OutputFormatError) as error:
        raise InputError(str(error)) from None
    _refuse_wrong_values(result)
    with result, staged(output, outdated) as (path_of, placed):
        try:
            _RUN_WRITERS[to](result, path_of)
        except OSError as error:
            if error.errno is not None or "errno" in str(error):  # an error of writing
                raise
            raise InputError(result.damaged(error)) from None
    return placed


def _refuse_wrong_values(result: Result) -> None:
    """Close a result and raise InputError if it holds values that no run leaves."""
    try:
        fault = wrong_value(result.file)
    except (KeyError, OSError, RuntimeError) as error:  # checksums of HDF5
        fault = " ".join(str(error).split())
    if fault:
        message = result.damaged(fault)
        result.close()
        raise InputError(message)


def _export_recipe(directory: Path, output: Path) -> list[Path]:
    if ovito_scene.in_parts(directory):
        raise InputError(
            f"{directory}: each rank wrote its own dumps (output.parts), which OVITO does not join; use --to vtp"
        )
    if missing := ovito_scene.missing_files(directory):
        raise InputError(
            f"{directory}: {', '.join(missing)} missing; OVITO reads what LAMMPS wrote: expected the directory of a "
            "finished run"
        )
    source = Path(ovito_scene.__file__).read_text(encoding="utf-8")
    run = os.path.relpath(directory.resolve(), output.resolve())
    with staged(output) as (path_of, placed):
        text = source.replace(f"RUN = {json.dumps(ovito_scene.RUN)}", f"RUN = {json.dumps(run)}", 1)
        path_of(OVITO_SCRIPT).write_text(text, encoding="utf-8")
    return placed


@contextmanager
def staged(
    output: Path, outdated: str = _NOTHING
) -> Iterator[tuple[Callable[[str], Path], list[Path]]]:
    """Give a scratch directory whose files are moved to ``output`` at the end, in order, or none on
    an error.

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
        Scratch path for a file of a name; and the paths of the files, once they are in place.

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
    except OSError as error:  # one that names no file is of the last begun
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
