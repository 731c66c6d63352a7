"""Packings of other programs: every reader returns the written grains, bitwise."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import ase
import ase.io
import numpy as np
import pytest

from granwave.lammps_inputs.case.packing.grains import (
    GrainChoices,
    Grains,
    parse_grains,
    read_grains,
)
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.readers.registry import READERS, reader_of
from granwave.lammps_inputs.readers.source import FileOptions, GrainSource
from granwave.workflows.run.driver import run_case
from tests.lammps_inputs.readers import writers


def read(path: Path, choices: GrainChoices | None = None, **options: Any) -> Grains:
    return read_grains(GrainSource(path, FileOptions(**options)), choices)


def fault(path: Path, content: str | bytes, **options: Any) -> str:
    writers.write(path, content)
    with pytest.raises(ValueError) as caught:
        read(path, **options)
    return str(caught.value)


@pytest.mark.parametrize("name", writers.FILES)
def test_grains_of_every_format_are_those_that_were_written(name: str, tmp_path: Path) -> None:
    path = writers.write(tmp_path / "grains", writers.FILES[name]())
    grains = read(path)
    assert np.array_equal(grains.position, writers.POSITION)
    assert np.array_equal(grains.diameter, writers.DIAMETER)
    if name not in writers.WITHOUT_VELOCITY:
        assert grains == parse_grains(writers.own_table(), None)
    assert grains.half_unit.shape == (3, 3)
    assert grains.half_unit.max() <= 1e-15


def test_every_format_has_a_file_here(tmp_path: Path) -> None:
    """All formats except those of ASE, which keep fewer digits."""
    seen = set()
    for name, content in writers.FILES.items():
        path = writers.write(tmp_path / name, content())
        seen.add(reader_of(GrainSource(path)).NAME)
    assert seen == set(READERS) - {"ase"}


@pytest.mark.parametrize("name", ["dump", "data", "h5md", "dump of several steps"])
def test_periodic_boxes_are_kept(name: str, tmp_path: Path) -> None:
    grains = read(writers.write(tmp_path / "grains", writers.FILES[name]()))
    assert grains.reading is not None and grains.reading.bounds is not None
    assert grains.reading.bounds == pytest.approx(writers.BOX)
    assert grains.period == (None if name == "data" else (0.04, 0.04))


def test_a_dump_in_other_units(tmp_path: Path) -> None:
    text = writers.dump_step(100, scale=1e3).replace("0.005\n", "5\n").replace("0.0075\n", "7.5\n")
    path = writers.write(tmp_path / "grains", text)
    choices = GrainChoices(keeps_velocities=False)
    grains = read(path, choices, units="mm")
    assert grains.position == pytest.approx(writers.POSITION, rel=1e-15)
    assert grains.diameter.tolist() == writers.DIAMETER.tolist()
    assert not grains.velocity.any()


def test_units_of_lammps_are_those_of_the_file(tmp_path: Path) -> None:
    text = writers.dump_step(100)
    later = text.replace("ITEM: NUMBER", "ITEM: UNITS\ncgs\nITEM: NUMBER", 1)
    grains = read(writers.write(tmp_path / "grains", later))
    assert grains.position == pytest.approx(writers.POSITION / 100)
    assert "found the units lj" in fault(tmp_path / "lj", later.replace("cgs", "lj"))


def test_a_step_of_a_dump_is_chosen(tmp_path: Path) -> None:
    text = writers.dump_step(0, moved=1e-3) + writers.dump_step(100)
    path = writers.write(tmp_path / "grains", text)
    assert read(path, step=0).position == pytest.approx(writers.POSITION + 1e-3)
    assert "found no step 7 (packing.step), expected one of 0, 100" in fault(path, text, step=7)


def test_scaled_places(tmp_path: Path) -> None:
    text = writers.dump_step(100).replace(" x y z ", " xs ys zs ")
    lengths = writers.BOX[:, 1]
    for place in writers.POSITION:
        numbers = " ".join(repr(number) for number in place.tolist())
        text = text.replace(
            numbers, " ".join(repr(number) for number in (place / lengths).tolist())
        )
    grains = read(writers.write(tmp_path / "grains", text))
    assert grains.position == pytest.approx(writers.POSITION, rel=1e-15)


def test_images_outside_of_the_box_are_put_back(tmp_path: Path) -> None:
    text = writers.dump_step(100).replace("1 1 0.01 ", "1 1 0.09 ")
    grains = read(writers.write(tmp_path / "grains", text))
    assert grains.position == pytest.approx(writers.POSITION)
    assert grains.reading is not None
    assert grains.reading.notes == ["1 grain outside of the periodic box wrapped back into it"]


def test_types_are_materials(tmp_path: Path) -> None:
    text = writers.dump_step(100).replace("\n3 1 ", "\n3 2 ")
    path = writers.write(tmp_path / "grains", text)
    choices = GrainChoices(materials={"1": "brass", "2": "steel"})
    assert read(path, choices).material == ("brass", "brass", "steel")
    with pytest.raises(ValueError, match="found no material of the type 2"):
        read(path, GrainChoices(materials={"1": "brass"}))
    with pytest.raises(ValueError, match="found no type 3"):
        read(path, GrainChoices(materials={"1": "brass", "2": "steel", "3": "ptfe"}))


@pytest.mark.parametrize(("up", "down"), [("z", (0, 0, -1)), ("-x", (1, 0, 0)), ("y", (0, -1, 0))])
def test_a_packing_is_turned(up: str, down: tuple[int, int, int], tmp_path: Path) -> None:
    path = writers.write(tmp_path / "grains", writers.dump_step(100))
    before = read(path)
    grains = read(path, GrainChoices(up=up))
    assert np.array_equal(grains.position[:, 2], before.position @ np.array(down))
    assert np.array_equal(grains.velocity[:, 2], before.velocity @ np.array(down))
    first, second, _ = grains.position
    assert np.linalg.norm(second - first) == pytest.approx(0.01)


def test_a_table_of_a_spreadsheet(tmp_path: Path) -> None:
    """A byte-order mark, line ends of Windows, decimal commas, millimetres."""
    text = "\ufeffx (mm);y (mm);z (mm);d (mm)\r\n0;0;0;6,35\r\n0;0;6,35;6,35\r\n"
    grains = read(writers.write(tmp_path / "g.csv", text))
    assert grains.position[:, 2].tolist() == [0.0, 6.35e-3]
    assert grains.diameter.tolist() == [6.35e-3, 6.35e-3]
    assert grains.half_unit.max() == pytest.approx(5e-6)


def test_ids_that_are_not_those_of_rows_are_noted(tmp_path: Path) -> None:
    text = writers.dump_step(100).replace("\n3 1 ", "\n30 1 ")
    grains = read(writers.write(tmp_path / "grains", text))
    assert grains.reading is not None
    assert grains.reading.notes[0].startswith("ids from 1 to 30; the 3 grains are numbered from 1")


def test_nodes_of_a_bar_are_left_out(tmp_path: Path) -> None:
    text = writers.data_file().replace("3 1 0.015 2500", "3 1 0 2500")
    grains = read(writers.write(tmp_path / "grains", text))
    assert len(grains) == 2
    assert grains.reading is not None and "1 points of diameter 0 ignored" in grains.reading.notes


@pytest.mark.parametrize("ending", ["xyz", "extxyz"])
def test_places_without_sizes_take_the_diameter_of_the_packing(ending: str, tmp_path: Path) -> None:
    atoms = ase.Atoms("X2", positions=[[0, 0, 0], [0, 0, 0.01]])
    ase.io.write(tmp_path / f"grains.{ending}", atoms)
    grains = read(tmp_path / f"grains.{ending}", diameter=0.01)
    assert grains.position.tolist() == [[0, 0, 0], [0, 0, 0.01]]
    with pytest.raises(ValueError, match="found no diameters"):
        read(tmp_path / f"grains.{ending}")


DUMP = writers.dump_step(100)


@pytest.mark.parametrize(("content", "options", "message"), [
    ("", {}, "found an empty file"),
    (b"\0\1\2\xff" * 99, {}, "found a binary file of no known format"),
    (b"LammpS RestartT\0\0", {}, "found a binary restart file of LAMMPS, expected text"),
    (DUMP[:-60], {}, "found 2 of 3 atoms in the step 100: the dump is truncated"),
    (DUMP.replace("OF ATOMS\n3", "OF ATOMS\n2"), {},
     "found 3 atoms in the step 100, expected 2 as in its NUMBER OF ATOMS: the dump is damaged"),
    (writers.data_file().replace("3 atoms", "2 atoms"), {}, "found more than 2 rows in the"),
    (writers.dump_step(0) + DUMP[:-60], {}, "packing.step = 0 reads the previous step"),
    (DUMP[:60], {}, "without its values: the dump is damaged or truncated"),
    (DUMP.replace("radius", "c_size"), {}, "found no radius or diameter among the columns id"),
    (DUMP.replace(" z ", " depth "), {}, "found no z among the columns"),
    (DUMP.replace("\n2 1 ", "\n1 1 "), {}, "found the id 1 twice, expected a unique id"),
    (DUMP.replace("0.0275", "nan"), {}, 'line 10: found "nan" for z, expected a finite number'),
    (DUMP.replace("0.0275", "0.0275 9"), {}, "line 10: found 13 values, expected 12"),
    (writers.data_file().replace("# sphere", "# full"), {}, "found atom_style full"),
    (writers.data_file().partition("2 1 0.01")[0], {}, "found 2 of 3 rows in the section Atoms"),
    (writers.data_file().partition("Velocities")[0][:-40], {}, "line 14: found 4 values"),
    (writers.data_file()[:-30], {}, "found 2 of 3 rows in the section Velocities"),
    (writers.mercury_step()[:-110], {}, "line 1: found 2 of 3 particles: the file is truncated"),
    (writers.mercury_step()[:-60], {}, "the file may be truncated"),
    (writers.mercury_restart()[:500], {}, "truncated"),
    (writers.vtk_ascii()[:-90], {}, "truncated"),
    (writers.vtk_binary()[:-9], {}, "found 8 of 9 numbers: the file is truncated"),
    (writers.vtp("ascii")[:300], {}, "found XML that is damaged or truncated"),
    (writers.h5md()[:900], {}, "found an HDF5 file that is damaged or truncated"),
    (writers.FILES["dump.gz"]()[:-30], {}, "found a .gz file that cannot be unpacked"),
    ("0 0 0 1\n0 0 1 1\n", {}, 'without names, expected a line of names, or packing.columns = '),
    ("a,b,c,d\n0,0,0,1\n", {}, "found no column x, expected x, y, z, diameter"),
    ("x,y,z,d\n0,0,0,1\n", {"columns": {"z": "depth"}}, 'found no column "depth" for z'),
    ("x,y,z,r,d\n0,0,0,1,2\n", {}, "found the column diameter (or radius for it) twice"),
    ("pos_x,cx,y,z,r\n0,0,0,0,1\n", {}, "found the columns pos_x and cx for x; choose one"),
    ("x (ft),y,z,r\n0,0,0,1\n", {}, 'found the unit "ft" of the column "x (ft)", expected m, dm'),
    ("x,y,z,d\n0,01,0,02,0,03,0,04\n", {}, "decimal commas need semicolons, tabs or blanks"),
])  # fmt: skip
def test_faults(
    content: str | bytes, options: dict[str, Any], message: str, tmp_path: Path
) -> None:
    assert message in fault(tmp_path / "grains", content, **options)


def test_two_units_in_a_file_are_noted(tmp_path: Path) -> None:
    rows = "".join(f"0,0,{k},0.01\n" for k in range(5))
    grains = read(writers.write(tmp_path / "grains", f"x,y,z,d\n{rows}0,0,50,10\n"))
    assert grains.reading is not None
    assert grains.reading.notes == [
        "line 7: a diameter of 10 m is 1e+03 times the median; are there two units in the file?"
    ]


def test_the_keys_of_a_case_reach_the_reader(tmp_path: Path) -> None:
    text = "pos_x pos_y height size id\n0 0 0 5 1\n0 0 10 5 2\n0 0 22.5 7.5 3\n"
    writers.write(tmp_path / "g.txt", text)
    columns = {"x": "pos_x", "z": "height", "radius": 4}
    packing = {"kind": "file", "file": str(tmp_path / "g.txt"), "columns": columns, "units": "mm"}
    case = case_from_dict({"packing": packing, "material": "brass"}, "mine")
    grains = case.packing.grains
    assert grains is not None
    assert grains.position[:, 2].tolist() == [0.0, 0.01, 0.0225]
    assert grains.diameter.tolist() == [0.01, 0.01, 0.015]
    again = case_from_dict(tomllib.loads(case.to_toml()), "mine")
    assert again.packing.grains == grains


@pytest.mark.parametrize(("key", "value", "message"), [
    ("format", "lamps-dump", 'packing.format: found "lamps-dump"'),
    ("units", "inch", 'packing.units: found "inch"'),
    ("columns", {"X": "a"}, "X is not a quantity"),
    ("columns", [], "packing.columns: found []"),
    ("types", {"1": 2}, "packing.types"),
    ("step", -1, "packing.step: found -1"),
    ("up", "w", 'packing.up: found "w"'),
    ("format", "h5md", "found an HDF5 file that is damaged or truncated"),
])  # fmt: skip
def test_faults_of_keys(key: str, value: Any, message: str, tmp_path: Path) -> None:
    writers.write(tmp_path / "g.csv", writers.own_table())
    packing = {"kind": "file", "file": str(tmp_path / "g.csv"), key: value}
    with pytest.raises(InputError) as caught:
        case_from_dict({"packing": packing, "material": "brass"}, "mine")
    assert message in str(caught.value)


def test_keys_of_a_file_belong_to_one() -> None:
    packing = {"kind": "chain", "size": 3, "diameter": 0.01, "units": "mm"}
    with pytest.raises(InputError, match=r'packing.units: applies only to packing.kind = "file"'):
        case_from_dict({"packing": packing, "material": "brass"}, "mine")


def test_an_impact_on_a_dump_is_that_on_our_table(lammps: Any, tmp_path: Path) -> None:
    """A dump and a data file that LAMMPS itself writes, against the table with all digits."""
    writers.write(tmp_path / "own.csv", writers.own_table())
    writers.write(tmp_path / "given.data", writers.data_file())
    lammps(f"""
