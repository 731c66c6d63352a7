"""Record of a run by the driver, `run.json`: state, versions, ranks, attempts, checkpoint."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.lammps_inputs.files import read_json, replace_text
from granwave.lammps_inputs.run_directory import RECORD_FILE

# states of a run
RUNNING, INTEGRATED = "running", "integrated"  # integrated: only the analysis remains
INTERRUPTED, FAILED, REFUSED, FINISHED = "interrupted", "failed", "refused", "finished"


@dataclasses.dataclass
class Record:
    """Record of one run.

    Attributes
    ----------
    state
        State: running, integrated, interrupted, failed (see ``reason``), refused (energy balance) or finished.
    n_steps, end_time_s
        Steps and simulated time so far.
    end_reason
        Why it ended: ``end_time``, ``settled`` (end_time = "auto"), ``longest`` (the same, at its limit), ...
    wall_time_s
        Wall time of the time integration, over all sessions of a resumed run.
    nodes
        Names of the nodes of the ranks, each once.
    attempts
        Rejected timesteps with their errors of the energy balance.
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
        """Replace the record in ``directory`` atomically."""
        replace_text(directory / RECORD_FILE, json.dumps(dataclasses.asdict(self), indent=2) + "\n")


def read(directory: Path) -> Record | None:
    """Read the record in ``directory``; None if missing or damaged."""
    return _record(read_json(directory / RECORD_FILE))


def recover(directory: Path) -> Record | None:
    """Read the record in result.h5, as of the analysis; None if there is none."""
    from granwave.analysis.result.reader import Result  # h5py takes longer to load than most commands need

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
