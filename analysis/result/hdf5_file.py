"""Atomic writing of HDF5 files, safe against full disks.

HDF5 crashes the program if it cannot write data that it holds in memory. Failing writes are therefore hidden from it,
and their error is raised after HDF5 has closed the file.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py

from granwave.lammps_inputs.files import naming, replacing


@contextlib.contextmanager
def new_hdf5(path: Path, **options: Any) -> Iterator[h5py.File]:
    """Give a new HDF5 file that replaces ``path`` when complete; on an error the old file remains.

    Parameters
    ----------
    options
        Options of `h5py.File`.

    Raises
    ------
    OSError
        The file cannot be written; the error names it.
    """
    with replacing(path) as scratch, unfailing(scratch) as stream, h5py.File(stream, "w", **options) as file:
        yield file


@contextlib.contextmanager
def unfailing(path: Path) -> Iterator[io.FileIO]:
    """Give a new file in which writing never fails; at the end, the first error is raised."""
    with naming(path), _Unfailing(path, "w+") as stream:
        try:
            yield stream
        finally:
            if stream.error is not None:
                raise stream.error


class _Unfailing(io.FileIO):
    error: OSError | None = None

    def write(self, data: Any) -> int:
        view = memoryview(data).cast("B")
        done = 0
        while self.error is None and done < len(view):
            try:
                done += super().write(view[done:])
            except OSError as error:
                self.error = error
        self.seek(len(view) - done, io.SEEK_CUR)
        return len(view)

    def truncate(self, size: int | None = None) -> int:
        try:
            return super().truncate(size)
        except OSError as error:
            self.error = self.error or error
            return self.tell() if size is None else size
