"""Values and words in messages."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from typing import Any

from granwave.lammps_inputs.errors import SHOWN_CHARACTERS, cut


def show(value: Any) -> str:
    """Format ``value`` as in a TOML file, cut to a readable length."""
    if isinstance(value, bool):
        shown = "true" if value else "false"
    elif isinstance(value, str):
        shown = '"' + printable(value.replace("\\", "\\\\")) + '"'
    elif isinstance(value, Mapping):
        shown = "{" + ", ".join(f"{key} = {show(item)}" for key, item in value.items()) + "}"
    elif isinstance(value, list | tuple):
        shown = "[" + ", ".join(show(item) for item in value[:SHOWN_CHARACTERS]) + "]"
    else:
        shown = str(value)
    return cut(shown)


def printable(text: str) -> str:
    """Escape line ends, control characters and direction marks, for a text on one line."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def did_you_mean(word: Any, known: Iterable[str], cutoff: float = 0.6) -> str:
    """Return a hint at the most similar known word; empty if none is similar."""
    near = difflib.get_close_matches(str(word).lower(), list(known), n=1, cutoff=cutoff)
    return f"; did you mean {near[0]}?" if near else ""


def counted(n: int, noun: str) -> str:
    """Return a number with its noun: ``1 run``, ``2 runs``."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"
