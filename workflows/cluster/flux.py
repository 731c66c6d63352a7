"""Flux."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from granwave.workflows.cluster.scheduler import PENDING, Scheduler


class Flux(Scheduler):
    """Flux."""

    name = "flux"
    title = "Flux"
    queue_type = "FLUX"
    job_id = "${FLUX_ENCLOSING_ID:-$FLUX_JOB_ID}"
    log_name = "{{id}}.log"
    programs = ("flux",)
    launcher = "flux run"
    variables = "FLUX_JOB_"
    keys: ClassVar[Mapping[str, str]] = {
        "--queue": "partition", "-q": "partition", "--bank": "account", "-B": "account",
        "--time-limit": "time", "-t": "time", "--nodes": "nodes", "-N": "nodes",
    }  # fmt: skip
    own_options = ("--job-name", "--output", "--error", "--nslots", "-n", "--dependency")

    def states_in(self, answer: str) -> dict[str, str]:
        """Return the states of jobs that have not ended."""
        states = super().states_in(answer)
        return {job: state for job, state in states.items() if state in ("running", PENDING)}
