"""Forces of contacts after the static stage, ``initial_force`` in result.h5, against closed forms."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from granwave.analysis import MissingOutputError, OutputFormatError, analyse
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.run_directory import MARKER
from granwave.workflows import run_case

FORCE = 20.0  # N
COLUMN = "initial_force"


def run(directory: Path, **sections: Any) -> Path:
    packing = {"kind": "chain", "size": 8, "diameter": 0.01}
    tables = {"name": "static", "packing": packing, "material": "steel", "run": {"end_time": 2e-6, "frames": 2}}
    tables |= {"contact": {"law": "hertz"}}
    case = case_from_dict(tables | {"precompression": {"kind": "uniaxial", "force": FORCE}} | sections)
    assert run_case(case, directory, figures=False).state == "finished"
    return directory


def table(directory: Path, group: str) -> dict[str, np.ndarray]:
    with h5py.File(directory / "result.h5") as file:
        assert group not in file or COLUMN not in file[group] or file[group][COLUMN].attrs["unit"] == "N"
        return {name: values[()] for name, values in file[group].items()}


@pytest.fixture(scope="module")
def struck(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Chain under a force, against which a striker rests that waits until the run begins."""
    striker = {"load": {"kind": "striker"}, "striker": [{"touches": [1], "velocity": [0.0, 0.0, 1.0]}]}
    return run(tmp_path_factory.mktemp("initial") / "chain", **striker, run={"end_time": 5e-5, "frames": 2})


@pytest.fixture
def copied(struck: Path, tmp_path: Path) -> Path:
    return shutil.copytree(struck, tmp_path / "run")


def test_chain_under_a_force(struck: Path) -> None:
    contacts, walls = (table(struck, group) for group in ("contacts", "wall_contacts"))
    of_striker = contacts["j"] == 9
    assert contacts[COLUMN][~of_striker] == pytest.approx(np.full(7, FORCE), rel=1e-7)
    assert walls["id"].tolist() == [8] and walls[COLUMN] == pytest.approx([FORCE], rel=1e-7)
    assert contacts[COLUMN][of_striker].tolist() == [0.0] and contacts["peak_force"][of_striker] > 0


def test_chain_on_a_bar(tmp_path: Path) -> None:
    """The contact with the face of a bar is one of the pair style."""
    bar = {"length": 0.1, "area": 1e-4, "elements": 20, "end": "fixed"}
    walls = table(run(tmp_path, boundary={"bottom": {"bar": bar, "material": "steel"}}), "wall_contacts")
    assert walls["id"].tolist() == [8] and walls[COLUMN] == pytest.approx([FORCE], rel=1e-6)


def test_planes_that_touch_spheres_of_two_materials(tmp_path: Path) -> None:
    """Each material has a fix of its own; two rows pressed by a force on each wall across."""
    directory = run(
        tmp_path,
        packing={"kind": "sc", "size": [3, 2, 2], "diameter": 0.01},
        replace=[{"index": [1, 6], "material": "brass"}],
        boundary={"sides": "wall"},
        precompression={"kind": "walls", "x_force": FORCE},
    )
    walls = table(directory, "wall_contacts")
    for name in (b"xlo", b"xhi"):
        on_wall = walls["wall"] == name
        assert on_wall.sum() == 4 and walls[COLUMN][on_wall].sum() == pytest.approx(FORCE, rel=1e-6)
    assert (directory / "dumps" / "initial_forces_xlo_2.dump").exists()


def test_results_of_a_version_that_did_not_write_them(copied: Path) -> None:
    marker = json.loads((copied / MARKER).read_text())
    own = [name for name in marker["files"] if "initial_forces" in name]
    assert own == ["dumps/initial_forces.dump", "dumps/initial_forces_bottom.dump"]
    for name in own:
        (copied / name).unlink()
        del marker["files"][name]
    (copied / MARKER).write_text(json.dumps(marker))
    before = table(copied, "contacts")
    analyse(copied, figures=False)
    after = table(copied, "contacts")
    assert before.keys() - after.keys() == {COLUMN} and COLUMN not in table(copied, "wall_contacts")
    assert all(np.array_equal(after[name], before[name], equal_nan=True) for name in after)


@pytest.mark.parametrize("name", ["initial_forces.dump", "initial_forces_bottom.dump"])
def test_missing_or_cut(copied: Path, name: str) -> None:
    path = copied / "dumps" / name
    text = path.read_text()
    path.write_text(text[:-3])
    with pytest.raises(OutputFormatError, match=rf"{name}: (is not what the run wrote|.* cut short)"):
        analyse(copied, figures=False)
    path.unlink()
    with pytest.raises(MissingOutputError, match=rf"{name} is missing; run the case again with --force"):
        analyse(copied, figures=False)


@pytest.mark.parametrize(("name", "old", "new"), [("", "1 2 ", "1 77 "), ("_bottom", "8 ", "3 ")])
def test_of_another_run(copied: Path, name: str, old: str, new: str) -> None:
    path = copied / "dumps" / f"initial_forces{name}.dump"
    path.write_text(path.read_text().replace(f"\n{old}", f"\n{new}"))
    with pytest.raises(
        OutputFormatError, match=rf"{path.name}: (is not what the run wrote|found .* belong to different runs)"
    ):
        analyse(copied, figures=False)
