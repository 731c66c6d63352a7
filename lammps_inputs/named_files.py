"""Files that a case or a scan names: absolute paths from the moment they are read.

A path in a file starts from the folder of that file (`read_toml`), one of ``--set`` or of a mapping in Python from the
working directory (`parse_overrides`, `Case.from_dict`). Whatever opens the named file needs to know neither.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

_KEYS = ("file", "initial_overlap")  # last parts of the keys whose text is a path


def with_absolute_paths(value: Any, directory: Path, key: str = "") -> Any:
    """Copy tables and lists with every path in them absolute, links followed.

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
    """Copy tables and lists with every path in them as seen from a folder, where that is shorter; for people."""
    start = os.path.realpath(directory)
    return _with_paths(value, key, lambda path: min(os.path.relpath(path, start), path, key=len))


def _with_paths(value: Any, key: str, change: Callable[[str], str]) -> Any:
    if isinstance(value, Mapping):
        return {name: _with_paths(item, name, change) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(_with_paths(item, key, change) for item in value)
    is_path = isinstance(value, str) and key.rpartition(".")[2] in _KEYS and value.strip() and "\0" not in value
    return change(value) if is_path else value
