"""LSF."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import ClassVar

from granwave.lammps_inputs.errors import RunError
from granwave.workflows.cluster.scheduler import Scheduler


class Lsf(Scheduler):
    """LSF."""

    name = "lsf"
    title = "LSF"
    queue_type = "LSF"
    job_id = "$LSB_JOBID"
    log_name = "%J.log"
    programs = ("bsub", "bjobs", "bkill")
    variables = "LSB_"
    keys: ClassVar[Mapping[str, str]] = {
        "-q": "partition",
        "-P": "account",
        "-W": "time",
    }
    own_options = ("-J", "-o", "-oo", "-e", "-eo", "-n", "-w")
    signs_in_log = re.compile(r"(TERM_\w+.*)")

    _EMPTY = "No unfinished job found"

    def queue(self) -> dict[str, str]:
        """Return the states of all jobs that have not ended, by id; raise as `Scheduler.queue`."""
        try:
            return super().queue()
        except RunError as error:
            if self._EMPTY in str(error):
                return {}
            raise
