"""Runs of plane crystals, compared with an independent solver; spheres compared with their
positions.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.analysis.figures.run_figures import run_figures
from granwave.analysis.measures.lines import lines_of, sensor_accelerations, sensor_velocities
from granwave.analysis.measures.signals import first_peak
from granwave.analysis.notebook.run import Run as Notebook
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs import build_packing
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows.cli.main import main
from granwave.workflows.library import load_case
from granwave.workflows.run.driver import run_case
from tests.helpers.twins.plane_twin import Discs, crystal
from tests.helpers.twins.square_twin import Plane, Spheres

D = 0.0127
L = 0.0254
LINES = [{"name": "down"}, {"name": "all", "index": "all"}]
RECORDED = 400  # instants


def made(place: Path, end: float = 4e-4, **changes: Any) -> Path:
    """Run a small crystal."""
    tables: dict[str, Any] = {
        "packing": {
            "kind": "hexagonal", "size": [4, 5], "top_row": "short", "shape": "cylinder", "diameter": D, "length": L,
        },
        "material": {"name": "soft", "youngs_modulus": 70e6, "poisson_ratio": 0.48, "density": 1130},
        "contact": {"law": "line", "friction": 0.3, "loss": {"time": 12e-6}},
        "load": {"kind": "plate", "mass": 10 * L, "velocity": 6.0},
        "boundary": {"sides": "wall"},
        "line": LINES,
        "run": {"end_time": end, "frames": 2},
        "output": {"history": RECORDED, "contact_forces": True},
    }  # fmt: skip
    tables = {
        name: table | changes.get(name, {}) if isinstance(table, dict) else table
        for name, table in tables.items()
    }
    run_case(case_from_dict({"name": "crystal", **tables}), place, figures=False)
    return place


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made(tmp_path_factory.mktemp("plane") / "run")


def test_every_grain_moves_as_in_an_independent_solver(run: Path) -> None:
    twin = Discs(crystal("hexagonal", 4, 5, True), D / 2, 70e6, 0.48, 1130, 0.3, 12e-6, 10.0, 6.0)
    time, velocity = twin.run(4e-4)
    with Result(run) as result:
        own = result["lines/all/time"]
        ours = result["lines/all/velocity"]
    expected = np.stack(
        [[np.interp(own, time, v) for v in one.T] for one in velocity.transpose(1, 0, 2)]
    )
    assert (
        np.abs(ours[:, :, [0, 2]] - expected.transpose(2, 0, 1)).max() < 0.05
    )  # of 6 m/s; the solver is of first order in the loss
    assert np.abs(ours[:, :, 1]).max() == 0  # nothing leaves the plane


def test_energy_momentum_and_symmetry(run: Path) -> None:
    with Result(run) as result:
        energy = {
            name: result[f"energy/{name}"]
            for name in ("kinetic", "elastic", "dissipated", "input", "plate")
        }
        speed = result["walls/plate/velocity"]
        impulse = result["walls/plate/impulse"]
        sides = [result[f"walls/{name}/force"] for name in ("xlo", "xhi")]
        position = result["lines/all/position"]
        moved = result["lines/all/displacement"]
    total = energy["kinetic"] + energy["elastic"] + energy["dissipated"]
    assert np.abs(total - energy["input"]).max() < 2e-5 * energy["input"][-1]
    mass = 10 * L
    assert energy["input"][-1] == pytest.approx(0.5 * mass * 36) and energy["plate"][
        0
    ] == pytest.approx(0.5 * mass * 36)
    assert mass * (speed[-1] - speed[0]) == pytest.approx(impulse[-1], rel=1e-3)
    assert sides[0] == pytest.approx(sides[1], rel=1e-6, abs=1e-6) and sides[0].max() > 0
    order = np.lexsort((position[:, 0], position[:, 2].round(9)))
    mirror = np.lexsort((-position[:, 0], position[:, 2].round(9)))
    assert np.abs(moved[:, order, 0] + moved[:, mirror, 0]).max() < 1e-9 * D


def test_a_line_is_measured(run: Path) -> None:
    with Result(run) as result:
        down, every = lines_of(result)
        assert result.unit("lines/down/lateral_force") == "N"
        own = np.isin(result["lines/all/id"], result["lines/down/id"])
        # half the horizontal sum of any line in the plane, so that a grain has one value
        assert np.array_equal(every.lateral_force[own], down.lateral_force, equal_nan=True)
        assert np.nanmin(down.lateral_force) > 0
    assert down.straight and down.distance / D == pytest.approx([0, np.sqrt(3), 2 * np.sqrt(3)])
    assert np.all(np.diff(down.arrival) > 0) and 150 < (down.front_speed or 0) < 250


def test_contact_forces_of_snapshots_as_a_table(run: Path) -> None:
    opened = Notebook(run)
    table = opened.contact_forces
    last = table[table["time"] == table["time"].max()].set_index(["i", "j"])
    end = opened.contacts.set_index(["i", "j"]).loc[last.index]
    assert len(last) and np.array_equal(last["force"], end["force"])
    sliding = np.linalg.norm(last[["tx", "ty", "tz"]], axis=1)
    assert (
        np.allclose(sliding, end["tangential_force"], rtol=1e-9, atol=1e-12) and sliding.max() > 0
    )
    assert table.attrs["units"] == {"time": "s", "i": "1", "j": "1"} | dict.fromkeys(
        ["force", "tx", "ty", "tz"], "N"
    )


@pytest.mark.needs_extension("inference")
def test_inferred_forces_are_those_of_the_run(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The plate, rough side walls and the floor are walls of the measurement; cylinders have their
    own inertia.
    """
    assert main(["infer", str(run), "--no-figures", "--json", "-o", str(tmp_path / "infer")]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["n_contacts"] > 30 and found["true_force_error"] < 1e-11


def test_contacts_deeper_than_a_tenth_of_the_radius_are_counted(run: Path) -> None:
    with Result(run) as result:
        deep = result["contacts/peak_overlap"] > 0.05 * D / 2
        assert result.along_lines.all() and deep.any()
        assert np.array_equal(result.beyond_law(0.1), deep)


def test_pressed_sides_and_a_gap(tmp_path: Path) -> None:
    pressed = made(
        tmp_path / "pressed", 5e-5, boundary={"side_gap": -2e-5}, contact={"friction": 0.0}
    )
    with Result(pressed) as result:
        force = result["walls/xlo/force"]
        kinetic = result["energy/kinetic"]
        total = kinetic + result["energy/elastic"] + result["energy/dissipated"]
        assert force[0] > 1.0  # the walls press before the plate does
        assert np.abs(total - result["energy/input"]).max() < 1e-5 * result.energy_input
    with Result(made(tmp_path / "gap", 5e-5, boundary={"side_gap": 1e-3})) as result:
        assert result["walls/xlo/force"].max() == 0


@pytest.mark.parametrize("friction", [0.3, pytest.param(2.0, marks=pytest.mark.validation)])
def test_long_waves_slide_in_both_crystals(tmp_path: Path, friction: float) -> None:
    """Friction 0.3 lets contacts slide, 2 holds them. Contacts in BCC carry smaller forces, so that
    line contacts are softer.
    """
    fronts = []
    for kind, spacing, rows in (("centred-square", 2**0.5, 10), ("hexagonal", 1.0, 8)):
        packing = {"kind": kind, "size": [round(16 / spacing), rows]}
        load = {"mass": 40 * L}
        run = made(
            tmp_path / kind, 8e-4, packing=packing, load=load, contact={"friction": friction}
        )
        with Result(run) as result:
            down = lines_of(result)[0]
        fronts.append(np.polyfit(down.arrival[1:4], down.distance[1:4], 1)[0])
    # contacts lie 45 and 30 degrees off the way of the wave, and slide where friction is below the
    # ratio of stiffnesses (tangential over normal) times the tangent of that angle; rows approach
    # each other without moving sideways
    angle = np.radians([45.0, 30.0])
    tangential = np.minimum(2 * (1 - 0.48) / (2 - 0.48) * np.tan(angle), friction)
    speed = np.cos(angle) * np.sqrt(
        2 * np.cos(angle) * (np.cos(angle) + tangential * np.sin(angle))
    )
    assert 0.95 < fronts[0] / fronts[1] / (speed[0] / speed[1]) < 1.0


@pytest.mark.validation
@pytest.mark.parametrize(("name", "kind", "size", "speed"), [
    ("lateral-square", "centred-square", (6, 16), 120.0), ("lateral-hexagonal", "hexagonal", (8, 14), 204.0),
])  # fmt: skip
def test_front_speeds_of_both_crystals(
    tmp_path: Path, name: str, kind: str, size: tuple[int, int], speed: float
) -> None:
    """Results are within 1 % of an earlier program, and of the independent solver with either
    tangential spring.
    """
    case = load_case(name, {"run.end_time": 2.4e-3, "line": LINES[:1]})
    run_case(case, tmp_path / name, figures=False)
    with Result(tmp_path / name) as result:
        (down,) = lines_of(result)
    assert down.front_speed == pytest.approx(speed, rel=0.01)
    for constant in (False, True):
        twin = Discs(
            crystal(kind, *size, True),
            D / 2,
            70e6,
            0.48,
            1130,
            0.3,
            12e-6,
            20.0,
            6.0,
            constant_spring=constant,
        )
        time, velocity = twin.run(1.6e-3)
        middle = np.abs(twin.centres[:, 0] - twin.centres[:, 0].mean()) < 0.1
        speeds = np.linalg.norm(velocity[:, middle], axis=2)
        arrival = [time[np.argmax(one > 0.3)] for one in speeds.T]
        front = np.polyfit(arrival, down.distance, 1)[0]
        assert front == pytest.approx(down.front_speed, rel=0.005 if constant else 0.002)


def test_figures_show_what_dissipates(run: Path) -> None:
    """Friction and damping, no yielding with an elastic law; no wave speed for contacts without a
    sharp front.
    """
    with Result(run) as result:
        figures = {
            name: run_figures()[name].draw(result)
            for name in ("dissipation_parts_principal", "energies")
        }
        whole = result["spheres/dissipated_energy"] / result.energy_input
        assert not result.yield_energy.any()
    parts, energies = (figures[name].columns for name in figures)
    assert np.allclose(parts["friction_over_input"] + parts["viscous_over_input"], whole, rtol=1e-9)
    assert not any("yielding" in name for name in (*parts, *energies))
    assert json.loads((run / "summary.json").read_text())["wave_speed_m_s"] is None


E = 193e9
NU = 0.3
RHO = 8000.0
DELRIN = {"youngs_modulus": 3.1e9, "poisson_ratio": 0.35, "density": 1400.0}
NX = 4
NY = 4
BEAD = 0.01906
SCATTERED = {"diameter_scatter": 2e-5, "seed": 4}
IN_PLANE = [{"touches": [5, 9]}, {"touches": 17, "velocity": [0.29, 0.0, 0.0]}]
FROM_ABOVE = [{"touches": [6, 7, 10, 11]}, {"touches": 17, "velocity": [0.0, 0.0, 0.65]}]


@pytest.mark.parametrize(
    ("strikers", "packing"),
    [
        pytest.param(
            [IN_PLANE[0], IN_PLANE[1] | {"offset": [0.0, 1.5e-3, 0.0]}], {}, id="off centre"
        ),
        pytest.param(
            [IN_PLANE[0] | {"offset": [0.0, 5e-6, 0.0]}, IN_PLANE[1]],
            {},
            id="aside",
            marks=pytest.mark.validation,
        ),
        pytest.param(IN_PLANE, SCATTERED, id="gaps", marks=pytest.mark.validation),
        pytest.param(FROM_ABOVE, SCATTERED | {"tilt": [1, 1]}, id="leaning"),
    ],
)
def test_as_the_independent_solver(
    strikers: list[dict[str, Any]], packing: dict[str, Any], tmp_path: Path
) -> None:
    case = case_from_dict(
        {
            "name": "square",
            "material": {"youngs_modulus": E, "poisson_ratio": NU, "density": RHO},
            "packing": {"kind": "square", "size": [NX, NY], "diameter": BEAD} | packing,
            "contact": {"law": "hertz"},
            "boundary": {"bottom": {"material": DELRIN}, "sides": {"material": DELRIN}},
            "striker": strikers,
            "sensor": [{"name": "A", "id": 6}, {"name": "B", "id": 10}, {"name": "C", "id": 15}],
            "run": {"end_time": 2e-4, "frames": 2},
        }
    )
    run_case(case, tmp_path / "run", figures=False)
    built = build_packing(case)
    with Result(tmp_path / "run") as result:
        time = result["probes/time"]
        ours = [
            np.stack(list(one(result).values()))
            for one in (sensor_velocities, sensor_accelerations)
        ]
        (early, first), (late, second) = (
            first_peak(time, sensor_accelerations(result)[name][:, 0], floor=0.5) for name in "AB"
        )
    modulus = E / (1 - NU**2)
    soft = DELRIN["youngs_modulus"] / (1 - DELRIN["poisson_ratio"] ** 2)
    low = -BEAD / 2
    high = (np.array([NX, NY]) - 0.5) * BEAD
    planes = [
        Plane(axis, edge, side, soft, NX * NY)
        for axis in (0, 1)
        for edge, side in ((low, 1), (high[axis], -1))
    ]
    velocity = np.zeros((NX * NY + 2, 3))
    velocity[-1] = strikers[1]["velocity"]
    twin = Spheres(built.positions, built.atoms.get_array("diameters") / 2, velocity, RHO, modulus,
                   (*planes, Plane(2, BEAD / 2, -1, soft, NX * NY)))  # fmt: skip
    times = time[:: max(1, len(time) // 120)]
    rows = [sensor.id - 1 for sensor in case.sensor]
    for found, expected in zip(ours, twin.run(times), strict=True):
        theirs = np.moveaxis(expected[:, rows], 0, 1)
        largest = np.abs(theirs).max()
        assert largest > 0
        np.testing.assert_allclose(
            found[:, :: max(1, len(time) // 120)], theirs, atol=2e-3 * largest
        )
    if "offset" in strikers[1]:  # it pushes the one at rest to the other side, on which A is
        assert first > 1.1 * second and early < late
    if "offset" in strikers[0]:  # B is on the side that is touched
        assert first < 0.9 * second and early > late
