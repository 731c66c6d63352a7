"""Golden outputs: decks of all built-in cases, summaries and report of small runs, kept in this
folder.

They show how a change of the code affects users. After an intended change of outputs:

    .venv/bin/python -m tests.golden.outputs        # regenerates them; git diff tests/golden shows the changes

`names` has the names that users type and read; they are regenerated with the outputs.

Input scripts are kept as they are; of data files and tables, which are large, the words and sums of
the numbers. Numbers are compared to 1e-6, as processors and libraries differ in the last bits, and
words to the letter.
"""

from __future__ import annotations

import hashlib
import json
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from granwave.analysis.reports.report import write_report
from granwave.lammps_inputs import write_deck
from granwave.lammps_inputs.case.packing.made_packing import packing_makers
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import SCRIPT_FILE, SUMMARY_FILE
from granwave.workflows import library, load_case, run_case
from granwave.workflows.solvers import GRANULAR, solver_of
from tests.golden import names

FOLDER = Path(__file__).parent
RENEW = "if that is meant: python -m tests.golden.outputs"
DIGESTS = "digests.json"
SUMMARIES = "summaries.json"
REPORT = "report.md"
_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?(?![\w.])")

SMALL = {"packing.size": [8, 8, 5], "run.end_time": 1e-4}
RUNS: dict[str, tuple[str, dict[str, Any]]] = {
    "fcc": ("fcc-small", SMALL),
    "hcp-hertz": (
        "hcp-small",
        SMALL | {"contact.law": "hertz", "boundary.sides": "periodic", "packing.size": [8, 8, 4]},
    ),
    "bcc-bilinear": (
        "fcc-small",
        SMALL | {"packing.kind": "bcc", "contact.law": "bilinear", "boundary.bottom": "fixed"},
    ),
    "square-thornton": (
        "fcc-small",
        SMALL | {"packing.kind": "square", "packing.size": [8, 8], "contact.law": "thornton"},
    ),
    "tolerance": ("fcc-tolerance", SMALL | {"packing.vacancies": 0.02}),
    "target": ("protected-target", SMALL),
    "chain": ("elastic-impact", {"packing.size": 12, "run.end_time": 2e-4}),
    "intruder": ("intruder", {"run.end_time": 1e-4}),
    "two-spheres": ("two-spheres", {}),
}
_OF_THE_MACHINE = {"wall_time_s": 1.0, "sphere_steps_per_s": 1.0, "versions": {}, "n_ranks": 1}


def granular_cases() -> list[str]:
    """Names of the built-in cases that LAMMPS runs, except cases whose packing it also makes.

    Poured beds differ between processors, as differences in the last bits grow in collisions.
    """
    tables = {name: read_toml(library.find(name)) for name in library.names()}
    return [
        name
        for name, table in tables.items()
        if solver_of(table) is GRANULAR and table["packing"]["kind"] not in packing_makers()
    ]


def split(text: str) -> tuple[str, list[float]]:
    """Words of a text, with # for each number, and the numbers."""
    return _NUMBER.sub("#", text), [float(number) for number in _NUMBER.findall(text)]


def digest(text: str) -> dict[str, Any]:
    """Digest of a large file of numbers that does not depend on the last bits."""
    words, numbers = split(text)
    weighted = sum(abs(number) * (1 + n % 97) for n, number in enumerate(numbers))
    return {
        "words": hashlib.sha256(words.encode()).hexdigest()[:16],
        "numbers": len(numbers),
        "sum": weighted,
    }


def write_decks(place: Path, names: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Write the decks of built-in cases below ``place``; returns digests of all files except the
    scripts.
    """
    digests: dict[str, dict[str, Any]] = {}
    for name in names:
        deck = write_deck(load_case(name), place / name)
        files = sorted(
            path for path in deck.directory.iterdir() if path.is_file() and path.name != SCRIPT_FILE
        )
        digests[name] = {
            path.name: digest(path.read_text(encoding="utf-8"))
            for path in files
            if not path.name.startswith(".")
        }
    return digests


def run_small(place: Path) -> dict[str, Any]:
    """Run the small cases below ``place`` and write a report; returns their summaries without
    machine-dependent values.
    """
    summaries = {}
    for name, (case, settings) in RUNS.items():
        outcome = run_case(load_case(case, settings), place / name, figures=False)
        summaries[name] = outcome.summary | _OF_THE_MACHINE
        (place / name / SUMMARY_FILE).write_text(json.dumps(summaries[name]), encoding="utf-8")
        ResultDirectory(place / name).note_files([SUMMARY_FILE])
    write_report([place / name for name in RUNS], place / REPORT, ["tolerance"])
    return summaries


def main() -> None:
    """Regenerate the golden outputs and names."""
    import tempfile

    names.write()
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch)
        digests = write_decks(place / "decks", granular_cases())
        for name in digests:
            (FOLDER / f"{name}.in").write_text(
                (place / "decks" / name / SCRIPT_FILE).read_text(encoding="utf-8")
            )
        summaries = run_small(place / "runs")
        (FOLDER / REPORT).write_text(
            (place / "runs" / REPORT).read_text(encoding="utf-8"), encoding="utf-8"
        )
    (FOLDER / DIGESTS).write_text(json.dumps(digests, indent=1) + "\n")
    (FOLDER / SUMMARIES).write_text(json.dumps(summaries, indent=1) + "\n")


if __name__ == "__main__":
    sys.exit(main())
