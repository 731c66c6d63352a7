"""Paths named in cases and scans, made absolute as soon as they are read.

A path in a file is relative to the folder of that file (`read_toml`); one in ``--set`` or in a Python mapping is
relative to the working directory (`parse_overrides`, `case_from_dict`). Code that opens the file need not know.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

_KEYS = ("file", "initial_overlap")  # last parts of the keys whose strings are paths


def with_absolute_paths(value: Any, directory: Path, key: str = "") -> Any:
    """Copy tables and lists with all paths in them absolute and links resolved.

    Parameters
    ----------
    value
        Tables of a case or a scan, or a value in them; in a scan a key may be dotted and hold a list of paths.
    directory
        Folder that relative paths start from.
    key
        Key of ``value``; empty for a whole file.
    """
    return _with_paths(value, key, lambda path: os.path.realpath(directory / path))


def with_short_paths(value: Any, directory: Path, key: str = "") -> Any:
    """Copy tables and lists with paths relative to a folder where that is shorter, for display."""
    start = os.path.realpath(directory)
    return _with_paths(value, key, lambda path: min(os.path.relpath(path, start), path, key=len))


def _with_paths(value: Any, key: str, change: Callable[[str], str]) -> Any:
    if isinstance(value, Mapping):
        return {name: _with_paths(item, name, change) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(_with_paths(item, key, change) for item in value)
    is_path = isinstance(value, str) and key.rpartition(".")[2] in _KEYS and value.strip() and "\0" not in value
    return change(value) if is_path else value
