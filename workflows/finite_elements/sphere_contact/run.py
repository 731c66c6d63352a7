"""One sphere-contact study, from case to figures."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.run_directory import CASE_FILE, CONTACT_TABLE, RESULT_FILE, SUMMARY_FILE
from granwave.lammps_inputs.run_state import note_files
from granwave.workflows.finite_elements.runner import ElementRun, run_elements
from granwave.workflows.finite_elements.sphere_contact.case import SphereContactCase
from granwave.workflows.finite_elements.sphere_contact.output import write_results
from granwave.workflows.finite_elements.sphere_contact.study import (
    TOLERANCE,
    History,
    integrate,
    make_solver,
    yield_unit,
)
from granwave.workflows.finite_elements.sphere_contact.summary import summarise

logger = logging.getLogger("granwave")

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

    Parameters and errors are those of `granwave.workflows.finite_elements.runner.run_elements`.
    """
    return run_elements(_Run, case, directory, progress=progress, force=force, resume=resume, figures=figures)


class _Run(ElementRun):
    RESULTS = (CASE_FILE, RESULT_FILE, SUMMARY_FILE, CONTACT_TABLE)
    FINISHED = ("done",)
    UNIT = " e-folds"

    def __init__(self, case: SphereContactCase) -> None:
        self.case, self.solver, self.history = case, make_solver(case), History()
        self._unit = yield_unit(case)
        self.total = self._place(case.max_overlap)

    @staticmethod
    def figures() -> ModuleType:
        from granwave.workflows.finite_elements.sphere_contact import figures

        return figures

    def integrate(self, report: Callable[[], None]) -> None:
        integrate(self.case, self.solver, self.history, lambda _: report())

    def progress(self) -> tuple[float, str]:
        """Share of the loading that is done, by the logarithm of the overlap, as its rate goes."""
        overlap = self.history.ledgers[-1].overlap
        return self._place(overlap), f"overlap {overlap / self._unit:.1f} alpha_y, cycle {self.history.cycles[-1]}"

    def _place(self, overlap: float) -> float:
        return math.log1p(max(0.0, overlap) / self._unit)

    def summarise(self, wall_time: float) -> dict[str, Any] | None:
        return summarise(self.case, self.solver, self.history, wall_time) if len(self.history.ledgers) > 1 else None

    def write(self, directory: Path, summary: dict[str, Any]) -> None:
        write_results(directory, self.case, self.solver, self.history, summary)
        note_files(directory, [CONTACT_TABLE])

    def conclude(self, directory: Path, summary: Mapping[str, Any], draw: Callable[[], None]) -> None:
        if self.history.end_reason == "refused":
            last = self.history.ledgers[-1]
            raise RunError(
                f"{self.case.name}: the energy balance is off by {100 * abs(last.balance / last.work):.3g} % of the "
                f"work of the faces at an overlap of {last.overlap:.4g} m, at most {100 * TOLERANCE:g} % is accepted; "
                f"what was computed is kept in {directory}. Take a smaller run.speed or run.max_overlap, or more "
                "run.elements"
            )
        if (summary.get("kinetic_share_max") or 0.0) > _MOST_KINETIC:
            logger.warning(
                "%s: not quasi-static: the kinetic energy reaches %.2g of the internal energy, expected at most %g; "
                "take a smaller run.speed",
                self.case.name,
                summary["kinetic_share_max"],
                _MOST_KINETIC,
            )
        draw()
