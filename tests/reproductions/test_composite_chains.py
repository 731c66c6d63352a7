"""Composite chains, and the homogeneous chain of the same source, compared with closed forms and
the independent solver.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import granwave as gw
from granwave.analysis.studies.study import Study
from granwave.lammps_inputs.run_directory import MARKER
from granwave.measures import Chain, exponential_decay, maxima
from granwave.workflows import load_scan
from tests.helpers.programs.scripts import FOLDER, row, study_of
from tests.helpers.twins import chain_twin as twin_of
from tests.helpers.twins.chain_twin import Bead, Record, Solid

pytestmark = [
    pytest.mark.xdist_group("composite chains"),
    pytest.mark.validation,
]  # its fixtures are made once

STEEL = {"modulus": 209e9, "ratio": 0.28, "density": 7925.0}
STEEL_BEAD = Bead(radius=5e-3, strength=None, **STEEL)
PTFE_BEAD = Bead(1.46e9, 0.46, None, 5e-3, 1870.0)
WALL = Solid(209e9, 0.28)


def run(directory: Path, name: str, changes: dict[str, Any]) -> gw.Run:
    return gw.run(name, {"run.frames": 2} | changes, directory=directory, progress=False)


def study_in(script: str, runs: list[gw.Run]) -> Study:
    study = study_of(f"composite_chains/{script}.py", runs)
    assert not study.failed
    return study


def columns(study: Study, name: str) -> dict[str, Any]:
    """Data of the picture whose name ends with a text."""
    (picture,) = [picture for picture in study.pictures if picture.name.endswith(name)]
    return dict(picture.drawing.columns)


# ---------------------------------------------------------------------- the homogeneous chain


@pytest.fixture(scope="module")
def like(tmp_path_factory: pytest.TempPathFactory) -> gw.Run:
    return run(tmp_path_factory.mktemp("homogeneous"), "homogeneous-chain", {})


@pytest.fixture(scope="module")
def homogeneous(like: gw.Run) -> Study:
    return study_in("homogeneous_chain", [like])


def test_homogeneous_chain_is_the_discrete_wave(homogeneous: Study) -> None:
    """Force and speed agree with theory to 0.2 %; finite elements of the source deviate by 0.7 to
    71 and 2 to 18 %.
    """
    force = row(homogeneous, "Peak force; source: penalty 1.5, automatic solver")
    speed = row(homogeneous, "Wave speed; source: penalty 1.5, automatic solver")
    assert (force.source, speed.source) == (27.22, 595)
    assert force.ours == pytest.approx(27.507, rel=1e-3)  # tests/helpers/twins/chain_twin.py
    assert force.ours == pytest.approx(force.theory, rel=2e-3)
    assert speed.ours == pytest.approx(speed.theory, rel=1e-3)


def test_contact_of_two_beads_of_the_homogeneous_chain(homogeneous: Study) -> None:
    """Force against approach follows Hertz's law; the beads separate at the time of the independent
    solver, ten times earlier than printed in the source.
    """
    exponent = row(homogeneous, "Exponent of force against approach, beads 5 and 6")
    assert (exponent.source, exponent.theory) == (1.554, 1.5)
    assert exponent.ours == pytest.approx(1.5, abs=1e-4)
    parting = row(homogeneous, "Beads 5 and 6 separate")
    bead = Bead(radius=2.38e-3, strength=None, **STEEL)
    twin = twin_of.Chain([bead] * 15, "hertz", right=WALL).run(
        1e-4, 2e-8, velocity={0: 0.626}, every=1
    )
    force = twin.forces[:, 4]
    over = np.flatnonzero((np.arange(len(force)) > force.argmax()) & (force <= 0))[0]
    assert parting.source == 0.6
    assert parting.ours == pytest.approx(1e3 * twin.times[over], abs=3e-4)


def test_a_force_on_disk_moves_every_row_that_measures_it(
    like: gw.Run, homogeneous: Study, tmp_path: Path
) -> None:
    unchecked = shutil.ignore_patterns(MARKER)  # it holds the sizes of the files
    shutil.copytree(like.directory, tmp_path / "copy", ignore=unchecked)
    with h5py.File(tmp_path / "copy" / "result.h5", "r+") as file:
        file["chain/contact_force"][...] = 1.1 * file["chain/contact_force"][...]
    before, after = (
        {one.quantity: one for one in study.rows}
        for study in (homogeneous, study_in("homogeneous_chain", [gw.load(tmp_path / "copy")]))
    )
    forces = [name for name in before if name.startswith("Peak force")]
    errors = [name for name in before if name.startswith("Error of")]
    assert len(forces) == 11 and len(errors) == 3
    for name in forces:
        assert after[name].ours == pytest.approx(1.1 * before[name].ours)
    for name in errors:
        assert abs(after[name].ours - before[name].ours) > 0.1  # per cent
    for name in set(before) - {*forces, *errors}:  # speeds, and what is not measured
        assert after[name].ours == pytest.approx(before[name].ours)


def test_speed_of_the_discrete_wave() -> None:
    """Comparison with a wave after 65 contacts of the twin, at its force there."""
    bead = Bead(radius=2.38e-3, strength=None, **STEEL)
    force = []
    twin = twin_of.Chain([bead] * 75, "hertz").run(5.6e-4, 5e-8, velocity={0: 0.626}, every=2)
    for contact in (45, 65):
        wave = twin.forces[:, contact]
        k = int(wave.argmax())
        a, b, c = np.polyfit(twin.times[k - 1 : k + 2] - twin.times[k], wave[k - 1 : k + 2], 2)
        force.append((float(twin.times[k] - b / (2 * a)), float(c - b * b / (4 * a))))
    speed = 20 * 4.76e-3 / (force[1][0] - force[0][0])
    nesterenko = gw.theory.ChainScales(gw.case("homogeneous-chain")).nesterenko(force[1][1])
    assert speed / nesterenko == pytest.approx(gw.theory.discrete_speed(), rel=2e-4)
    assert gw.theory.discrete_speed() == pytest.approx(1.01246, abs=2e-5)


# ---------------------------------------------------------------------- composite chains


SIX = {"run.end_time": 1.3e-3, "output.history": 1300}
THREE = {"replace.1.index": {"first": 8, "last": 10}, "sensor.2.id": 12, "run.end_time": 4e-4}
STRENGTHS = {
    "material": {"preset": "stainless-steel", "yield_strength": 1e13},
    "replace.1.material": {"preset": "brass-composite", "yield_strength": 550e6},
}


@pytest.fixture(scope="module")
def chains(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[int, str], gw.Run]:
    """Chains with N2 = 3 and 6 of brass, elastic and yielding; the shorter ones until the output
    pulse has passed.
    """
    folder = tmp_path_factory.mktemp("composite")
    return {
        (n, law): run(
            folder / f"{n}-{law}",
            "composite-chain",
            {**SIX, **STRENGTHS, **length, "contact.law": law},
        )
        for n, length in ((3, THREE), (6, {}))
        for law in ("hertz", "elastoplastic")
    }


@pytest.fixture(scope="module")
def brass(chains: dict[tuple[int, str], gw.Run]) -> Study:
    return study_in("composite_chain", list(chains.values()))


@pytest.mark.parametrize(
    "law", ["hertz", pytest.param("elastoplastic", marks=pytest.mark.validation)]
)
def test_composite_chain_against_the_twin(
    chains: dict[tuple[int, str], gw.Run], brass: Study, law: str
) -> None:
    """Peak force of every contact, sensor peaks and V of the chain of N2 = 6."""
    chain = Chain(chains[6, law])
    elastic = law == "hertz"
    beads = (
        [STEEL_BEAD] * 8
        + [Bead(103e9, 0.34, None if elastic else 550e6, 5e-3, 8398.0)] * 6
        + [STEEL_BEAD] * 27
    )
    twin = twin_of.Chain(beads, law, right=WALL).run(3.5e-4, 4e-8, velocity={0: 0.626}, every=5)
    before = chain.time <= 3.5e-4
    ours = chain.force[before].max(axis=0)[: len(twin.peak_force)]
    theirs = twin.forces.max(axis=0)[: len(ours)]
    reached = twin.forces.argmax(axis=0)[: len(ours)] < len(twin.times) - 10  # the pulse has passed
    assert np.count_nonzero(reached) > 15
    assert ours[reached] == pytest.approx(theirs[reached], rel=3e-3)
    peaks = [0.5 * (twin.forces[:, k - 1] + twin.forces[:, k]).max() for k in (6, 15)]
    assert chain.sensors["incident"].max() == pytest.approx(peaks[0], rel=1e-3)
    kind = "elastic" if elastic else "yielding at 550 MPa"
    assert row(brass, f"lambda, N2 = 6, {kind}").ours == pytest.approx(
        peaks[1] / peaks[0], rel=3e-3
    )
    assert row(brass, f"V, N2 = 6, {kind}").ours == pytest.approx(
        491.3 if elastic else 450.1, rel=2e-3
    )


def test_loss_in_the_section_lowers_the_pulse(brass: Study) -> None:
    """Elastic: the ratio hardly depends on the length; yielding: the pulse is lower and later, more
    so in the longer.
    """
    data = columns(brass, "length")
    elastic = data["elastic_ratio"]
    yielding = data["yielding_at_550_MPa_ratio"]
    assert elastic[1] == pytest.approx(elastic[0], rel=0.01)
    assert yielding[1] < 0.75 * yielding[0] < 0.5
    assert np.all(data["yielding_at_550_MPa_speed_m_s"] < data["elastic_speed_m_s"])


def test_reflections(brass: Study) -> None:
    """The pulse reflected at the end returns at the time given in the source; the back reflection
    is weak and earlier.
    """
    incident, back, end = (
        row(brass, name) for name in ("Incident", "Backward reflection", "Pulse reflected")
    )
    assert (end.unit, end.source) == ("ms", 1.25)
    assert end.ours == pytest.approx(1.25, rel=0.03)
    assert incident.ours < back.ours < end.ours
    force = [
        float(one.remark.removeprefix("The force is ").split(" N")[0]) for one in (incident, back)
    ]
    assert force[1] < 0.05 * force[0]
    assert not [one for one in brass.rows if one.quantity.startswith(("Forward", "Delayed"))]


def test_rows_beside_the_source(brass: Study) -> None:
    assert row(brass, "V, N2 = 3, elastic").source == 469
    assert row(brass, "V, N2 = 3, elastic").ours == pytest.approx(511.6, rel=2e-3)
    assert row(brass, "V, N2 = 6, yielding at 550 MPa").source is None
    stress = row(brass, "Largest pressure, first contact of the section, N2 = 6, elastic")
    assert stress.source == 1200  # compressive
    von_mises = row(
        brass, "Largest von Mises stress, first contact of the section, N2 = 6, elastic"
    )
    assert von_mises.source == 1200
    assert von_mises.ours == pytest.approx(1319, abs=1)
    assert not [one for one in brass.rows if one.ours is None and one.theory is None], (
        "it compares nothing"
    )
    speed = row(brass, "Speed of the striker")
    assert speed.ours is None and speed.theory == pytest.approx(
        np.sqrt(2 * 9.81 * np.sin(np.pi / 60) * 0.01)
    )


@pytest.fixture(scope="module")
def soft(tmp_path_factory: pytest.TempPathFactory) -> gw.Run:
    """The elastic chain of six beads of PTFE, until waves return from its end."""
    changes = {"replace.1.material": "ptfe", "run.end_time": 1.3e-3, "output.history": 1300}
    return run(tmp_path_factory.mktemp("ptfe") / "run", "composite-chain", changes)


@pytest.fixture(scope="module")
def ptfe(soft: gw.Run) -> Study:
    return study_in("composite_chain", [soft])


@pytest.fixture(scope="module")
def ptfe_twin() -> Record:
    chain = twin_of.Chain(
        [STEEL_BEAD] * 8 + [PTFE_BEAD] * 6 + [STEEL_BEAD] * 27, "hertz", right=WALL
    )
    return chain.run(1e-3, 1e-7, velocity={0: 0.626}, every=5)


def test_output_of_ptfe_has_two_peaks(ptfe: Study, ptfe_twin: Record) -> None:
    """Times and heights of both peaks at the second contact behind the section, and of the train
    before it, compared with the independent solver.
    """
    for name, contact in (
        ("Second output peak / first output peak", 15),
        ("Second wave into the section / first wave", 7),
    ):
        force = ptfe_twin.forces[:, contact]
        first, second = maxima(force, 0.05 * float(force.max()))[:2]
        found = row(ptfe, name)
        assert found.ours == pytest.approx(force[second] / force[first], rel=3e-3)
        later = 1e6 * (ptfe_twin.times[second] - ptfe_twin.times[first])
        microseconds = found.remark.partition(" µs")[0].split(" ")[-1]
        assert float(microseconds) == pytest.approx(later, abs=3)
    assert row(ptfe, "Second output peak / first output peak").ours == pytest.approx(
        0.494, abs=0.005
    )


def test_the_train_needs_no_reflection() -> None:
    """The second wave of the train is unchanged if the section is infinite."""
    chain = twin_of.Chain([STEEL_BEAD] * 8 + [PTFE_BEAD] * 12, "hertz")
    twin = chain.run(3.6e-4, 1e-7, velocity={0: 0.626}, every=2)
    force = twin.forces[:, 7]
    first, second = (force[n] for n in maxima(force, 0.05 * float(force.max()))[:2])
    assert twin.forces[-1, 15:].max() < 1e-6 * force.max()  # nothing has come to the end
    assert second / first == pytest.approx(0.450, abs=0.002)


def test_energy_by_section(soft: gw.Run, ptfe: Study, ptfe_twin: Record) -> None:
    """The sum agrees with the energy record; the fractions agree with the independent solver."""
    data = columns(ptfe, "waves")
    twin = ptfe_twin
    time = data["elastic_time_s"]
    shares = np.stack(
        [data[f"elastic_{part}_over_input"] for part in ("first_steel", "light", "second_steel")],
        axis=1,
    )
    before = time < 9e-4  # the wall bears nothing yet
    ledger = np.interp(
        time[before], soft.energies.index, soft.energies.input / soft.energies.input.iloc[-1]
    )
    assert shares.sum(axis=1)[before] == pytest.approx(ledger, rel=1e-5)
    mass = np.array([7925.0] * 8 + [1870.0] * 6 + [7925.0] * 27) * np.pi / 6 * 1e-6
    stored = (
        0.4
        * twin.forces[:, :40]
        * np.maximum(twin.displacements[:, :-1] - twin.displacements[:, 1:], 0)
    )
    beads = 0.5 * mass * twin.velocities**2
    beads[:, :-1] += 0.5 * stored
    beads[:, 1:] += 0.5 * stored
    theirs = np.stack(
        [beads[:, part].sum(axis=1) for part in (slice(0, 8), slice(8, 14), slice(14, 41))], axis=1
    )
    for moment in (2e-4, 4e-4, 6e-4, 8e-4):
        k = int(np.argmin(np.abs(twin.times - moment)))
        ours = [np.interp(twin.times[k], time, share) for share in shares.T]
        assert ours == pytest.approx(theirs[k] / twin.work[-1], abs=2e-3)


def test_energy_turns_back_in_ptfe_not_in_brass(brass: Study, ptfe: Study) -> None:
    """Fraction of the energy leaving the section that travels back, at its third contact: a hundred
    times as large for PTFE as for brass.
    """
    assert (
        row(brass, "Energy travelling back").ours < 0.01
        and row(ptfe, "Energy travelling back").ours > 0.5
    )


def test_pressures_are_those_of_hertz(chains: dict[tuple[int, str], gw.Run], brass: Study) -> None:
    """(6 F E*^2/(pi^3 R*^2))^(1/3) at the force of the run; the source's two stresses have a ratio,
    ours stays near one.
    """
    chain = Chain(chains[6, "hertz"])
    modulus = 103e9 / (2 * (1 - 0.34**2))
    force = chain.force[:, chain.contact_between(8)].max()
    expected = (6 * force * modulus**2 / (np.pi**3 * 2.5e-3**2)) ** (1 / 3)
    first = row(brass, "Largest pressure, first contact of the section, N2 = 6, elastic")
    assert first.ours == pytest.approx(1e-6 * expected, rel=1e-3)
    last = row(brass, "Last of these pressures / first, N2 = 6, elastic")
    assert last.ours == pytest.approx(0.98, abs=0.01)


def test_mean_pressure_of_a_yielded_contact(
    chains: dict[tuple[int, str], gw.Run], brass: Study
) -> None:
    """Force over the area of the law, pi R* alpha_y (alpha/alpha_y)^c3 (thesis 2.9, 2.10)."""
    chain = Chain(chains[6, "elastoplastic"])
    contact = chain.contact_between(8)
    modulus = 103e9 / (2 * (1 - 0.34**2))
    radius = 2.5e-3
    strength = 550e6
    at_yield = np.pi**2 / 4 * (1.6 * strength / modulus) ** 2 * radius
    reduced = chain.of_contacts("peak_overlap")[contact] / at_yield
    power = np.log(2.37 * 177.6 - 59.96) / np.log(177.6)
    area = np.pi * radius * at_yield * reduced**power
    expected = chain.of_contacts("peak_force")[contact] / area
    mean = row(brass, "Mean pressure, first contact of the section, N2 = 6, yielding at 550 MPa")
    assert mean.ours == pytest.approx(1e-6 * expected, rel=1e-6)
    assert mean.source == 1200


def test_speed_over_that_in_steel(brass: Study) -> None:
    """The wave of the discrete chain of steel has 613.9 m/s; the source's elements have 595 m/s."""
    found = row(brass, "V / speed in a chain of steel, N2 = 3")
    assert found.bound
    assert found.source == pytest.approx(1.042 * 469 / 595)
    assert found.ours == pytest.approx(row(brass, "V, N2 = 3, elastic").ours / 613.9, rel=1e-3)


