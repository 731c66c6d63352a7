"""One continuum run, from case to figures."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.run_directory import CASE_FILE, RESULT_FILE, SUMMARY_FILE
from granwave.workflows.finite_elements.punch.case import ContinuumCase
from granwave.workflows.finite_elements.punch.history import TOLERANCE, History, integrate, make_solver
from granwave.workflows.finite_elements.punch.output import write_result
from granwave.workflows.finite_elements.punch.summary import LARGE_STRAIN, summarise
from granwave.workflows.finite_elements.runner import ElementRun, run_elements

logger = logging.getLogger("granwave")


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

    Parameters and errors are those of `granwave.workflows.finite_elements.runner.run_elements`.
    """
    return run_elements(_Run, case, directory, progress=progress, force=force, resume=resume, figures=figures)


class _Run(ElementRun):
    RESULTS = (CASE_FILE, RESULT_FILE, SUMMARY_FILE)
    FINISHED = ("end_time", "settled", "longest")
    UNIT = "us"

    def __init__(self, case: ContinuumCase) -> None:
        self.case, self.solver, self.history = case, make_solver(case), History()
        self.total = None if isinstance(case.run.end_time, str) else round(1e6 * case.run.end_time, 2)

    @staticmethod
    def figures() -> ModuleType:
        from granwave.workflows.finite_elements.punch import figures

        return figures

    def integrate(self, report: Callable[[], None]) -> None:
        integrate(self.case, self.solver, self.history, lambda _: report())

    def progress(self) -> tuple[float, str]:
        """Time done, us."""
        last, given = self.history.instants[-1], self.case.punch.energy
        return 1e6 * last.time, f"dissipated {last.plastic / given:.3f}, balance {self.history.balance_error:.1e}"

    def summarise(self, wall_time: float) -> dict[str, Any] | None:
        return summarise(self.case, self.solver, self.history, wall_time) if self.history.instants else None

    def write(self, directory: Path, summary: dict[str, Any]) -> None:
        write_result(directory, self.case, self.solver, self.history, summary)

    def conclude(self, directory: Path, summary: Mapping[str, Any], draw: Callable[[], None]) -> None:
        if summary["plastic_zone_strain"] > LARGE_STRAIN:
            logger.warning(
                "%s: strains are not small: 1 %% of the plastic zone exceeds %.2f, the largest is %.2f; expected below "
                "%g. The solution is one of small strains: lower punch.velocity or punch.mass to trust it",
                self.case.name,
                summary["plastic_zone_strain"],
                summary["largest_strain"],
                LARGE_STRAIN,
            )
        draw()
        if self.history.end_reason == "refused":
            raise RunError(
                f"{self.case.name}: the energy balance is off by {100 * self.history.balance_error:.3g} % of the input "
                f"at {1e6 * self.history.instants[-1].time:.4g} us, at most {100 * TOLERANCE:g} % is accepted; "
                f'what was computed is kept in {directory}. Take run.timestep = "auto" or a smaller one, or more '
                "run.elements"
            )
