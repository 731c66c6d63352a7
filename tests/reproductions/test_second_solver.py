"""Tables of the second solvers next to the studies: parts are computed again, and all of them under
the marker ``validation``.
"""

from __future__ import annotations

from typing import Any

import pytest

from granwave.analysis.measures.hertz_lattices import discrete_speed, discrete_width
from granwave.analysis.studies.registry import load_study
from granwave.workflows import load_case
from tests.helpers import second_solver
from tests.helpers.bodies.symmetric_row import SymmetricRow
from tests.helpers.programs.scripts import FOLDER
from tests.helpers.twins import viscous_twin

ROOT = FOLDER.parent
SOLITARY = load_study(str(FOLDER / "thesis" / "chapter_4" / "solitary_wave.py"))
SHORT = {"chapter_8": [0, 9], "chapter_7": [], "chapter_5": [0, 1]}  # cheap and unlike


def numbers(row: dict[str, str]) -> dict[str, float]:
    """Numbers of a row of a table."""
    return {name: float(value) for name, value in row.items() if is_number(value)}


def is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def compare(chapter: str, chosen: list[Any]) -> None:
    """Compute some rows of a chapter again, and compare each with its table."""
    _, solve = second_solver.CHAPTERS[chapter]
    rows = second_solver.table(chapter)
    for one in chosen:
        row = second_solver.written(solve(one))
        key = list(row.items())[: second_solver.N_KEYS[chapter]]
        (stored,) = [kept for kept in rows if list(kept.items())[: len(key)] == key]
        assert numbers(row) == pytest.approx(numbers(stored), rel=1e-4), one


@pytest.mark.parametrize("chapter", [name for name, chosen in SHORT.items() if chosen])
def test_part_of_a_table(chapter: str) -> None:
    cases, _ = second_solver.CHAPTERS[chapter]
    everything = cases()
    compare(chapter, [everything[n] for n in SHORT[chapter]])


@pytest.mark.validation
@pytest.mark.parametrize("chapter", SHORT)
def test_a_whole_table(chapter: str) -> None:
    cases, _ = second_solver.CHAPTERS[chapter]
    chosen = cases()
    compare(chapter, chosen)
    assert len(second_solver.table(chapter)) <= len(chosen)


@pytest.mark.parametrize("chapter", SHORT)
def test_a_row_stands_once(chapter: str) -> None:
    rows = second_solver.table(chapter)
    keys = {tuple(row.values())[: second_solver.N_KEYS[chapter]] for row in rows}
    assert len(keys) == len(rows) > 10


def test_table_of_the_page() -> None:
    """Numbers on the page agree with the solver."""
    rows = second_solver.table("chapter_5")
    small = [row for row in rows if row["packing"] == "small"]
    fractions = {(row["velocity_m_s"], row["normals"]): row["dissipated_fraction"] for row in small}
    page = (ROOT / "docs" / "explanation" / "proof.md").read_text(encoding="utf-8")
    for velocity in map(str, second_solver.VELOCITIES):
        fixed = float(fractions[velocity, "of the start"])
        true = float(fractions[velocity, "true"])
        assert f"| {velocity} | {fixed:.4f} | {true:.4f} |" in page


def test_short_row_of_the_filter() -> None:
    """First contacts of a row of chapter 7, before the wave has gone far, and its static state."""
    case = load_case("filter-row")
    row = SymmetricRow.of(case)
    peaks, _ = row.struck(case.load.index[0] - 1, 1.0, 2e-4)
    rows = second_solver.table("chapter_7")
    (stored,) = [kept for kept in rows if list(kept.values())[:3] == ["2700", "0.56", "0.0008"]]
    assert peaks[20] == pytest.approx(float(stored["contact_21_N"]), rel=1e-4)
    assert row.side_stiffness == pytest.approx(float(stored["side_stiffness"]), rel=1e-6)
    assert row.wall_force()[0] == pytest.approx(float(stored["wall_force_N"]), rel=1e-6)


def test_constants_of_the_discrete_chain() -> None:
    """Peak force of an impulse, speed and width of the wave far down a chain, of `viscous_twin` and
    of the lattice.
    """
    modulus = 115e9
    ratio = 0.3
    radius = 0.005
    density = 8500.0
    speed = 1.0
    n = 60
    mass = density * 4 / 3 * 3.141592653589793 * radius**3
    law = viscous_twin.hertz(modulus, ratio, radius)
    found = viscous_twin.chain(law, mass, n, speed, 9e-4)
    force = found["force"][40]
    effective = modulus / (2 * (1 - ratio**2))
    unit = (mass**3 * effective**2 * radius / 2 * speed**6) ** 0.2
    assert force.max() / unit == pytest.approx(SOLITARY.DISCRETE["coefficient"], abs=2e-4)
    assert SOLITARY.DISCRETE["speed"] == discrete_speed()
    assert discrete_width() == pytest.approx(SOLITARY.DISCRETE["width"], abs=5e-4)
