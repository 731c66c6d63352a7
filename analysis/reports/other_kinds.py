"""Sentences on runs, inferred forces and small waves, and tables of the latter with a row for each
value.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import h5py
import numpy as np

from granwave.analysis.document.model import (
    BLANK,
    Cell,
    DocumentTable,
    TableColumn,
    is_number,
    value_cell,
)
from granwave.analysis.formatting.numbers import plain
from granwave.analysis.quantities import quantity
from granwave.analysis.reports.inputs import ReportRun
from granwave.analysis.reports.setting import range_in
from granwave.extensions.inference.forces import tables as inference
from granwave.extensions.waves.spectra import quantities as spectra
from granwave.lammps_inputs.files import regular
from granwave.lammps_inputs.run_directory import SPECTRA_FILE

_PASSES = 0.5  # of the driven grain's amplitude
_MOST_STRETCHES = 3  # of frequency, in a sentence
#: Rows of other kinds of results, by their keys in summary.json.
_OF_INFERENCE = (
    "n_grains", "n_contacts", "n_significant_contacts", "n_loaded_contacts", "n_sliding_contacts", "largest_force_N",
    "mean_normal_force_N", "noise", "true_force_error", "standard_error_fraction", "acceleration_error",
    "residual_fraction", "chi2_per_equation", "youngs_modulus_Pa", "youngs_modulus_error_Pa", "n_equations",
    "n_unknowns",
)  # fmt: skip
_OF_SPECTRA = (
    "highest_frequency_Hz", "lowest_frequency_Hz", "widest_gap_Hz", "widest_gap_relative",
    "attenuation_in_widest_gap", "attenuation_spacing_m", "speeds_m_s", "largest_amplitude_ratio",
    "least_participation_ratio", "static_force_N", "contact_stiffness_N_per_m", "unit_frequency_Hz",
    "n_grains_in_cell", "n_grains", "n_left_out", "n_contacts_in_cell", "n_contacts", "n_bands", "n_modes", "n_floppy",
)  # fmt: skip
_IN_PER_CENT = (
    "noise", "true_force_error", "standard_error_fraction", "acceleration_error", "residual_fraction",
    "widest_gap_relative",
)  # fmt: skip
_SHOWN_IN = {"Hz": ("kHz", 1e-3), "Pa": ("GPa", 1e-9), "m": ("mm", 1e3)}
TITLES = {
    "inference": "Inferred forces",
    "bands": "Bands",
    "modes": "Modes",
    "transmission": "Transmission",
}
# shares below are errors of rounding
_PER_CENT = 100.0
_ROUNDING = 1e-9
_SENTENCES = {  # by kind of result; those whose values are all there are shown
    "inference": (
        "{n_loaded_contacts} of {n_contacts} contacts bear a force, at most {largest_force_N}.",
        "{n_significant_contacts} of them bear a force above two standard errors.",
        "These forces are off by {true_force_error} of the true ones, for noise of {noise}.",
        "Their standard error is {standard_error_fraction} of the forces.",
        "What these forces leave unexplained is {residual_fraction} of the data.",
    ),
    "bands": (
        "No wave passes at {widest_gap_Hz}, the widest gap ({widest_gap_relative} of its middle).",
        "Nothing passes below {lowest_edge_Hz}.",
        "Nothing passes above {highest_edge_Hz}.",
        "Long waves run at {speeds_m_s}.",
    ),
    "modes": (
        "{n_modes} modes from {lowest_frequency_Hz} on.",
        "The highest frequency is {highest_frequency_Hz}.",
        "The least participation ratio is {least_participation_ratio}.",
    ),
}
_OF_WAVES = {
    entry.name: entry for entry in (*spectra.OF_BANDS, *spectra.OF_MODES, *spectra.OF_TRANSMISSION)
}


def label_in(run: ReportRun, key: str) -> str:
    """Return the label of a value of such a result; empty if it is not known."""
    entries = inference.QUANTITIES if run.is_inference else _OF_WAVES
    return entries[key].label if key in entries else ""


def by_kind(runs: Sequence[ReportRun]) -> list[list[ReportRun]]:
    """Return the inferences, and the small waves of each kind, of some runs."""
    found: dict[str, list[ReportRun]] = {}
    for run in runs:
        if not run.has_balance:
            found.setdefault(str(run.summary.get("kind")), []).append(run)
    return list(found.values())


def table_of(runs: Sequence[ReportRun], caption: str) -> DocumentTable:
    """Make a table of inferences or small waves: a row for each value, a column for each run."""
    entries = _OF_INFERENCE if runs[0].is_inference else _OF_SPECTRA
    rows = []
    for key in entries:
        label = label_in(runs[0], key)
        unit = quantity(key).unit
        unit, scale = ("%", _PER_CENT) if key in _IN_PER_CENT else _SHOWN_IN.get(unit, (unit, 1.0))
        cells = [_span_cell(run.summary.get(key), scale) for run in runs]
        rows.append((Cell(label, label), *cells, Cell(unit)))
    heads = [run.label for run in runs] if len(runs) > 1 else ["Value"]
    columns = (
        TableColumn("Quantity", key=True),
        *(TableColumn(head, numeric=True) for head in heads),
        TableColumn("Unit"),
    )
    kept = tuple(row for row in rows if any(cell.text != BLANK for cell in row[1:-1]))
    return DocumentTable(caption, columns, kept, captioned=len(runs) > 1, by_row=True)


def _span_cell(value: Any, scale: float) -> Cell:
    """Return the cell of a number, or of the range of several."""
    values = [one for one in (value if isinstance(value, list) else [value]) if is_number(one)]
    if not values:
        return value_cell(None)
    if scale == _PER_CENT and 0 < max(values) < _ROUNDING:
        return Cell(f"< {plain(f'{scale * _ROUNDING:.0e}')}", max(values))
    low, high = (
        value_cell(one * scale if scale != 1 else one) for one in (min(values), max(values))
    )
    return low if low.text == high.text else Cell(f"{low.text} to {high.text}", low.value)


def sentences(texts: Iterable[str], values: Mapping[str, str]) -> str:
    """Return the sentences of which all values are known, with these values."""
    known = []
    for text in texts:
        with contextlib.suppress(KeyError):
            known.append(text.format_map(values))
    return " ".join(known)


def printed(summary: Mapping[str, Any]) -> dict[str, str]:
    """Return the numbers of a summary by key, with units, shares in per cent, and lists as ranges."""
    found = {}
    for key, value in summary.items():
        numbers = [one for one in (value if isinstance(value, list) else [value]) if is_number(one)]
        if not numbers:
            continue
        if key in _IN_PER_CENT or key.endswith("_fraction") or key == "transmission":
            found[key] = " to ".join(dict.fromkeys(map(share, (min(numbers), max(numbers)))))
        else:
            found[key] = (
                str(value) if isinstance(value, int) else range_in(numbers, quantity(key).unit)
            )
    return found


def share(value: float) -> str:
    """Return a share in per cent, with three digits; rounding is none."""
    return f"{plain(f'{100 * value:.3g}')} %" if abs(value) > _ROUNDING else "0 %"


def in_words(run: ReportRun) -> str:
    """Return what came out of an inference, of bands, modes or a transmission."""
    kind = str(run.summary.get("kind"))
    summary = dict(run.summary)
    if kind == "transmission":
        return _of_transmission(run)
    if kind == "bands":
        lowest = [
            edges[0]
            for edges in summary.get("band_edges_Hz") or []
            if edges and edges[0] is not None
        ]
        summary["lowest_edge_Hz"] = min(lowest, default=0.0) or None
        complete = (run.number("n_bands") or 0) >= (run.number("n_freedoms") or 0)
        summary["highest_edge_Hz"] = summary.get("highest_frequency_Hz") if complete else None
    text = sentences(_SENTENCES[kind], printed(summary))
    return (
        text
        if kind != "bands" or summary.get("widest_gap_Hz")
        else f"There is no gap between the bands. {text}"
    )


def _of_transmission(run: ReportRun) -> str:
    """Return at which frequencies at least half of the motion of the drive comes through."""
    try:
        with h5py.File(regular(run.directory / SPECTRA_FILE), "r") as file:
            names = ("frequency", "amplitude_ratio", "sensor")
            frequency, ratio, sensors = (file[f"transmission/{name}"][()] for name in names)
    except (OSError, KeyError):
        return ""
    parts = []
    for sensor, amplitude in zip(sensors, ratio.T, strict=True):
        passes = np.concatenate([[False], amplitude >= _PASSES, [False]]).astype(int)
        edges = np.flatnonzero(np.diff(passes)).reshape(-1, 2)
        stretches = [
            f"{1e-3 * frequency[start]:.4g} to {1e-3 * frequency[stop - 1]:.4g}"
            for start, stop in edges
        ]
        more = " and elsewhere" if len(stretches) > _MOST_STRETCHES else ""
        where = f"at {', '.join(stretches[:_MOST_STRETCHES])} kHz{more}" if stretches else "nowhere"
        peak = int(np.argmax(amplitude))
        parts.append(
            f"Grain {sensor} moves at least half as much as grain {run.summary.get('drive')} {where}, at most "
            f"{amplitude[peak]:.4g} times at {1e-3 * frequency[peak]:.4g} kHz."
        )
    return " ".join(parts)
