"""MPI ranks: work of the first, and how all of them leave."""

from __future__ import annotations

import json
import subprocess
import sys
import textwrap

import pytest

from tests.conftest import BIN, PLAIN

WORK = """
    import json, sys, time
    from pathlib import Path
    from mpi4py import MPI
    from granwave.workflows.run.mpi import on_first

    begin = time.process_time()
    found = on_first(MPI.COMM_WORLD, lambda: time.sleep(1.5) or 42)
    used = time.process_time() - begin
    quick = time.monotonic()
    for _ in range(100):
        on_first(MPI.COMM_WORLD, lambda: None)
    note = {"found": found, "used": used, "quick": time.monotonic() - quick}
    try:
        on_first(MPI.COMM_WORLD, lambda: {}["nothing"])
    except KeyError as error:
        note["error"] = str(error)
    Path(sys.argv[1], str(MPI.COMM_WORLD.rank)).write_text(json.dumps(note))
"""


def test_other_ranks_leave_their_cores_to_the_first(tmp_path):
    """They wait without use of the processor, get the result or the error, and lose no time in short work."""
    script = tmp_path / "work.py"
    script.write_text(textwrap.dedent(WORK))
    command = [str(BIN / "mpiexec"), "-n", "2", sys.executable, str(script), str(tmp_path)]
    subprocess.run(command, check=True, timeout=120, env=PLAIN)
    notes = [json.loads((tmp_path / str(rank)).read_text()) for rank in range(2)]
    assert [note["found"] for note in notes] == [42, 42]
    assert [note["error"] for note in notes] == ["'nothing'", "'nothing'"]
    assert notes[1]["used"] < 0.5
    assert max(note["quick"] for note in notes) < 5


@pytest.mark.parametrize("status", [0, 2])
def test_ranks_that_leave_are_not_taken_for_killed_ones(tmp_path, status):
    """Several times, as a launcher that loses a rank does so now and then."""
    script = tmp_path / "leave.py"
    script.write_text(f"from granwave.workflows.run.mpi import leave\nleave({status})\n")
    command = [str(BIN / "mpiexec"), "-n", "4", sys.executable, "-m", "mpi4py", str(script)]
    for _ in range(6):
        ended = subprocess.run(command, timeout=120, env=PLAIN, capture_output=True, text=True)
        assert (ended.returncode, ended.stdout, ended.stderr) == (status, "", "")
