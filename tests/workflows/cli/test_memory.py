"""Memory that runs out."""

import pytest

from granwave.lammps_inputs.errors import RunError
from granwave.workflows.cli import package
from granwave.workflows.cli.main import FAILED, main
from granwave.workflows.run.lammps_engine import Engine


@pytest.mark.parametrize(
    "error",
    [
        MemoryError("cannot allocate 3 GiB"),
        ImportError("libx.so: failed to map segment from shared object"),
        ImportError("libx.so: cannot allocate memory in static TLS block"),
    ],
)
def test_one_line_and_the_status_of_a_failure(monkeypatch, capsys, error):
    def fail(*_):
        raise error

    monkeypatch.setattr(package, "keys", fail)
    assert main(["keys"]) == FAILED
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and "there is not enough memory" in lines[0] and str(error) in lines[0]


def test_a_missing_module_is_not_taken_for_it(monkeypatch):
    def fail(*_):
        raise ImportError("no module named x")

    monkeypatch.setattr(package, "keys", fail)
    with pytest.raises(ImportError):
        main(["keys"])


def test_in_lammps():
    class Lammps:
        def commands_string(self, text):
            raise Exception(
                "ERROR on proc 0: Failed to reallocate 192282624 bytes for array atom:v (src/memory.cpp:102)"
            )

    with pytest.raises(RunError, match=r"there is not enough memory .*192282624 bytes"):
        Engine(Lammps()).commands("run 1")
