"""Files of the user are kept and named in messages; unusual names; one process at a time."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.workflows.cli.main import main
from granwave.workflows.run.directory import held
from tests.conftest import PLAIN

TINY = ["two-spheres", "--set", "run.frames=2"]
QUICK = [*TINY, "--no-figures"]


def files(directory: Path) -> dict[str, bytes]:
    return {
        str(p.relative_to(directory)): p.read_bytes()
        for p in sorted(directory.rglob("*"))
        if p.is_file()
    }


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def says(capsys):
    """Run a command that must end with a given status; returns its messages."""

    def run(status: int, *words: object) -> str:
        capsys.readouterr()
        assert main([str(word) for word in words]) == status, capsys.readouterr().err
        return capsys.readouterr().err

    return run


# ---------------------------------------------------------------------- directories


def test_folders_are_shared_and_force_removes_what_is_ours(says, tmp_path):
    mine = [
        Path("r", *parts)
        for parts in (("figures", "mine.png"), ("dumps", "mine.txt"), ("points", "x"), ("notes",))
    ]
    for path in mine:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("mine")
    says(0, "run", *TINY, "-o", "r")
    assert (tmp_path / "r" / "figures" / "energies.png").exists()
    assert "already holds results (" in says(2, "run", *QUICK, "-o", "r")
    says(0, "run", *QUICK, "--set", "load.velocity=3", "-o", "r", "--force")
    assert [path.read_text() for path in mine] == ["mine"] * 4
    assert [path.name for path in (tmp_path / "r" / "figures").iterdir()] == ["mine.png"]
    says(0, "write", *TINY, "-o", "r", "--force")
    assert [path.read_text() for path in mine] == ["mine"] * 4 and not Path(
        "r", "summary.json"
    ).exists()


@pytest.mark.needs_extension("continuum")
@pytest.mark.parametrize("words", [[], ["--force"]])
@pytest.mark.parametrize(
    ("name", "command"),
    [
        ("log.lammps", ["run", *TINY]),
        ("figures/energies.csv", ["run", *TINY]),
        ("dumps/spheres.bin", ["run", *TINY]),
        ("contact.csv", ["continuum", "sphere-contact"]),
        ("report.html", ["scan", "restitution"]),
        ("suite.json", ["scan", "protection"]),
    ],
)
def test_files_by_our_names_are_refused(says, tmp_path, name, command, words):
    path = tmp_path / "r" / name
    path.parent.mkdir(parents=True)
    path.write_text("mine")
    before = files(tmp_path)
    message = says(2, *command, "-o", "r", *words)
    assert (
        f"{name} would be overwritten, and granwave did not write it" in message and "-o" in message
    )
    assert len(message.splitlines()) == 1 and files(tmp_path) == before


def test_a_deck_that_was_run_by_hand_is_not_lost(says, tmp_path):
    says(0, "write", *TINY, "-o", "r")
    says(0, "run", *QUICK, "-o", "r", "--resume")  # no results yet that could be lost
    says(0, "write", *TINY, "-o", "r", "--force")
    Path("r", "dumps", "energy.txt").write_text("# by LAMMPS")
    before = files(tmp_path / "r")
    assert "contains a manual LAMMPS run" in says(2, "run", *QUICK, "-o", "r", "--resume")
    assert files(tmp_path / "r") == before


def test_an_empty_directory_stays_where_nothing_came_of_it(says, tmp_path):
    Path("r").mkdir()
    says(2, "run", *TINY, "--set", "packing.size=[1000,1000,1000]", "-o", "r")
    with held(ResultDirectory(tmp_path / "r")):
        pass
    with held(ResultDirectory(tmp_path / "a" / "b")):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["r"]


def test_dumps_that_were_moved_to_another_disk_are_read(says, tmp_path):
    says(0, "run", *QUICK, "-o", "r")
    Path("r", "dumps").rename("far")
    Path("r", "dumps").symlink_to(tmp_path / "far")
    before = files(tmp_path / "far")
    says(0, "analyse", "r", "--no-figures")
    says(0, "run", *QUICK, "-o", "r", "--resume")
    assert "dumps (a link)" in says(2, "run", *QUICK, "-o", "r", "--force")
    assert files(tmp_path / "far") == before and Path("r", "summary.json").exists()


# ---------------------------------------------------------------------- single files


@pytest.mark.parametrize(
    ("output", "mine"),
    [
        ("law.png", "law.csv"),
        ("law.png", "law.pdf"),
        ("law.png", "law.png"),
        ("law.csv", "law.csv"),
    ],
)
def test_a_plot_of_a_law_overwrites_nothing_of_others(says, tmp_path, output, mine):
    Path(mine).write_text("overlap_m,force_N\n")
    assert f"{mine}: exists, and granwave did not write it" in says(2, "law", "-o", output)
    assert files(tmp_path) == {mine: b"overlap_m,force_N\n"}
    Path(mine).unlink()
    for _ in range(2):  # its own is replaced, another table not
        says(0, "law", "-o", output)
    assert output.endswith("png") or "law.csv: exists" in says(
        2, "law", "--restitution", "-o", output
    )


@pytest.mark.parametrize("suffix", [".html", ".md", ".pdf"])
def test_a_report_replaces_its_own_only(says, tmp_path, suffix):
    says(0, "run", *QUICK, "-o", "r")
    name = f"notes{suffix}"
    Path(name).write_text("# Report: my own notes\n\n1 run.\n")
    assert f"{name}: exists, and granwave did not write it" in says(2, "report", "r", "-o", name)
    assert Path(name).read_text() == "# Report: my own notes\n\n1 run.\n"
    for _ in range(2):
        says(0, "report", "r", "-o", f"ours{suffix}")


def test_pictures_of_a_report_overwrite_no_others(says, tmp_path):
    says(0, "run", *TINY, "-o", "r")
    says(0, "report", "r", "-o", "ours.md")
    pictures = files(tmp_path / "ours_files")
    Path("mine_files").mkdir()
    Path("mine_files", next(iter(pictures))).write_text("mine")
    assert "is not a figure of mine.md" in says(2, "report", "r", "-o", "mine.md")
    assert (
        files(tmp_path / "mine_files") == {next(iter(pictures)): b"mine"}
        and not Path("mine.md").exists()
    )
    Path("ours_files", "mine.png").write_text("mine")
    Path("r", "figures", "energies.png").unlink()
    says(0, "report", "r", "-o", "ours.md")
    left = set(files(tmp_path / "ours_files"))
    assert "mine.png" in left and len(pictures.keys() - left) == 1


# ---------------------------------------------------------------------- one at a time, and where nothing can be written


@pytest.mark.needs_extension("pictures")
def test_one_process_at_a_time(says, tmp_path):
    Path("mine").write_text("mine")
    Path("linked").mkdir()
    Path("linked", ".granwave-lock").symlink_to(
        tmp_path / "mine"
    )  # a lock is not taken through a link
    assert (
        "cannot be written to" in says(2, "run", *QUICK, "-o", "linked")
        and Path("mine").read_text() == "mine"
    )
    says(0, "run", *QUICK, "-o", "r")
    says(0, "law", "-o", "law.csv")
    before = files(tmp_path / "r")
    with held(ResultDirectory(tmp_path / "r")):
        for command in (
            ["run", *QUICK, "-o", "r", "--force"],
            ["analyse", "r"],
            ["fit", "law.csv", "-o", "r"],
            ["export", "r", "--to", "csv", "-o", "r"],
        ):
            message = says(2, *command)
            assert "in use by another run or scan" in message and len(message.splitlines()) == 1
        assert files(tmp_path / "r").keys() - before.keys() == {".granwave-lock"}
    assert files(tmp_path / "r") == before


def test_a_disk_that_can_only_be_read(says, tmp_path):
    says(0, "run", *QUICK, "-o", "r")
    disk = tmp_path / "disk"
    disk.mkdir()
    if subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=9m", "tmpfs", disk], capture_output=True
    ).returncode:
        pytest.skip("no disk can be mounted here")
    try:
        shutil.copytree("r", disk / "r")
        subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
        for command in (
            ["run", *QUICK, "-o", "disk/new"],
            ["run", *QUICK, "-o", "disk/r", "--force"],
            ["write", *TINY, "-o", "disk/new"],
            ["analyse", "disk/r"],
            ["export", "disk/r", "--to", "csv"],
            ["report", "r", "-o", "disk/r.html"],
            ["law", "-o", "disk/law.png"],
        ):
            message = says(2, *command)
            assert (
                "cannot be written to" in message
                and "disk" in message
                and len(message.splitlines()) == 1
            )
        says(0, "report", "disk/r", "-o", "r.html")
        says(0, "export", "disk/r", "--to", "csv", "-o", "out")
    finally:
        subprocess.run(["umount", "-l", disk], check=True)


def test_a_full_standard_output_is_told():
    with open("/dev/full", "w") as full:
        command = [sys.executable, "-m", "granwave.workflows", "show", "two-spheres"]
        done = subprocess.run(
            command, stdout=full, stderr=subprocess.PIPE, text=True, env=PLAIN, timeout=60
        )
    assert (done.returncode, done.stderr) == (1, f"granwave: standard output: {os.strerror(28)}\n")
