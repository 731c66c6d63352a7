"""Main values of an inference for the terminal and notebooks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from granwave.analysis.summary_table import lines


def in_words(summary: Mapping[str, Any]) -> str:
    """Return the main values, a line each."""

    def shown(key: str, form: str, factor: float = 1.0) -> str:
        values = summary.get(key)
        if not isinstance(values, list):
            values = [values]
        numbers = [value if factor == 1 else factor * value for value in values if isinstance(value, int | float)]
        if not numbers:
            return ""
        low, high = format(min(numbers), form), format(max(numbers), form)
        return low if low == high else f"{low} to {high}"

    significant = shown("n_significant_contacts", "d")
    counted = ("n_significant_contacts" if significant else "n_loaded_contacts", "d")
    above = " above two standard errors" if significant else ""
    rows = [
        ("grains", shown("n_grains", "d")),
        ("contacts", f"{shown('n_contacts', 'd')}, {shown(*counted)} of them bear a force{above}"),
        (
            "equations",
            f"{shown('n_equations', 'd')} for {shown('n_unknowns', 'd')} unknowns, {summary['weights']} weights",
        ),
        ("largest force", f"{shown('largest_force_N', '.4g')} N"),
        ("residuals", f"{shown('residual_fraction', '.2g', 100)} % of the data"),
    ]
    if instants := summary["n_instants"] - 1:
        rows.insert(0, ("instants", str(instants + 1)))
    if text := shown("chi2_per_equation", ".3g"):
        rows.append(("chi^2", f"{text} for each free equation (1: as the noise)"))
    if text := shown("standard_error_fraction", ".2g", 100):
        rows.append(("standard error", f"{text} % of the forces, from {summary['repetitions']} repetitions"))
    if text := shown("youngs_modulus_error_Pa", ".2g", 1e-6):
        rows.append(("Young's modulus", f"{shown('youngs_modulus_Pa', '.4g', 1e-6)} +- {text} MPa"))
    if text := shown("acceleration_error", ".2g", 100):
        rows.append(("accelerations", f"off by {text} %"))
    if text := shown("true_force_error", ".2g", 100):
        rows.append(("forces", f"off by {text} % of the true ones"))
    return lines([*rows, *(("note", note) for note in summary["notes"])])
