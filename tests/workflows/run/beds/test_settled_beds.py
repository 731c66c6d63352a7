"""Impacts on beds that a LAMMPS script has settled with friction, or that settle damped."""

from __future__ import annotations

import dataclasses
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import granwave as gw
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.restart_file import read_restart
from granwave.workflows.run import static_progress
from granwave.workflows.run.lammps_engine import open_engine

pytestmark = pytest.mark.xdist_group("settled beds")  # its fixtures are made once

PERIOD = 0.033
GRAVITY = 9.81
DENSITY = 8500.0
D = 0.010
SOFT = {"name": "soft", "youngs_modulus": 1e9, "poisson_ratio": 0.3, "density": DENSITY}
LAWS = {"hertz": "hertz 1e9 0.30", "elastoplastic": "elastoplastic 1e9 0.30 1e6"}

BED = """
units si
atom_style sphere
atom_modify map yes
newton off
comm_modify vel yes
boundary p p m
region box block 0 {period} 0 {period} -0.06 0.02 units box
create_box 1 box
lattice sc 0.011
region floor block 0 0.0329 0 0.0329 -0.001 0.001 units box
create_atoms 1 region floor
lattice sc 0.0113 origin 0.2 0.2 0.2
region grains block 0 0.0320 0 0.0320 -0.05 -0.013 units box
create_atoms 1 region grains
group floor region floor
reset_atoms id sort yes
set group all diameter 0.010 density 8500
neighbor 1e-3 bin
neigh_modify delay 0 every 1 check yes
pair_style gran/hysteretic 1e-3
pair_coeff * * {law} friction 0.4 loss time 2e-5
group grains subtract all floor
variable vx atom 0.05*sin(12.9898*id)
variable vy atom 0.05*sin(78.233*id+1)
velocity grains set v_vx v_vy 0 units box
fix weight grains gravity 9.81 vector 0 0 1
fix motion grains nve/sphere
timestep 5e-7
run 200000
fix drag grains viscous 0.5
fix twist grains viscous/sphere 1e-5
run 400000
unfix drag
unfix twist
compute now all gran/hysteretic/energy
compute sphere all gran/hysteretic/atom
compute largest all reduce max c_sphere[1]
compute bearing floor reduce sum fz
variable force atom sqrt(fx^2+fy^2+fz^2)
compute net grains reduce max v_force
thermo_style custom step c_now c_now[6] c_largest c_bearing c_net
thermo_modify norm no
run 0 post no
variable elastic equal $(c_now:%.17g)
variable springs equal $(c_now[6]:%.17g)
variable largest equal $(c_largest:%.17g)
variable bearing equal $(c_bearing:%.17g)
variable net equal $(c_net:%.17g)
write_restart bed.restart
"""
VALUES = ("elastic", "springs", "largest", "bearing", "net")


@dataclasses.dataclass(frozen=True)
class SettledBed:
    """A bed: law, folder of its restart file, and values of its last step."""

    law: str
    folder: Path
    values: dict[str, float]

    @property
    def file(self) -> Path:
        """The restart file."""
        return self.folder / "bed.restart"

    def case(self, **changes: Any) -> dict[str, Any]:
        """Case of an impact on the bed."""
        floor = 1 + np.flatnonzero(np.abs(read_restart(self.file).position[:, 2]) < 1e-6)
        strength = {"yield_strength": 1e6} if self.law == "elastoplastic" else {}
        return {
            "name": "bed",
            "material": SOFT | strength,
            "packing": {"kind": "restart", "file": str(self.file), "period": [PERIOD, PERIOD]},
            "contact": {"law": self.law, "friction": 0.4, "loss": {"time": 2e-5}},
            "hold": [{"index": floor.tolist()}],
            "boundary": {"bottom": "free", "sides": "periodic"},
            "precompression": {"kind": "gravity", "acceleration": GRAVITY},
            "load": {"velocity": 0.5},
            "run": {"end_time": 2e-4, "frames": 2},
        } | changes


