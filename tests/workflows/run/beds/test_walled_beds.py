"""Impacts on beds of two materials between walls, settled by a LAMMPS script with friction."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import granwave as gw
from granwave.lammps_inputs.errors import InputError, RunError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.restart_file import RestartSpheres, read_restart
from granwave.workflows.run.lammps_engine import open_engine

pytestmark = pytest.mark.xdist_group("walled beds")  # its fixtures are made once

GRAVITY = 9.81
WIDTH = 0.033
D = 0.010
SOFT = {"youngs_modulus": 1e9, "poisson_ratio": 0.3, "density": 8500.0}
SOFTER = {"youngs_modulus": 5e8, "poisson_ratio": 0.3, "density": 4000.0}
CONTACT = {"law": "hertz", "friction": 0.4, "loss": {"time": 2e-5}}
CONTACT_WORDS = "friction 0.4 loss time 2e-5"

# the sides are one fix for all types, the floor is one for each
BED = f"""
units si
atom_style sphere
atom_modify map yes
newton off
comm_modify vel yes
boundary f f f
region box block -0.01 {WIDTH + 0.01} -0.01 {WIDTH + 0.01} -0.1 0.02 units box
create_box 2 box
lattice sc 0.0108 origin 0.55 0.55 0.45
region grains block 0 {WIDTH} 0 {WIDTH} -0.035 -0.003 units box
create_atoms 1 region grains
reset_atoms id sort yes
variable odd atom id%2
group odd variable odd
set group odd type 2
set type 1 diameter {D} density 8500
set type 2 diameter 0.0096 density 4000
group hard type 1
group softer type 2
neighbor 1e-3 bin
neigh_modify delay 0 every 1 check yes
pair_style gran/hysteretic 1e-3
pair_coeff 1 1 hertz 1e9 0.30 {CONTACT_WORDS}
pair_coeff 2 2 hertz 5e8 0.30 {CONTACT_WORDS}
pair_coeff 1 2 hertz 1e9 0.30 5e8 0.30 {CONTACT_WORDS}
fix ground hard wall/gran/hysteretic zplane NULL 0.0 hertz 1e9 0.30 {CONTACT_WORDS}
fix below softer wall/gran/hysteretic zplane NULL 0.0 hertz 5e8 0.30 {CONTACT_WORDS}
fix x1 hard wall/gran/hysteretic xplane 0.0 {WIDTH} hertz 1e9 0.30 {CONTACT_WORDS}
fix x2 softer wall/gran/hysteretic xplane 0.0 {WIDTH} hertz 5e8 0.30 {CONTACT_WORDS}
fix y1 hard wall/gran/hysteretic yplane 0.0 {WIDTH} hertz 1e9 0.30 {CONTACT_WORDS}
fix y2 softer wall/gran/hysteretic yplane 0.0 {WIDTH} hertz 5e8 0.30 {CONTACT_WORDS}
variable vx atom 0.1*sin(12.9898*id)
variable vy atom 0.1*sin(78.233*id+1)
velocity all set v_vx v_vy 0 units box
fix weight all gravity {GRAVITY} vector 0 0 1
fix motion all nve/sphere
timestep 1e-6
run 100000
fix drag all viscous 0.3
fix twist all viscous/sphere 1e-5
run 250000
unfix drag
unfix twist
compute now all gran/hysteretic/energy
compute sphere all gran/hysteretic/atom
compute largest all reduce max c_sphere[1] f_ground[2] f_below[2] &
    f_x1[2] f_x2[2] f_y1[2] f_y2[2]
