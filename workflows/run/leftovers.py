"""Remains of killed processes: scratch directories, and shared memory of MPI.

Each belongs to a file that its process keeps locked. A later start removes the files of this user
that are no longer locked.
"""

from __future__ import annotations

import atexit
import contextlib
import fcntl
import os
import re
import shutil
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

_PREFIX = "granwave-"
_LOCK = "lock"  # in a scratch directory
_NOTE = ".segments"  # suffix of the file with the names of the shared memory of a process
_MEMORY = Path("/dev/shm")
_MAPS = Path("/proc/self/maps")
_SEGMENT = re.compile(rf"{_MEMORY}/((?:mpich_shm|ucx_shm_posix)_\w+)$", re.MULTILINE)
_NAME = re.compile(r"(?:mpich_shm|ucx_shm_posix)_\w+")
_NOTED: dict[int, tuple[Path, int]] = {}  # file and its descriptor, by process


@contextlib.contextmanager
def scratch_directory(prefix: str = _PREFIX) -> Iterator[Path]:
    """Make a directory for temporary files that is removed at the end, or by a later start."""
    clear()
    with tempfile.TemporaryDirectory(prefix=prefix) as name:
        lock = _locked(Path(name) / _LOCK)
        try:
            yield Path(name)
        finally:
            os.close(lock)


def note_segments() -> None:
    """Note the shared memory that this process maps, for a later start if this process is
    killed.
    """
    process = os.getpid()
    if process in _NOTED or not _MAPS.exists():
        return
    segments = sorted(set(_SEGMENT.findall(_MAPS.read_text(encoding="utf-8", errors="replace"))))
    path = Path(tempfile.gettempdir()) / f"{_PREFIX}{os.getuid()}-{process}{_NOTE}"
    with contextlib.suppress(OSError):  # without it no files are removed
        _NOTED[process] = path, _locked(path, "\n".join(segments))
        atexit.register(forget)


def forget() -> None:
    """Remove the note of this process, which ends in order."""
    if found := _NOTED.pop(os.getpid(), None):
        path, lock = found
        path.unlink(missing_ok=True)
        os.close(lock)


def remove_own() -> None:
    """Remove the shared memory of this process, which ends at once, and its note."""
    if found := _NOTED.get(os.getpid()):
        _remove_segments(found[0])
        forget()


def clear() -> None:
    """Remove the files of terminated processes of this user."""
    with contextlib.suppress(OSError), os.scandir(tempfile.gettempdir()) as entries:
        for entry in entries:
            if entry.name.startswith(_PREFIX):
                with contextlib.suppress(OSError):
                    _clear(Path(entry.path))


def _clear(path: Path) -> None:
    status = path.lstat()
    folder = stat.S_ISDIR(status.st_mode)
    if status.st_uid != os.getuid() or not (folder or path.suffix == _NOTE):
        return
    lock = os.open(path / _LOCK if folder else path, os.O_RDWR | os.O_NOFOLLOW)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if folder:
            shutil.rmtree(path, ignore_errors=True)
        else:
            _remove_segments(path)
            path.unlink()
    finally:
        os.close(lock)


def _remove_segments(note: Path) -> None:
    for name in note.read_text(encoding="utf-8").split():
        segment = _MEMORY / name
        with contextlib.suppress(OSError):
            if _NAME.fullmatch(name) and segment.lstat().st_uid == os.getuid():
                segment.unlink()


def _locked(path: Path, text: str = "") -> int:
    """Make a file that is locked as soon as it has its name; return its descriptor."""
    scratch = path.with_name(f"{path.name}.new")
    lock = os.open(scratch, os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW, 0o600)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        os.write(lock, text.encode())
        scratch.replace(path)
    except OSError:
        os.close(lock)
        scratch.unlink(missing_ok=True)
        raise
    return lock
