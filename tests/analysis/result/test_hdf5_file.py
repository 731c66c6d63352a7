"""HDF5 files that are written whole or not at all."""

from __future__ import annotations

import signal
from pathlib import Path

import h5py
import pytest

from granwave.analysis.result.hdf5_file import new_hdf5


def test_ctrl_c_waits_for_the_file_and_keeps_the_old_one(tmp_path: Path) -> None:
    """An error that leaves a write within HDF5 ends the program by a signal."""
    path, written = tmp_path / "x.h5", False
    with new_hdf5(path) as file:
        file["a"] = 1
    with pytest.raises(KeyboardInterrupt), new_hdf5(path) as file:
        signal.raise_signal(signal.SIGINT)
        file["b"] = 2
        written = True
    assert written and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    with h5py.File(path) as file:
        assert list(file) == ["a"]
    assert [one.name for one in tmp_path.iterdir()] == ["x.h5"]