@dataclasses.dataclass
class RecordedBar:
    """Progress bar that records its input: completed parts, and the note."""

    label: str
    looks: list[tuple[int, str]]

    def update(self, done: int, note: str, *, last: bool = False) -> None:
        """Record the shown text."""
        self.looks.append((done, note))

    def close(self) -> None:
        """Close nothing."""


@pytest.fixture(
    scope="module",
    params=["hertz", pytest.param("elastoplastic", marks=pytest.mark.validation)],
)
def bed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> SettledBed:
    folder = tmp_path_factory.mktemp(request.param)
    script = BED.format(period=PERIOD, law=LAWS[request.param])
    script = script.replace("bed.restart", f"{folder}/bed.restart")
    with open_engine(None, "none", folder) as engine:
        engine.commands(script)
        values = {name: float(engine.lammps.extract_variable(name)) for name in VALUES}
    return SettledBed(request.param, folder, values)


def test_forces_of_a_settled_bed_do_not_jump(bed: SettledBed, tmp_path: Path) -> None:
    run = gw.run(bed.case(), directory=tmp_path / "out", figures=False)
    spheres = read_restart(bed.file)
    weight = GRAVITY * float(spheres.mass[np.abs(spheres.position[:, 2]) > 1e-6].sum())
    assert bed.values["bearing"] == pytest.approx(weight, rel=0.02)  # it has settled
    lines = (tmp_path / "out" / "dumps" / "prestage.txt").read_text().splitlines()
    record = dict(zip(lines[0].lstrip("#").split(), map(float, lines[1].split()), strict=True))
    assert record["largest_force"] == pytest.approx(bed.values["largest"], abs=1e-6 * weight)
    net = record["residual"] * record["largest_force"]
    assert net == pytest.approx(bed.values["net"], abs=1e-3 * weight)
    both = bed.values["elastic"] + bed.values["springs"]
    assert record["stored"] == pytest.approx(both, rel=1e-9)
    assert bed.values["springs"] > 0
    assert run.summary["energy_balance_error"] < 1e-5
    with Result(tmp_path / "out") as result:
        forces = np.asarray(result.file["contacts/initial_force"])
    assert forces.max() == pytest.approx(bed.values["largest"], rel=1e-6)


@pytest.mark.parametrize("relaxation", ["damped", "minimiser"])
def test_rounded_beds_relax(
    bed: SettledBed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, relaxation: str
) -> None:
    """In a damped run the bed hardly moves, because friction supports it; without friction it
    rearranges.

    Both show their progress.
    """
    bars: list[RecordedBar] = []

    def made(total: int, label: str, *, enabled: bool) -> RecordedBar:
        assert enabled
        bars.append(RecordedBar(label, []))
        return bars[-1]

    monkeypatch.setattr(static_progress, "_LOOK_EVERY", 0.01)
    monkeypatch.setattr(static_progress, "Progress", made)
    spheres = read_restart(bed.file)
    rows = np.column_stack([spheres.position, 2 * spheres.radius]).tolist()
    lines = [",".join(f"{value:.6g}" for value in row) for row in rows]
    text = "\n".join(["x,y,z,diameter", *lines]) + "\n"
    packing = {"kind": "file", "grains": text, "period": [PERIOD, PERIOD]}
    packing |= {"contacts": "relax", "relaxation": relaxation}
    run = gw.run(bed.case(packing=packing), directory=tmp_path / "out", figures=False)
    lines = (tmp_path / "out" / "dumps" / "prestage.txt").read_text().splitlines()
    record = dict(zip(lines[0].lstrip("#").split(), map(float, lines[1].split()), strict=True))
    assert record["residual"] < 1e-6
    assert run.summary["energy_balance_error"] < 1e-5
    (bar,) = bars
    assert bar.label == "bed in out: static stage"
    shares = [share for share, _ in bar.looks]
    assert shares == sorted(shares)
    assert shares[-1] == 1000
    notes = "\n".join(note for _, note in bar.looks)
    net = ", net force \\S+ of it" if relaxation == "damped" else ""
    assert re.search(rf"^\d+ steps, largest force \S+ N{net}$", notes, re.MULTILINE)


