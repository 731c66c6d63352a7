"""Atomic replacement of files, system errors that name their file, and reading JSON that may be damaged."""

from __future__ import annotations

import contextlib
import errno
import functools
import json
import math
import os
import re
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

DISK_IS_FULL = (errno.ENOSPC, errno.EDQUOT)  # error numbers
_BLOCK = 2**20  # bytes read at a time


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a hidden scratch file beside ``path`` that replaces it at the end; on an error the old file stays."""
    scratch = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with naming(path):
            yield scratch
            os.replace(scratch, path)
    finally:
        discard(scratch)


def discard(scratch: Path) -> None:
    """Remove a file that may still be open, and free its disk space at once.

    HDF5 crashes at the end of the program if the disk is too full to write the rest of an open file.
    """
    with contextlib.suppress(OSError):  # an earlier error is the one to report
        os.truncate(scratch, 0)
        scratch.unlink()


@contextlib.contextmanager
def naming(path: Path) -> Iterator[None]:
    """Make system errors that name no file, such as that of a full disk, name this one.

    Errors that a library raises in their place (HDF5, PIL) are converted, too.
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
    """Return the system's error number in a message of HDF5."""
    found = re.search(r"errno = (\d+)", message)
    return int(found[1]) if found else None


def _is_scratch(name: Any, path: Path) -> bool:
    """Return True for a scratch file of `replacing`."""
    return Path(os.fsdecode(name)).name == f".{path.name}.{os.getpid()}"


def replace_text(path: Path, text: str) -> None:
    """Replace a text file (UTF-8) atomically."""
    replace_bytes(path, text.encode("utf-8"))


def replace_bytes(path: Path, content: bytes) -> None:
    """Replace a file atomically."""
    with replacing(path) as scratch:
        scratch.write_bytes(content)


def read_regular(path: Path) -> bytes:
    """Read a whole file; refuse pipes and devices, which may never end.

    Raises
    ------
    OSError
        The file cannot be read, or is a pipe or a device.
    """
    if path.exists() and not path.is_file() and not path.is_dir():
        raise OSError(errno.EINVAL, "is a pipe or a device, expected a file", str(path))
    return path.read_bytes()


def read_text(path: Path) -> str:
    """Read a whole file as UTF-8; refuse pipes and devices.

    Raises
    ------
    OSError
        The file cannot be read, or is a pipe or a device.
    ValueError
        It is not UTF-8; the message gives the line.
    """
    raw = read_regular(path)
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise ValueError(
            f"found bytes that are not UTF-8 (line {line}), expected UTF-8 text; save it as UTF-8"
        ) from None


def read_json(path: Path) -> dict[str, Any] | None:
    """Read a JSON table; None if the file is missing or damaged."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):  # RecursionError: brackets nested too deeply
        return None
    return content if isinstance(content, dict) else None


def checksum(path: Path, size: int | None = None, *, after: tuple[int, int] = (0, 0)) -> int:
    """Return the CRC-32 of a file, or of its first ``size`` bytes.

    Parameters
    ----------
    after
        Size and CRC-32 of a part at the beginning that was read before.
    """
    status = path.stat()
    end = status.st_size if size is None else size
    return _checksum(path, end, after, (status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns))


@functools.lru_cache(maxsize=1024)  # each file is read once, as long as it stays the same
def _checksum(path: Path, end: int, after: tuple[int, int], _state: tuple[int, ...]) -> int:
    place, found = after
    with path.open("rb") as file:
        file.seek(place)
        while block := file.read(min(_BLOCK, max(end - place, 0))):
            found, place = zlib.crc32(block, found), place + len(block)
    return found


def head(path: Path, size: int = -1) -> bytes:
    """Read the first bytes of a file, all if ``size`` is negative; empty if it cannot be read."""
    try:
        with path.open("rb") as file:
            return file.read(size)
    except OSError:
        return b""


def plain(value: Any) -> Any:
    """Convert tables, lists and numbers to types of JSON: plain numbers for numpy's, null for NaN and infinity."""
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    value = value.item() if isinstance(value, np.generic) else value
    return None if isinstance(value, float) and not math.isfinite(value) else value
