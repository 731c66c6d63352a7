"""Tables of inferred forces, and of bands, modes and transmission: a row for each value, a column for each result."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from granwave.analysis.document.cells import BLANK, is_number, value_cell
from granwave.analysis.document.model import Cell, Column, Table
from granwave.analysis.formatting.numbers import plain
from granwave.analysis.inference import tables as inference
from granwave.analysis.reports.inputs import Run
from granwave.analysis.spectra import quantities as spectra

#: Rows of other kinds of results: key, label, unit, and how many of it make one of summary.json.
_OF_INFERENCE = (
    ("n_grains", "Grains", "", 1.0),
    ("n_contacts", "Candidate contacts", "", 1.0),
    ("n_significant_contacts", "Contacts with a force above two standard errors", "", 1.0),
    ("n_loaded_contacts", "Contacts with any force", "", 1.0),
    ("n_sliding_contacts", "Contacts that slide", "", 1.0),
    ("largest_force_N", "Largest contact force", "N", 1.0),
    ("mean_normal_force_N", "Mean normal force", "N", 1.0),
    ("noise", "Noise of strains and accelerations", "%", 100.0),
    ("true_force_error", "Error of the forces, of the true ones", "%", 100.0),
    ("standard_error_fraction", "Standard error of the forces", "%", 100.0),
    ("acceleration_error", "Error of the accelerations", "%", 100.0),
    ("residual_fraction", "Unexplained, of the data", "%", 100.0),
    ("chi2_per_equation", "Chi squared for each free equation", "", 1.0),
    ("youngs_modulus_Pa", "Young's modulus", "GPa", 1e-9),
    ("youngs_modulus_error_Pa", "Standard error of Young's modulus", "GPa", 1e-9),
    ("n_equations", "Equations", "", 1.0),
    ("n_unknowns", "Unknowns", "", 1.0),
)
_OF_SPECTRA = (
    ("highest_frequency_Hz", "Highest frequency", "kHz", 1e-3),
    ("lowest_frequency_Hz", "Lowest frequency", "kHz", 1e-3),
    ("widest_gap_Hz", "Widest gap", "kHz", 1e-3),
    ("widest_gap_relative", "Its width, of its middle", "%", 100.0),
    ("attenuation_in_widest_gap", "Largest attenuation there, from plane to plane (ln)", "", 1.0),
    ("attenuation_spacing_m", "Distance of these planes", "mm", 1e3),
    ("speeds_m_s", "Speeds of long waves", "m/s", 1.0),
    ("largest_amplitude_ratio", "Largest amplitude of each sensor, over the drive's", "", 1.0),
    ("least_participation_ratio", "Smallest participation ratio", "", 1.0),
    ("static_force_N", "Mean static force", "N", 1.0),
    ("contact_stiffness_N_per_m", "Mean contact stiffness", "N/m", 1.0),
    ("unit_frequency_Hz", "Unit of frequency, root of stiffness over mass", "kHz", 1e-3),
    ("n_grains_in_cell", "Grains of the cell", "", 1.0),
    ("n_grains", "Grains", "", 1.0),
    ("n_left_out", "Grains left out, that bear no load", "", 1.0),
    ("n_contacts_in_cell", "Contacts of the cell", "", 1.0),
    ("n_contacts", "Contacts that bear a force", "", 1.0),
    ("n_bands", "Bands", "", 1.0),
    ("n_modes", "Modes", "", 1.0),
    ("n_floppy", "Floppy modes", "", 1.0),
)
_TITLES = {"inference": "Inferred forces", "bands": "Bands", "modes": "Modes", "transmission": "Transmission"}
_PER_CENT, _ROUNDING = 100.0, 1e-9  # shares below are errors of rounding
_LABELS = {
    entry.name: entry.label
    for entry in (*inference.ENTRIES, *spectra.OF_BANDS, *spectra.OF_MODES, *spectra.OF_TRANSMISSION)
}


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
    for key, label, unit, scale in entries:
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


def label_in(key: str) -> str:
    """Return the label of a value of these results; empty if it has none."""
    return _LABELS.get(key, "")


def title_of(runs: Sequence[Run]) -> str:
    """Return the title of the table of results of one kind."""
    return _TITLES[str(runs[0].summary.get("kind"))]
