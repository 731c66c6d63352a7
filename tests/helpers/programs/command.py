"""The command line in the process of the tests."""

from __future__ import annotations

import contextlib
import logging
import subprocess
import sys
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from granwave.workflows.cli.main import main


def command(
    words: Sequence[str], folder: Path, capfd: pytest.CaptureFixture[str]
) -> subprocess.CompletedProcess[str]:
    """Run ``granwave`` with these words in a folder, as in a separate process but a second
    faster.
    """
    capfd.readouterr()
    with pytest.MonkeyPatch.context() as patch, _started_anew():
        patch.chdir(folder)
        try:
            status = main(words)
        except SystemExit as leaving:
            status = leaving.code if isinstance(leaving.code, int) else 1
    said = capfd.readouterr()
    return subprocess.CompletedProcess(words, status, said.out, said.err)


@contextlib.contextmanager
def _started_anew() -> Iterator[None]:
    """Send log messages and warnings to standard error, as in a separate process."""
    root = logging.getLogger()
    ours = logging.getLogger("granwave")
    handlers = root.handlers[:]
    level = root.level
    own_level = ours.level
    root.handlers[:] = []
    try:
        with warnings.catch_warnings():
            warnings.resetwarnings()
            warnings.simplefilter("ignore", DeprecationWarning)
            warnings.simplefilter("ignore", PendingDeprecationWarning)
            warnings.simplefilter("ignore", ResourceWarning)
            warnings.showwarning = _print_warning
            yield
    finally:
        root.handlers[:] = handlers
        root.setLevel(level)
        ours.setLevel(own_level)


def _print_warning(
    message: Warning | str, category: type[Warning], name: str, line: int, *_: Any
) -> None:
    print(warnings.formatwarning(message, category, name, line), file=sys.stderr)
