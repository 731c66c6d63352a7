"""Files: atomic replacement, system errors that name their file, rows of CSV, TOML with absolute
paths; free memory.

Rows of CSV are read with the numbers of their lines; a # outside quotes begins a comment. Paths
that cases and scans name are made absolute as soon as they are read: a path in a file is relative
to the folder of the file (`read_toml`), in ``--set`` or in a Python mapping to the working
directory (`parse_overrides`, `case_from_dict`). Code that opens the file need not know.
"""

from __future__ import annotations

import contextlib
import csv
import difflib
import errno
import functools
import json
import math
import os
import re
import stat
import tomllib
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from granwave.lammps_inputs.errors import InputError, InputFault

DISK_IS_FULL = (errno.ENOSPC, errno.EDQUOT)  # error numbers
_BLOCK = 2**20  # bytes read at a time


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Provide a hidden scratch file next to ``path`` that replaces it at the end; on an error the
    old file is kept.
    """
    scratch = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with naming(path):
            yield scratch
            os.replace(scratch, path)
    finally:
        discard(scratch)


def discard(scratch: Path) -> None:
    """Remove a file that may still be open, and free its disk space at once.

    HDF5 crashes at the end of the program if the disk is too full to write the rest of an open
    file.
    """
    with contextlib.suppress(OSError):  # the earlier error is reported
        os.truncate(scratch, 0)
        scratch.unlink()


@contextlib.contextmanager
def scratch_files(path: Path) -> Iterator[Callable[[], Path]]:
    """Provide a function that returns names of hidden scratch files next to ``path``; they are
    removed at the end.
    """
    made: list[Path] = []

    def name() -> Path:
        made.append(path.with_name(f".{path.name}.{os.getpid()}{len(made):08}"))
        return made[-1]

    try:
        yield name
    finally:
        for scratch in made:
            discard(scratch)


@contextlib.contextmanager
def naming(path: Path) -> Iterator[None]:
    """Add this file to system errors that name no file, such as a full disk.

    Other errors raised by libraries (HDF5, PIL) are also converted.
    """
    try:
        yield
    except OSError as error:
        number = error.errno or _number_in(str(error))
        scratch = f".{path.name}.{os.getpid()}"  # scratch file of `replacing`
        if number is None or (
            error.filename is not None and Path(os.fsdecode(error.filename)).name != scratch
        ):
            raise
        reason = (
            os.strerror(number)
            if error.errno is None or "errno = " in str(error)
            else error.strerror
        )
        raise OSError(number, reason, str(path)) from error
    except RuntimeError as error:  # h5py, when it closes a file
        if (number := _number_in(str(error))) is None:
            raise
        raise OSError(number, os.strerror(number), str(path)) from error


def _number_in(message: str) -> int | None:
    """Return the system's error number in a message of HDF5."""
    found = re.search(r"errno = (\d+)", message)
    return int(found[1]) if found else None


def replace_text(path: Path, text: str) -> None:
    """Replace a text file (UTF-8) atomically."""
    replace_bytes(path, text.encode("utf-8"))


def replace_bytes(path: Path, content: bytes) -> None:
    """Replace a file atomically."""
    with replacing(path) as scratch:
        scratch.write_bytes(content)


def is_special(path: Path) -> bool:
    """Return True for a pipe, a socket or a device, also through a link; opening it may never
    end.
    """
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def regular(path: Path) -> Path:
    """Return the path of a file to be opened.

    Raises
    ------
    OSError
        It is a pipe, a socket or a device.
    """
    if is_special(path):
        raise OSError(errno.EINVAL, "is a pipe or a device, expected a file", str(path))
    return path


def read_regular(path: Path) -> bytes:
    """Read a complete file; reject pipes and devices, which may never end.

    Raises
    ------
    OSError
        The file cannot be read, or is a pipe or a device.
    """
    return regular(path).read_bytes()


def read_text(path: Path, decode: Callable[[bytes], str] | None = None) -> str:
    """Read a complete file as UTF-8, or by another decoder; reject pipes and devices.

    Raises
    ------
    OSError
        The file cannot be read, or is a pipe or a device.
    ValueError
        It is not UTF-8; the message gives the line.
    """
    raw = read_regular(path)
    return decoded(raw) if decode is None else decode(raw)


