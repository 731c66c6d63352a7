"""Python without assertions and docstrings (-OO, PYTHONOPTIMIZE=2): all but MDAnalysis works."""

from __future__ import annotations

import os
import subprocess
import sys

from tests.conftest import PLAIN

IMPORT_ALL = """
import importlib, pkgutil
import granwave
for module in pkgutil.walk_packages(granwave.__path__, "granwave."):
    if not module.name.endswith(("__main__", ".trajectory")) and ".plugins." not in module.name:
        importlib.import_module(module.name)
try:
    import granwave.analysis.trajectory
except ImportError as error:
    print(error)
"""


def _run(*words: str) -> subprocess.CompletedProcess[str]:
    environment = {**PLAIN, "PYTHONOPTIMIZE": "2", "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, timeout=300, env=environment)


def test_every_module_can_be_imported_and_the_one_that_cannot_work_says_why() -> None:
    done = _run("-c", IMPORT_ALL)
    assert done.returncode == 0, done.stderr
    assert done.stdout == (
        "granwave.analysis.universe: MDAnalysis needs docstrings, which python -OO (PYTHONOPTIMIZE=2) drops; use -O\n"
    )


def test_bad_input_is_refused_all_the_same(tmp_path: os.PathLike[str]) -> None:
    done = _run("-m", "granwave.workflows", "run", "fcc-small", "-o", f"{tmp_path}/r", "--set", "load.velocity=-1")
    assert done.returncode == 2 and "load.velocity: found -1" in done.stderr and "Traceback" not in done.stderr
