"""``granwave selftest``: known answers, plugin, MPI ranks and restart, computed on this machine.

Two reference values are closed forms, written here independently of the laws used in the runs; R
and m are the effective radius and mass of the pair, K = 4/3 E* sqrt(R):

    Hertz 1882       F = K a^1.5, a_max = (5 m v^2/(4 K))^(2/5); the contact lasts 2.943 a_max/v
    Thornton 1997    F_max = F_y sqrt(6/5 (v/v_y)^2 - 1/5) and, with r = v_y/v, restitution
                     e^2 = 6 sqrt(3)/5 (1 - r^2/6) sqrt(r/(r + 2 sqrt(6/5 - r^2/5)))

The third reference value, of a small packing, is a stored result with all digits.
"""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import math
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from granwave import plugins
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.errors import GranwaveError, InputError, RunError
from granwave.lammps_inputs.files import replace_text
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import DUMPS, ENERGY_FILE, RESULT_FILE
from granwave.workflows.cli.installation.doctor import examine
from granwave.workflows.cli.terminal import BOLD, GREEN, RED, coloured, in_shell, print_json
from granwave.workflows.cluster.profile import load_profile
from granwave.workflows.run import mpi, record
from granwave.workflows.run.directory import RunDirectory
from granwave.workflows.run.driver import run_case
from granwave.workflows.run.lammps_engine import check_release
from granwave.workflows.run.leftovers import scratch_directory

_BRASS = {
    "youngs_modulus": 115e9,
    "poisson_ratio": 0.30,
    "density": 8500.0,
    "yield_strength": 550e6,
}
# m, m/s
_DIAMETER = 0.010
_SPEED = 1.0
_PAIR: dict[str, Any] = {
    "material": _BRASS,
    "packing": {"kind": "chain", "size": 2, "diameter": _DIAMETER},
    "load": {"velocity": _SPEED},
    "boundary": {"bottom": "free"},
    "run": {"end_time": 8e-5, "frames": 2},
    "output": {"probes": [{"contact": [1, 2]}], "probe_interval": 2e-7},
}
_PACKING: dict[str, Any] = {
    "material": _BRASS,
    "packing": {"kind": "fcc", "size": [8, 8, 5], "diameter": _DIAMETER},
    "load": {"velocity": 5.0},
    "run": {"end_time": 1e-4, "frames": 3},
}
# expected fraction of the input, and contacts, of `_PACKING`
_DISSIPATED = 0.83929649013269
_YIELDED = 375
_EXACT = 1e-9  # relative difference of a run that was stopped and resumed
_FIELDS = ("spheres", "contacts", "wall_contacts", "particles")  # groups of result.h5
_OF_THE_CLOCK = ("wall_time_s", "sphere_steps_per_s", "energy_balance_error")
_LOOK = 0.002  # s between checks for the first steps of a run
_WIDTHS = (32, 16, 16, 0)  # characters of the columns
_WRONG = (
    "results of this installation are wrong; do not use it, and report this table with the "
    "output of granwave doctor"
)
_NO_RANKS = (
    "use one rank until granwave run two-spheres --np {} works; its message gives the reason"
)
_NO_RESUME = "do not use --resume here; granwave run two-spheres shows whether runs work"


@dataclasses.dataclass(frozen=True)
class Check:
    """One line of the table: the check, the expected and the found answer, and the
    remedy.
    """

    what: str
    expected: str
    found: str
    ok: bool
    remedy: str = ""


def selftest(options: argparse.Namespace) -> int:
    """Execute ``granwave selftest``; return the exit status.

    Raises
    ------
    InputError
        It is itself started on ranks, or the profile is invalid.
    """
    if mpi.launched():
        raise InputError(
            "selftest: started by an MPI launcher; start it without one, and set --np N"
        )
    launcher = load_profile(options.profile).launcher_command if options.profile else []
    begin = time.monotonic()
    checks = []
    if not options.json:
        print(coloured(_line("what", "expected", "found", "ok"), BOLD, sys.stdout), flush=True)
    with scratch_directory("granwave-selftest-") as scratch:
        for check in _all(scratch, options.ranks, launcher):
            checks.append(check)
            if not options.json:
                state = (
                    coloured("yes", GREEN, sys.stdout)
                    if check.ok
                    else coloured("NO", RED, sys.stdout)
                )
                print(_line(check.what, check.expected, check.found, state), flush=True)
    failed = [check for check in checks if not check.ok]
    seconds = time.monotonic() - begin
    if options.json:
        rows = [dataclasses.asdict(check) for check in checks]
        print_json({"passed": not failed, "wall_time_s": seconds, "checks": rows})
        return 1 if failed else 0
    print(f"\n{len(checks) - len(failed)} of {len(checks)} are as expected, in {seconds:.0f} s")
    for check in failed:
        print(f"{coloured('fix', RED, sys.stdout)}  {check.what}: {check.remedy}")
    return 1 if failed else 0


