"""The effect of the contact law on results, as the page on limits has it, agrees with runs."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw
from tests.documents.pages import ROOT

LIMITS = ROOT / "docs" / "explanation" / "limits.md"
TEXT = LIMITS.read_text(encoding="utf-8")
DEFAULT = "elastoplastic"
FITTED = "elastoplastic-fe"
#: Columns of the first table: key of the summary, factor to the unit of the column.
QUANTITIES = (
    ("dissipated_fraction", 100.0),
    ("wall_peak_force_N", 1.0),
    ("peak_reduction", 1.0),
    ("zone_depth_90_interpolated_m", 1e3),
)
BRASS = {
    "youngs_modulus": (115e9, 115e9),
    "poisson_ratio": (0.30, 0.30),
    "yield_strength": (550e6, 550e6),
    "radius": (0.005, 0.005),
}
#: Constants with which the default law has a part of the other law.
OF_LOADING = {"pressure_limit": 2.385, "pressure_rate": 0.172}
OF_RESIDUAL = {"residual_slope": 0.762, "residual_offset": 5.36, "residual_rate": 0.131}
FITTED_RANGE = np.geomspace(1.05, 100, 60)  # overlaps in units of the overlap at first yield


def table(name: str) -> Iterator[list[str]]:
    """Iterate over the cells of a table of the page."""
    (rows,) = re.findall(rf"<!-- {name} -->\n(.*?)<!-- /{name} -->", TEXT, re.DOTALL)
    for line in rows.strip().splitlines()[2:]:
        yield [cell.strip().replace("`", "") for cell in line.strip("| ").split(" | ")]


def effects() -> dict[tuple[str, str], list[str]]:
    """Return the values of the first table by case and law."""
    found = {}
    case = ""
    for cells in table("law effects"):
        if len(cells) > len(QUANTITIES) + 1:
            case = cells.pop(0)
        law, *values = cells
        found[case, law.removeprefix("| ")] = values
    return found


EFFECTS = effects()


def law_of(name: str, **constants: float) -> ContactLaw:
    return ContactLaw(law=name, **BRASS, **constants)


def lost(law: ContactLaw, peak: float) -> float:
    """Return the fraction of the work of loading that a contact dissipates."""
    largest = peak * law.yield_overlap
    overlaps = np.linspace(0, largest, 2001)
    loading = np.trapezoid([law.force(overlap, overlap) for overlap in overlaps], overlaps)
    unloading = np.trapezoid([law.force(overlap, largest) for overlap in overlaps], overlaps)
    return 1 - unloading / loading


@pytest.mark.parametrize(("peak", "default", "fitted"), [(2, "29 %", "6 %"), (20, "59 %", "52 %")])
def test_dissipation_of_a_contact(peak, default, fitted):
    assert f"{lost(law_of(DEFAULT), peak):.0%}".replace("%", " %") == default
    assert f"{lost(law_of(FITTED), peak):.0%}".replace("%", " %") == fitted
    assert default in TEXT and f" {fitted}" in TEXT


def test_changed_constants_give_a_part_of_the_other_law():
    """The residual indentation agrees within 0.03 of the overlap, the loading within 7 %."""
    fitted = law_of(FITTED)
    parts = law_of(DEFAULT, **OF_LOADING, **OF_RESIDUAL)
    residual = []
    loading = []
    for overlap in FITTED_RANGE * parts.yield_overlap:
        difference = parts.residual_overlap(overlap) - fitted.residual_overlap(overlap)
        residual.append(difference / overlap)
        ratio = parts.force(overlap, overlap) / fitted.force(overlap, overlap)
        loading.append(ratio - 1)
    assert max(map(abs, residual)) == pytest.approx(0.03, abs=0.002)
    assert max(map(abs, loading)) == pytest.approx(0.07, abs=0.005)
    for name, value in (OF_LOADING | OF_RESIDUAL).items():
        assert f"`{name} = {value:g}`" in TEXT


PAGES = {
    "README.md": ("fcc-small", (0, 1)),
    "docs/start.md": ("fcc-small", (0, 1)),
    "docs/howto/contact-laws.md": ("fcc-small", (0, 1)),
    "docs/howto/target.md": ("protected-target", (2,)),
    "docs/howto/questions.md": ("protected-target", (2,)),
}


@pytest.mark.parametrize("page", PAGES)
def test_pages_have_the_values_of_the_table(page):
    """A page that states a result of the default law also states the result of the other law."""
    case, columns = PAGES[page]
    text = (ROOT / page).read_text(encoding="utf-8")
    for law in (DEFAULT, FITTED):
        for column in columns:
            value = EFFECTS[case, law][column]
            assert re.search(rf"(?<![\d.]){re.escape(value)}", text), (page, law, value)
    assert "effect-of-the-contact-law-on-the-results" in text


def test_ranges_in_the_text_are_of_the_table():
    """The packings are the cases with a force on the bottom."""
    packings = {case for case, _ in EFFECTS if EFFECTS[case, DEFAULT][1] != "-"}
    values = {key: [*map(float, cells[:2])] for key, cells in EFFECTS.items() if key[0] in packings}
    fractions = [values[case, DEFAULT][0] - values[case, FITTED][0] for case in packings]
    ratios = [values[case, FITTED][1] / values[case, DEFAULT][1] - 1 for case in packings]
    assert f"{min(fractions):.0f} to {max(fractions):.0f} % of the input less" in TEXT
    assert f"{100 * min(ratios):.0f} to {100 * max(ratios):.0f} % larger" in TEXT


def shown(summary: dict[str, Any], column: int, value: str) -> str:
    """Return a value of a summary with the decimals of the table."""
    key, factor = QUANTITIES[column]
    if summary[key] is None:
        return "-"
    decimals = len(value.partition(".")[2])
    return f"{factor * summary[key]:.{decimals}f}"


def summary_of(process: Callable[..., Any], folder: Path, case: str, *sets: str) -> dict[str, Any]:
    """Run a case with changed keys, and return its summary."""
    words: list[str] = []
    for one in sets:
        words += ["--set", one]
    ranks = min(2, os.cpu_count() or 1)
    done = process("run", case, "-o", folder, "--no-figures", "--np", ranks, *words, timeout=1200)
    assert done.returncode == 0, done.stderr
    return dict(json.loads((folder / "summary.json").read_text()))


@pytest.mark.validation
@pytest.mark.parametrize(("case", "law"), EFFECTS)
def test_results_with_both_laws(process, tmp_path, case, law):
    summary = summary_of(process, tmp_path / "r", case, f"contact.law={law}")
    values = EFFECTS[case, law]
    assert [shown(summary, column, value) for column, value in enumerate(values)] == values
    if (case, law) == ("fcc-small", DEFAULT):
        assert f"of the {summary['n_plastic_contacts']} contacts" in TEXT


@pytest.mark.validation
def test_the_first_page_has_both_laws(process, tmp_path):
    """Its case ends earlier than the built-in case."""
    text = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    forces = []
    for law in (DEFAULT, FITTED):
        sets = (f"contact.law={law}", "run.end_time=3e-4")
        summary = summary_of(process, tmp_path / law, "fcc-small", *sets)
        assert f"{100 * summary['dissipated_fraction']:.1f} %" in text
        forces.append(summary["wall_peak_force_N"])
    assert f"{100 * (forces[1] / forces[0] - 1):.0f} % larger" in text


@pytest.mark.validation
@pytest.mark.parametrize("row", list(table("law parts")), ids=lambda row: row[0])
def test_results_with_a_part_of_the_other_law(process, tmp_path, row):
    constants = {
        "nothing": {},
        "loading": OF_LOADING,
        "residual indentation": OF_RESIDUAL,
        "both": OF_LOADING | OF_RESIDUAL,
    }[row[0]]
    sets = [f"contact.{name}={value}" for name, value in constants.items()]
    summary = summary_of(process, tmp_path / "r", "fcc-small", *sets)
    assert [shown(summary, column, row[column - 2]) for column in (0, 1)] == row[-2:]