def decoded(raw: bytes) -> str:
    """Return the text of bytes in UTF-8, with or without a byte-order mark.

    Raises
    ------
    ValueError
        They are not UTF-8; the message gives the line.
    """
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        text = (
            f"found bytes that are not UTF-8 (line {line}), expected UTF-8 text; save it as UTF-8"
        )
        raise UnicodeError(text) from None


def read_user_text(
    path: Path,
    what: str,
    hint: Callable[[Path], str] = lambda _: "",
    decode: Callable[[bytes], str] | None = None,
) -> str:
    """Read a text file that a user named; raise InputError. ``hint`` returns additional text for a
    missing file, ``decode`` the text of bytes that may not be UTF-8.
    """
    try:
        return read_text(path, decode)
    except FileNotFoundError:
        fault = f"no such file{hint(path)}"
    except IsADirectoryError:
        fault = f"found a directory, expected a {what}"
    except UnicodeError as error:
        fault = str(error)
    except (OSError, ValueError) as error:
        fault = f"cannot be read: {getattr(error, 'strerror', None) or error}"
    raise InputError(InputFault(source=str(path), sentence=fault))


def read_json(path: Path) -> dict[str, Any] | None:
    """Read a JSON table; None if the file is missing or damaged."""
    return _table(path, json.loads)


def read_tables(path: Path) -> dict[str, Any] | None:
    """Read the tables of a TOML file; None if the file is missing, empty or damaged."""
    return _table(path, tomllib.loads) or None


def _table(path: Path, parse: Callable[[str], Any]) -> dict[str, Any] | None:
    try:
        content = parse(regular(path).read_text(encoding="utf-8"))
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
    now = path.stat()
    state = (now.st_ino, now.st_size, now.st_mtime_ns, now.st_ctime_ns)
    return _checksum(path, now.st_size if size is None else size, after, state)


@functools.lru_cache(maxsize=1024)  # each file is read once while it is unchanged
def _checksum(path: Path, end: int, after: tuple[int, int], _state: tuple[int, ...]) -> int:
    place, found = after
    with regular(path).open("rb") as file:
        file.seek(place)
        while block := file.read(min(_BLOCK, max(end - place, 0))):
            found = zlib.crc32(block, found)
            place = place + len(block)
    return found


def head(path: Path, size: int = -1) -> bytes:
    """Read the first bytes of a file, all if ``size`` is negative; empty if it cannot be read."""
    try:
        with regular(path).open("rb") as file:
            return file.read(size)
    except OSError:
        return b""


def plain(value: Any) -> Any:
    """Convert tables, lists and numbers to types of JSON: plain numbers for numpy's, null for NaN
    and infinity.
    """
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    value = value.item() if isinstance(value, np.generic) else value
    return None if isinstance(value, float) and not math.isfinite(value) else value


def refuse_too_large(what: str, memory: float, remedy: str, available: float | None = None) -> None:
    """Raise InputError if ``what`` needs more ``memory`` than ``available``, bytes (default: the
    memory of the machine).
    """
    available = available_memory() if available is None else available
    if memory > available:
        raise InputError(
            f"{what} require about {memory / 2**30:.1f} GiB of memory; available: "
            f"{available / 2**30:.1f} GiB; {remedy} or another machine"
        )


def available_memory() -> float:
    """Return the memory that is available to a new program on this machine, bytes."""
    try:
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return float(line.split()[1]) * 1024
    except OSError:
        pass  # not Linux: fall back on the total memory
    return float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")


_SPECIAL = re.compile('[,"#]')
_NUMBER = re.compile(
    r"[-+]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[-+]?[0-9]+)?|nan|inf|infinity)", re.IGNORECASE
)
_WHOLE = re.compile(r"[-+]?[0-9]+")

_FORMULA = ("=", "+", "-", "@", "\t", "\r")  # first characters of formulas in spreadsheets


def read_number(word: str) -> float:
    """Convert a word to a number; NaN and infinity are numbers here.

    Raises
    ------
    ValueError
        It is none, as a word with underscores or with digits beyond ASCII, which Python would take.
    """
    if not _NUMBER.fullmatch(word.strip()):
        raise ValueError(f"found {word!r}, expected a number")
    return float(word)