def test_friction_of_the_holder(tmp_path: Path) -> None:
    """Friction due to the weight reduces the pulse only slightly; the recorded energy is friction
    times weight times path.
    """
    runs = [
        run(tmp_path / f"{n}-{mu}", "composite-chain", changes | {"boundary.holder_friction": mu})
        for n, changes in ((3, THREE), (6, {"run.end_time": 4e-4}))
        for mu in (0.0, 1.0)
    ]
    study = study_in("holder_friction", runs)
    short, long, taken = study.rows
    assert short.ours == pytest.approx(-0.215, abs=0.01) and short.kind == "alone"
    assert long.ours < short.ours
    assert taken.kind == "verification" and taken.ours == pytest.approx(taken.theory, rel=1e-3)
    assert len(study.verdict) == 1 and f"{-long.ours:.2g} %" in study.verdict[0]


def test_losses_in_the_contacts(tmp_path: Path) -> None:
    """The output pulse decreases along the section; speeds of the source are compared with ours."""
    loss = {"contact.loss": {"dashpot": {"restitution": 0.97}}}
    long = {"replace.1.index": {"first": 8, "last": 31}, "sensor.2.id": 33, "run.end_time": 8e-4}
    runs = [
        run(tmp_path / f"{n}", "composite-chain", part | loss)
        for n, part in ((3, THREE), (24, long))
    ]
    study = study_in("contact_losses", runs)
    speed = row(study, "V, N2 = 3, brass-composite, restitution 0.97")
    assert speed.source == 469.0 and speed.ours == pytest.approx(508.2, rel=1e-3)
    assert row(study, "Change of lambda").ours < -10
    (verdict,) = study.verdict
    assert verdict.startswith("With restitution 0.97 lambda falls") and "measured: 9.6 %" in verdict


def test_exponential_fit() -> None:
    x = np.arange(3.0, 25.0)
    fit = exponential_decay(x, 424 + 60 * np.exp(-x / 7))
    assert fit is not None
    assert (fit.end, fit.span, fit.length) == pytest.approx((424, 60, 7), rel=1e-4)
    assert fit.residual < 1e-6
    assert exponential_decay(x[:3], x[:3]) is None


@pytest.mark.parametrize("name", ["brass", "ptfe", "holder-friction", "contact-losses"])
def test_scans_have_their_sensor_on_the_second_bead_behind(name: str) -> None:
    for point in load_scan(FOLDER / "composite_chains" / f"{name}.toml").points:
        section = point.case.replace[0].index
        assert section[0] == 8
        assert {sensor.name: sensor.id for sensor in point.case.sensor} == {
            "incident": 6,
            "output": section[-1] + 2,
        }
