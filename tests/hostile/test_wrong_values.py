"""Results whose values no run leaves, without the checksums that would show it: text in place of
numbers, numbers that are not finite, ids that are none.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.exports.export import export
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.case.parse import parse_overrides
from granwave.lammps_inputs.errors import InputError
from granwave.workflows.library import load_case
from granwave.workflows.run.driver import run_case
from tests.helpers.made_up.run_files import without_checksums

WRONG = {
    "spheres/id": 2**62,
    "particles/spheres/id": -5,
    "spheres/position": np.inf,
    "spheres/time_first": -np.inf,
    "contacts/i": 0,
    "contacts/j": 2**62,
    "contacts/peak_force": np.nan,
    "wall_contacts/id": -1,
    "energy/kinetic": np.nan,
    "energy/time": 1e9,
    "walls/bottom/force": np.inf,
    "particles/spheres/velocity/value": np.nan,
    "particles/spheres/position/time": np.nan,
}
TEXTS = ("spheres/radius", "energy/input", "particles/spheres/box/edges", "walls/bottom/force")
TEXTS += ("particles/spheres/velocity/value", "contacts/i")


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Directory of a finished run whose files have no checksums."""
    place = tmp_path_factory.mktemp("finished") / "run"
    changes = parse_overrides({"packing.size": [4, 4, 3], "run.end_time": 2e-5, "run.frames": 5})
    run_case(load_case("fcc-small", changes), place, figures=False)
    return without_checksums(place)


@pytest.fixture
def run(finished: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(finished, tmp_path / "run"))


def replace(run: Path, name: str, values: Any, **options: Any) -> None:
    """Replace a data set, and keep its attributes."""
    with h5py.File(run / "result.h5", "r+") as file:
        attributes = dict(file[name].attrs)
        del file[name]
        file.create_dataset(name, data=values, **options).attrs.update(attributes)


@pytest.mark.parametrize(
    "to", ["csv", pytest.param("vtp", marks=pytest.mark.needs_extension("pictures")), "netcdf"]
)
@pytest.mark.parametrize("name", WRONG)
def test_values(run: Path, name: str, to: str) -> None:
    with h5py.File(run / "result.h5") as file:
        values = file[name][()]
    values = values.astype("i8") if values.dtype.kind in "iu" else values
    values.flat[values.size // 2] = WRONG[name]
    replace(run, name, values)
    with pytest.raises(InputError, match=r"result\.h5 is damaged \(.*granwave analyse") as caught:
        export(run, to, run.parent / "out")
    assert name.removesuffix("/value") in str(caught.value)
    assert not (run.parent / "out").exists()


@pytest.mark.parametrize("name", TEXTS)
def test_text(run: Path, name: str) -> None:
    with h5py.File(run / "result.h5") as file:
        shape = file[name].shape
    replace(run, name, np.full(shape, "abc", dtype=object), dtype=h5py.string_dtype())
    with pytest.raises(OutputFormatError, match=f"{name} does not hold numbers"):
        Result(run)


def test_values_of_a_run_are_accepted(run: Path) -> None:
    assert export(run, "csv", run.parent / "out")
