"""Output on terminals and for programs: colours, tables, JSON, and the shell commands that enable
tab completion.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Container, Sequence
from typing import Any

from granwave.lammps_inputs.errors import InputError, InputFault
from granwave.lammps_inputs.files import plain
from granwave.lammps_inputs.streams import is_terminal

# ANSI codes
BOLD = "1"
RED = "31"
GREEN = "32"
YELLOW = "33"

SHELLS = ("bash", "zsh", "fish")
#: Lines that enable completion, by shell, and the file for them.
SWITCH_ON = {
    "bash": ('eval "$(granwave completion bash)"', "~/.bashrc"),
    "zsh": ('eval "$(granwave completion zsh)"', "~/.zshrc, after compinit"),
    "fish": ("granwave completion fish | source", "~/.config/fish/config.fish"),
}


def coloured(text: str, code: str, stream: Any) -> str:
    """Return a text with a colour, if the stream is a terminal that shows it and NO_COLOR is not
    set.
    """
    shows = (
        is_terminal(stream) and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
    )
    return f"\033[{code}m{text}\033[0m" if shows else text


def columns(rows: Sequence[Sequence[str]], left: Container[int] = ()) -> str:
    """Format a table; the columns ``left`` are left-aligned, the other columns right-aligned."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    aligned = [
        [
            f"{text:{'<' if k in left else '>'}{width}}"
            for k, (text, width) in enumerate(zip(row, widths, strict=True))
        ]
        for row in rows
    ]
    return "\n".join("  ".join(row).rstrip() for row in aligned)


def warn(text: str) -> None:
    """Print a warning on standard error."""
    print(f"granwave: warning: {text}", file=sys.stderr)


def warn_of_lacks(name: str, afford: Callable[[], object]) -> list[str]:
    """Return and print the missing resources of this machine for a run, as warnings; another
    machine may have them.

    Parameters
    ----------
    afford
        Function that raises InputError if this machine cannot run the case.
    """
    try:
        afford()
    except InputError as error:
        lacks = [
            f"{line_of(fault)} (on this machine; granwave run would stop)" for fault in error.items
        ]
    else:
        lacks = []
    for lack in lacks:
        warn(lack if lack.startswith(name) else f"{name}: {lack}")
    return lacks


#: Options of functions in messages, and the corresponding options of the command line.
_OPTIONS = {
    "force=True": "--force",
    "resume=True": "--resume",
    "with directory=...": "with -o",
}


def line_of(fault: InputFault) -> str:
    """Return a fault in one line, with the option that changed its key."""
    return in_shell(f"--set: {fault}" if fault.changed else str(fault))


def in_shell(text: str) -> str:
    """Replace options of functions in a message by the options of the command line."""
    for words, option in _OPTIONS.items():
        text = text.replace(words, option)
    return text


def print_json(values: Any) -> None:
    """Print one JSON document, and nothing else, on standard output; NaN and infinity become
    null.
    """
    print(json.dumps(plain(values), indent=2, allow_nan=False, default=os.fspath))  # paths as text
    sys.stdout.flush()
