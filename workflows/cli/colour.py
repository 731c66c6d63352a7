"""Colours of what is printed on terminals; none where output goes elsewhere, or NO_COLOR is set."""

from __future__ import annotations

import os
from typing import Any

BOLD, RED, GREEN, YELLOW = "1", "31", "32", "33"  # ANSI codes


def coloured(text: str, code: str, stream: Any) -> str:
    """Return a text with a colour, if the stream is a terminal that shows it."""
    shows = stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
    return f"\033[{code}m{text}\033[0m" if shows else text
