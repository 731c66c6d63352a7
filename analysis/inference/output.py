"""Output files of an inference: forces.csv, grains.csv, summary.json and figures."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import tomli_w

from granwave.analysis.figures.style import Columns, Drawing, FigureFolder, style, write_csv
from granwave.analysis.inference import drawings
from granwave.analysis.inference.infer import Inference
from granwave.analysis.inference.tables import force_columns, grain_columns
from granwave.lammps_inputs.files import plain, replace_text, replacing
from granwave.lammps_inputs.ownership import claim, clear, figure_files
from granwave.lammps_inputs.run_directory import (
    INFERENCE,
    INFERRED_FORCES,
    INFERRED_GRAINS,
    MADE_CASE,
    MADE_MEASUREMENT,
    SUMMARY_FILE,
)

FIGURES = ("force_network", "residuals", "force_errors", "modulus", "noise")
FILES = (INFERRED_FORCES, INFERRED_GRAINS, MADE_MEASUREMENT, MADE_CASE, SUMMARY_FILE)
WRITTEN = (*FILES, *(file for name in FIGURES for file in figure_files(name)))


def write_inference(
    directory: Path,
    found: Sequence[Inference],
    times: Sequence[float],
    summary: Mapping[str, Any],
    *,
    figures: bool = True,
    measurement: Columns | None = None,
    case: Mapping[str, Any] | None = None,
    more_forces: Columns | None = None,
    noise_drawing: Drawing | None = None,
) -> None:
    """Write the files of an inference into a directory, created if necessary; earlier ones are replaced.

    Figures show the instant with the largest force.

    Parameters
    ----------
    measurement
        Columns of measurement.csv, of measurements made of a run.
    case
        Tables of measurement.toml, the case that measurement.csv is inferred with.
    more_forces
        Further columns of forces.csv.
    noise_drawing
        Figure of the error against the noise.

    Raises
    ------
    InputError
        A file of such a name exists, and granwave did not write it.
    """
    directory.mkdir(parents=True, exist_ok=True)
    clear(directory, WRITTEN)
    written = {INFERRED_FORCES: {**force_columns(found, times), **(more_forces or {})}}
    written[INFERRED_GRAINS] = dict(grain_columns(found, times))
    if measurement is not None:
        written[MADE_MEASUREMENT] = dict(measurement)
    texts = {SUMMARY_FILE: json.dumps(plain(dict(summary)), indent=2, allow_nan=False) + "\n"}
    if case is not None:
        texts[MADE_CASE] = tomli_w.dumps(plain(dict(case)))
    claim(directory, [*written, *texts], kind=INFERENCE)
    for name, columns in written.items():
        with replacing(directory / name) as scratch:
            write_csv(columns, scratch, exact=True)
    for name, text in texts.items():
        replace_text(directory / name, text)
    if not figures:
        return
    shown = max(found, key=lambda one: float(one.force.max(initial=0.0)))
    folder = FigureFolder(directory)
    with style():
        draw = (drawings.network, drawings.residuals, drawings.errors, drawings.modulus, lambda _: noise_drawing)
        for name, one in zip(FIGURES, draw, strict=True):
            folder.draw(partial(one, shown), name)
