"""The driver's own record of a run, `run.json`: what happened, with what, and how far."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.files import read_json, replace_text
from granwave.lammps_inputs.run_directory import RECORD_FILE

# states of a run
RUNNING, INTEGRATED = "running", "integrated"  # integrated: only the analysis is still to be done
INTERRUPTED, FAILED, REFUSED, FINISHED = "interrupted", "failed", "refused", "finished"


@dataclasses.dataclass
class Record:
    """One run.

    Attributes
    ----------
    state
        running, integrated, interrupted, failed (see ``reason``), refused (energy balance) or finished.
    n_steps, end_time_s
        Done so far.
    end_reason
        Why it ended: ``end_time``, ``settled`` (end_time = "auto"), ``longest`` (the same, at its limit), ...
    wall_time_s
        Of the time integration, all sessions of a resumed run together.
    nodes
        That the ranks run on, each once.
    attempts
        Timesteps that were tried and dropped because the energy balance did not close: timestep_s and error.
    checkpoint
        Step and file sizes at the last checkpoint.
    """

    state: str = RUNNING
    name: str = ""
    timestep_s: float = 0.0
    n_steps: int = 0
    end_time_s: float = 0.0
    end_reason: str | None = None
    reason: str | None = None
    wall_time_s: float = 0.0
    n_ranks: int = 1
    nodes: list[str] = dataclasses.field(default_factory=list)
    versions: dict[str, str] = dataclasses.field(default_factory=dict)
    attempts: list[dict[str, float]] = dataclasses.field(default_factory=list)
    checkpoint: dict[str, Any] | None = None

    def write(self, directory: Path) -> None:
        """Replace the record in ``directory``, all or nothing."""
        replace_text(directory / RECORD_FILE, json.dumps(dataclasses.asdict(self), indent=2) + "\n")


def read(directory: Path) -> Record | None:
    """The record in ``directory``, or None where there is none that can be read."""
    return _record(read_json(directory / RECORD_FILE))


def recover(directory: Path) -> Record | None:
    """The record that result.h5 holds, as it was when the run was analysed; None where there is none."""
    try:
        with Result(directory) as result:
            return _record(result.record)
    except (MissingOutputError, OutputFormatError, KeyError, ValueError):
        return None


def _record(content: dict[str, Any] | None) -> Record | None:
    try:
        return None if content is None else Record(**content)
    except TypeError:  # keys of another version
        return None
