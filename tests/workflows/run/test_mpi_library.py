"""A missing or foreign MPI library is named before MPI starts, with the command that installs the
one that LAMMPS requires.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from granwave.lammps_inputs.errors import RunError
from granwave.plugins import LIBMPI
from granwave.workflows.cli.installation import doctor
from granwave.workflows.run import mpi, mpi_library
from tests.conftest import PLAIN

MISSING = f"{LIBMPI}: cannot open shared object file: No such file or directory"
FOREIGN = "Open MPI v4.1.4, package: Debian OpenMPI, ident: 4.1.4\0"


@pytest.fixture
def foreign(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """An environment without MPICH, in which mpi4py finds Open MPI."""

    def load(path: str) -> None:
        raise OSError(MISSING)

    monkeypatch.setattr(mpi_library, "CDLL", load)
    monkeypatch.setitem(
        sys.modules, "mpi4py.MPI", SimpleNamespace(Get_library_version=lambda: FOREIGN)
    )
    monkeypatch.setattr("mpi4py.MPI", sys.modules["mpi4py.MPI"], raising=False)
    monkeypatch.setattr(sys, "prefix", str(tmp_path))


def test_a_foreign_library(foreign: None, tmp_path: Path) -> None:
    fault = mpi_library.library_fault()
    assert fault == (
        f"LAMMPS requires {LIBMPI}, which is not in {tmp_path / 'lib'}; the MPI library found is "
        "Open MPI v4.1.4, which LAMMPS cannot use"
    )
    with pytest.raises(RunError) as raised:
        mpi.check_library()
    remedy = f"{sys.executable} -m pip install --force-reinstall --no-deps mpich"
    assert str(raised.value) == f"MPI cannot be started: {fault}; install MPICH: {remedy}"


def test_the_remedy_without_a_wheel_of_mpich(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mpi_library, "_is_installed", lambda name: False)
    assert mpi_library.installation_of_mpich().endswith("-m pip install mpich")


def test_a_library_elsewhere_is_no_fault() -> None:
    """A site's library that LAMMPS can be loaded with is accepted, and MPI is started once."""
    script = (
        "from granwave.workflows.run import mpi, mpi_library\n"
        "mpi_library.is_in_environment = lambda: False\n"
        "print(repr(mpi_library.library_fault()), mpi.world().size, mpi.world().size)\n"
    )
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, env=PLAIN)
    assert (done.returncode, done.stdout) == (0, "'' 1 1\n"), done.stderr


def test_no_library_at_all(tmp_path: Path) -> None:
    """All commands end with the fault, and the exit starts or ends no MPI."""
    script = (
        "import sys\n"
        "from granwave.workflows.run import mpi_library\n"
        "mpi_library.is_in_environment = lambda: False\n"
        "from granwave.workflows.cli.main import main\n"
        f"sys.exit(main(['run', 'fcc-small', '-o', {str(tmp_path / 'run')!r}]))\n"
    )
    environment = PLAIN | {"MPI4PY_LIBMPI": "/nonexistent", "PMI_RANK": "0"}
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, env=environment)
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    assert line.startswith("granwave: MPI cannot be started: found no MPI library; ")


def test_doctor_names_the_library_only_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "_LIBRARY_CHECK", "import sys; sys.exit('no libmpi')")
    findings = {finding.part: finding for finding in doctor.examine()}
    assert "lammps module" not in findings
    finding = findings["MPI library"]
    assert not finding.works
    assert finding.found == "no libmpi. Parts that use MPI: not checked"
    assert finding.remedy.startswith("install MPICH: ")


def test_doctor_quotes_the_output_of_an_mpi_that_does_not_start() -> None:
    script = "import sys; sys.exit('An error occurred in MPI_Init_thread')"
    finding = doctor._attempt("part", [sys.executable, "-c", script], "", "remedy of the part")
    assert finding.found == "MPI cannot be started: An error occurred in MPI_Init_thread"
    assert finding.remedy == "remedy of the part"
