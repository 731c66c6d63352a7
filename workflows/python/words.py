"""Messages of errors with options called as in Python: ``force=True`` for ``--force``."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator

from granwave.lammps_inputs.errors import InputError, RunError

_COMMAND = re.compile(r"\bgranwave (run|scan|continuum|analyse)\b")
# options of the command line in messages, and what they are called here
_WORDS = (
    (re.compile(r"^--set: "), ""),
    (re.compile(r"--(force|resume)\b"), r"\1=True"),
    (re.compile(r"--np (\d+)"), r"ranks=\1"),
    (re.compile(r" with -o\b"), " with directory=..."),
    (re.compile(r"--(noise|time|case|repeat)\b"), r"\1"),
    (re.compile(r"--(frame|position)-(rate|noise)\b"), r"\1_\2"),
    (re.compile(r"^-o "), "directory: "),
)


@contextlib.contextmanager
def words_of_python() -> Iterator[None]:
    """Call options in the messages of errors as they are called here; commands to type stay as they are."""
    try:
        yield
    except InputError as error:
        raise InputError(map(in_python, error.errors)) from error.__cause__
    except RunError as error:
        raise RunError(in_python(str(error))) from error.__cause__


def in_python(line: str) -> str:
    """Replace the options of the command line in a message, unless it gives a command to type."""
    if _COMMAND.search(line):
        return line.removeprefix("--set: ")
    for pattern, word in _WORDS:
        line = pattern.sub(word, line)
    return line
