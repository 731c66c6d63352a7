"""Export of a run or a scan to the formats of ParaView, pandas, xarray and OVITO.

Files are written to a scratch directory, and moved to their final location when all are complete.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from granwave.analysis.errors import OutputFormatError, did_you_mean
from granwave.analysis.exports.formats import NOTHING, ExportFormat, of_result, staged
from granwave.analysis.exports.names import CSV, NETCDF, export_names
from granwave.analysis.exports.selection import ALL, SNAPSHOTS, Selection
from granwave.analysis.exports.to_tables import (
    CSV_PARTS,
    OUTDATED_CSV,
    OUTDATED_SNAPSHOTS,
    write_run_csv,
    write_run_netcdf,
    write_scan_csv,
    write_scan_netcdf,
)
from granwave.analysis.result.not_a_run import around, similar
from granwave.analysis.scans.table import read_scan
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.extensions import extensions, joined, load
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import EXPORT_DIRECTORY, is_scan


def _write_some_csv(directory: Path, output: Path, parts: tuple[str, ...]) -> list[Path]:
    """Write some tables of a run; tables of earlier exports are kept."""
    return of_result(partial(write_run_csv, only=parts))(directory, output)


def _select_csv(selected: Selection, parts: tuple[str, ...]) -> Callable[[Path, Path], list[Path]]:
    """Return the function that writes the selected rows of tables; by default of the tables from
    which something is selected.
    """
    tables = parts or selected.tables
    outdated = OUTDATED_SNAPSHOTS if SNAPSHOTS in tables else NOTHING
    return of_result(partial(write_run_csv, only=tables, selected=selected), outdated)


def _select_netcdf(
    selected: Selection, _parts: tuple[str, ...]
) -> Callable[[Path, Path], list[Path]]:
    """Return the function that writes the selected rows of all tables."""
    return of_result(partial(write_run_netcdf, selected=selected))


_OWN = {
    CSV: ExportFormat(
        "tables with units in their headers (pandas, spreadsheets)",
        of_result(write_run_csv, OUTDATED_CSV),
        write_scan_csv,
        CSV_PARTS,
        _write_some_csv,
        _select_csv,
    ),
    NETCDF: ExportFormat(
        "result.nc (xarray)",
        of_result(write_run_netcdf),
        write_scan_netcdf,
        select=_select_netcdf,
    ),
}


def export_format(name: str) -> ExportFormat:
    """Return the format of a name, one of `export_names`.

    Raises
    ------
    InputError
        Two formats have this name.
    """
    added = {one.name: one.exports for one in extensions()}
    entry: ExportFormat | str = joined("export format", _OWN, added)[name]
    return load(entry) if isinstance(entry, str) else entry


def export(
    directory: str | Path,
    to: str,
    output: str | Path | None = None,
    only: Sequence[str] = (),
    selected: Selection = ALL,
) -> list[Path]:
    """Export a run or a scan; files of an earlier export to the same format are replaced.

    Files are moved to their final location after all are complete.

    Parameters
    ----------
    directory
        Directory of a run or, for csv and netcdf, of a scan, whose table is exported.
    to
        One of `export_names`.
    output
        Directory to write to; by default ``directory/export``.
    only
        Names of the tables of a run to export, of csv; by default all. Tables of earlier exports
        then stay.
    selected
        Rows to export, of csv, netcdf and vtp. By default csv then has the tables from which
        something is selected.

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
    names = export_names()
    if to not in names:
        hint = did_you_mean(to.lower(), names, 0.4) or f"expected one of {', '.join(names)}"
        raise InputError(f"--to {to}: unknown format; {hint}")
    if not directory.exists():
        raise InputError(
            f"{directory}: no such directory{similar(directory)}; expected the directory of a run "
            "or a scan"
        )
    if not directory.is_dir():
        raise InputError(
            f"{directory}: is a file, expected the directory of a run or of a scan{around(directory)}"
        )
    if output is not None:
        results_directory(output)
        return _export(directory, to, Path(output), tuple(only), selected)
    placed = _export(directory, to, directory / EXPORT_DIRECTORY, tuple(only), selected)
    # the files are moved with the results by --force
    ResultDirectory(directory).claim([f"{EXPORT_DIRECTORY}/"])
    return placed


def _some(chosen: ExportFormat, directory: Path, output: Path, only: tuple[str, ...]) -> list[Path]:
    """Export parts of a run; raise InputError if it has none of them."""
    assert chosen.some is not None  # this format has parts
    placed = chosen.some(directory, output, only)
    if not placed:
        raise InputError(f"--only: {', '.join(only)}: this run contains no such data")
    return placed


def _selected(
    chosen: ExportFormat,
    directory: Path,
    output: Path,
    only: tuple[str, ...],
    selected: Selection,
) -> list[Path]:
    """Export selected rows of a run; raise InputError if there are none."""
    if chosen.select is None:
        able = " or ".join(name for name in export_names() if export_format(name).select)
        raise InputError(
            f"{selected.words}: this format exports a run as a whole; select nothing, or use "
            f"--to {able}"
        )
    if only:
        selected.refuse_tables_without(only)
    placed = chosen.select(selected, only)(directory, output)
    if not placed:
        raise InputError(f"{selected.words}: this run has no tables to select from")
    return placed


def _refuse_wrong_parts(chosen: ExportFormat, to: str, only: Sequence[str]) -> None:
    """Raise InputError unless a format can export only these parts."""
    if only and not chosen.parts:
        able = " or ".join(name for name in export_names() if export_format(name).parts)
        raise InputError(
            f"--only: --to {to} exports a run as a whole; remove it, or use --to {able}"
        )
    unknown = [name for name in only if name not in chosen.parts]
    if unknown:
        expected = f"expected some of {', '.join(chosen.parts)}"
        hint = did_you_mean(unknown[0], chosen.parts) or expected
        raise InputError(f"--only: found {unknown[0]}; {hint}")


def _export_run(
    chosen: ExportFormat,
    directory: Path,
    output: Path,
    only: tuple[str, ...],
    selected: Selection,
) -> list[Path]:
    """Export a run, or parts or selected rows of it."""
    if not selected.is_empty:
        return _selected(chosen, directory, output, only, selected)
    if only:
        return _some(chosen, directory, output, only)
    return chosen.run(directory, output)


def _export(
    directory: Path, to: str, output: Path, only: tuple[str, ...], selected: Selection
) -> list[Path]:
    chosen = export_format(to)
    _refuse_wrong_parts(chosen, to, only)
    if not is_scan(directory):
        return _export_run(chosen, directory, output, only, selected)
    if only or not selected.is_empty:
        superfluous = ", ".join(filter(None, ("--only" if only else "", selected.words)))
        raise InputError(
            f"{directory}: is a scan, which is exported as a single table; remove {superfluous}"
        )
    if chosen.scan is None:
        able = " or ".join(name for name in export_names() if export_format(name).scan)
        raise InputError(
            f"{directory}: is a scan, but --to {to} exports a single run; use the directory of a "
            f"point, {directory / 'points'}/ID (see scan.csv), or use --to {able}"
        )
    try:
        scan = read_scan(directory)
    except OutputFormatError as error:
        raise InputError(str(error)) from None
    with staged(output) as (path_of, placed):
        chosen.scan(scan, path_of)
    return placed
