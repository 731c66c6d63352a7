"""The list of the data sets of result.h5: runs write them, with their units and shapes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import pytest

from granwave.analysis.result.data_sets import GROUPS, data_set_at, data_sets
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows.run.driver import run_case
from tests.helpers.made_up.small_cases import grains_at

FIXED = {"end_time": 1e-5, "timestep": 2e-8, "frames": 2}
CHAIN = {"kind": "chain", "size": 6, "diameter": 0.01}
PLATE = {"mass": 0.02, "stiffness": 1e9}
BAR = {"length": 0.05, "area": 1e-4, "elements": 5, "material": "steel"}
LOSS = {"time": 1e-6}
DAMPED = {"contacts": "relax", "relaxation": "damped"}
LAYERS = {"kind": "fcc", "size": [4, 4, 3], "diameter": 0.01}
CASES: dict[str, dict[str, Any]] = {
    "packing": {
        "packing": LAYERS,
        "contact": {
            "law": "hertz", "friction": 0.3, "rolling": 0.02, "twisting": 0.02, "loss": LOSS,
        },
        "run": {"end_time": 1e-5, "frames": 2},
        "line": [{"name": "down", "index": [1, 5, 9]}],
        "output": {"probes": [{"sphere": 5}, {"contact": [1, 5]}]},
    },
    "cell": {
        "packing": CHAIN,
        "contact": {"law": "hertz", "cohesion": {"kind": "jkr", "energy": 0.1}},
        "boundary": {"bottom": {"plate": PLATE, "material": "steel"}, "holder_friction": 0.1},
    },
    "bars": {
        "packing": CHAIN,
        "load": {"kind": "force", "shape": "half-sine", "amplitude": 100.0, "duration": 2e-5},
        "bar": BAR,
        "incident_bar": BAR,
    },
    "pressed": {
        "packing": grains_at([[0, 0, 0], [0.01, 0, 0]], groups=["pair", "pair"]),
        "contact": {"law": "hertz"},
        "boundary": {"bottom": "free", "x": "wall"},
        "precompression": {"kind": "walls", "x_force": 20.0},
        "load": {"kind": "plate", "mass": 0.01, "velocity": 1e-4},
        "absorb": [{"index": [1], "rate": 1e4}],
    },
    "settled": {
        "packing": grains_at([[0, 0, 0], [0, 0, 0.01]]) | DAMPED,
        "contact": {"law": "hertz", "friction": 0.3},
        "precompression": {"kind": "gravity"},
    },
}  # fmt: skip


def written(directory: Path, tables: Mapping[str, Any]) -> dict[str, h5py.Dataset]:
    """Data sets of the result of a case, by their paths."""
    case = case_from_dict({"name": "small", "material": "brass", "run": FIXED} | dict(tables))
    run_case(case, directory, figures=False)
    found: dict[str, Any] = {}

    def note(path: str, item: h5py.Dataset | h5py.Group) -> None:
        if isinstance(item, h5py.Dataset):
            found[path] = (item.attrs["unit"], item.ndim)
        elif "value" in item:  # links, which visititems visits once
            found.update({f"{path}/{name}": ("s" if name == "time" else "1", 1)
                          for name in ("step", "time")})  # fmt: skip

    with h5py.File(directory / "result.h5") as file:
        file.visititems(note)
    return found


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data_sets")
    return {name: written(folder / name, tables) for name, tables in CASES.items()}


@pytest.mark.parametrize("name", CASES)
def test_every_data_set_is_listed_with_its_unit_and_shape(files, name):
    for path, (unit, dimensions) in files[name].items():
        entry = data_set_at(path)
        assert entry is not None, f"{path} is not listed in analysis/result/data_sets.py"
        assert (entry.unit, len(entry.shape.split(", "))) == (unit, dimensions), path


def test_every_listed_data_set_is_written(files):
    paths = set().union(*files.values())
    for entry in data_sets():
        assert any(map(entry.matches, paths)), f"{entry.path} is not in a result"
        assert entry.meaning, entry.path


def test_the_pressed_walls_of_the_static_stage_have_units(files):
    assert files["pressed"]["prestage/moved_x"] == ("m", 1)
    assert files["pressed"]["prestage/force_x"] == ("N", 1)


def test_names_and_ids_stand_for_capitals():
    assert data_set_at("walls/bottom/force").path == "walls/NAME/force"
    assert (
        data_set_at("particles/spheres/velocity/value").path == "particles/spheres/velocity/value"
    )
    assert data_set_at("spheres/colour") is None
    assert len(GROUPS) == 11
