"""Reading of TOML files, with errors that name fault and place."""

from __future__ import annotations

import difflib
import tomllib
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_regular
from granwave.lammps_inputs.named_files import with_absolute_paths


def read_toml(path: str | Path) -> dict[str, Any]:
    """Read a TOML file (UTF-8, with or without a byte-order mark) and make the paths in it absolute.

    Raises
    ------
    InputError
        The file is missing, unreadable, not UTF-8, or not TOML.
    """
    path = Path(path)
    try:
        raw = read_regular(path)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file{_similar(path)}") from None
    except IsADirectoryError:
        raise InputError(f"{path}: found a directory, expected a TOML file") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{path}: cannot be read: {reason}") from None
    try:
        content = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise InputError(
            f"{path}: found bytes that are not UTF-8 (line {line}), expected UTF-8 text; save it as UTF-8"
        ) from None
    try:
        return dict(with_absolute_paths(tomllib.loads(content), path.parent))
    except (ValueError, RecursionError) as error:  # wrong TOML, too long a number, too deep a nesting
        raise InputError(f"{path}: not valid TOML: {error}") from None


def _similar(path: Path) -> str:
    try:
        names = [entry.name for entry in path.parent.iterdir() if entry.is_file()]
    except OSError:
        return f"; there is no directory {path.parent}"
    near = difflib.get_close_matches(path.name, names, n=1)
    return f"; did you mean {path.parent / near[0]}?" if near else ""


def read_tables(path: Path) -> dict[str, Any] | None:
    """Read the tables of a TOML file; None if the file is missing, empty or damaged."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8")) or None
    except (OSError, ValueError, RecursionError):
        return None