def test_grains_that_roll_come_to_rest_soon(tmp_path: Path) -> None:
    """A grain rolls off the ridge of two held grains, and comes to rest between them and a wall.

    With the drag that damps the oscillations of contacts it took 41 000 steps.
    """
    places = [[0.02, 0.02, -0.005], [0.03, 0.02, -0.005], [0.025, 0.0201, -0.01366]]
    lines = [",".join(map(str, [*place, D])) for place in places]
    case = {
        "name": "ridge",
        "material": SOFT | {"youngs_modulus": 7e7, "density": 2500.0},
        "packing": {
            "kind": "file",
            "grains": "\n".join(["x,y,z,diameter", *lines]) + "\n",
            "contacts": "relax",
            "relaxation": "damped",
            "enclosure": {"x": [0, 0.05], "y": [0.0101, 0.0299], "bottom": 0.0},
        },
        "contact": {"law": "hertz", "friction": 0.3},
        "hold": [{"index": [1, 2]}],
        "boundary": {"sides": "wall", "bottom": "wall"},
        "precompression": {"kind": "gravity"},
        "load": {"velocity": 0.01},
        "run": {"end_time": 1e-4, "frames": 2},
    }
    gw.run(case, directory=tmp_path / "out", figures=False)
    lines = (tmp_path / "out" / "dumps" / "prestage.txt").read_text().splitlines()
    record = dict(zip(lines[0].lstrip("#").split(), map(float, lines[1].split()), strict=True))
    assert record["displacement"] == pytest.approx(0.005, rel=0.02)
    assert record["residual"] < 1e-6
    assert record["iterations"] < 25_000


CLUMP = """
units si
atom_style sphere
atom_modify map yes
newton off
comm_modify vel yes
boundary f f f
region box block -0.05 0.05 -0.05 0.05 -0.05 0.05
create_box 1 box
create_atoms 1 single 0 0 0
create_atoms 1 single 0.0096 0 0
create_atoms 1 single 0.03 0 0
create_atoms 1 single 0.03999 0 0
set group all diameter 0.010 density 8500
{numbers}
pair_style gran/hysteretic 1e-3
pair_coeff * * hertz 1e9 0.30
group clump id 1 2
neigh_modify exclude group clump clump
fix clump clump rigid/nve single
timestep 1e-6
run 1 post no
write_restart {file}
"""


def restart_of_clump(folder: Path, numbers: str) -> Path:
    """Write a restart file of a dimer with these commands for its number, and of a single grain."""
    file = folder / "clump.restart"
    with open_engine(None, "none", folder) as engine:
        engine.commands(CLUMP.format(numbers=numbers, file=file))
    return file


def case_of_clump(file: Path) -> dict[str, Any]:
    return {
        "name": "clump",
        "material": SOFT | {"density": 8500.0},
        "packing": {"kind": "restart", "file": str(file)},
        "contact": {"law": "hertz"},
        "boundary": {"bottom": "free"},
        "load": {"index": 3, "velocity": 1e-3},
        "run": {"end_time": 1e-4, "frames": 2},
    }


def test_a_restart_file_with_overlapping_spheres_without_numbers_is_refused(
    tmp_path: Path,
) -> None:
    file = restart_of_clump(tmp_path, "")
    fault = r"packing\.restart: found spheres 1 and 2, which overlap without a contact"
    with pytest.raises(InputError, match=fault):
        case_from_dict(case_of_clump(file), "clump")


