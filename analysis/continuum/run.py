"""One continuum run, from case to figures."""

from __future__ import annotations

import json
import logging
import shutil
import time
from pathlib import Path
from typing import Any

from tqdm import tqdm

from granwave.analysis.continuum import output
from granwave.analysis.continuum.case import ContinuumCase, check_memory, load_continuum_case
from granwave.analysis.continuum.history import TOLERANCE, History, integrate, make_solver
from granwave.analysis.continuum.summary import LARGE_STRAIN, summarise
from granwave.lammps_inputs.errors import InputError, RunError

logger = logging.getLogger("granwave")

FIGURES_DIRECTORY = "figures"
_RESULTS = (output.CASE_FILE, output.RESULT_FILE, output.SUMMARY_FILE, FIGURES_DIRECTORY)
_FINISHED = ("end_time", "settled", "longest")


def run_continuum(
    case: ContinuumCase,
    directory: str | Path,
    *,
    progress: bool = False,
    force: bool = False,
    resume: bool = False,
    figures: bool = True,
) -> dict[str, Any]:
    """Run a continuum case; leaves case.toml, result.h5, summary.json and figures in ``directory``.

    Parameters
    ----------
    progress
        Show a bar on a terminal.
    force
        Replace the results that are there.
    resume
        Accept the finished results of the same case that are there; an unfinished run begins anew.

    Returns
    -------
    dict
        What summary.json holds.

    Raises
    ------
    InputError
        The directory holds results, or another case, or the mesh does not fit into memory; nothing was changed.
    RunError
        The energy balance was refused; what was computed is kept.
    """
    directory = Path(directory)
    finished = _decide(case, directory, force=force, resume=resume)
    if finished is not None:
        return finished
    check_memory(case)
    _clear(directory)
    directory.mkdir(parents=True, exist_ok=True)
    output.write_text(directory / output.CASE_FILE, case.to_toml())
    solver, history = make_solver(case), History()
    begin = time.perf_counter()
    try:
        with _Bar(case, enabled=progress) as bar:
            integrate(case, solver, history, bar.show)
    finally:
        if history.instants:
            summary = output.plain(summarise(case, solver, history, time.perf_counter() - begin))
            output.write_result(directory, case, solver, history, summary)
            output.write_summary(directory, summary)
    if summary["plastic_zone_strain"] > LARGE_STRAIN:
        logger.warning(
            "%s: strains are not small: 1 %% of the plastic zone exceeds %.2f, the largest is %.2f; expected below %g. "
            "The solution is one of small strains: lower punch.velocity or punch.mass to trust it",
            case.name,
            summary["plastic_zone_strain"],
            summary["largest_strain"],
            LARGE_STRAIN,
        )
    if figures:
        # the drawing library takes longer to load than a small run to compute
        from granwave.analysis.continuum.figures import draw_figures

        draw_figures(directory)
    if history.end_reason == "refused":
        raise RunError(
            f"{case.name}: the energy balance is off by {100 * history.balance_error:.3g} % of the input at "
            f"{1e6 * history.instants[-1].time:.4g} us, at most {100 * TOLERANCE:g} % is accepted; "
            f'what was computed is kept in {directory}. Take run.timestep = "auto" or a smaller one, or more '
            "run.elements"
        )
    return summary


def _decide(case: ContinuumCase, directory: Path, *, force: bool, resume: bool) -> dict[str, Any] | None:
    """The finished summary if there is one to be kept, else None: run."""
    if resume and force:
        raise InputError(
            "--resume and --force exclude each other: one goes on with what is there, the other replaces it"
        )
    if directory.exists() and not directory.is_dir():
        raise InputError(f"{directory}: is a file, expected a directory; choose another with -o")
    found = [name for name in _RESULTS if (directory / name).exists()]
    if resume and (directory / output.CASE_FILE).exists():
        _same_case(case, directory)
        return _finished_summary(directory)
    if found and not force:
        raise InputError(
            f"{directory}: already holds results ({', '.join(found[:3])}{', ...' if len(found) > 3 else ''}); "
            "--resume goes on with them, --force replaces them, or choose another directory with -o"
        )
    return None


def _same_case(case: ContinuumCase, directory: Path) -> None:
    try:
        there = load_continuum_case(directory / output.CASE_FILE).to_dict()
    except InputError:
        there = {}  # of a granular run, or damaged: another case in any event
    here = case.to_dict()
    if there != here:
        keys = sorted(name for name in {*there, *here} if there.get(name) != here.get(name))
        raise InputError(
            f"{directory}: holds another case (different: {', '.join(keys)}); --force replaces it, or choose another "
            "directory with -o"
        )


def _finished_summary(directory: Path) -> dict[str, Any] | None:
    try:
        summary = json.loads((directory / output.SUMMARY_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return summary if summary.get("end_reason") in _FINISHED else None


def _clear(directory: Path) -> None:
    for name in _RESULTS:
        path = directory / name
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)


class _Bar:
    """Time done of the time to do; with end_time = "auto" only the time done."""

    def __init__(self, case: ContinuumCase, *, enabled: bool) -> None:
        self._given = case.punch.energy
        total = None if isinstance(case.run.end_time, str) else round(1e6 * case.run.end_time, 2)
        self._bar = tqdm(total=total, desc=case.name, unit="us", disable=None if enabled else True)

    def __enter__(self) -> _Bar:
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()

    def show(self, history: History) -> None:
        """Bring the bar up to the last instant."""
        last = history.instants[-1]
        note = f"dissipated {last.plastic / self._given:.3f}, balance {history.balance_error:.1e}"
        self._bar.set_postfix_str(note, refresh=False)
        self._bar.update(round(1e6 * last.time - self._bar.n, 2))
