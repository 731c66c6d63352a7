"""`granwave.run` in threads: the working directory and its files are unchanged, and the results
equal those of consecutive runs.
"""

from __future__ import annotations

import asyncio
import os
import threading
import time
from pathlib import Path
from typing import Any

import pytest

import granwave as gw
from granwave.lammps_inputs.deck.script import with_absolute_files
from granwave.lammps_inputs.errors import InputError
from granwave.workflows.run import turns

SMALL: dict[str, Any] = {"packing.size": [4, 4, 3], "run.end_time": 4e-5, "run.frames": 5}
PULSE: dict[str, Any] = {
    "load": {"kind": "force", "shape": "table", "file": "pulse.txt"},
    "precompression.force": 10.0,
    "run.end_time": 4e-5,
    "run.frames": 3,
    "output.history": 50,
}
NAMES = ("log.lammps", "dumps/energy.txt", "dumps/spheres.bin", "data.granwave", "load.txt")
ODD = "100% a*b “c” \"d\" $e 'f' # &"  # characters that LAMMPS replaces, or ends words at


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Working directory with files of the user that have the names of files of a run."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "dumps").mkdir()
    for name in NAMES:
        (tmp_path / name).write_text("mine")
    return tmp_path


def untouched(place: Path) -> bool:
    """True if the user's files and the working directory are unchanged."""
    return Path.cwd() == place and all((place / name).read_text() == "mine" for name in NAMES)


def test_three_threads(place: Path) -> None:
    peaks: dict[str, float] = {}
    seen: set[str] = set()

    def work(name: str) -> None:
        run = gw.run("fcc-small", SMALL, directory=name, progress=False)
        peaks[name] = run["peak_force_N"]

    threads = [threading.Thread(target=work, args=(name,)) for name in ("a", "b", "c")]
    for thread in threads:
        thread.start()
        time.sleep(0.05)
    while any(thread.is_alive() for thread in threads):
        seen.add(os.getcwd())
        time.sleep(0.002)
    alone = gw.run("fcc-small", SMALL, directory="d", progress=False)
    assert peaks == dict.fromkeys("abc", alone["peak_force_N"])
    assert seen <= {str(place)}
    assert untouched(place)


def test_to_thread_and_a_failure(place: Path) -> None:
    async def both() -> list[Any]:
        works = [
            asyncio.to_thread(gw.run, "fcc-small", SMALL, directory=name, progress=False)
            for name in ("a", "a")
        ]
        return await asyncio.gather(*works, return_exceptions=True)

    found = asyncio.run(both())
    (failure,) = [one for one in found if isinstance(one, Exception)]
    assert isinstance(failure, InputError)
    assert "in use by another run or scan" in str(failure) or "already holds results" in str(
        failure
    )
    assert untouched(place)


def test_a_directory_with_an_odd_name(place: Path) -> None:
    plain = gw.run("fcc-small", SMALL, directory="plain", progress=False)
    odd = gw.run("fcc-small", SMALL, directory=ODD, progress=False)
    assert odd["peak_force_N"] == plain["peak_force_N"]
    assert (odd.contacts["peak_force"] == plain.contacts["peak_force"]).all()
    assert untouched(place)


def test_files_that_the_script_names(place: Path) -> None:
    """A table of forces, and a static stage with its files."""
    Path("pulse.txt").write_text("0 0\n1e-5 500\n2e-5 0\n")
    plain = gw.run("precompressed-chain", PULSE, directory="plain", progress=False)
    odd = gw.run("precompressed-chain", PULSE, directory=ODD, progress=False)
    assert odd["peak_force_N"] == plain["peak_force_N"]
    assert untouched(place)


def test_names_in_commands() -> None:
    text = "dump d all custom 1 dumps/spheres.%.bin id\nread_data       data.granwave\n# mydata.granwave"
    assert with_absolute_files(text, "/a b") == (
        'dump d all custom 1 "/a b/dumps/spheres.%.bin" id\n'
        'read_data       "/a b/data.granwave"\n# mydata.granwave'
    )
    assert with_absolute_files(text, "") == text
    restart = "write_restart checkpoint-120.%.restart nfile 2\nlog log.lammps append"
    assert with_absolute_files(restart, "/a") == (
        'write_restart "/a/checkpoint-120.%.restart" nfile 2\nlog "/a/log.lammps" append'
    )


def test_a_forked_copy_does_not_wait_for_a_thread_it_does_not_have() -> None:
    entered = threading.Event()
    leave = threading.Event()

    def hold() -> None:
        with turns.turn():
            entered.set()
            leave.wait(30)

    thread = threading.Thread(target=hold)
    thread.start()
    entered.wait(30)
    process = os.fork()
    if not process:
        os._exit(0 if turns._TURN.lock.acquire(timeout=5) else 1)
    status = os.waitpid(process, 0)[1]
    leave.set()
    thread.join()
    assert status == 0


class _TwoRanks:
    size = 2


def test_a_thread_on_several_ranks_is_refused() -> None:
    faults: list[str] = []

    def work() -> None:
        try:
            turns.refuse_threads_of_ranks(_TwoRanks())  # type: ignore[arg-type]
        except InputError as error:
            faults.append(str(error))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert "found a run in a thread on 2 MPI ranks" in faults[0]
    turns.refuse_threads_of_ranks(_TwoRanks())  # type: ignore[arg-type]
