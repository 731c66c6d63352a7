"""Tables of the second solvers, with which studies of the reproductions compare.

Rows with cylinders (chapters 7 and 8 of the thesis) are solved by `symmetric_row`, packings of
spheres (chapter 5) by the network of `twins.twin`. A table is next to the study that reads it:

    .venv/bin/python -m tests.helpers.second_solver [CHAPTER ...]      # writes them anew

All take some ten minutes. Tests recompute parts of them.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from granwave.lammps_inputs.case.case import Case
from granwave.measures import decay_rate, first_peak
from granwave.workflows.scanning.scan_file import load_scan
from tests.helpers.bodies.symmetric_row import SymmetricRow, soft_material
from tests.helpers.twins.twin import Network, fcc, middle_of_top

THESIS = Path(__file__).parents[2] / "reproductions" / "thesis"
TABLE = "second_solver.csv"
Row = dict[str, float | str]

FILTERS = ("pressed", "touching", "density", "density-touching", "decay", "approach")
CONTACTS = (21, 31, 61, 101, 151, 201)  # whose peak forces are kept; of spheres n and n + 1
DECAY = (71, 201)  # contacts between which the decay is measured
SWITCHES = ("open", "loose")
SENSORS = (6, 21)  # spheres; a sensor reads the mean of its two contact forces
CONTACT = 13
MOVED = (10, 25)  # spheres, near the struck one and far from it
FLOOR = 0.05  # of the largest force: lower peaks are not the first one
SIZES = {"reference": (72, 72, 30), "small": (12, 12, 8)}
VELOCITIES = (1, 5, 10, 40, 80)  # m/s, of the small packing
DIAMETER = 0.01
FAST = 20  # m/s: from here on the timestep is halved


def cases(chapter: str, scans: list[str]) -> Iterator[Case]:
    """Iterate over the cases of all points of the scans of a chapter."""
    for name in scans:
        scan = load_scan(THESIS / chapter / f"{name}.toml", here=False)
        yield from (point.case for point in scan.points)


def filter_cases() -> list[Case]:
    """Chains of chapter 7 with cylinders at all gaps."""
    return list(cases("chapter_7", [f"filter-{name}" for name in FILTERS]))


def filter_row(case: Case) -> Row:
    """Peak forces, N, and decay per contact of a row of chapter 7; before the wave K of sphere and
    cylinder, N/m^1.5, force of a wall on a cylinder, N, and shift of a cylinder, m.
    """
    row = SymmetricRow.of(case)
    end = case.run.end_time
    assert isinstance(end, float)
    assert case.load.velocity is not None
    peaks, _ = row.struck(case.load.index[0] - 1, case.load.velocity, end)
    first, last = DECAY
    diameter = 2 * row.radius
    moved = case.precompression.moves["x"] if case.precompression else 0.0
    values: Row = {
        "density_kg_m3": soft_material(case).density,
        "gamma": round(2 * row.small / diameter, 9),
        "a": round(2 * moved / diameter, 12),
        "decay_per_contact": decay_rate(np.arange(first, last + 1), peaks[first - 1 : last]),
        "largest_N": peaks.max(),
        "side_stiffness": row.side_stiffness,
        "wall_force_N": row.wall_force()[len(row.along) // 2],
        "shift_m": row.across[len(row.along) // 2] - row.at_rest()[len(row.along) // 2],
    }
    return values | {f"contact_{contact}_N": peaks[contact - 1] for contact in CONTACTS}


def switch_cases() -> list[Case]:
    """Rows of chapter 8 with and without cylinders."""
    return list(cases("chapter_8", [f"switch-{name}" for name in SWITCHES]))


def state_of(row: SymmetricRow) -> str:
    """State of the cylinders of a row of chapter 8."""
    if not len(row.along):
        return "no cylinders"
    gap = row.gap[0]
    before = row.along[0] - row.place[gap]
    behind = row.place[gap + 1] - row.along[0]
    if np.isclose(before, behind, rtol=1e-3):
        return "open gaps"
    return "loose, upstream" if before < behind else "loose, downstream"


def switch_row(case: Case) -> Row:
    """First and largest forces of the sensors of a row of chapter 8, N and s."""
    row = SymmetricRow.of(case)
    end = case.run.end_time
    assert isinstance(end, float)
    assert case.load.velocity is not None
    time, force, moved = row.motion(case.load.index[0] - 1, case.load.velocity, end)
    values: Row = {
        "state": state_of(row),
        "cylinders": 2 * len(row.along),
        "friction": row.friction,
        "spheres": len(row.place),
        "velocity_m_s": case.load.velocity,
    }
    for sphere in SENSORS:
        signal = (force[:, sphere - 2] + force[:, sphere - 1]) / 2
        when, peak = first_peak(time, signal, floor=FLOOR)
        values[f"sphere_{sphere}_first_N"] = peak
        values[f"sphere_{sphere}_first_s"] = when
        values[f"sphere_{sphere}_largest_N"] = signal.max()
    values[f"contact_{CONTACT}_N"] = force[:, CONTACT - 1].max()
    values |= {f"sphere_{sphere}_moved_m": moved[sphere - 1] for sphere in MOVED}
    return values


def impacts() -> list[tuple[str, int, bool]]:
    """Packing, velocity, m/s, and whether the initial normals are kept, of chapter 5."""
    true = [("small", velocity, False) for velocity in VELOCITIES]
    fixed = [("small", velocity, True) for velocity in VELOCITIES]
    return [*true, *fixed, ("reference", 5, True)]


def impact(chosen: tuple[str, int, bool]) -> Row:
    """Dissipation, peak force and yielded contacts of an impact of chapter 5.

    The last layer of the reference packing is held for 1 ms; the small packing is free for 0.2 ms.
    """
    packing, velocity, fixed = chosen
    place, pairs = fcc(SIZES[packing], DIAMETER)
    whole = packing == "reference"
    held = np.flatnonzero(place[:, 2] == place[:, 2].max()) if whole else ()
    network = Network(place, pairs, DIAMETER / 2, fixed_normals=fixed, held=held)
    network.v[middle_of_top(place), 2] = velocity
    step = 1e-7 if velocity < FAST else 5e-8
    end = 1e-3 if whole else 2e-4
    network.run(step, round(end / step))
    return {
        "packing": packing,
        "velocity_m_s": velocity,
        "normals": "of the start" if fixed else "true",
        "dissipated_fraction": network.dissipated() / (0.5 * network.mass * velocity**2),
        "peak_force_F_y": network.largest_force() / network.force_y,
        "yielded_contacts": int((network.peak > 1).sum()),
    }


#: What is solved for each chapter, and the function that makes a row of it.
CHAPTERS: dict[str, tuple[Callable[[], list], Callable[..., Row]]] = {
    "chapter_7": (filter_cases, filter_row),
    "chapter_8": (switch_cases, switch_row),
    "chapter_5": (impacts, impact),
}
#: Columns at the beginning of each table that say what a row is of.
N_KEYS = {"chapter_7": 3, "chapter_8": 5, "chapter_5": 3}


def table(chapter: str) -> list[dict[str, str]]:
    """Rows of the stored table of a chapter."""
    with (THESIS / chapter / TABLE).open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def written(row: Row) -> dict[str, str]:
    """Values of a row as stored in a table: numbers with seven digits."""
    return {key: value if isinstance(value, str) else f"{value:.7g}" for key, value in row.items()}


def write(chapter: str) -> None:
    """Solve all rows of a chapter, equal rows only once, and write its table."""
    chosen, solve = CHAPTERS[chapter]
    rows = [written(solve(one)) for one in chosen()]
    with (THESIS / chapter / TABLE).open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(row for n, row in enumerate(rows) if row not in rows[:n])


def main(chapters: list[str]) -> None:
    """Write the tables of some chapters, or of all."""
    for chapter in chapters or CHAPTERS:
        write(chapter)


if __name__ == "__main__":
    main(sys.argv[1:])
