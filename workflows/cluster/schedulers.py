"""The schedulers by their names in profiles."""

from __future__ import annotations

import functools

from granwave.workflows.cluster.flux import Flux
from granwave.workflows.cluster.grid_engine import GridEngine
from granwave.workflows.cluster.lsf import Lsf
from granwave.workflows.cluster.pbs import Moab, Pbs, Torque
from granwave.workflows.cluster.scheduler import Scheduler
from granwave.workflows.cluster.slurm import Slurm, SlurmAccounting

_ALL: tuple[type[Scheduler], ...] = (Slurm, Pbs, Torque, Lsf, GridEngine, Moab, Flux)
SCHEDULERS = {kind.name: kind for kind in _ALL}


@functools.cache
def scheduler(name: str, status: str = "squeue") -> Scheduler:
    """Return the scheduler of a name in `SCHEDULERS`; ``status`` is the key of a profile."""
    if status == "sacct":
        return SlurmAccounting()
    return SCHEDULERS[name]()