def _line(*words: str) -> str:
    return "  ".join(
        f"{word:<{width}}" for word, width in zip(words, _WIDTHS, strict=True)
    ).rstrip()


def _all(scratch: Path, ranks: int, launcher: Sequence[str]) -> Iterator[Check]:
    """Make all checks; if LAMMPS does not load the plugin, there is nothing to compute."""
    release = plugins.lammps_release()
    wrong = check_release()
    yield Check(
        "LAMMPS release",
        release,
        wrong.split()[1] if wrong else release,
        wrong is None,
        wrong or "",
    )
    parts = {one.part: one for one in examine()}
    wanted = [
        "plugin",
        "lammps module",
        "lmp command",
        *(["MPI ranks"] if ranks > 1 and not launcher else []),
    ]
    for part in (parts[name] for name in wanted):
        yield Check(
            part.part, "works", "works" if part.works else part.found, part.works, part.remedy
        )
    if wrong or not parts["lammps module"].works:
        yield Check(
            "known answers",
            "computed",
            "not run",
            False,
            "fix the failed checks above, then run this again",
        )
        return
    yield from _attempt("two spheres, Hertz", _WRONG, partial(_hertz, scratch))
    yield from _attempt("two spheres, Thornton", _WRONG, partial(_thornton, scratch))
    yield from _attempt("packing", _WRONG, partial(_packing, scratch))
    if ranks > 1 and (launcher or parts["MPI ranks"].works):
        yield from _attempt(
            f"{ranks} ranks", _NO_RANKS.format(ranks), partial(_ranks, scratch, ranks, launcher)
        )
    yield from _attempt("stopped and resumed", _NO_RESUME, partial(_resumed, scratch))


def _attempt(what: str, remedy: str, work: Callable[[], list[Check]]) -> list[Check]:
    """Return the checks of some runs; a single failed check if a run ends with an error."""
    try:
        return work()
    except (GranwaveError, OSError) as error:
        return [Check(what, "a run", in_shell(str(error)), False, remedy)]


def _run(
    scratch: Path, name: str, tables: dict[str, Any], **options: Any
) -> tuple[Path, dict[str, Any]]:
    """Run a case on one rank; return its directory and summary."""
    outcome = run_case(
        case_from_dict({"name": name, **tables}), scratch / name, figures=False, **options
    )
    if outcome.state == record.REFUSED:
        raise RunError("energy balance error too large")
    return outcome.directory, outcome.summary


def _number(what: str, unit: str, expected: float, found: float, digits: int = 5) -> Check:
    """Compare two numbers to some digits, and show one more digit."""
    shown, got = (f"{value:.{digits + 1}g} {unit}".strip() for value in (expected, found))
    return Check(
        what,
        shown,
        got,
        abs(found - expected) <= 0.5 * 10.0 ** (1 - digits) * abs(expected),
        _WRONG,
    )


def _pair_constants() -> tuple[float, float, float]:
    """Return mass (kg), radius (m) and modulus (Pa) of a pair of equal spheres, as in Hertz's
    formulas.
    """
    mass = _BRASS["density"] * math.pi / 6 * _DIAMETER**3
    return (
        mass / 2,
        _DIAMETER / 4,
        _BRASS["youngs_modulus"] / (2 * (1 - _BRASS["poisson_ratio"] ** 2)),
    )


def _hertz(scratch: Path) -> list[Check]:
    mass, radius, modulus = _pair_constants()
    stiffness = 4 / 3 * modulus * math.sqrt(radius)
    overlap = (5 * mass * _SPEED**2 / (4 * stiffness)) ** 0.4
    duration = 0.8 * overlap / _SPEED * math.gamma(0.4) * math.gamma(0.5) / math.gamma(0.9)
    directory, summary = _run(scratch, "hertz", _PAIR | {"contact": {"law": "hertz"}})
    with Result(directory) as result:
        times = result["probes/time"]
        overlaps = result["probes/contact_1_2_overlap"]
    last = np.flatnonzero(overlaps > 0)[-2:]  # the force is almost zero
    slope = np.diff(overlaps[last])[0] / np.diff(times[last])[0]
    end = times[last[-1]] - overlaps[last[-1]] / slope
    return [
        _number(
            "two spheres, Hertz: peak force", "N", stiffness * overlap**1.5, summary["peak_force_N"]
        ),
        _number("two spheres, Hertz: contact", "µs", 1e6 * duration, 1e6 * end),
    ]


def _thornton(scratch: Path) -> list[Check]:
    mass, radius, modulus = _pair_constants()
    pressure = _BRASS["yield_strength"]  # pressure of first yield, and of flow
    force = math.pi**3 * radius**2 * pressure**3 / (6 * modulus**2)
    share = (
        math.sqrt(math.pi**5 * radius**3 * pressure**5 / (30 * modulus**4 * mass)) / _SPEED
    )  # v_y/v
    squared = (
        1.2
        * math.sqrt(3)
        * (1 - share**2 / 6)
        * math.sqrt(share / (share + 2 * math.sqrt(1.2 - share**2 / 5)))
    )
    tables = _PAIR | {"contact": {"law": "thornton", "yield_factor": 1.0}}
    summary = _run(scratch, "thornton", tables)[1]
    restitution = 1 - 2 * summary["impactor_velocity_m_s"] / _SPEED
    return [
        _number(
            "plastic pair: peak force",
            "N",
            force * math.sqrt(1.2 / share**2 - 0.2),
            summary["peak_force_N"],
        ),
        _number("plastic pair: restitution", "", math.sqrt(squared), restitution),
    ]


