"""Ways to run a case other than by LAMMPS in this process: on MPI ranks of its own, or by finite elements."""

from __future__ import annotations

import os
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.errors import InputError, RunError
from granwave.workflows.run import mpi, record
from granwave.workflows.solvers import SPHERE_CONTACT, Kind


def run_elements_case(found: Any, kind: Kind, place: Path, *, resume: bool, **how: Any) -> None:
    """Run a case of finite elements."""
    from granwave.workflows.run.directory import held

    run_it: Any
    if kind is SPHERE_CONTACT:
        from granwave.workflows.finite_elements.sphere_contact.run import run_sphere_contact as run_it
    else:
        from granwave.workflows.finite_elements.punch.run import run_continuum as run_it
    if not resume:
        kind.check(found, kind.cost(found, 1, how["figures"]), place)
    with held(place):
        run_it(found, place, resume=resume, **how)


def run_on_ranks(
    found: Case,
    place: Path,
    ranks: int,
    *,
    checkpoint: float,
    figures: bool,
    force: bool,
    resume: bool,
    progress: bool,
) -> None:
    """Run a case on MPI ranks in processes of their own; arguments as in `granwave.workflows.run.driver.run_case`.

    Raises
    ------
    InputError
        The directory holds results or another case, or there is no mpiexec. Nothing was run.
    RunError
        The ranks failed; results so far are kept.
    KeyboardInterrupt
        The run was interrupted; it wrote a checkpoint.
    """
    from granwave.workflows.run.directory import decide

    mpi.check_cores(ranks)
    decide(found, place, resume=resume, force=force, n_ranks=ranks, figures=figures)
    options = {"--force": force, "--resume": resume, "--no-figures": not figures}
    with tempfile.TemporaryDirectory(prefix="granwave-") as scratch:
        file = Path(scratch) / "case.toml"
        file.write_text(found.to_toml(), encoding="utf-8")
        words = ["run", str(file), "-o", str(place), "--checkpoint", str(checkpoint)]
        words += [option for option, wanted in options.items() if wanted]
        with (Path(scratch) / "stderr").open("w+b") as stream:
            shown = progress and os.isatty(2)  # the bar of the first rank
            stderr = None if shown else stream.fileno()
            status = mpi.launch(ranks, words, stdout=subprocess.DEVNULL, stderr=stderr)
            stream.seek(0)
            text = stream.read().decode("utf-8", "replace")
    if status == 130:
        raise KeyboardInterrupt(f"{place}: stopped before its end; resume=True goes on")
    said = [line.removeprefix("granwave: ") for line in text.splitlines() if line.startswith("granwave: ")]
    errors = [line for line in said if not line.startswith("warning: ")]
    if status == 2:
        raise InputError(errors or f"{place}: the ranks refused their input")
    state = record.read(place)
    if status and (state is None or state.state not in (record.REFUSED, record.INTERRUPTED)):
        reason = (state.reason if state else None) or (
            errors[-1] if errors else f"the ranks ended with status {status}"
        )
        raise RunError(reason)


def raise_unfinished(place: Path) -> None:
    """Raise the error of a run that was interrupted or refused."""
    found = record.read(place)
    if found is not None and found.state == record.INTERRUPTED:
        raise KeyboardInterrupt(f"{place}: stopped before its end; resume=True goes on")
    if found is not None and found.state == record.REFUSED:
        raise RunError(f"{place}: the energy balance was refused; what was computed is kept, granwave.load shows it")
