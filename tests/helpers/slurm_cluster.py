"""Fixture `slurm`, to be imported by test modules: Slurm cluster of two virtual nodes (tests/helpers/slurm/cluster.py)."""

from __future__ import annotations

import fcntl
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.helpers.slurm import cluster


@dataclass(frozen=True)
class Slurm:
    """Running cluster."""

    partition: str = cluster.PARTITION
    nodes: tuple[str, ...] = cluster.NODES
    cpus: int = cluster.CPUS  # of a node


@pytest.fixture
def slurm() -> Iterator[Slurm]:
    """Provide a cluster for one test, or the running one of ours; skip if none is possible. Tests use it one at a time."""
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
