"""Runs with a dashpot of specified restitution, for impacts on held bodies and on bodies of finite
mass.

A sphere that hits a mass M at rest rebounds with (m - e M)/(m + M) of its velocity, and with -e if
the other body is held.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from granwave.lammps_inputs import expected_peak_overlap
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import viscous_loss
from granwave.lammps_inputs.deck.commands import pair_coefficients
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.encounters import encounters
from granwave.workflows import run_case

MASS = 7850 * math.pi / 6 * 0.01**3
ASKED = 0.5
DASHPOT = {"dashpot": {"restitution": ASKED}}


def chain(size: int, loss: dict[str, Any], **tables: Any) -> Case:
    """Steel spheres of 10 mm, with an impact at 1 m/s on the first."""
    data = {
        "packing": {"kind": "chain", "size": size, "diameter": 0.01},
        "material": "steel",
        "contact": {"law": "hertz", "loss": loss},
        "load": {"velocity": 1.0},
        "run": {"end_time": 2e-4},
        "boundary": {"bottom": "free"},
    }
    return case_from_dict(data | tables, "case")


def left(case: Case, folder: Path) -> float:
    """Velocity of the impacted sphere at the end, m/s."""
    summary = run_case(case, folder, figures=False).summary
    assert summary["energy_balance_error"] < 3e-6
    return float(summary["impactor_velocity_m_s"])


def plate(mass: float, stiffness: float = 1.0) -> dict[str, Any]:
    return {"bottom": {"plate": {"mass": mass, "stiffness": stiffness}}}


@pytest.mark.parametrize(
    ("size", "tables", "expected"),
    [
        (2, {"boundary": {"bottom": "fixed"}}, -ASKED),
        (2, {"hold": [{"index": [2]}]}, -ASKED),
        (2, {"hold": [{"index": [2], "directions": "z"}]}, -ASKED),
        (2, {"hold": [{"index": [2], "directions": "xy"}]}, (1 - ASKED) / 2),
        (2, {"guide": [{"index": [2], "free": "z"}]}, (1 - ASKED) / 2),
        (2, {}, (1 - ASKED) / 2),
        (1, {"boundary": {"bottom": "wall"}}, -ASKED),
        (1, {"boundary": plate(1e6 * MASS)}, -ASKED),
        (1, {"boundary": plate(10 * MASS)}, (1 - 10 * ASKED) / 11),
        (1, {"boundary": plate(0.00411)}, (1 - ASKED) / 2),
        (1, {"boundary": plate(0.1 * MASS)}, (1 - 0.1 * ASKED) / 1.1),
        (1, {"boundary": plate(MASS, 1e11)}, -ASKED),
    ],
)
def test_velocity_after_a_collision(tmp_path, size, tables, expected) -> None:
    assert left(chain(size, DASHPOT, **tables), tmp_path / "run") == pytest.approx(
        expected, abs=1e-3
    )


def test_a_sphere_on_one_that_is_held_aside(tmp_path) -> None:
    """At 45 degrees in x and z, held along x: 1/m* = 1/m + cos^2/m. Held along x and z, y is free."""
    slope = 0.01 / math.sqrt(2)
    (tmp_path / "grains.csv").write_text(
        "x,y,z,diameter,vx,vy,vz\n0,0,0,0.01,0,0,0.01\n"
        f"{slope:.17g},0,{slope * (1 + 1e-9):.17g},0.01,0,0,0\n"
    )
    for directions, along in (("x", 0.5), ("z", 0.5), ("xyz", 0.0), ("y", 1.0)):
        data = {
            "packing": {"kind": "file", "file": str(tmp_path / "grains.csv")},
            "material": "steel",
            "contact": {"law": "hertz", "loss": DASHPOT},
            "load": {"kind": "grains"},
            "hold": [{"index": [2], "directions": directions}],
            "boundary": {"bottom": "free"},
            "run": {"end_time": 8e-4},
        }
        speed = 0.01 * (1 - (1 + ASKED) / 2 / (1 + along))  # J = (1 + e) m* v cos
        found = left(case_from_dict(data, "case"), tmp_path / directions)
        assert found == pytest.approx(speed, abs=2e-5), directions


@pytest.mark.validation
def test_ranks_and_a_resumed_run(granwave, tmp_path) -> None:
    words = [
        "run", "two-spheres", "--no-figures", "--set=packing.size=2", "--set=boundary.bottom=fixed",
        "--set=contact.law=hertz", "--set=contact.loss.dashpot.restitution=0.5", "--set=load.velocity=1.0",
        "--set=run.end_time=2e-4",
    ]  # fmt: skip
    found = []
    for ranks in (1, 2):
        folder = tmp_path / str(ranks)
        assert granwave(*words, "-o", folder, "--np", ranks).returncode == 0
        found.append(json.loads((folder / "summary.json").read_text())["impactor_velocity_m_s"])
    assert found[0] == found[1]
    assert found[0] == pytest.approx(-ASKED, abs=1e-3)


@pytest.mark.parametrize("mass", [MASS, 0.1 * MASS])
def test_loss_time_of_a_restitution_at_a_plate(tmp_path, mass) -> None:
    """The restitution at 1 m/s is specified for the sphere and the plate."""
    case = chain(1, {"restitution": ASKED, "velocity": 1.0}, boundary=plate(mass))
    ratio = mass / MASS
    expected = (1 - ratio * ASKED) / (1 + ratio)
    assert left(case, tmp_path / "run") == pytest.approx(expected, abs=1e-3)


def test_a_free_bar_counts_with_its_mass() -> None:
    """A short bar with the mass of a sphere: the factor of the pair, which treats the face of the
    bar as held.
    """
    bar = {"length": 0.01, "area": MASS / 7850 / 0.01, "elements": 4}
    assembly = assemble(chain(1, DASHPOT, bar=bar))
    kind, factor = viscous_loss(assembly, assembly.case.contact, assembly.material, None, flat=True)
    words = {tuple(line.split()[1:3]): line.split() for line in pair_coefficients(assembly)}
    assert kind == "dashpot"
    assert float(words["1", "3"][-1]) == pytest.approx(factor / math.sqrt(2), rel=1e-12)
    assert float(words["1", "1"][-1]) == pytest.approx(factor, rel=1e-12)
    long = assemble(chain(1, DASHPOT, bar=bar | {"length": 1.0, "elements": 100}))
    words = {tuple(line.split()[1:3]): line.split() for line in pair_coefficients(long)}
    assert float(words["1", "3"][-1]) == pytest.approx(factor / math.sqrt(1.01), rel=1e-12)


def test_largest_overlap_of_a_held_sphere(tmp_path) -> None:
    """The bound on overlaps follows from the total energy, and is reached without damping."""
    free = chain(2, {"time": 0.0})
    for name, tables in (
        ("fixed", {"boundary": {"bottom": "fixed"}}),
        ("hold", {"hold": [{"index": [2]}]}),
    ):
        case = chain(2, {"time": 0.0}, **tables)
        bound = expected_peak_overlap(case)
        assert bound == pytest.approx(2**0.4 * expected_peak_overlap(free), rel=1e-6)
        run = run_case(case, tmp_path / name, figures=False)
        force = run.summary["peak_force_N"]
        law = max(encounters(assemble(case)), key=lambda one: one.energy).law
        assert float(law.loading_force(bound)) == pytest.approx(force, rel=1e-3)
    guided = chain(2, {"time": 0.0}, guide=[{"free": "z"}])
    assert expected_peak_overlap(guided) == expected_peak_overlap(free)


def test_encounters_with_a_light_plate() -> None:
    """Twice the effective mass; a plate on a spring counts as a wall."""
    for mass, stiffness, expected in (
        (MASS, 1.0, MASS),
        (0.1 * MASS, 1.0, 2 * MASS / 11),
        (1e-3 * MASS, 1e13, 2 * MASS),
    ):
        case = chain(1, DASHPOT, boundary=plate(mass, stiffness))
        (at_plate,) = [one for one in encounters(assemble(case)) if one.against_wall]
        assert at_plate.mass == pytest.approx(expected, rel=1e-3)
    load = {"kind": "plate", "mass": MASS, "velocity": 1.0}
    case = chain(1, DASHPOT, load=load)
    (at_plate,) = [one for one in encounters(assemble(case)) if one.against_wall]
    assert at_plate.mass == pytest.approx(MASS, rel=1e-12)
