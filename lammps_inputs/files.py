"""Files that are replaced whole or not at all, errors that name their file, and JSON that may be damaged."""

from __future__ import annotations

import contextlib
import errno
import json
import math
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

DISK_IS_FULL = (errno.ENOSPC, errno.EDQUOT)  # error numbers


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A hidden scratch file beside ``path`` that takes its place at the end; on an error the old file stays."""
    scratch = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with naming(path):
            yield scratch
            os.replace(scratch, path)
    finally:
        discard(scratch)


def discard(scratch: Path) -> None:
    """Remove a file that may still be open, and free its room at once.

    HDF5 crashes at the end of the program where it cannot write the rest of a file for want of room.
    """
    with contextlib.suppress(OSError):  # what went wrong before is what matters
        os.truncate(scratch, 0)
        scratch.unlink()


@contextlib.contextmanager
def naming(path: Path) -> Iterator[None]:
    """Within it, an error of the system that names no file, as that of a full disk, names this one.

    What a library raises in its place (HDF5, PIL) becomes such an error too.
    """
    try:
        yield
    except OSError as error:
        number = error.errno or _number_in(str(error))
        if number is None or (error.filename is not None and not _is_scratch(error.filename, path)):
            raise
        reason = os.strerror(number) if error.errno is None or "errno = " in str(error) else error.strerror
        raise OSError(number, reason, str(path)) from error
    except RuntimeError as error:  # h5py, when it closes a file
        if (number := _number_in(str(error))) is None:
            raise
        raise OSError(number, os.strerror(number), str(path)) from error


def _number_in(message: str) -> int | None:
    """The error number of the system in a message of HDF5."""
    found = re.search(r"errno = (\d+)", message)
    return int(found[1]) if found else None


def _is_scratch(name: Any, path: Path) -> bool:
    """A scratch file of `replacing`."""
    return Path(os.fsdecode(name)).name == f".{path.name}.{os.getpid()}"


def replace_text(path: Path, text: str) -> None:
    """Replace a text file (UTF-8) whole or not at all."""
    replace_bytes(path, text.encode("utf-8"))


def replace_bytes(path: Path, content: bytes) -> None:
    """Replace a file whole or not at all."""
    with replacing(path) as scratch:
        scratch.write_bytes(content)


def read_regular(path: Path) -> bytes:
    """Read a file whole, if it has an end.

    Raises
    ------
    OSError
        It cannot be read, or is a pipe or a device, which may never end.
    """
    if path.exists() and not path.is_file() and not path.is_dir():
        raise OSError(errno.EINVAL, "is a pipe or a device, expected a file", str(path))
    return path.read_bytes()


def read_json(path: Path) -> dict[str, Any] | None:
    """The JSON table in a file; None where there is none, or none that can be read."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):  # the last of brackets nested without end
        return None
    return content if isinstance(content, dict) else None


def head(path: Path, size: int = -1) -> bytes:
    """The first bytes of a file, all if ``size`` is negative; none where it cannot be read."""
    try:
        with path.open("rb") as file:
            return file.read(size)
    except OSError:
        return b""


def plain(value: Any) -> Any:
    """Tables, lists and numbers as JSON has them: numpy's as plain ones, NaN and infinity as null."""
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    value = value.item() if isinstance(value, np.generic) else value
    return None if isinstance(value, float) and not math.isfinite(value) else value
