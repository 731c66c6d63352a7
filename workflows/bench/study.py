"""Wall time of the reference study and of its parts: steps, analysis, figures."""

from __future__ import annotations

import json
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.run_directory import RECORD_FILE, SUMMARY_FILE
from granwave.workflows.bench.timing import STUDY, Report, spread
from granwave.workflows.run import mpi

MOST_REPEATS = 3  # each takes half a minute
PARTS = ("start", "steps", "analysis", "figures")


def time_study(repeats: int, ranks: int, report: Report) -> dict[str, Any]:
    """Run the reference study as users do, and time its parts.

    Parameters
    ----------
    repeats
        Number of runs, at most `MOST_REPEATS`.
    ranks
        Number of MPI ranks of the time integration.

    Returns
    -------
    dict
        ``ranks``, ``n_steps``, and lists of wall times, s: ``start`` (program, packing, deck, set-up of LAMMPS),
        ``steps``, ``analysis`` (with the start of the program) and ``figures``.
    """
    report(f"\nreference study ({STUDY}) on {ranks} ranks, wall time of its parts, s:")
    times: dict[str, list[float]] = {part: [] for part in PARTS}
    n_steps = 0
    with tempfile.TemporaryDirectory(prefix="granwave-bench-") as scratch:
        directory = Path(scratch) / "run"
        for _ in range(min(repeats, MOST_REPEATS)):
            whole = _timed("run", STUDY, "-o", str(directory), "--np", str(ranks), "--force", "--no-figures")
            record = json.loads((directory / RECORD_FILE).read_text(encoding="utf-8"))
            n_steps = _steps(directory)
            analysis = _timed("analyse", str(directory), "--no-figures")
            figures = _timed("analyse", str(directory)) - analysis
            steps = float(record["wall_time_s"])
            for part, value in zip(PARTS, (whole - steps - analysis, steps, analysis, figures), strict=True):
                times[part].append(value)
    for part, values in times.items():
        report(f"{part:>10} {spread(values):>28}" + (f"   {n_steps} steps" if part == "steps" else ""))
    return {"ranks": ranks, "n_steps": n_steps, **times}


def _steps(directory: Path) -> int:
    return int(json.loads((directory / SUMMARY_FILE).read_text(encoding="utf-8"))["n_steps"])


def _timed(*words: str) -> float:
    """Run a command of granwave; return its wall time, s."""
    begin = time.perf_counter()
    subprocess.run([*mpi.PYTHON, "-m", "granwave.workflows", *words], check=True, capture_output=True)
    return time.perf_counter() - begin
