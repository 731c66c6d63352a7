"""Python code of docs/howto/python.md, run unmodified."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from granwave.workflows.python.api import __all__ as names
from tests.conftest import PLAIN

PAGE = (Path(__file__).parent.parent / "docs" / "howto" / "python.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```python\n(.*?)^```", PAGE, flags=re.MULTILINE | re.DOTALL)


def test_code(tmp_path):
    pytest.importorskip("snakemake")
    (tmp_path / "page.py").write_text("\n".join(BLOCKS))
    environment = PLAIN | {"MPLBACKEND": "agg"}
    done = subprocess.run(
        [sys.executable, "page.py"], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert "peak contact force" in done.stdout and "packing.kind: found" in done.stdout
    assert {path.name for path in tmp_path.iterdir()} == {"page.py", "small", "pair", "pairs", "force.png"}


def test_names_are_there():
    assert len(BLOCKS) > 10
    assert set(re.findall(r"\bgw\.(\w+)", PAGE)) <= set(names)