def _packing(scratch: Path) -> list[Check]:
    summary = _run(scratch, "packing", _PACKING)[1]
    yielded = summary["n_plastic_contacts"]
    return [
        _number("FCC 8 × 8 × 5: dissipated", "", _DISSIPATED, summary["dissipated_fraction"]),
        Check(
            "FCC 8 × 8 × 5: yielded",
            f"{_YIELDED} contacts",
            f"{yielded} contacts",
            yielded == _YIELDED,
            _WRONG,
        ),
    ]


def _ranks(scratch: Path, ranks: int, launcher: Sequence[str]) -> list[Check]:
    """Run the start of the packing on several ranks; every field must equal the result of one rank
    bit by bit. There are few steps, because ranks that share a core wait for each other in each
    step.
    """
    tables = _PACKING | {"run": {"end_time": 1.5e-5, "frames": 2}}
    alone = _run(scratch, "alone", tables)[0]
    case = scratch / "ranks.toml"
    there = scratch / "ranks"
    replace_text(case, case_from_dict({"name": "ranks", **tables}).to_toml())
    status, lines = mpi.launch_unseen(
        ranks, ["run", str(case), "-o", str(there), "--no-figures"], launcher
    )
    if status:
        raise RunError(lines[-1] if lines else f"the ranks ended with status {status}")
    n_ranks = ResultDirectory(there).summary()["n_ranks"]
    one = _fields(alone)
    several = _fields(there)
    same = sum(name in several and several[name] == content for name, content in one.items())
    what = f"{ranks} ranks: fields as on one rank"
    remedy = "results depend on the number of ranks: use one rank, and report this table"
    return [
        Check(
            f"{ranks} ranks: at work",
            str(ranks),
            str(n_ranks),
            n_ranks == ranks,
            _NO_RANKS.format(ranks),
        ),
        Check(
            what, f"{len(one)} fields", f"{same} fields", same == len(one) == len(several), remedy
        ),
    ]


def _fields(directory: Path) -> dict[str, Any]:
    """Return the values of grains, contacts and snapshots of a result by name; sums over all grains
    are omitted, because their rounding depends on the order of the ranks.
    """
    found: dict[str, Any] = {}

    def take(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and name.partition("/")[0] in _FIELDS:
            values = item[()]
            found[name] = values.tolist() if values.dtype.kind == "O" else values.tobytes()

    with h5py.File(directory / RESULT_FILE, "r") as file:
        file.visititems(take)
    return found


def _resumed(scratch: Path) -> list[Check]:
    """Stop the packing after its first steps, and continue; the values must equal the values of the
    uninterrupted run.
    """
    with _stopped_early(scratch / "resumed", scratch / "stop"):
        _run(scratch, "resumed", _PACKING)
    half = RunDirectory(scratch / "resumed").read_record()
    if half is None or half.state != record.INTERRUPTED or half.checkpoint is None:
        return [
            Check(
                "stopped run",
                "a checkpoint",
                half.state if half else "no record",
                False,
                _NO_RESUME,
            )
        ]
    resumed = _run(scratch, "resumed", _PACKING, resume=True)[1]
    whole = ResultDirectory(scratch / "packing").summary()
    values = {
        name: one
        for name, one in whole.items()
        if isinstance(one, int | float) and name not in _OF_THE_CLOCK
    }
    same = sum(math.isclose(value, resumed[name], rel_tol=_EXACT) for name, value in values.items())
    what = f"resumed at step {half.checkpoint['step']}: values"
    return [
        Check(
            what,
            f"{len(values)} as uninterrupted",
            f"{same} as uninterrupted",
            same == len(values),
            _NO_RESUME,
        )
    ]


@contextlib.contextmanager
def _stopped_early(directory: Path, stop: Path) -> Iterator[None]:
    """Stop the run in the ``with`` block by its stop file, after its first row of energies."""
    done = threading.Event()

    def ask() -> None:
        path = directory / DUMPS / ENERGY_FILE
        while not done.wait(_LOOK):
            with contextlib.suppress(OSError):
                if path.stat().st_size:
                    return stop.touch()

    before = os.environ.get(mpi.STOP_FILE)
    os.environ[mpi.STOP_FILE] = str(stop)
    watcher = threading.Thread(target=ask, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        done.set()
        watcher.join()
        stop.unlink(missing_ok=True)
        os.environ.pop(mpi.STOP_FILE)
        if before is not None:
            os.environ[mpi.STOP_FILE] = before
