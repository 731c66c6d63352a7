"""No code is run from files that the user has not named."""

from __future__ import annotations

import ast
import json
import os
import pickle
from collections.abc import Iterator
from pathlib import Path

import pytest

from granwave.workflows.cli.installation import selftest
from granwave.workflows.cli.main import main
from tests.documents.pages import ROOT
from tests.helpers.made_up.synthetic_scan import grid, write_scan

PACKAGES = ("analysis", "lammps_inputs", "workflows", "plugins")
NETWORK = {
    "socket",
    "http",
    "requests",
    "ftplib",
    "smtplib",
    "ssl",
    "urllib.request",
    "xmlrpc",
    "webbrowser",
}
OWN_PIPES = {
    "analysis/figures/run_figures.py",
    "analysis/figures/side_by_side.py",
}  # unpickle what our own processes send
OF_STUDIES = "analysis/studies/registry.py"  # runs the Python files that the user names
SMALL = [
    "--set",
    "packing.size=[6,6,4]",
    "--set",
    "run.end_time=1e-4",
    "--set",
    "run.frames=2",
    "--no-figures",
]


def calls() -> Iterator[tuple[str, str, ast.Call]]:
    """File, name and node of every call of the packages."""
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Call):
                    yield path.relative_to(ROOT).as_posix(), ast.unparse(node.func), node


def test_no_code_is_made_of_text_nor_unpickled_from_files():
    found = list(calls())
    assert len(found) > 10_000
    assert not [
        file
        for file, name, _ in found
        if name in ("eval", "exec", "compile", "os.system", "os.popen", "np.load")
    ]
    assert {
        file for file, name, _ in found if "pickle.load" in name or "Unpickler" in name
    } <= OWN_PIPES
    assert {file for file, name, _ in found if name.endswith("exec_module")} == {OF_STUDIES}
    given = [(name, keyword.arg) for _, name, node in found for keyword in node.keywords]
    assert not [
        name
        for name, word in given
        if word == "allow_pickle" or (word == "shell" and "subprocess" in name)
    ]


def test_no_module_of_the_network():
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                names = [one.name for one in node.names] if isinstance(node, ast.Import) else []
                names += [str(node.module)] if isinstance(node, ast.ImportFrom) else []
                assert not NETWORK & {
                    part for name in names for part in (name, name.partition(".")[0])
                }, path


def test_a_result_that_names_a_study_runs_nothing(tmp_path, caplog):
    scan = write_scan(tmp_path / "scan", grid(load__velocity=[1.0, 2.0]))
    done = tmp_path / "executed"
    study = tmp_path / "mine.py"
    study.write_text(f"open({str(done)!r}, 'w').close()\ndef rows(runs): return []\n")
    index = json.loads((scan / "scan.json").read_text())
    (scan / "scan.json").write_text(json.dumps(index | {"study": [str(study)]}))
    assert main(["report", str(scan), "-o", str(tmp_path / "report.md")]) == 0
    assert not done.exists() and "reports load external code only on request" in caplog.text
    assert (
        main(["report", str(scan), "-o", str(tmp_path / "report.md"), "--study", str(study)]) == 0
    )
    assert done.exists()


class Payload:
    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self):
        return os.mkdir, (str(self.mark),)


@pytest.mark.parametrize("name", ["grains.traj", "grains.pckl", "grains.npy", "grains.csv"])
def test_pickled_grains_are_refused(tmp_path, name, capsys):
    """This includes files with the head of ASE's old trajectories, which were pickled."""
    mark = tmp_path / "executed"
    heads = {"grains.traj": b"PickleTrajectory", "grains.npy": b"\x93NUMPY\x01\x00"}
    (tmp_path / name).write_bytes(heads.get(name, b"") + pickle.dumps(Payload(mark)))
    case = tmp_path / "case.toml"
    case.write_text(f'material = "brass"\n[packing]\nkind = "file"\nfile = "{name}"\n')
    assert main(["check", str(case)]) == 2
    assert not mark.exists() and name in capsys.readouterr().err


def test_an_input_script_that_lies_there_is_not_executed(tmp_path, monkeypatch):
    """LAMMPS scripts can run shell commands: neither analysis nor resuming runs a script that was
    changed.
    """
    place = tmp_path / "run"
    mark = tmp_path / "executed"
    with selftest._stopped_early(place, tmp_path / "stop"):
        assert main(["run", "fcc-small", "-o", str(place), *SMALL]) == 130
    script = place / "in.granwave"
    script.write_text(f"shell mkdir {mark}\n" + script.read_text())
    assert main(["run", "fcc-small", "-o", str(place), *SMALL, "--resume"]) == 0
    assert (
        not mark.exists() and "shell" not in script.read_text()
    )  # the run began again, with a deck of its own
    script.write_text(f"shell mkdir {mark}\n" + script.read_text())
    assert main(["analyse", str(place), "--no-figures"]) in (0, 2)
    assert not mark.exists()
