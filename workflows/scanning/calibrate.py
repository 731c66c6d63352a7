"""Measurement of the speed of this machine under full load, with the first steps of one point."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import statistics
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import cast

import tomli_w

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.files import available_memory
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.cost import seconds_per_step
from granwave.workflows.run import mpi
from granwave.workflows.run.lammps_engine import Engine, open_engine
from granwave.workflows.scanning.scan_file import Point
from granwave.workflows.solvers import GRANULAR

_WARM, _SPAN = 1.5, 1.0  # s of wall time: warm-up, in which contacts get loaded, and measurement
_LONGEST = 60.0  # s after which the measurement is given up


def slowness_of(point: Point, jobs: int) -> float | None:
    """Measure the wall time of a granular point over the planned one; None if not possible.

    The first part of the impact is timed, in which nearly all contacts are elastic, without the static stage.

    Parameters
    ----------
    jobs
        Number of simultaneous measurements, limited by memory: cores that share a cache slow each other down.
    """
    if point.kind is not GRANULAR:
        return None
    case = dataclasses.replace(cast(Case, point.case), precompression=None)
    document = tomli_w.dumps(case.to_dict())
    at_once = max(1, min(jobs, int(available_memory() / point.plan.memory)))
    with ThreadPoolExecutor(at_once) as pool:
        times = list(pool.map(_timed, [document] * at_once))
    found = [seconds for seconds in times if seconds is not None]
    return statistics.fmean(found) / seconds_per_step(assemble(case)) if found else None


def _timed(document: str) -> float | None:
    """Measure the wall time of a step in a separate process, s; None on failure."""
    command = [*mpi.PYTHON, "-m", "granwave.workflows.scanning.calibrate"]
    try:
        done = subprocess.run(
            command, input=document, capture_output=True, text=True, timeout=_LONGEST, env=mpi.alone(), check=True
        )
        return float(json.loads(done.stdout.splitlines()[-1]))
    except (subprocess.SubprocessError, OSError, ValueError, IndexError):
        return None


def _measure(document: str) -> float:
    """Measure the wall time of a step on one rank, s."""
    from granwave.lammps_inputs.deck.deck import write_deck
    from granwave.lammps_inputs.deck.script import part
    from granwave.lammps_inputs.load_case import load_case

    with tempfile.TemporaryDirectory(prefix="granwave-") as scratch:
        path = Path(scratch) / "case.toml"
        path.write_text(document, encoding="utf-8")
        deck = write_deck(load_case(path), Path(scratch) / "deck")
        with contextlib.chdir(deck.directory), open_engine(mpi.world(), log="none") as engine:
            engine.commands(part(deck.script.read_text(encoding="utf-8"), "setup"))
            engine.commands("run 20 post no")
            _run_for(engine, _WARM)
            return _run_for(engine, _SPAN)


def _run_for(engine: Engine, span: float) -> float:
    """Run for ``span`` seconds of wall time; return the wall time of a step, s."""
    piece, steps, begin = 50, 0, time.monotonic()
    while (elapsed := time.monotonic() - begin) < span:
        engine.commands(f"run {piece} pre no post no")
        steps += piece
    return elapsed / steps


if __name__ == "__main__":
    print(json.dumps(_measure(sys.stdin.read())))