def read_whole(word: str) -> int:
    """Convert a word to a whole number; raise ValueError as `read_number`."""
    if not _WHOLE.fullmatch(word.strip()):
        raise ValueError(f"found {word!r}, expected a whole number")
    return int(word)


def csv_cell(word: str) -> str:
    """Return a word without line breaks as a cell of a table, in quotes if needed."""
    return '"' + word.replace('"', '""') + '"' if _SPECIAL.search(word) else word


def write_csv_rows(file: TextIO, rows: Iterable[Iterable[object]]) -> None:
    """Write rows as CSV; text that a spreadsheet would interpret as a formula is preceded by an
    apostrophe.
    """

    def plain_text(cell: object) -> object:
        if isinstance(cell, str) and cell[:1] in _FORMULA and len(cell) > 1:
            try:
                float(cell)
            except ValueError:
                return f"'{cell}"
        return cell

    csv.writer(file, lineterminator="\n").writerows(
        [plain_text(cell) for cell in row] for row in rows
    )


# last parts of the keys whose strings are paths
_KEYS = ("file", "restart", "initial_overlap", "stl")
_LAW = "law"  # last part of the key of a law, or of a file with one
TOML_SUFFIX = ".toml"


def with_absolute_paths(value: Any, directory: Path, key: str = "") -> Any:
    """Copy tables and lists with all paths in them absolute and links resolved.

    Parameters
    ----------
    value
        Tables of a case or a scan, or a value in them; in a scan a key may be dotted and hold a
        list of paths.
    directory
        Folder that relative paths start from.
    key
        Key of ``value``; empty for a complete file.
    """
    return _with_paths(value, key, lambda path: os.path.realpath(directory / path))


def with_short_paths(value: Any, directory: Path, key: str = "") -> Any:
    """Copy tables and lists with paths relative to a folder if that is shorter, for display."""
    start = os.path.realpath(directory)
    return _with_paths(value, key, lambda path: min(os.path.relpath(path, start), path, key=len))


def _with_paths(value: Any, key: str, change: Callable[[str], str]) -> Any:
    if isinstance(value, Mapping):
        return {name: _with_paths(item, name, change) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(_with_paths(item, key, change) for item in value)
    is_path = isinstance(value, str) and value.strip() and "\0" not in value
    return change(value) if is_path and _names_file(key.rpartition(".")[2], value) else value


def _names_file(key: str, value: str) -> bool:
    """Return True for a value, by the last part of its key, that is a path."""
    return key in _KEYS or (key == _LAW and value.endswith(TOML_SUFFIX))


def read_toml(path: str | Path) -> dict[str, Any]:
    """Read a TOML file (UTF-8, with or without a byte-order mark) and make the paths in it
    absolute.

    Raises
    ------
    InputError
        The file is missing, unreadable, not UTF-8, or not TOML.
    """
    path = Path(path)
    content = read_user_text(path, "TOML file", _similar)
    try:
        return dict(with_absolute_paths(tomllib.loads(content), path.parent))
    except (
        ValueError,
        RecursionError,
    ) as error:  # wrong TOML, too long a number, too deep a nesting
        raise InputError(_not_toml(path, content, error)) from None


def _not_toml(path: Path, content: str, error: Exception) -> InputFault:
    """Return the fault of a file that is not valid TOML, with its line if known."""
    found = re.search(r"at line (\d+)", str(error))
    if found is None:
        return InputFault(source=str(path), sentence=f"not valid TOML: {error}")
    number = int(found[1])
    line = content.split("\n")[number - 1].lstrip()[:60]  # characters shown
    shown = f": {''.join(filter(str.isprintable, line))}" if line else ""
    sentence = f"not valid TOML: {error}{shown}"
    return InputFault(source=str(path), line=number, sentence=sentence)


def _similar(path: Path) -> str:
    try:
        names = [entry.name for entry in path.parent.iterdir() if entry.is_file()]
    except OSError:
        return f"; there is no directory {path.parent}"
    near = difflib.get_close_matches(path.name, names, n=1)
    return f"; did you mean {path.parent / near[0]}?" if near else ""
