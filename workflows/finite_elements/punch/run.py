"""One continuum run, from case to figures."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tqdm import tqdm

from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.files import plain
from granwave.lammps_inputs.run_directory import CASE_FILE, RESULT_FILE, SUMMARY_FILE
from granwave.workflows.finite_elements.frame import begin
from granwave.workflows.finite_elements.punch import output
from granwave.workflows.finite_elements.punch.case import ContinuumCase
from granwave.workflows.finite_elements.punch.history import TOLERANCE, History, integrate, make_solver
from granwave.workflows.finite_elements.punch.summary import LARGE_STRAIN, summarise

logger = logging.getLogger("granwave")

_RESULTS = (CASE_FILE, RESULT_FILE, SUMMARY_FILE)
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
    directory = results_directory(directory)
    there = begin(
        case, directory, _RESULTS, _FINISHED, resume=resume, force=force, figures=_figures if figures else None
    )
    if there is not None:
        return there
    solver, history = make_solver(case), History()
    started = time.perf_counter()
    try:
        with _Bar(case, enabled=progress) as bar:
            integrate(case, solver, history, bar.show)
    finally:
        if history.instants:
            summary = plain(summarise(case, solver, history, time.perf_counter() - started))
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
        from granwave.workflows.finite_elements.punch.figures import draw_figures

        draw_figures(directory)
    if history.end_reason == "refused":
        raise RunError(
            f"{case.name}: the energy balance is off by {100 * history.balance_error:.3g} % of the input at "
            f"{1e6 * history.instants[-1].time:.4g} us, at most {100 * TOLERANCE:g} % is accepted; "
            f'what was computed is kept in {directory}. Take run.timestep = "auto" or a smaller one, or more '
            "run.elements"
        )
    return summary


def _figures() -> Iterable[str]:
    from granwave.workflows.finite_elements.punch.figures import FIGURES  # the drawing library takes a second to load

    return FIGURES


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