variable force atom sqrt(fx^2+fy^2+fz^2)
compute net all reduce max v_force
thermo_style custom step c_now c_now[6] c_largest[1] c_net f_ground[8] f_x1[8] f_ground
thermo_modify norm no
run 0 post no
variable springs equal $(c_now[6]:%.17g)
variable walls equal $(f_ground[8]+f_below[8]+f_x1[8]+f_x2[8]+f_y1[8]+f_y2[8]:%.17g)
variable normal equal $(c_now+f_ground+f_below+f_x1+f_x2+f_y1+f_y2:%.17g)
variable largest equal $(max(c_largest):%.17g)
variable net equal $(c_net:%.17g)
write_restart FOLDER/bed.restart
"""
VALUES = ("springs", "walls", "normal", "largest", "net")


@dataclasses.dataclass(frozen=True)
class WalledBed:
    """A bed: its restart file, and values of its last step."""

    file: Path
    values: dict[str, float]
    spheres: RestartSpheres

    @property
    def weight(self) -> float:
        """Weight of all grains, N."""
        return GRAVITY * float(self.spheres.mass.sum())

    def case(self, **changes: Any) -> dict[str, Any]:
        """Case of a steel sphere that hits the bed."""
        top = 1 + int(np.argmin(self.spheres.position[:, 2] - self.spheres.radius))
        striker = {"diameter": 0.006, "material": "steel", "touches": [top], "velocity": [0, 0, 1]}
        return {
            "name": "walled",
            "material": {"name": "soft", **SOFT},
            "materials": {"softer": SOFTER},
            "packing": {
                "kind": "restart",
                "file": str(self.file),
                "types": {"1": "soft", "2": "softer"},
                "enclosure": {"x": [0.0, WIDTH], "y": [0.0, WIDTH], "bottom": 0.0},
            },
            "contact": CONTACT,
            "boundary": {"bottom": "wall", "sides": "wall"},
            "precompression": {"kind": "gravity", "acceleration": GRAVITY},
            "striker": [striker],
            "load": {"kind": "striker"},
            "run": {"end_time": 1e-4, "frames": 2},
        } | changes


@pytest.fixture(scope="module")
def bed(tmp_path_factory: pytest.TempPathFactory) -> WalledBed:
    folder = tmp_path_factory.mktemp("walled")
    with open_engine(None, "none", folder) as engine:
        engine.commands(BED.replace("FOLDER", str(folder)))
        values = {name: float(engine.lammps.extract_variable(name)) for name in VALUES}
    file = folder / "bed.restart"
    return WalledBed(file, values, read_restart(file))


def test_struck_bed_between_walls_does_not_jump(bed: WalledBed, tmp_path: Path) -> None:
    run = gw.run(bed.case(), directory=tmp_path / "out", figures=False)
    lines = (tmp_path / "out" / "dumps" / "prestage.txt").read_text().splitlines()
    record = dict(zip(lines[0].lstrip("#").split(), map(float, lines[1].split()), strict=True))
    assert bed.values["net"] < 1e-3 * bed.weight
    net = record["residual"] * record["largest_force"]
    assert net == pytest.approx(bed.values["net"], abs=1e-6 * bed.weight)
    assert net < 1e-3 * bed.weight
    assert record["largest_force"] == pytest.approx(bed.values["largest"], rel=1e-6)
    assert bed.values["springs"] > 0
    assert bed.values["walls"] > 0
    stored = sum(bed.values[name] for name in ("springs", "walls", "normal"))
    assert record["stored"] == pytest.approx(stored, rel=1e-9)
    assert run.summary["energy_balance_error"] < 1e-5


def test_case_of_a_walled_bed_is_read_again(bed: WalledBed) -> None:
    case = case_from_dict(bed.case(), "walled")
    assert sorted(set(case.packing.grains.material)) == ["soft", "softer"]
    assert case_from_dict(case.to_dict(), "walled") == case


PLACES = {"x": [0.0, WIDTH], "y": [0.0, WIDTH], "bottom": 0.0}


@pytest.mark.parametrize(
    ("keys", "fault"),
    [
        ({"enclosure": PLACES | {"bottom": 1e-5}}, "at the wall of fix ground, such as sphere"),
        (
            {"enclosure": PLACES | {"x": [-1e-4, WIDTH]}},
            "expected a wall of the case there; define it",
        ),
        ({"types": {"1": "soft"}}, r"packing\.types: found no material of the type 2"),
        ({"types": None}, r"packing\.types: found no material of the type 1"),
        ({"types": {"1": "soft", "2": "soft"}}, r"material\.density: found sphere \d+ with a mass"),
        ({"types": {"1": "soft", "2": "softer", "3": "soft"}}, "found no type 3"),
        ({"contacts": "relax"}, r"packing\.contacts: found .relax.; remove it"),
    ],
)
def test_faults_of_walled_beds(bed: WalledBed, keys: dict[str, Any], fault: str) -> None:
    tables = bed.case()
    packing = tables["packing"] | keys
    tables["packing"] = {name: value for name, value in packing.items() if value is not None}
    with pytest.raises(InputError, match=fault):
        case_from_dict(tables, "walled")


def test_walls_that_the_case_lacks_are_named(bed: WalledBed) -> None:
    boundary = {"bottom": "free", "sides": "wall"}
    with pytest.raises(InputError, match="at the wall of fix ground"):
        case_from_dict(bed.case(boundary=boundary), "walled")


def one_sphere(folder: Path, contacts: str) -> dict[str, Any]:
    """Tables of a case with the restart file of one sphere and these contacts."""
    script = f"""
    units si
    atom_style sphere
    atom_modify map yes
    newton off
    comm_modify vel yes
    boundary f f f
    region box block -1 1 -1 1 -1 1 units box
    create_box 1 box
    create_atoms 1 single 0 0 -0.004999 units box
    set group all diameter {D} density 8500
    {contacts}
    fix motion all nve/sphere
    timestep 1e-7
    run 1
    write_restart {folder}/one.restart
    """
    with open_engine(None, "none", folder) as engine:
        engine.commands(script)
    return {
        "material": SOFT | {"name": "soft"},
        "packing": {"kind": "restart", "file": str(folder / "one.restart")},
        "contact": {"law": "hertz"},
        "precompression": {"kind": "gravity"},
        "load": {"index": [1]},
    }


def test_walls_of_other_styles_are_named(tmp_path: Path) -> None:
    contacts = """
    pair_style gran/hysteretic 1e-3
    pair_coeff * * hertz 1e9 0.30
    fix slope all wall/gran hertz/history 1e6 NULL 10 NULL 0.5 1 zplane NULL 0.0
    """
    tables = one_sphere(tmp_path, contacts)
    with pytest.raises(InputError, match=r"found fix slope of style wall/gran, expected walls"):
        case_from_dict(tables, "one")


def test_a_bed_of_another_pair_style_is_to_be_read_as_grains(tmp_path: Path) -> None:
    """The file does not contain the walls either: there is one message, about the pair style."""
    contacts = """
    pair_style granular
    pair_coeff * * hertz/material 1e9 0.5 0.3 tangential mindlin NULL 0.5 0.4
    fix ground all wall/gran granular hertz/material 1e9 0.5 0.3 &
        tangential mindlin NULL 0.5 0.4 zplane NULL 0.0
    """
    tables = one_sphere(tmp_path, contacts)
    tables["packing"]["enclosure"] = {"bottom": 0.1}
    with pytest.raises(InputError, match="lmp -restart2data") as error:
        case_from_dict(tables, "granular")
    assert "which it does not touch in the file" not in str(error.value)


def test_a_law_with_other_history_is_an_error(bed: WalledBed, tmp_path: Path) -> None:
    contact = CONTACT | {"rolling": {"coefficient": 0.01}}
    with pytest.raises(RunError, match="the contact has another law, friction, loss or resistance"):
        gw.run(bed.case(contact=contact), directory=tmp_path / "out", figures=False)
