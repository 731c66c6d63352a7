"""Python without assertions and docstrings (-OO, PYTHONOPTIMIZE=2): everything except MDAnalysis works."""

from __future__ import annotations

import os
import subprocess
import sys

from tests.conftest import PLAIN

IMPORTS = """
import granwave.analysis.figures.run_figures, granwave.analysis.exports.export, granwave.analysis.reports.report
import granwave.workflows.run.driver, granwave.workflows.cli.scan
try:
    from granwave.analysis.result import universe
except ImportError as error:
    print(error)
"""


def _run(*words: str) -> subprocess.CompletedProcess[str]:
    environment = {**PLAIN, "PYTHONOPTIMIZE": "2", "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, timeout=300, env=environment)


def test_what_runs_and_draws_needs_no_docstrings_and_what_does_says_so() -> None:
    done = _run("-c", IMPORTS)
    assert done.returncode == 0, done.stderr
    assert done.stdout == (
        "granwave.analysis.universe: MDAnalysis needs docstrings, which python -OO (PYTHONOPTIMIZE=2) drops; use -O\n"
    )


def test_bad_input_is_refused_all_the_same(tmp_path: os.PathLike[str]) -> None:
    done = _run("-m", "granwave.workflows", "run", "fcc-small", "-o", f"{tmp_path}/r", "--set", "load.velocity=-1")
    assert done.returncode == 2 and "load.velocity: found -1" in done.stderr and "Traceback" not in done.stderr
