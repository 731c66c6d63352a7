"""Plan of a run on a cluster, for ``granwave check --profile``: ranks, nodes, memory of a node and
of a rank, time limit, and jobs of a chain.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from granwave.analysis.formatting.numbers import counted, duration
from granwave.lammps_inputs.planning.plan import Plan
from granwave.workflows.check_part import CheckPart
from granwave.workflows.cluster.profile import Profile
from granwave.workflows.cluster.scheduler import before_limit
from granwave.workflows.scanning.batches import memory_on_node

_GIB = 2**30
_BYTES_PER_MB = 1e6
_MOST_JOBS = 1000  # most jobs of a proposed chain


@dataclasses.dataclass(frozen=True)
class ClusterPlan:
    """A run on a cluster.

    Attributes
    ----------
    profile
        Profile of the cluster.
    expected
        Its plan: a `Plan`, or the cost of a case that is not of a packing.
    ranks
        Number of MPI ranks.
    """

    profile: Profile
    expected: Any
    ranks: int

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return self.profile.nodes_of(self.ranks)

    @property
    def memory(self) -> float:
        """Memory on the node of the first rank, which needs most, bytes."""
        return memory_on_node(self.expected, self.ranks, self.nodes)

    @property
    def limit(self) -> float:
        """Time limit of a job, s."""
        expected = self.expected
        longest = expected.times.longest if isinstance(expected, Plan) else expected.wall_time
        return 60.0 * self.profile.minutes(expected.wall_time, longest)

    @property
    def n_jobs(self) -> int:
        """Number of jobs for the expected time; each runs until it writes its checkpoint."""
        useful = self.limit - before_limit(int(self.limit))
        return max(1, math.ceil(self.expected.wall_time / useful))

    def part(self) -> CheckPart:
        """Return rows and values of the cluster."""
        profile = self.profile
        where = f"{counted(self.ranks, 'rank')} on {counted(self.nodes, 'node')}"
        partition = f", partition {profile.partition}" if profile.partition else ""
        rows = [
            ("cluster", f"{profile.queue.title}: {where}{partition}"),
            ("memory of a node", f"about {self.memory / _GIB:.2f} GiB{self._of_ranks()}"),
            ("time limit", self._time()),
        ]
        values = {
            "scheduler": profile.scheduler,
            "n_ranks": self.ranks,
            "n_nodes": self.nodes,
            "memory_of_node_bytes": self.memory,
            "time_limit_s": self.limit,
            "n_jobs": self.n_jobs,
        }
        if isinstance(self.expected, Plan):
            values["memory_first_rank_bytes"] = self.expected.first_rank
            values["memory_other_rank_bytes"] = self.expected.other_rank
        return CheckPart(rows=rows, values=values)

    def _of_ranks(self) -> str:
        """Return the memory of single ranks as text."""
        if self.ranks == 1 or not isinstance(self.expected, Plan):
            return ""
        first = self.expected.first_rank / _GIB
        other = self.expected.other_rank / _GIB
        return f": the first rank {first:.2f} GiB, each other at most {other:.2f} GiB"

    def _time(self) -> str:
        """Return time limit and number of jobs as text."""
        text = duration(self.limit)
        if self.n_jobs > 1:
            text += f": about {self.n_jobs} jobs, --chain {min(self.n_jobs + 1, _MOST_JOBS)}"
        return text

    def warnings(self) -> list[str]:
        """Return the resources that the profile lacks for the run."""
        given = self.profile.memory
        needed = math.ceil(self.memory / _BYTES_PER_MB)
        if given is None or given >= needed:
            return []
        return [
            f"memory of the profile: found {given} MB on each node, expected at least {needed}; "
            "request more memory, or more nodes"
        ]