units si
atom_style sphere
boundary f f f
newton off
read_data {tmp_path / "given.data"}
pair_style gran/hooke 1e5 NULL 0 NULL 0 0
pair_coeff * *
comm_modify vel yes
run 0
write_dump all custom {tmp_path / "grains.dump"} id type x y z vx vy vz radius &
  modify format float %.17g
write_data {tmp_path / "grains.data"}
""")
    summaries = []
    for name in ("own.csv", "grains.dump", "grains.data"):
        tables = {
            "packing": {"kind": "file", "file": str(tmp_path / name)},
            "material": "brass",
            "boundary": {"bottom": "free"},
            "run": {"end_time": 2e-5, "frames": 2},
        }
        case = case_from_dict(tables, "grains")
        summaries.append(run_case(case, tmp_path / f"run-{name}", figures=False).summary)
    own = summaries[0]["peak_force_N"]
    assert own > 1.0
    for summary in summaries[1:]:
        assert summary["peak_force_N"] == pytest.approx(own, rel=1e-9)
        assert summary["energy_dissipated_J"] == pytest.approx(
            summaries[0]["energy_dissipated_J"], rel=1e-9
        )


OF_EACH_READER = (
    "dump", "dump of liggghts", "yaml", "data", "molecule", "yade.txt", "yade.spheres",
    "mercury.data", "mercury.restart", "lethe", "vtk", "vtp appended", "h5md", "xyz",
    "esys.geo", "mfix", "packing.xyzd",
)  # fmt: skip


def impact(path: Path, directory: Path) -> dict[str, Any]:
    """Return the summary of a run with the grains of a file, at rest if the file has no
    velocities.
    """
    tables = {
        "packing": {"kind": "file", "file": str(path)},
        "material": "brass",
        "boundary": {"bottom": "free"},
        "load": {"kind": "impact", "velocity": 0.25},
        "run": {"end_time": 2e-5, "frames": 2},
    }
    return run_case(case_from_dict(tables, "grains"), directory, figures=False).summary


def test_an_impact_on_a_file_of_every_reader_is_that_on_our_table(tmp_path: Path) -> None:
    formats = [
        reader_of(GrainSource(writers.write(tmp_path / name, writers.FILES[name]()))).NAME
        for name in OF_EACH_READER
    ]
    assert {*formats} == {*READERS} - {"ase"}
    table = writers.own_table()
    at_rest = "\n".join(",".join(row.split(",")[:4]) for row in table.splitlines())
    own = {
        name: impact(writers.write(tmp_path / f"{name}.csv", text), tmp_path / f"run {name}")
        for name, text in (("moving", table), ("at rest", at_rest))
    }
    assert own["moving"]["peak_force_N"] > 1.5 * own["at rest"]["peak_force_N"] > 1.0
    for name in OF_EACH_READER:
        summary = impact(tmp_path / name, tmp_path / f"run {name}")
        like = own["at rest" if name in writers.WITHOUT_VELOCITY else "moving"]
        for quantity in ("peak_force_N", "energy_dissipated_J"):
            assert summary[quantity] == pytest.approx(like[quantity], rel=1e-9), (name, quantity)
