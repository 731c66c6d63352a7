"""One sphere-contact study, from case to figures."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tqdm import tqdm

from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.files import plain
from granwave.lammps_inputs.run_directory import CASE_FILE, CONTACT_TABLE, RESULT_FILE, SUMMARY_FILE
from granwave.lammps_inputs.run_state import note_sizes
from granwave.workflows.finite_elements.frame import begin
from granwave.workflows.finite_elements.sphere_contact import output
from granwave.workflows.finite_elements.sphere_contact.case import SphereContactCase
from granwave.workflows.finite_elements.sphere_contact.study import (
    TOLERANCE,
    History,
    integrate,
    make_solver,
    yield_unit,
)
from granwave.workflows.finite_elements.sphere_contact.summary import summarise

logger = logging.getLogger("granwave")

_RESULTS = (CASE_FILE, RESULT_FILE, SUMMARY_FILE, CONTACT_TABLE)
_FINISHED = ("done",)
_MOST_KINETIC = 0.01  # of the internal energy


def run_sphere_contact(
    case: SphereContactCase,
    directory: str | Path,
    *,
    progress: bool = False,
    force: bool = False,
    resume: bool = False,
    figures: bool = True,
) -> dict[str, Any]:
    """Run a sphere-contact study; leaves case.toml, result.h5, contact.csv, summary.json and figures in ``directory``.

    Parameters
    ----------
    progress
        Show a bar on a terminal.
    force
        Replace the results that are there.
    resume
        Accept the finished results of the same case that are there; an unfinished study begins anew.

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
        if len(history.ledgers) > 1:
            summary = plain(summarise(case, solver, history, time.perf_counter() - started))
            output.write_results(directory, case, solver, history, summary)
            note_sizes(directory, [CONTACT_TABLE])
    if history.end_reason == "refused":
        last = history.ledgers[-1]
        raise RunError(
            f"{case.name}: the energy balance is off by {100 * abs(last.balance / last.work):.3g} % of the work of the "
            f"faces at an overlap of {last.overlap:.4g} m, at most {100 * TOLERANCE:g} % is accepted; what was "
            f"computed is kept in {directory}. Take a smaller run.speed or run.max_overlap, or more run.elements"
        )
    if (summary.get("kinetic_share_max") or 0.0) > _MOST_KINETIC:
        logger.warning(
            "%s: not quasi-static: the kinetic energy reaches %.2g of the internal energy, expected at most %g; "
            "take a smaller run.speed",
            case.name,
            summary["kinetic_share_max"],
            _MOST_KINETIC,
        )
    if figures:
        # the drawing library takes longer to load than a small study to compute
        from granwave.workflows.finite_elements.sphere_contact.figures import draw_figures

        draw_figures(directory)
    return summary


def _figures() -> Iterable[str]:
    from granwave.workflows.finite_elements.sphere_contact.figures import (
        FIGURES,  # the drawing library takes a second to load
    )

    return FIGURES


class _Bar:
    """How far loading has come, by the logarithm of the overlap, as its rate goes."""

    def __init__(self, case: SphereContactCase, *, enabled: bool) -> None:
        self._unit = yield_unit(case)
        total = round(self._place(case.max_overlap), 2)
        self._bar = tqdm(total=total, desc=case.name, unit=" e-folds", disable=None if enabled else True)

    def __enter__(self) -> _Bar:
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()

    def _place(self, overlap: float) -> float:
        return math.log1p(max(0.0, overlap) / self._unit)

    def show(self, history: History) -> None:
        """Bring the bar up to the last entry."""
        last = history.ledgers[-1]
        note = f"overlap {last.overlap / self._unit:.1f} alpha_y, cycle {history.cycles[-1]}"
        self._bar.set_postfix_str(note, refresh=False)
        self._bar.update(max(0.0, round(self._place(last.overlap) - self._bar.n, 2)))
