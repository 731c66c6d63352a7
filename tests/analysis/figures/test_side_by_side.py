"""Figures drawn by several processes: the same files, order, errors and warnings as with one
process.
"""

from __future__ import annotations

import logging
import os
import shutil
import sys
from pathlib import Path

import h5py
import matplotlib
import numpy as np
import pytest

from granwave.analysis import draw_figures, write_result
from granwave.analysis.errors import MissingDataError, MissingOutputError
from granwave.analysis.figures import side_by_side, style
from granwave.analysis.figures.run_figures import _shares, run_figures
from granwave.analysis.figures.side_by_side import PROCESSES
from granwave.analysis.pipeline import analyse
from granwave.lammps_inputs.case.figures import Figures
from granwave.lammps_inputs.errors import InputError
from tests.helpers.made_up import synthetic

NAMES = ("energies", "probes", "impactor_velocity", "bottom_force")


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Finished run of a packing, without figures."""
    folder = tmp_path_factory.mktemp("finished") / "run"
    directory = synthetic.write_run(folder, synthetic.make_case("fcc", (6, 6, 4)))
    write_result(directory)
    return directory


@pytest.fixture(scope="module")
def before(finished, tmp_path_factory):
    """Figures of the run, drawn by one process."""
    directory = tmp_path_factory.mktemp("drawn") / "run"
    shutil.copytree(finished, directory)
    with pytest.MonkeyPatch.context() as alone:
        alone.setenv(PROCESSES, "1")
        draw_figures(directory, names=NAMES)
    return files(directory)


@pytest.fixture
def run(finished, tmp_path):
    """Copy of the finished run."""
    return Path(shutil.copytree(finished, tmp_path / "run"))


@pytest.fixture
def several(monkeypatch):
    """Two processes, as on two cores."""
    monkeypatch.setenv(PROCESSES, "2")
    monkeypatch.setattr(side_by_side, "_LEAST_FIGURES", 1)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})


def files(directory):
    return {path.name: path.read_bytes() for path in (directory / "figures").iterdir()}


def drawn_by_one(directory, monkeypatch, names=NAMES):
    with monkeypatch.context() as alone:
        alone.setenv(PROCESSES, "1")
        draw_figures(directory, names=names)
    return files(directory)


def never(*_):
    raise AssertionError("drawn here")


def damage(directory, change):
    with h5py.File(directory / "result.h5", "r+") as file:
        change(file)


@pytest.mark.needs_extension("pictures")
def test_files_are_those_of_one_process(run, several, monkeypatch):
    """Figures are in the requested order, including two that share their work; settings of
    matplotlib have no effect.
    """
    names = ("energies", "packing_3d", "probes", "packing_3d_dissipation", "bottom_force")
    before = drawn_by_one(run, monkeypatch, names)
    seen = []
    foreign = {
        "text.usetex": True,
        "image.cmap": "no-such-map",
        "axes.facecolor": "#eeffee",
        "figure.dpi": 50,
    }
    with matplotlib.rc_context(foreign):
        written = draw_figures(run, seen.append, names)
        assert matplotlib.rcParams["image.cmap"] == "no-such-map"
    assert seen == list(names)
    assert written == [run / "figures" / f"{name}.png" for name in names if name != "probes"]
    assert files(run) == before
    assert {name.split(".")[0] for name in before} == set(names) - {"probes"}


def test_helpers_draw(run, before, several, monkeypatch):
    with side_by_side.helpers(len(NAMES)) as others, style.style():
        monkeypatch.setattr(others, "_take", lambda _: ())
        outcomes = list(others.draw(NAMES, never, (run, NAMES, Figures())))
    found = zip(NAMES, outcomes, strict=True)
    assert before == {
        name + suffix: content for name, files in found for suffix, content in (files or {}).items()
    }


def test_figures_that_no_longer_apply_are_removed(run, several):
    """Unknown names of figures, and a directory without results, are errors."""
    draw_figures(run, names=("energies", "impactor_velocity"))
    damage(
        run,
        lambda file: file["energy/struck_velocity"].write_direct(
            np.zeros(len(file["energy/time"]))
        ),
    )
    draw_figures(run, names=("energies", "impactor_velocity"))
    assert {path.stem for path in (run / "figures").iterdir()} == {"energies"}
    with pytest.raises(KeyError, match="nothing"):
        draw_figures(run, names=("impactor_velocity", "nothing", "bottom_force"))
    with pytest.raises(MissingOutputError):
        draw_figures(run.parent)


def test_an_error_comes_at_its_place(run, several):
    """The figures before the failing one have been written, the figures after it have not."""
    damage(run, lambda file: file.__delitem__("energy/struck_velocity"))
    seen = []
    with pytest.raises(MissingDataError, match="struck_velocity"):
        draw_figures(run, seen.append, NAMES)
    assert seen == ["energies", "probes", "impactor_velocity"]
    assert {path.stem for path in (run / "figures").iterdir()} == {"energies"}


def test_warnings_are_seen_here(run, several):
    def change(file):
        for name in ("kinetic", "input"):
            file[f"energy/{name}"][3] = float("inf")

    damage(run, change)
    with pytest.warns(RuntimeWarning, match="invalid value"):
        draw_figures(run, names=("energies", "bottom_force"))


def test_a_file_of_others_is_left_alone(run, several, caplog):
    (run / "figures").mkdir()
    (run / "figures" / "bottom_force.png").write_text("mine")
    with caplog.at_level(logging.WARNING):
        written = draw_figures(run, names=NAMES)
    assert "bottom_force: not drawn" in caplog.text
    assert (run / "figures" / "bottom_force.png").read_text() == "mine"
    assert len(written) == 2


@pytest.mark.parametrize("moment", ["before", "after"])
def test_helpers_that_die(run, before, several, monkeypatch, moment):
    with side_by_side.helpers(len(NAMES)) as others:
        processes = others._processes
        take = others._take
        assert len(processes) == 1
        if moment == "before":
            for process in processes:
                process.kill()
                process.wait()
        else:
            monkeypatch.setattr(
                others,
                "_take",
                lambda left: [process.kill() for process in processes] and take(left),
            )
        draw_figures(run, names=NAMES, helpers=others)
    assert files(run) == before


def test_no_python_for_helpers(run, before, several, monkeypatch):
    monkeypatch.setattr(sys, "executable", "/nowhere/python")
    draw_figures(run, names=NAMES)
    assert files(run) == before


def test_helpers_end_with_an_error(several):
    with pytest.raises(KeyError), side_by_side.helpers(8) as others:
        raise KeyError
    assert [process.poll() is None for process in others._processes] == [False]


def test_helpers_draw_once(several):
    with side_by_side.helpers(1) as others:
        assert list(others.draw((), never, ())) == []
        with pytest.raises(ValueError, match="start new ones"):
            next(others.draw((), never, ()))


@pytest.mark.parametrize(
    ("cores", "most", "figures", "memory", "expected"),
    [
        (1, "", 18, 9e9, 1), (2, "", 18, 9e9, 2), (64, "", 18, 9e9, 4), (2, "", 5, 9e9, 1), (8, "1", 18, 9e9, 1),
        (8, "3", 18, 9e9, 3), (8, "3", 18, 0.3e9, 1),
    ],
)  # fmt: skip
def test_number_of_processes(monkeypatch, cores, most, figures, memory, expected):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(cores)))
    monkeypatch.setattr(side_by_side, "available_memory", lambda: memory)
    monkeypatch.delenv(PROCESSES, raising=False)
    if most:
        monkeypatch.setenv(PROCESSES, most)
    with side_by_side.helpers(figures) as others:
        assert len(others._processes) == expected - 1
    monkeypatch.setenv(PROCESSES, "many")
    with (
        pytest.raises(InputError, match="found 'many' in the environment"),
        side_by_side.helpers(18),
    ):
        pass


def test_analysis_starts_helpers(tmp_path, monkeypatch, several):
    directory = synthetic.write_run(tmp_path, synthetic.make_case("chain", 12))
    started = []
    start = side_by_side.Helpers.start
    monkeypatch.setattr(
        side_by_side.Helpers, "start", lambda self: (started.append(0), start(self))
    )
    analyse(directory, figures=False)
    assert not started
    analyse(directory)
    assert len(started) == 1
    assert (directory / "figures" / "energies.csv").exists()


@pytest.mark.needs_extension("pictures")
def test_shares_hold_every_figure_once():
    """Slow figures come first, and two figures that share their work stay together; the others keep
    their order.
    """
    names = tuple(run_figures())
    shares = _shares(names)
    assert sorted(number for share in shares for number in share) == list(range(len(names)))
    assert [names[number] for number in shares[0]] == ["packing_3d", "packing_3d_dissipation"]
    assert _shares(("energies", "packing_3d_dissipation", "probes")) == [[1], [0], [2]]
