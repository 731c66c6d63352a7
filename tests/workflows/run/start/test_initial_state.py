"""Spheres that the ranks create are bitwise identical to those that LAMMPS reads from the data
file, in the same order.
"""

from __future__ import annotations

import contextlib
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from granwave.lammps_inputs import write_deck
from granwave.lammps_inputs.deck.script import READ_DATA, part
from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows.run import initial_state
from granwave.workflows.run.initial_state import make_spheres
from granwave.workflows.run.lammps_engine import Engine, open_engine
from tests.analysis.lammps_output.test_parts import CASES, case_of
from tests.conftest import BIN, PLAIN
from tests.helpers.made_up import synthetic

GRAINS = (
    "x,y,z,diameter,vz\n0.0,0.0,0.0,0.01,0\n0.0,0.0,0.01,0.01,-2.5\n0.0021,0.0,0.0195,0.009,1\n"
)
ARRAYS = ("id", "type", "x", "v", "radius", "rmass", "image")
MADE = {name: tables for name, tables in CASES.items() if "bar" not in tables}
MADE["cylinders"] = {
    "kind": "square",
    "size": (6, 5),
    "packing": {"shape": "cylinder", "length": 0.02, "diameter_scatter": 1e-6},
}
# run on several ranks by this file itself
RANKS = ("periodic", "vacancies and scatter", "striker")


def states(case, directory: Path, comm) -> list[list[bytes]]:
    """Own atoms of a rank as read and as created, and both restart files."""
    if comm.rank == 0:
        write_deck(case, directory)
    comm.barrier()
    before, _, _ = part((directory / "in.granwave").read_text(), "setup").partition(
        f"{READ_DATA}\n"
    )
    found = []
    for made in (False, True):
        with contextlib.chdir(directory), open_engine(comm, log="none") as engine:
            engine.commands(before)
            make_spheres(engine, assemble(case)) if made else engine.commands(READ_DATA)
            engine.commands("write_restart state")
            found.append(
                [engine.per_atom(name).tobytes() for name in ARRAYS] + [Path("state").read_bytes()]
            )
    return found


@pytest.mark.parametrize("name", [*MADE, "grains that move"])
def test_made_as_read(tmp_path, monkeypatch, name):
    from mpi4py import MPI

    monkeypatch.setattr(initial_state, "_BATCH", 50)
    if name in MADE:
        case = case_of(**MADE[name])
    else:
        (tmp_path / "grains.csv").write_text(GRAINS)
        packing = {"file": str(tmp_path / "grains.csv"), "kind": "file"}
        case = synthetic.case_from_dict(
            {"material": "brass", "packing": packing, "load": {"kind": "grains"}}
        )
    read, made = states(case, tmp_path / "deck", MPI.COMM_SELF)
    assert [
        name for name, a, b in zip((*ARRAYS, "restart"), read, made, strict=True) if a != b
    ] == []
    assert len(made[0]) == assemble(case).n_spheres * 4


@pytest.mark.validation
def test_on_three_ranks(tmp_path):
    words = [
        str(BIN / "mpiexec"),
        "-n",
        "3",
        sys.executable,
        "-m",
        "mpi4py",
        "-m",
        __name__,
        str(tmp_path),
    ]
    done = subprocess.run(
        words,
        cwd=Path(__file__).parents[4],
        env=PLAIN,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert sorted(done.stdout.split("\n")) == sorted(["", *(f"{name}: True" for name in RANKS)])


@pytest.mark.parametrize(("tagint", "imageint", "shift"), [(4, 4, 1 << 10), (8, 8, 1 << 21)])
def test_integers_of_lammps(tagint, imageint, shift):
    """Ids and images are passed with the integer size of the LAMMPS build; lost spheres are an
    error.
    """
    seen = []

    def create(_handle, n, ids, types, positions, velocities, images, expand):
        arrays = [(ids, f"i{tagint}"), (types, "i4"), (images, f"i{imageint}")]
        seen.extend(np.ctypeslib.as_array((np.ctypeslib.as_ctypes_type(form) * n).from_address(at.value)).tolist()
                    for at, form in arrays)  # fmt: skip

    lammps = SimpleNamespace(
        lib=SimpleNamespace(lammps_create_atoms=create, lammps_has_error=lambda _: False),
        lmp=None,
        has_exceptions=False,
        extract_setting={"tagint": tagint, "imageint": imageint}.get,
        extract_global=lambda _: 2,
    )
    ids = np.array([7, 2**31 - 1 if tagint == 4 else 2**40])
    of_all = (
        ids,
        np.array([1, 2]),
        np.zeros((2, 3)),
        np.zeros((2, 3)),
        np.array([[0, 0, 0], [-1, 1, 0]]),
    )
    Engine(lammps).create_atoms(*of_all, n_atoms=2)
    zero = shift // 2 * (1 + shift + shift**2)
    assert seen == [ids.tolist(), [1, 2], [zero, zero - 1 + shift]]
    with pytest.raises(RunError, match="the ranks created 2 of 3 spheres"):
        Engine(lammps).create_atoms(*of_all, n_atoms=3)


if __name__ == "__main__":
    from mpi4py import MPI

    for one in RANKS:
        is_read, is_made = states(
            case_of(**MADE[one]), Path(sys.argv[1]) / one.replace(" ", "-"), MPI.COMM_WORLD
        )
        alike = MPI.COMM_WORLD.allreduce(int(is_read == is_made), op=MPI.MIN)
        if MPI.COMM_WORLD.rank == 0:
            print(f"{one}: {bool(alike)}")
