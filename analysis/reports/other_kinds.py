"""Inferred forces, bands, modes and transmission: their outcome in sentences, and tables with a row for each value."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.analysis.document.model import BLANK, Cell, Column, Table, is_number, value_cell
from granwave.analysis.formatting.numbers import plain
from granwave.analysis.inference import tables as inference
from granwave.analysis.quantities import quantity
from granwave.analysis.reports.inputs import Run
from granwave.analysis.spectra import quantities as spectra
from granwave.lammps_inputs.run_directory import SPECTRA_FILE

_PASSES = 0.5  # of the driven grain's amplitude
_MOST_STRETCHES = 3  # of frequency, in a sentence
_EXACT = 1e-9  # below which what is unexplained is rounding
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
TITLES = {"inference": "Inferred forces", "bands": "Bands", "modes": "Modes", "transmission": "Transmission"}
_PER_CENT, _ROUNDING = 100.0, 1e-9  # shares below are errors of rounding
_OF_WAVES = {entry.name: entry for entry in (*spectra.OF_BANDS, *spectra.OF_MODES, *spectra.OF_TRANSMISSION)}


def label_in(run: Run, key: str) -> str:
    """Return the label of a value of such a result; empty if it is not known."""
    entries = inference.QUANTITIES if run.is_inference else _OF_WAVES
    return entries[key].label if key in entries else ""


def by_kind(runs: Sequence[Run]) -> list[list[Run]]:
    """Return the inferences, and the small waves of each kind, of some runs."""
    found: dict[str, list[Run]] = {}
    for run in runs:
        if not run.has_balance:
            found.setdefault(str(run.summary.get("kind")), []).append(run)
    return list(found.values())


def table_of(runs: Sequence[Run], caption: str) -> Table:
    """Make a table of inferences or small waves: a row for each value, a column for each run."""
    entries = _OF_INFERENCE if runs[0].is_inference else _OF_SPECTRA
    rows = []
    for key in entries:
        label, unit = label_in(runs[0], key), quantity(key).unit
        unit, scale = ("%", _PER_CENT) if key in _IN_PER_CENT else _SHOWN_IN.get(unit, (unit, 1.0))
        cells = [_span_cell(run.summary.get(key), scale) for run in runs]
        rows.append((Cell(label, label), *cells, Cell(unit)))
    heads = [run.label for run in runs] if len(runs) > 1 else ["Value"]
    columns = (Column("Quantity", key=True), *(Column(head, numeric=True) for head in heads), Column("Unit"))
    kept = tuple(row for row in rows if any(cell.text != BLANK for cell in row[1:-1]))
    return Table(caption, columns, kept, captioned=len(runs) > 1, by_row=True)


def _span_cell(value: Any, scale: float) -> Cell:
    """Return the cell of a number, or of the range of several."""
    values = [one for one in (value if isinstance(value, list) else [value]) if is_number(one)]
    if not values:
        return value_cell(None)
    if scale == _PER_CENT and 0 < max(values) < _ROUNDING:
        return Cell(f"< {plain(f'{scale * _ROUNDING:.0e}')}", max(values))
    low, high = (value_cell(one * scale if scale != 1 else one) for one in (min(values), max(values)))
    return low if low.text == high.text else Cell(f"{low.text} to {high.text}", low.value)


def in_words(run: Run) -> str:
    """Return what came out of an inference, of bands, modes or a transmission."""
    return _WORDS[str(run.summary.get("kind"))](run)


def share(value: float) -> str:
    """Return a share in per cent, with three digits."""
    return f"{plain(f'{100 * value:.3g}')} %"


def _of_inference(run: Run) -> str:
    """Return how many contacts bear how large forces, how far these are off, and what they leave unexplained."""
    found, contacts, largest = (_numbers(run, key) for key in ("n_loaded_contacts", "n_contacts", "largest_force_N"))
    clear = _numbers(run, "n_significant_contacts")
    parts = []
    if found and contacts and largest:
        above = " above two standard errors" if clear else ""
        verb = "bears" if (clear or found) == [1.0] else "bear"
        parts.append(
            f"{_span(clear or found, 'd')} of {_span(contacts, 'd')} contacts {verb} a force{above}, at most "
            f"{_span(largest, '.4g')} N."
        )
    noise, true = _numbers(run, "noise"), _numbers(run, "true_force_error")
    if true:
        of_noise = f", for noise of {_span([100 * one for one in noise], '.3g')} %" if any(noise) else ""
        parts.append(f"These forces are off by {_error(true)} of the true ones{of_noise}.")
    elif errors := _numbers(run, "standard_error_fraction"):
        parts.append(f"Their standard error is {_error(errors)} of the forces.")
    else:
        parts.append("Their standard errors are not known, for no noise is given.")
    residual = _numbers(run, "residual_fraction")
    if residual:
        parts.append(f"What these forces leave unexplained is {_error(residual)} of the data.")
    return " ".join(parts)


def _numbers(run: Run, key: str) -> list[float]:
    """Return the numbers of a value of the summary, of all instants; empty without any."""
    value = run.summary.get(key)
    values = value if isinstance(value, list) else [value]
    return [float(one) for one in values if isinstance(one, int | float) and not isinstance(one, bool)]


def _span(values: Sequence[float], form: str) -> str:
    low, high = (format(round(one) if form == "d" else one, form) for one in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def _error(values: Sequence[float]) -> str:
    """Return shares in per cent, with two digits; rounding is none."""
    return f"{_span([100 * one for one in values], '.2g')} %" if max(values) > _EXACT else "less than 1e-7 %"


def _of_bands(run: Run) -> str:
    gap, width = run.summary.get("widest_gap_Hz"), run.number("widest_gap_relative")
    top, decay = run.number("highest_frequency_Hz"), run.number("attenuation_in_widest_gap")
    plane, speeds = run.number("attenuation_spacing_m"), _numbers(run, "speeds_m_s")
    parts = []
    if isinstance(gap, list) and width is not None:
        text = f"No wave passes from {1e-3 * gap[0]:.4g} to {1e-3 * gap[1]:.4g} kHz, the widest gap ({share(width)} of "
        text += "its middle)"
        if decay is not None and plane is not None:
            text += f"; there amplitudes fall by up to {share(1 - float(np.exp(-decay)))} every {1e3 * plane:.4g} mm"
        parts.append(f"{text}.")
    else:
        parts.append("There is no gap between the bands.")
    lowest = [edges[0] for edges in run.summary.get("band_edges_Hz") or [] if edges and edges[0] is not None]
    if lowest and min(lowest) > 0:
        parts.append(f"Nothing passes below {1e-3 * min(lowest):.4g} kHz.")
    if top is not None and (run.number("n_bands") or 0) >= (run.number("n_freedoms") or 0):
        parts.append(f"Nothing passes above {1e-3 * top:.4g} kHz.")
    if speeds:
        listed = " and ".join(dict.fromkeys(f"{one:.4g}" for one in speeds))
        parts.append(f"Long waves run at {listed} m/s.")
    return " ".join(parts)


def _of_modes(run: Run) -> str:
    low, high, ratio = (
        run.number(key) for key in ("lowest_frequency_Hz", "highest_frequency_Hz", "least_participation_ratio")
    )
    count, grains = run.number("n_modes"), run.number("n_grains")
    if low is None or count is None:
        return ""
    text = f"{count:.0f} modes from {1e-3 * low:.4g}" + (f" to {1e-3 * high:.4g} kHz." if high else " kHz up.")
    if ratio is not None and grains:
        text += f" The most localised moves as {ratio * grains:.2g} of {grains:.0f} grains would alike."
    return text


def _of_transmission(run: Run) -> str:
    """Return at which frequencies the motion of the drive comes through."""
    drive = run.summary.get("drive")
    try:
        with h5py.File(run.directory / SPECTRA_FILE, "r") as file:
            names = ("frequency", "amplitude_ratio", "sensor")
            frequency, ratio, sensors = (file[f"transmission/{name}"][()] for name in names)
    except (OSError, KeyError):
        return ""
    parts = []
    for sensor, amplitude in zip(sensors, ratio.T, strict=True):
        stretches = _stretches(1e-3 * frequency, amplitude >= _PASSES)
        passes = (
            f"at least half as much as grain {drive} {stretches}" if stretches else f"less than half of grain {drive}"
        )
        peak = int(np.argmax(amplitude))
        most = f"{amplitude[peak]:.4g} times at {1e-3 * frequency[peak]:.4g} kHz"
        parts.append(f"Grain {sensor} moves {passes}, at most {most}.")
    return " ".join(parts)


def _stretches(frequency: NDArray[np.float64], passes: NDArray[np.bool_]) -> str:
    """Return where a motion passes: ``at 0.5 to 16.4 kHz``; empty where it never does."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], passes, [False]]).astype(int)))
    found = [f"{frequency[start]:.4g} to {frequency[stop - 1]:.4g}" for start, stop in edges.reshape(-1, 2)]
    if not found:
        return ""
    more = " and elsewhere" if len(found) > _MOST_STRETCHES else ""
    return f"at {', '.join(found[:_MOST_STRETCHES])} kHz{more}"


_WORDS: dict[str, Callable[[Run], str]] = {
    "inference": _of_inference,
    "bands": _of_bands,
    "modes": _of_modes,
    "transmission": _of_transmission,
}
