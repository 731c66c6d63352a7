"""The fixture `slurm`: a real Slurm of two virtual nodes, see tests/helpers/slurm/cluster.py. Import it into the test module that wants it."""

from __future__ import annotations

import fcntl
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.helpers.slurm import cluster


@dataclass(frozen=True)
class Slurm:
    """A cluster that is up."""

    partition: str = cluster.PARTITION
    nodes: tuple[str, ...] = cluster.NODES
    cpus: int = cluster.CPUS  # of a node

    def cancel_all(self) -> None:
        """Take every job out of the queue, for tests that leave some behind."""
        subprocess.run(["scancel", f"--partition={self.partition}"], check=True)


@pytest.fixture
def slurm() -> Iterator[Slurm]:
    """A cluster for one test, or the one of ours that is up; skip where there can be none. Tests take turns."""
    with (Path(tempfile.gettempdir()) / "granwave-test-slurm.turn").open("w") as turn:
        fcntl.flock(turn, fcntl.LOCK_EX)
        was_up = cluster.is_up()
        try:
            cluster.start()
        except cluster.CannotError as reason:
            pytest.skip(str(reason))
        yield Slurm()
        if not was_up:
            cluster.stop()
