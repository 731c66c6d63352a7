"""Runs with viscous damping, friction of the guide, a prescribed displacement."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import granwave as gw
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs import auto_timestep, write_deck
from granwave.lammps_inputs.contact.law import dashpot_factor
from granwave.lammps_inputs.deck.commands import pair_coefficients, wall_commands
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows import load_case, run_case
from granwave.workflows.run.checks import Balance

PACKING = {
    "packing.size": [6, 6, 4],
    "packing.kind": "fcc",
    "contact.loss": {"restitution": 0.45, "velocity": 2.0},
    "contact.friction": 0.2,
    "run.end_time": 1e-4,
    "run.frames": 3,
}


@pytest.mark.parametrize(
    ("name", "law", "loss", "restitution"),
    [
        ("sphere-on-wall", "hertz", {"dashpot": {"restitution": 0.9}}, 0.9),
        ("two-spheres", "elastoplastic", {"restitution": 0.5, "velocity": 1.0}, 0.5),
    ],
)
def test_restitution_is_that_asked_for(
    tmp_path: Path, name: str, law: str, loss: dict, restitution: float
) -> None:
    case = load_case(
        name, {"contact.law": law, "contact.loss": loss, "load.velocity": 1.0, "run.end_time": 1e-4}
    )
    summary = run_case(case, tmp_path / "run", figures=False).summary
    assert summary["restitution"] == pytest.approx(restitution, abs=1e-3)
    assert summary["energy_balance_error"] < 1e-5
    lost = (1 - restitution**2) * (0.5 if name == "two-spheres" else 1.0)
    assert summary["dissipated_fraction"] == pytest.approx(lost, abs=2e-3)
    assert (summary["viscous_fraction"] == pytest.approx(summary["dissipated_fraction"])) == (
        law == "hertz"
    )


@pytest.mark.parametrize("restitution", [0.05, 0.5, 0.97, 1.0])
def test_dashpot_of_a_restitution(restitution: float) -> None:
    """The factor is accurate to 1e-6, and near Antypov and Elliott's closed form, which allows
    tension.
    """
    factor = dashpot_factor(restitution)
    closed = -np.sqrt(5) * np.log(restitution) / np.hypot(np.log(restitution), np.pi)
    assert factor == pytest.approx(closed, rel=0.05 if restitution > 0.9 else 10)
    assert factor >= closed


@pytest.fixture(scope="module")
def directory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("losses") / "run"
    run_case(load_case("fcc-small", PACKING), folder, figures=False)
    return folder


def test_the_ledger_is_the_sum_of_contacts_and_walls(directory: Path) -> None:
    with Result(directory) as result:
        viscous = result["energy/viscous"][-1]
        dissipated = result["energy/dissipated"][-1]
        contacts = result["contacts/viscous_energy"].sum()
        planes = result["wall_contacts/viscous_energy"].sum()
        assert contacts + planes == pytest.approx(viscous, rel=1e-9)
        assert min(contacts, planes) > 0 and np.all(
            np.diff(result["energy/viscous"]) > -1e-9 * viscous
        )
        assert result["spheres/viscous_energy"].sum() == pytest.approx(viscous, rel=1e-9)
        assert result["spheres/dissipated_energy"].sum() == pytest.approx(dissipated, rel=1e-9)
        parts = result.yield_ledger[-1] + viscous + result["energy/friction"][-1]
        assert parts == pytest.approx(dissipated, rel=1e-9)
        assert result.yield_energy.sum() == pytest.approx(result.yield_ledger[-1], rel=1e-6)
        assert result.frame(result.n_frames - 1, "viscous_energy").sum() == pytest.approx(
            contacts, rel=1e-6
        )
        total = result["energy/kinetic"] + result["energy/elastic"] + result["energy/dissipated"]
        assert np.abs(total / result["energy/input"] - 1).max() < 1e-5


def test_damping_along_the_surface_is_in_every_account(tmp_path: Path) -> None:
    """Energies of contacts, walls, spheres and snapshots; the viscous dissipation is larger than
    without damping.
    """
    small = {"packing.size": [4, 4, 2], "run.end_time": 3e-5, "contact.law": "hertz"}
    lost = []
    for name, ratio in (("plain", 0.0), ("damped", 1.0)):
        loss = {"contact.loss": {"dashpot": 0.3, "tangential": ratio}}
        case = load_case("fcc-small", PACKING | small | loss)
        run = run_case(case, tmp_path / name, figures=False)
        lost.append(run.summary["energy_dissipated_viscous_J"])
        assert run.summary["energy_balance_error"] < 1e-5
    assert lost[1] > 1.02 * lost[0]
    words = (tmp_path / "damped" / "in.granwave").read_text()
    assert words.count("loss dashpot 0.3 loss_tangential 1") == 2  # of spheres and of the bottom
    assert "loss_tangential" not in (tmp_path / "plain" / "in.granwave").read_text()
    with Result(tmp_path / "damped") as result:
        contacts = result["contacts/viscous_energy"].sum()
        planes = result["wall_contacts/viscous_energy"].sum()
        assert contacts + planes == pytest.approx(lost[1], rel=1e-9)
        assert result["spheres/viscous_energy"].sum() == pytest.approx(lost[1], rel=1e-9)
        last = result.frame(result.n_frames - 1, "viscous_energy").sum()
        assert last == pytest.approx(contacts, rel=1e-6)


def test_walls_and_pairs_without_friction_are_not_damped_along_them(tmp_path: Path) -> None:
    data = {
        "packing": {"kind": "chain", "size": 4, "diameter": 0.01},
        "material": "steel",
        "contact": {"law": "hertz", "friction": 0.2, "loss": {"time": 1e-6, "tangential": 0.5}},
        "boundary": {"friction": 0.0},
        "replace": [{"index": 2, "material": "brass"}],
        "pair": [{"materials": ["steel", "brass"], "friction": 0.0}],
    }
    write_deck(case_from_dict(data, "case"), tmp_path)
    script = (tmp_path / "in.granwave").read_text().splitlines()
    words = {tuple(line.split()[1:3]): line for line in script if line.startswith("pair_coeff")}
    assert words["1", "1"].endswith("friction 0.2 loss time 1e-06 loss_tangential 0.5")
    assert words["1", "2"].endswith("loss time 1e-06")
    (bottom,) = (line for line in script if "wall/gran/hysteretic" in line)
    assert bottom.endswith("loss time 1e-06")


def test_a_pair_has_its_own_loss(tmp_path: Path) -> None:
    """A pair keeps the loss of [contact] if it changes only other keys; a loss of 0 means no
    loss.
    """
    data = {
        "packing": {"kind": "chain", "size": 4, "diameter": 0.01},
        "material": "steel",
        "contact": {"law": "hertz", "loss": {"time": 1e-6}},
        "replace": [{"index": 2, "material": "brass"}, {"index": 3, "material": "aluminium"}],
        "pair": [
            {"materials": ["steel", "brass"], "loss": {"dashpot": 0.2}},
            {"materials": ["brass", "aluminium"], "law": "elastoplastic"},
            {"materials": ["steel", "rigid"], "loss": {"time": 0}},
        ],
    }
    write_deck(case_from_dict(data, "case"), tmp_path)
    script = (tmp_path / "in.granwave").read_text().splitlines()
    words = {tuple(line.split()[1:3]): line for line in script if line.startswith("pair_coeff")}
    assert words["1", "1"].endswith("loss time 1e-06") and words["1", "2"].endswith(
        "loss dashpot 0.2"
    )
    assert "elastoplastic" in words["2", "3"] and words["2", "3"].endswith("loss time 1e-06")
    assert not any("loss" in line for line in script if line.startswith("fix             bottom"))
    assert not any("vel yes" in line for line in script)  # the pair style sends them


def test_what_yielding_leaves_cannot_be_more() -> None:
    wanted = {"contact.loss": {"restitution": 0.95, "velocity": 5.0}}
    with pytest.raises(
        InputError, match=r"contact\.loss: .*at most 0\.5\d+, the restitution of law elastoplastic"
    ):
        load_case("two-spheres", wanted)


@pytest.mark.validation
def test_ranks_and_resumed_runs_are_alike(granwave, directory: Path, tmp_path: Path) -> None:
    """Two ranks are bitwise identical to one, and an interrupted run to an uninterrupted run."""
    words = [f"--set={key}={value}" for key, value in {
        "packing.size": "[6,6,4]", "contact.loss": "{restitution=0.45,velocity=2.0}", "contact.friction": 0.2,
        "run.end_time": 1e-4, "run.frames": 3,
    }.items()]  # fmt: skip
    assert (
        granwave(
            "run", "fcc-small", *words, "-o", tmp_path / "two", "--np", 2, "--no-figures"
        ).returncode
        == 0
    )
    with Result(directory) as one, Result(tmp_path / "two") as two:
        for name in (
            "contacts/viscous_energy",
            "contacts/peak_force",
            "wall_contacts/viscous_energy",
        ):
            assert np.array_equal(one[name], two[name])
        assert np.array_equal(one.frame(2, "displacement"), two.frame(2, "displacement"))


def test_a_chain_knows_its_loss(tmp_path: Path) -> None:
    """Relaxation time for which two beads have the specified restitution."""
    changes = {
        "packing.size": 2,
        "run.end_time": 1e-5,
        "output.history": 0,
        "contact.loss": {"restitution": 0.9, "velocity": 1.0},
    }
    chain = gw.measures.Chain(
        gw.run("elastic-impact", changes, directory=tmp_path / "run", progress=False)
    )
    kind, time = chain.loss
    assert kind == "time"
    assert chain.law.collide(chain.mass / 2, 1.0, loss_time=time)["restitution"] == pytest.approx(
        0.9, abs=1e-5
    )


N = 8
MU = 40.0
G = 9.81
SPEED = 0.3
END = 4e-4
DIAMETER = 0.01
MODULUS = 209e9
RATIO = 0.28
DENSITY = 7925.0
CASE = {
    "packing.size": N,
    "packing.diameter": DIAMETER,
    "load.velocity": SPEED,
    "boundary.bottom": "free",
    "boundary.holder_friction": MU,
    "run.end_time": END,
    "run.timestep": "auto",
    "run.energy_tolerance": 1e-7,
    "output.history": 200,
}
FASTEST_AT_REST = 1e-6  # m/s, below which friction fades here, and only here


def independent(times: np.ndarray) -> np.ndarray:
    """Velocities (n_times, N) of a Hertzian chain with friction mu m g tanh(v/v0) on every bead."""
    mass = DENSITY * np.pi / 6 * DIAMETER**3
    stiffness = np.sqrt(DIAMETER) * MODULUS / (3 * (1 - RATIO**2))

    def change(_: float, state: np.ndarray) -> np.ndarray:
        place, velocity = state.reshape(2, N)
        force = stiffness * np.maximum(place[:-1] - place[1:], 0) ** 1.5
        rubbing = MU * mass * G * np.tanh(velocity / FASTEST_AT_REST)
        net = -rubbing
        net[:-1] -= force
        net[1:] += force
        return np.concatenate([velocity, net / mass])

    start = np.zeros(2 * N)
    start[N] = SPEED
    found = solve_ivp(change, (0, times[-1]), start, "LSODA", times, rtol=1e-8, atol=1e-13)
    assert found.success
    return found.y[N:].T


@pytest.fixture(scope="module")
def held(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("holder") / "run"
    run_case(load_case("homogeneous-chain", CASE), folder, figures=False)
    return folder


def test_motion_is_that_of_an_independent_chain(held: Path) -> None:
    """Velocities agree within 1e-4 of the impact speed, while friction dissipates a large part of
    the energy and beads come to rest.
    """
    with Result(held) as result:
        times = result["chain/time"]
        ours = result["chain/velocity"]
    assert 0 < np.count_nonzero(ours[-1] == 0) < N
    assert np.abs(ours - independent(times)).max() < 1e-4 * SPEED


def test_the_ledger_has_what_the_holder_took(held: Path) -> None:
    """The friction of the guide has its own column and fraction, equal to friction times weight
    times path; nothing yields.
    """
    summary = json.loads((held / "summary.json").read_text())
    with Result(held) as result:
        time = result["chain/time"]
        velocity = result["chain/velocity"]
        work = (
            MU
            * result["spheres/mass"].sum()
            / N
            * G
            * np.trapezoid(np.abs(velocity), time, axis=0).sum()
        )
        holder = result["energy/holder"][-1]
        dissipated = result["energy/dissipated"][-1]
        assert np.all(result.yield_ledger == 0)
    assert holder == pytest.approx(work, rel=2e-3)
    assert dissipated == pytest.approx(holder, rel=1e-12)
    assert 0.2 < summary["holder_fraction"] < 0.9
    assert summary["holder_fraction"] == pytest.approx(summary["dissipated_fraction"], rel=1e-12)
    assert summary["energy_dissipated_plastic_J"] == 0 and summary["energy_balance_error"] < 1e-6


def test_a_smooth_holder_is_none(tmp_path: Path) -> None:
    smooth = CASE | {"boundary.holder_friction": 0.0, "run.end_time": 5e-5}
    summary = run_case(
        load_case("homogeneous-chain", smooth), tmp_path / "run", figures=False
    ).summary
    assert summary["holder_fraction"] is None and summary["energy_dissipated_holder_J"] is None
    assert "gran/holder" not in (tmp_path / "run" / "in.granwave").read_text()


PUSH = [[0, 0], [1e-6, 1e-5], [1e-3, 1e-5]]  # 10 m/s for 1 us, then held


def case_of(table: list[list[float]], **changes: Any) -> dict[str, Any]:
    return {
        "material": "brass",
        "packing": {"kind": "chain", "size": 5, "diameter": 0.01},
        "load": {"kind": "displacement", "shape": "table", "table": table},
        "run": {"end_time": 1e-5},
    } | changes


def test_a_displacement_that_stops_has_one_balance(tmp_path: Path) -> None:
    """The grain returns 0.22 J when it stops, of which the packing keeps 4e-4 J: errors are
    relative to the latter.
    """
    outcome = run_case(case_from_dict(case_of(PUSH)), tmp_path / "run", figures=False)
    summary = outcome.summary
    assert summary["energy_input_J"] == pytest.approx(4.2e-4, rel=0.02)
    record = json.loads((tmp_path / "run/run.json").read_text())
    assert summary["energy_balance_error"] <= 1e-5 and outcome.state == "finished"
    assert [try_["energy_balance_error"] > 1e-5 for try_ in record["attempts"]] == [True] * len(
        record["attempts"]
    )
    grain = 8500 * 3.141592653589793 / 6 * 0.01**3
    seen = Balance(tmp_path / "run/dumps/energy.txt", moved=grain).read()
    assert seen.error == pytest.approx(summary["energy_balance_error"], rel=1e-9)


@pytest.mark.parametrize("law", ["elastoplastic", "hertz"])
@pytest.mark.parametrize("table", [[[0, 1e-6], [1e-4, 1e-6]], [[1e-5, 1e-6], [1e-4, 2e-6]]])
def test_a_displacement_begins_at_zero(table: list[list[float]], law: str) -> None:
    with pytest.raises(
        InputError, match=r"load\.table: found 1e-06 m at the start, expected 0: .* subtract 1e-06"
    ):
        case_from_dict(case_of(table, contact={"law": law}))


SPIN = {
    "packing.size": [6, 6, 4],
    "contact.friction": 0.2,
    "contact.rolling": {"coefficient": 0.05, "damping": 0.5},
    "contact.twisting": "marshall",
    "load.spin": [300.0, 0.0, 600.0],
    "run.end_time": 1e-4,
    "run.frames": 3,
}


def test_the_ledger_has_columns_of_rolling_and_twisting(tmp_path: Path) -> None:
    found = run_case(load_case("fcc-small", SPIN), tmp_path / "run", figures=False).summary
    assert found["energy_balance_error"] < 1e-5
    with Result(tmp_path / "run") as result:
        lost = {name: result[f"energy/{name}"] for name in ("friction", "rolling", "twisting")}
        whole = sum(values[-1] for values in lost.values())
        contacts = result["contacts/friction_energy"].sum()
        walls = result["wall_contacts/friction_energy"].sum()
        assert contacts + walls == pytest.approx(whole, rel=1e-9)
        assert result["spheres/friction_energy"].sum() == pytest.approx(whole, rel=1e-9)
        assert result.yield_energy.sum() == pytest.approx(result.yield_ledger[-1], rel=1e-6)
        for name in ("rolling", "twisting"):
            assert np.all(np.diff(lost[name]) > -1e-9 * lost[name][-1]) and lost[name][-1] > 0
            assert np.all(result[f"energy/elastic_{name}"] >= 0)
            assert found[f"{name}_fraction"] == pytest.approx(lost[name][-1] / result.energy_input)
            assert found[f"energy_dissipated_{name}_J"] == lost[name][-1]


SDS = {"coefficient": 2e-5, "stiffness": 4.0, "damping": 1e-5}
PARTIAL = {"friction": 0.2, "tangential": "partial_slip"}


@pytest.mark.parametrize(
    ("changes", "has", "has_not"),
    [
        ({"friction": 0.3}, "friction 0.3", "rolling twisting tangential cohesion"),
        (
            {"friction": 0.3, "rolling": 0.02, "twisting": SDS},
            "rolling sds mindlin 0 0.02 twisting sds 4 1e-05 2e-05",
            "",
        ),
        ({"friction": 0.3, "rolling": 0.0, "twisting": "marshall"}, "twisting marshall", "rolling"),
        (
            {"rolling": {"coefficient": 0.05, "damping": 0.5}},
            "rolling sds mindlin 0.5 0.05",
            "twisting",
        ),
        (PARTIAL, "friction 0.2 tangential partial_slip", "rolling"),
        (PARTIAL | {"friction": 0.0}, "", "tangential"),
        ({"law": "hertz", "cohesion": {"kind": "jkr", "energy": 10.0}}, "cohesion jkr 10", "dmt"),
        ({"cohesion": {"kind": "dmt", "energy": 0.0}}, "", "cohesion"),
    ],
)
def test_words_of_pair_style_and_walls(changes: dict, has: str, has_not: str) -> None:
    """The loss is in the deck, and is recovered from the case file."""
    case = load_case("fcc-small", {f"contact.{name}": value for name, value in changes.items()})
    assert case_from_dict(case.to_dict()) == case
    for lines in (pair_coefficients(assemble(case)), wall_commands(assemble(case))):
        text = "\n".join(lines)
        assert has in text and not [word for word in has_not.split() if word in text]


def test_a_pair_has_its_own_words() -> None:
    soft = {
        "materials": {"soft": {"preset": "aluminium"}},
        "material": "soft",
        "contact.friction": 0.2,
    }
    for own, words in (({"tangential": "partial_slip"}, "tangential partial_slip"),
                       ({"cohesion": {"kind": "dmt", "energy": 0.5}}, "cohesion dmt 0.5")):  # fmt: skip
        case = load_case("fcc-small", soft | {"pair": [{"materials": ["soft", "soft"]} | own]})
        assert words in "\n".join(pair_coefficients(assemble(case)))
        assert words not in "\n".join(wall_commands(assemble(case)))
        assert own.items() <= case.to_dict()["pair"][0].items()


def test_a_given_stiffness_or_damping_shortens_the_timestep() -> None:
    usual = auto_timestep(load_case("fcc-small", {"contact.friction": 0.3, "contact.rolling": 0.1}))
    assert usual == auto_timestep(load_case("fcc-small", {"contact.friction": 0.3}))
    for name, value in (("stiffness", 1e12), ("damping", 1e6)):
        case = load_case("fcc-small", {"contact.rolling": {"coefficient": 0.1, name: value}})
        assert auto_timestep(case) < 0.5 * usual
