"""A comparison as a separate page, with its figures as files next to it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from granwave.analysis.document.model import Link
from granwave.analysis.figures.style import OWN_PICTURES, Drawing, save, style
from granwave.analysis.reports.comparison.compare import BOTTOM_FORCE, compare_inputs
from granwave.analysis.reports.comparison.comparison import Comparison
from granwave.analysis.reports.comparison.figures.registry import FIGURES
from granwave.analysis.reports.inputs import ReportInputs, read_inputs
from granwave.analysis.reports.outline import build_comparison
from granwave.analysis.reports.report import output_faults, write_page
from granwave.lammps_inputs.directories import output_path, refuse_other_file
from granwave.lammps_inputs.errors import InputError, InputFault
from granwave.lammps_inputs.own_files import AnyPath
from granwave.lammps_inputs.run_directory import FIGURE_SUFFIXES

_TABLE = ".csv"


def write_comparison(
    directories: Sequence[str | Path],
    output: str | Path,
    quantities: Sequence[str] = (),
    measured: AnyPath | None = None,
    measured_as: str = BOTTOM_FORCE,
    *,
    shift: float = 0.0,
    scale: float = 1.0,
) -> tuple[Comparison, Path]:
    """Compare runs, and write the page and its figures; older files of this name are replaced.

    Parameters
    ----------
    directories
        Directories of runs and scans, whose finished points are compared.
    output
        Path of the page: ``.html``, ``.pdf`` or ``.md``; figures go to ``NAME_figures`` next to it.
    quantities, measured, measured_as, shift, scale
        As of `granwave.analysis.reports.comparison.compare.compare_runs`.

    Raises
    ------
    InputError
        A directory is no result, a name is unknown, a file cannot be read, or another file has the
        name of an output file. Nothing was written.
    RunError
        Writing failed, on a full disk for instance.
    """
    output = output_path(output)
    folder = figure_folder(output)
    errors = output_faults(output)
    errors += _other_figures(folder)
    inputs: ReportInputs | None = None
    try:
        inputs = read_inputs(directories, output.parent, repeated=True, skip_unfinished=True)
        comparison = compare_inputs(
            inputs, quantities, measured, measured_as, shift=shift, scale=scale
        )
    except InputError as error:
        raise InputError([*errors, *error.items]) from None
    if errors:
        raise InputError(errors)
    link = Link(f"{folder.name}/", quote(os.fsencode(folder.name)))
    report = build_comparison(inputs, comparison, link)
    _save_figures(comparison, folder)
    write_page(report, output)
    return comparison, output


def figure_folder(output: Path) -> Path:
    """Return the folder of the figures of a page."""
    return output.with_name(f"{output.stem}_figures")


def _other_figures(folder: Path) -> list[str | InputFault]:
    """Return messages for files that granwave did not write and that have the name of a figure."""
    if folder.exists() and not folder.is_dir():
        return [
            f"{folder}: is a file, but the figures require a directory of this name; move it "
            "elsewhere"
        ]
    if not folder.exists():
        return []
    errors: list[str | InputFault] = []
    for name in FIGURES:
        for suffix in FIGURE_SUFFIXES:
            if suffix in OWN_PICTURES:
                errors += _refusal(folder / f"{name}{suffix}", OWN_PICTURES[suffix])
        table = folder / f"{name}{_TABLE}"
        if table.exists() and not table.with_suffix(".png").exists():
            errors.append(f"{table}: was not written by granwave; move it elsewhere")
    return errors


def _refusal(path: Path, own: bytes) -> list[Any]:
    try:
        refuse_other_file(path, own)
    except InputError as error:
        return list(error.items)
    return []


def _save_figures(comparison: Comparison, folder: Path) -> None:
    """Save the figures as PNG, PDF and CSV; remove the figures of an older comparison."""
    with style():
        drawings = {name: comparison.drawing(name) for name in comparison.wanted_figures}
        present = {
            name: drawing for name, drawing in drawings.items() if isinstance(drawing, Drawing)
        }
        if present:
            folder.mkdir(exist_ok=True)
        for name in FIGURES:
            if name not in present:
                for suffix in FIGURE_SUFFIXES:
                    (folder / f"{name}{suffix}").unlink(missing_ok=True)
        for name, drawing in present.items():
            save(drawing, folder / name)
