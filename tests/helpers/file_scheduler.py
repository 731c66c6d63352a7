"""Distribution of tests among the processes of pytest-xdist, for ``--dist loadgroup``."""

from __future__ import annotations

from xdist.scheduler import LoadGroupScheduling


class FileScheduling(LoadGroupScheduling):
    """Schedule that gives the tests of a group, or else of a file, to one process.

    Fixtures of a module are then made once, and not in each process; and scheduling 10 000 single
    tests took several seconds in the process that distributes them.
    """

    def _split_scope(self, nodeid: str) -> str:
        """Return the name of the group of a test, or the path of its file."""
        return super()._split_scope(nodeid).partition("::")[0]