def test_a_restart_file_with_clumps(tmp_path: Path) -> None:
    """Spheres with the same number continue as a rigid body, with their spin."""
    numbers = "fix numbers all property/atom mol ghost yes\nset atom 1*2 mol 1\n"
    numbers += "velocity all create 0.0 1\nset atom 1 vz 1.0\nset atom 2 vz 2.0"
    case = case_of_clump(restart_of_clump(tmp_path, numbers))
    gw.run(case, directory=tmp_path / "out", figures=False)
    with Result(tmp_path / "out") as result:
        first, last = (result.frame(k, "velocity") for k in (0, -1))
        moved = result.frame(-1, "displacement")[:2]
        place = result["spheres/position"][:2] + moved
    # the script has given two spheres without spin to a body, which keeps their angular momentum
    arm = 0.0048
    radius = 0.005
    half = 0.5 * arm**2 / (arm**2 + 0.4 * radius**2)
    velocity = 1.5 + np.array([-half, half])
    assert first[:2, 2] == pytest.approx(velocity, rel=1e-4)
    assert last[:2].mean(axis=0) == pytest.approx(first[:2].mean(axis=0), rel=1e-9)
    assert np.linalg.norm(place[1] - place[0]) == pytest.approx(0.0096, rel=1e-9)
    assert moved[:, 2] == pytest.approx(1e-4 * velocity, rel=1e-2)
    turning = [np.linalg.norm(velocity[1] - velocity[0]) for velocity in (first, last)]
    assert turning[1] == pytest.approx(turning[0], rel=1e-6)


def test_case_of_a_bed_is_read_again(bed: SettledBed) -> None:
    case = case_from_dict(bed.case(), "bed")
    assert (case.packing.kind, case.packing.contacts) == ("file", "keep")
    again = case_from_dict(tomllib.loads(case.to_toml()), "bed")
    assert again == case
    assert again.packing.restart == str(bed.file)


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        (
            {"contact": {"law": "hertz", "initial_overlap": 1e-6}},
            "packing.restart: found with contact.initial_overlap",
        ),
        ({"material": SOFT | {"density": 8000.0, "yield_strength": 1e6}}, "with a mass of"),
    ],
)
def test_faults_of_beds(bed: SettledBed, changes: dict[str, Any], fault: str) -> None:
    with pytest.raises(InputError, match=fault):
        case_from_dict(bed.case(**changes), "bed")


@pytest.mark.parametrize(("content", "fault"), [
    (b"something else", "found no LAMMPS restart file, expected a file written by write_restart"),
    (b"LammpS RestartT\0" + bytes(99),
     "found a LAMMPS restart file without its end; it is truncated"),
    (b"LAMMPS data file via write_data\n\n27 atoms\n1 atom types\n",
     "found a LAMMPS data file, which has no plastic indentations and springs; expected a restart "
     'file: add write_restart next to write_data, or use packing.kind = "file"'),
])  # fmt: skip
def test_files_that_are_no_restart(content: bytes, fault: str, tmp_path: Path) -> None:
    (tmp_path / "a.restart").write_bytes(content)
    packing = {"kind": "restart", "file": str(tmp_path / "a.restart")}
    with pytest.raises(InputError, match=re.escape(fault)):
        case_from_dict({"packing": packing, "material": "brass"})


@pytest.mark.parametrize(("key", "value", "fault"), [
    ("up", "z", 'packing.up: applies only to packing.kind = "file"; found "restart", whose bed is '
                'not'),
    ("units", "mm", 'packing.units: applies only to packing.kind = "file"; found "restart", whose '
                    'file'),
])  # fmt: skip
def test_a_restart_file_needs_no_keys_of_reading(key: str, value: str, fault: str) -> None:
    packing = {"kind": "restart", "file": "a.restart", key: value}
    with pytest.raises(InputError, match=re.escape(fault)):
        case_from_dict({"packing": packing, "material": "brass"})


def test_a_restart_needs_its_file() -> None:
    with pytest.raises(
        InputError, match=r"packing\.file: missing; packing\.kind = .restart. requires"
    ):
        case_from_dict({"packing": {"kind": "restart"}, "material": "brass"})
