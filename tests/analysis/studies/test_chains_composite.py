"""Composite chains, the homogeneous chain of the same source, and two unlike spheres, against closed forms and the twin."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.analysis.measures.chains.composite_section import Composite, composite_of
from granwave.analysis.measures.chains.probed_pair import Pair
from granwave.analysis.measures.hertz_chain import discrete_speed
from granwave.analysis.measures.signals import decay
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.study import Row, Study, make_studies
from granwave.lammps_inputs.case.material import material
from granwave.workflows import load_case, load_scan, run_case
from tests.helpers.chain_twin import Bead, Chain, Solid

STEEL = {"modulus": 209e9, "ratio": 0.28, "density": 7925.0}


def run(directory: Path, name: str, changes: dict[str, Any]) -> ChainRun:
    outcome = run_case(load_case(name, changes), directory, figures=False)
    (found,) = ChainRun.among([(directory.name, directory, outcome.summary)])
    return found


def rows_of(study: Study) -> dict[str, Row]:
    return {row.quantity: row for row in study.rows}


# ---------------------------------------------------------------------- the homogeneous chain


@pytest.fixture(scope="module")
def homogeneous(tmp_path_factory: pytest.TempPathFactory) -> Study:
    found = run(tmp_path_factory.mktemp("homogeneous"), "homogeneous-chain", {})
    (study,) = make_studies({"homogeneous-chain": [found]})
    return study


def test_homogeneous_chain_is_the_discrete_wave(homogeneous: Study) -> None:
    """Force and speed agree with theory to 0.2 %; finite elements of the source deviate by 0.7 to 71 and 2 to 18 %."""
    rows = rows_of(homogeneous)
    force = rows["Peak force; source: penalty 1.5, automatic solver"]
    speed = rows["Wave speed; source: penalty 1.5, automatic solver"]
    assert (force.source, speed.source) == (27.22, 595)
    assert force.ours == pytest.approx(27.507, rel=1e-3)  # tests/chain_twin.py
    assert force.ours == pytest.approx(force.expected, rel=2e-3)
    assert speed.ours == pytest.approx(speed.expected, rel=1e-3)
    assert {picture.name for picture in homogeneous.pictures} == {"homogeneous_forces", "homogeneous_errors"}


def test_speed_of_the_discrete_wave() -> None:
    """Comparison with a wave after 65 contacts of the twin, at its force there."""
    bead, force = Bead(radius=2.38e-3, strength=None, **STEEL), []
    twin = Chain([bead] * 75, "hertz").run(5.6e-4, 5e-8, velocity={0: 0.626}, every=2)
    for contact in (45, 65):
        wave = twin.forces[:, contact]
        k = int(wave.argmax())
        a, b, c = np.polyfit(twin.times[k - 1 : k + 2] - twin.times[k], wave[k - 1 : k + 2], 2)
        force.append((float(twin.times[k] - b / (2 * a)), float(c - b * b / (4 * a))))
    speed = 20 * 4.76e-3 / (force[1][0] - force[0][0])
    stiffness = 2 * STEEL["modulus"] / (4.76e-3 * STEEL["density"] ** 1.5 * (1 - STEEL["ratio"] ** 2))
    nesterenko = 0.6802 * stiffness ** (1 / 3) * force[1][1] ** (1 / 6)
    assert speed / nesterenko == pytest.approx(discrete_speed(), rel=2e-4)
    assert discrete_speed() == pytest.approx(1.01246, abs=2e-5)


def test_other_like_chains_have_no_source(tmp_path: Path) -> None:
    other = run(tmp_path / "run", "homogeneous-chain", {"load.velocity": 1.0, "run.end_time": 1.2e-4})
    (study,) = make_studies({"homogeneous-chain": [other]})
    assert all(row.source is None and row.ours == pytest.approx(row.expected, rel=2e-3) for row in study.rows)


# ---------------------------------------------------------------------- composite chains


SIX = {"run.end_time": 1.3e-3, "output.history": 1300}
STRENGTHS = {
    "material": {"preset": "stainless-steel", "yield_strength": 1e13},
    "replace.1.material": {"preset": "brass-composite", "yield_strength": 550e6},
}


@pytest.fixture(scope="module")
def chains(tmp_path_factory: pytest.TempPathFactory) -> list[ChainRun]:
    """Chains with N2 = 3 and 6 of brass, elastic and yielding; the shorter ones until the output pulse has passed."""
    folder = tmp_path_factory.mktemp("composite")
    three = {"replace.1.index": {"first": 8, "last": 10}, "sensor.2.id": 12, "run.end_time": 4e-4}
    return [
        run(folder / f"{n}-{law}", "composite-chain", {**SIX, **STRENGTHS, **length, "contact.law": law})
        for n, length in ((3, three), (6, {}))
        for law in ("hertz", "elastoplastic")
    ]


def chain_of(runs: list[ChainRun], n: int, *, elastic: bool) -> Composite:
    found = [chain for run in runs if (chain := composite_of(run)) is not None]
    assert {chain.light.name for chain in found} == {"brass-composite"}
    return next(chain for chain in found if chain.n == n and (chain.strength == np.inf) is elastic)


@pytest.mark.parametrize("elastic", [True, False])
def test_composite_chain_against_the_twin(chains: list[ChainRun], elastic: bool) -> None:
    """Peak force of every contact, sensor peaks and V of the chain of N2 = 6."""
    chain = chain_of(chains, 6, elastic=elastic)
    steel = Bead(radius=5e-3, strength=None, **STEEL)
    brass = Bead(103e9, 0.34, None if elastic else 550e6, 5e-3, 8398.0)
    beads = [steel] * 8 + [brass] * 6 + [steel] * 27  # the striker first
    law = "hertz" if elastic else "elastoplastic"
    twin = Chain(beads, law, right=Solid(209e9, 0.28)).run(3.5e-4, 4e-8, velocity={0: 0.626}, every=5)
    before = chain.run.time <= 3.5e-4
    ours = chain.run.force[before].max(axis=0)[: len(twin.peak_force)]
    theirs = twin.forces.max(axis=0)[: len(ours)]
    reached = twin.forces.argmax(axis=0)[: len(ours)] < len(twin.times) - 10  # the pulse has passed
    assert np.count_nonzero(reached) > 15
    assert ours[reached] == pytest.approx(theirs[reached], rel=3e-3)
    peaks = [0.5 * (twin.forces[:, k - 1] + twin.forces[:, k]) for k in (6, 15)]
    assert chain.incident[1] == pytest.approx(peaks[0].max(), rel=1e-3)
    assert chain.output[1] == pytest.approx(peaks[1].max(), rel=3e-3)
    assert chain.speed == pytest.approx(491.3 if elastic else 450.1, rel=2e-3)


def test_loss_in_the_section_lowers_the_pulse(chains: list[ChainRun]) -> None:
    """Elastic: the ratio hardly depends on the length; yielding: the pulse is lower and later, more so in the longer."""
    elastic = [chain_of(chains, n, elastic=True) for n in (3, 6)]
    yielding = [chain_of(chains, n, elastic=False) for n in (3, 6)]
    assert elastic[1].ratio == pytest.approx(elastic[0].ratio, rel=0.01)
    assert yielding[1].ratio < 0.75 * yielding[0].ratio < 0.5
    assert all(slow.speed < fast.speed for slow, fast in zip(yielding, elastic, strict=True))


def test_reflections(chains: list[ChainRun]) -> None:
    """The pulse reflected at the end returns at the time given in the source; the back reflection is weak and earlier."""
    waves = chain_of(chains, 6, elastic=True).reflections
    assert waves["end"].time == pytest.approx(1.25e-3, rel=0.03)
    assert not waves["end"].forth
    assert waves["incident"].forth
    assert waves["incident"].time < waves["BRW"].time < waves["end"].time
    assert waves["BRW"].force < 0.05 * waves["incident"].force
    assert "FRW" not in waves


def test_composite_study(chains: list[ChainRun]) -> None:
    (study,) = make_studies({"composite-chain": chains})
    rows = rows_of(study)
    assert rows["V, N2 = 3, elastic"].source == 469
    assert rows["V, N2 = 3, elastic"].ours == pytest.approx(511.6, rel=2e-3)
    assert rows["V, N2 = 6, yielding at 550 MPa"].source is None
    assert len(study.pictures) == 3
    assert all(picture.drawing.columns for picture in study.pictures)
    end = next(row for name, row in rows.items() if name.startswith("Pulse back"))
    assert (end.unit, end.source) == ("ms", 1.25)


def test_a_chain_without_sensors_is_no_composite_chain(chains: list[ChainRun]) -> None:
    from dataclasses import replace

    bare = [replace(one, case=replace(one.case, sensor=())) for one in chains]
    assert not make_studies({"composite-chain": bare})


def test_exponential_fit() -> None:
    x = np.arange(3.0, 25.0)
    fit = decay(x, 424 + 60 * np.exp(-x / 7))
    assert fit is not None
    assert (fit.end, fit.span, fit.length) == pytest.approx((424, 60, 7), rel=1e-4)
    assert fit.residual < 1e-6
    assert decay(x[:3], x[:3]) is None


@pytest.mark.parametrize("name", ["composite-brass", "composite-ptfe"])
def test_scans_have_their_sensor_on_the_second_bead_behind(name: str) -> None:
    for point in load_scan(name).points:
        section = point.case.replace[0].index
        assert section[0] == 8
        assert {sensor.name: sensor.id for sensor in point.case.sensor} == {"incident": 6, "output": section[-1] + 2}


# ---------------------------------------------------------------------- two unlike spheres


PROBED = {"packing.diameter": 0.00952, "run.end_time": 4e-5, "output.probes": [{"contact": [1, 2]}]}


@pytest.fixture(scope="module")
def pairs(tmp_path_factory: pytest.TempPathFactory) -> list[ChainRun]:
    folder = tmp_path_factory.mktemp("pairs")
    cases = {
        "like": {"load.velocity": 50.5},
        "radii": {"load.velocity": 72.8, "replace": [{"index": 2, "diameter": 0.03808}]},
        "weak": {"load.velocity": 48.5, "material": {"preset": "brass", "yield_strength": 500e6}},
        "unlike": {"load.velocity": 52.6, "replace": [{"index": 2, "material": "steel"}]},
    }
    return [run(folder / name, "two-spheres", PROBED | changes) for name, changes in cases.items()]


def test_unlike_spheres_follow_the_law(pairs: list[ChainRun]) -> None:
    """Loading and unloading; values at 0.4 mm of the independent law (tests/twin.py) in kN."""
    found = {one.label: Pair(one) for one in pairs}
    assert max(pair.deviation for pair in found.values()) < 1e-3
    assert all(pair.deepest > 0.199 * pair.law.effective_radius for pair in found.values())
    for name, force in (("like", 8.972), ("weak", 8.266), ("unlike", 9.251)):
        assert found[name].at(0.4e-3) == pytest.approx(1e3 * force, rel=2e-4)
    radius = found["radii"].law.effective_radius
    assert radius == pytest.approx(0.8 * 0.00476)
    assert found["radii"].law.yield_force == pytest.approx(4.996287 * (radius / 2.38e-3) ** 2, rel=1e-6)


def test_unlike_study(pairs: list[ChainRun]) -> None:
    (study,) = make_studies({"unlike-spheres": pairs})
    assert len(study.pictures) == 4
    spread = next(row for row in study.rows if row.quantity.startswith("Spread"))
    assert abs(spread.ours) < 0.1  # per cent: one normalized curve for ratios 1 and 4
    assert all(row.ours == pytest.approx(row.expected, rel=1e-3) for row in study.rows if row.expected)
    assert not make_studies({"unlike-spheres": pairs[:1]})


def test_materials_of_the_composite_source() -> None:
    """Table 1 of the source; densities are in kg/m^3, printed there as g/m^3."""
    for name, values in {
        "stainless-steel": (209e9, 0.28, 7925),
        "brass-composite": (103e9, 0.34, 8398),
        "ptfe": (1.46e9, 0.46, 1870),
    }.items():
        found = material(name)
        assert (found.youngs_modulus, found.poisson_ratio, found.density) == values
        assert found.yield_strength is None
