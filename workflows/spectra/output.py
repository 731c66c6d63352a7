"""Files of bands, modes and transmission in a directory of results."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from granwave.analysis.figures.style import Columns, Drawing, FigureFolder, style, write_csv
from granwave.analysis.spectra.files import Table, case_in, write_spectra
from granwave.analysis.spectra.states import State
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import plain, replace_text, replacing
from granwave.lammps_inputs.ownership import claim, clear, refuse_foreign, refuse_other_kind, results_in
from granwave.lammps_inputs.run_directory import SPECTRA, SPECTRA_FILE
from granwave.workflows.run.directory import held

Figures = Mapping[str, Callable[[], Drawing | None]]


def check_place(directory: Path, name: str, *, force: bool, case: str | None = None) -> Path:
    """Return the absolute path of a directory for results of this name.

    Parameters
    ----------
    case
        Text of the case; None where it is known later alone.

    Raises
    ------
    InputError
        It holds such results already, those of another case or kind, or files that granwave did not write.
    """
    place = results_directory(directory, force=force)
    refuse_other_kind(place, SPECTRA)
    names = _names(name)
    others = [one for one in results_in(place) if one not in names and one.endswith((".csv", ".json"))]
    if not force and case is not None and others and case_in(place / SPECTRA_FILE) not in ("", case):
        raise InputError(
            f"{place}: holds results of another case ({others[0]}); --force replaces its {SPECTRA_FILE}, or choose "
            "another directory with -o"
        )
    if not force and (there := sorted(set(names) & set(results_in(place)))):
        raise InputError(
            f"{place}: already holds results ({there[0]}); --force replaces them, or choose another directory with -o"
        )
    refuse_foreign(place, [*names, SPECTRA_FILE])
    return place


def write_output(
    directory: Path,
    name: str,
    state: State,
    tables: Mapping[str, Table],
    columns: Columns,
    summary: Mapping[str, Any],
    figures: Figures,
) -> list[Path]:
    """Write NAME.csv, NAME.json, the groups of spectra.h5 and the figures; return the paths of the files."""
    with held(directory):
        names = _names(name)
        if case_in(directory / SPECTRA_FILE) not in ("", state.case.to_toml()):
            clear(directory)  # with --force: tables of the other case would lie beside those of this one
        claim(directory, [*names, SPECTRA_FILE], kind=SPECTRA)
        write_spectra(directory / SPECTRA_FILE, state, tables)
        with replacing(directory / names[0]) as scratch:
            write_csv(columns, scratch)
        replace_text(directory / names[1], json.dumps(plain(dict(summary)), indent=1, allow_nan=False) + "\n")
        folder = FigureFolder(directory)
        with style():
            for figure, draw in figures.items():
                folder.draw(draw, figure)
    return [directory / one for one in (*names, SPECTRA_FILE)] + folder.written


def _names(name: str) -> Sequence[str]:
    return [f"{name}.csv", f"{name}.json"]
