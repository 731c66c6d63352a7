"""Chapters 2 and 3 of the thesis."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import granwave as gw
from granwave.analysis.studies.registry import load_study
from granwave.analysis.studies.study import Study
from tests.helpers.programs.scripts import FOLDER, columns, row, study_of

pytestmark = [
    pytest.mark.xdist_group("early chapters"),
    pytest.mark.validation,
]  # its fixtures are made once


def run(directory: Path, name: str, changes: dict[str, Any]) -> gw.Run:
    return gw.run(name, changes, directory=directory, progress=False)


@pytest.fixture(scope="module")
def pulses(tmp_path_factory: pytest.TempPathFactory) -> list[gw.Run]:
    """Two pulses of equal impulse, one with a tenth of it, and the first pulse on an elastic
    chain.
    """
    directory = tmp_path_factory.mktemp("pulses")
    loads = [(20e3, 1e-5, "elastoplastic"), (40e3, 5e-6, "elastoplastic"), (2e3, 1e-5, "elastoplastic"),
             (20e3, 1e-5, "hertz")]  # fmt: skip
    return [
        run(directory / str(n), "elastoplastic-pulse",
            {"run.frames": 2, "load.amplitude": force, "load.duration": lasts, "contact.law": law})
        for n, (force, lasts, law) in enumerate(loads)
    ]  # fmt: skip


def study(name: str, runs: list[gw.Run]) -> Study:
    return study_of(f"thesis/chapter_2/{name}.py", runs)


def test_decay_and_collapse(pulses: list[gw.Run]) -> None:
    """Peak forces (N) of the independent solver at contacts 1, 3, 5, 9; runs of one impulse agree."""
    found = study("elastoplastic_decay", pulses)
    unit = gw.theory.ChainScales(pulses[0].case).force
    for name, forces, tolerance in (
        ("20 kN, 10", (6989, 3229, 2002, 1306), 2e-3),
        ("2 kN, 10", (624, 382, 257, 124), 5e-3),
    ):
        largest = columns(found)[f"peak_force_normalised_{name} µs"] * unit
        assert largest[[0, 2, 4, 8]] == pytest.approx(forces, rel=tolerance)
    assert row(found, "Largest difference").ours < 0.15
    for impulse, contact in ((0.46, 4), (0.046, 10)):
        tag = f"I {impulse} "
        assert (
            row(found, f"First contact with a larger force in a later wave, {tag}").ours == contact
        )
        constant = row(found, f"C: mean of (x/R*) F/(E*R*^2 I), contacts 10 to 100, {tag}")
        assert constant.ours == pytest.approx(0.268, rel=0.1)
        power = row(
            found, f"Exponent of the peak force against distance, contacts 15 to 100, {tag}"
        )
        assert power.ours == pytest.approx(-1, abs=0.15)
    assert row(found, "a: ").ours == pytest.approx(0.0374, rel=0.02)
    assert row(found, "Start of the second regime, contact, I 0.46 ").ours == 7
    assert row(found, "Contact at which a trailing wave meets the leading one, I 0.046 ").ours == 22


def test_one_law_for_several_waves(pulses: list[gw.Run]) -> None:
    """Two exponential waves of one length have the geometric mean of their starts, and the mean of
    their decays.
    """
    common_decay = load_study(
        str(FOLDER / "thesis" / "chapter_2" / "elastoplastic_decay.py")
    ).common_decay
    contact = np.arange(9)
    waves = [
        SimpleNamespace(leading=unit * start * np.exp(-decay * contact), unit=unit)
        for unit, start, decay in ((2.0, 0.03, 0.2), (5.0, 0.05, 0.3))
    ]
    assert common_decay(waves, 7) == pytest.approx((np.sqrt(0.03 * 0.05), 0.25))
    found = study("elastoplastic_decay", pulses)
    apart = [
        row(found, f"b: decay of the leading wave per contact, contacts 1 to 7, I {impulse} ").ours
        for impulse in (0.046, 0.46)
    ]
    assert apart[0] < row(found, "b of one law 2.25").ours < apart[1]


def test_speed(pulses: list[gw.Run]) -> None:
    found = study("elastoplastic_speed", pulses)
    for name, power in (("against distance", -0.18), ("against the peak force", 0.18)):
        strong = row(found, f"Exponent of the leading speed {name}, contacts 10 to 95, I 0.46 ")
        assert strong.ours == pytest.approx(power, abs=0.03)
    last = row(found, "Exponent of the leading speed against the impulse")
    assert last.ours == pytest.approx(1 / 6, abs=0.03)


def test_dissipation(pulses: list[gw.Run]) -> None:
    found = study("elastoplastic_dissipation", pulses)
    assert row(
        found, "Dissipated up to contact 87 / (F_y alpha_y), I 0.46"
    ).deviation == pytest.approx(0, abs=0.06)
    fitted = [row(found, f"d{n} of 2.28").theory for n in range(3)]
    assert fitted == pytest.approx([1.10e-4, -7.7e-7, 1.840e-8], rel=0.01)
    model = columns(found)["model_integral_20 kN, 10 µs"]
    assert np.all(np.diff(model) > 0) and model[0] == pytest.approx(0, abs=1e-9)


def test_elastic_chain_beside(pulses: list[gw.Run]) -> None:
    found = row(study("elastic_beside", pulses), "Elastic chain")
    assert found.theory == pytest.approx(0.0298, abs=1e-4)
    assert found.ours == pytest.approx(found.theory, rel=0.03)


def test_unlike_spheres_follow_the_law(tmp_path: Path) -> None:
    """Loading and unloading; values at 0.4 mm of the independent law (tests/helpers/twins/twin.py) in kN."""
    probed = {
        "packing.diameter": 0.00952,
        "run.end_time": 4e-5,
        "output.probes": [{"contact": [1, 2]}],
    }
    cases = {
        "like": {"load.velocity": 50.5},
        "radii": {"load.velocity": 72.8, "replace": [{"index": 2, "diameter": 0.03808}]},
        "weak": {"load.velocity": 48.5, "material": {"preset": "brass", "yield_strength": 500e6}},
        "unlike": {"load.velocity": 52.6, "replace": [{"index": 2, "material": "steel"}]},
    }
    found = study(
        "unlike_spheres",
        [run(tmp_path / n, "two-spheres", probed | case) for n, case in cases.items()],
    )
    # the printed formulas are the law itself: such rows test the code
    assert {one.kind for one in found.rows} == {"verification"}
    assert row(found, "Largest distance of 4 recorded curves").ours < 0.1  # %
    for what, force in (
        ("sigma_y 550 MPa", 8.972),
        ("sigma_y 500 MPa", 8.266),
        ("brass on steel", 9.251),
    ):
        assert row(found, f"Force at 0.4 mm, {what}").ours == pytest.approx(force, rel=2e-4)
    data = found.pictures[0].drawing.columns
    assert data["overlap_over_radius_2"].max() > 0.199
    of_yield = data["force_of_radius_2_over_yield_force"]
    alike = data["force_of_radius_1_over_yield_force"]
    assert of_yield.max() == pytest.approx(alike.max(), rel=0.01)  # the law scales with R*


SHORT = {
    "packing.size": 8,
    "bar.length": 1.2,
    "bar.elements": 120,
    "run.end_time": 4e-4,
    "load.amplitude": 2e3,
}


def of_shape(study: Study, start: str, shape: str) -> gw.Row:
    (found,) = [
        one
        for one in study.rows
        if one.quantity.startswith(start) and f", {shape} " in one.quantity
    ]
    return found


def test_pulses_in_a_bar(tmp_path: Path) -> None:
    """A half-sine on two meshes, and a rectangle; energy converges with the square of the element,
    kinks with 2/3.
    """
    short = {"incident_bar.length": 1.0, "load.duration": 4e-5, "run.end_time": 3e-4}
    runs = [
        run(
            tmp_path / f"{shape}{n}",
            "bar-pulse",
            short | {"load.shape": shape, "incident_bar.elements": n},
        )
        for shape, n in (("half-sine", 100), ("half-sine", 200), ("rectangle", 200))
    ]
    study = study_of("thesis/chapter_3/elastic_bar.py", runs)
    for start, tolerance in (
        ("Speed", 2e-4),
        ("Impedance", 1e-3),
        ("Peak at a section", 5e-3),
        ("Energy", 1e-3),
    ):
        found = of_shape(study, start, "half-sine")
        assert found.ours == pytest.approx(found.theory, rel=tolerance)
    assert of_shape(study, "Largest deviation", "half-sine").ours < 0.08
    assert 1.2 < of_shape(study, "Peak at a section", "rectangle").ours < 1.28
    assert row(study, "Order of the error").ours == pytest.approx(2 / 3, abs=0.25)
    errors = study.pictures[1].drawing.columns["half-sine: error_of_energy"]
    assert errors[0] < 0.3 * errors[1]
    energy = runs[1]["energy_input_J"]
    assert energy == pytest.approx(1e4**2 * 4e-5 / 2 / ((200e9 * 8100) ** 0.5 * 1.27e-4), rel=1e-3)


@pytest.mark.validation
def test_places_of_an_odd_bead(tmp_path: Path) -> None:
    """A softer bead reduces the transmission most near the bar."""
    kinds = [(name, name, 1) for name in ("brass", "aluminium", "steel")]
    kinds += [("brass", "aluminium", place) for place in (2, 5, 8)] + [("brass", "steel", 8)]
    runs = []
    for base, odd, place in kinds:
        changes = {
            "material": base,
            "replace.1.material": odd,
            "replace.1.index": place,
            "output.history": 0,
        }
        runs.append(run(tmp_path / f"{base}{odd}{place}", "intruder", SHORT | changes))
    study = study_of("thesis/chapter_3/intruder_place.py", runs)
    least = row(study, "Transmitted energy, aluminium: smallest")
    assert (
        least.quantity.endswith("at position 8")
        and least.ours < row(study, "Transmitted energy, all brass").ours
    )
    assert columns(study)["place_of_aluminium"].tolist() == [2, 5, 8]
    assert len(study.verdict) == 1


def test_properties_of_an_odd_bead(tmp_path: Path) -> None:
    """Heavier and softer beads transmit less."""
    changes = SHORT | {
        "output.history": 0,
        "replace.1.index": 4,
        "run.end_time": 6e-4,
        "bar.length": 1.6,
    }
    steel = {"preset": "steel"}
    kinds: list[Any] = ["steel", *(steel | {"density": r * 7850} for r in (5, 20))]
    kinds += [steel | {"yield_strength": r * 7e8} for r in (0.1, 0.3)]
    runs = [
        run(
            tmp_path / str(n),
            "intruder",
            changes | {"material": "steel", "replace.1.material": kind},
        )
        for n, kind in enumerate(kinds)
    ]
    data = columns(study_of("thesis/chapter_3/intruder_properties.py", runs))
    assert data["density_ratio"] == pytest.approx([1, 5, 20])
    assert np.all(np.diff(data["energy_ratio_by_density"]) < 0)
    assert data["yield_strength_ratio"] == pytest.approx([0.1, 0.3, 1])
    assert data["energy_ratio_by_yield_strength"][0] < 0.95


def test_split_hopkinson(tmp_path: Path) -> None:
    changes = {
        "packing.size": 4,
        "replace.1.index": 2,
        "bar.elements": 200,
        "incident_bar.elements": 200,
    }
    changes |= {"run.end_time": 8e-4, "output.history": 400}
    found = run(tmp_path, "split-hopkinson", changes)
    study = study_of("thesis/chapter_3/split_hopkinson.py", [found])
    assert row(study, "Peak force, incident").ours == pytest.approx(30, rel=1e-2)
    transmitted, reflected = (
        row(study, f"Energy, {one} / incident").ours for one in ("transmitted", "reflected")
    )
    assert 0 < transmitted < 0.1 < reflected < 1
    assert of_shape(study, "Speed", "table").ours == pytest.approx((200e9 / 8100) ** 0.5, rel=1e-3)
    assert [picture.name for picture in study.pictures] == [
        "split_hopkinson",
        "split_hopkinson_map",
    ]
    assert found["energy_balance_error"] < 1e-5
