"""Elastoplastic and bilinear chains: quantities and models of the studies, for short chains."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from granwave.analysis.measures.chains.elastoplastic_model import (
    QUADRATIC,
    dissipation_at,
    integrated_dissipation,
    peak_force,
    quadratic_of,
    summed_dissipation,
)
from granwave.analysis.measures.chains.elastoplastic_pulse import Pulses
from granwave.analysis.measures.chains.hertz_chain import IMPULSE_LIMIT
from granwave.analysis.studies.chains.elastoplastic import pulse as elastoplastic_pulse
from granwave.analysis.studies.chains.runs import ChainRun, from_thesis
from granwave.analysis.studies.study import Row, Study, draw_studies, make_studies
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.workflows import run_case
from granwave.workflows.library import load_case


def run(case: str, directory: Path, **overrides: Any) -> ChainRun:
    changed = load_case(case, {name.replace("__", "."): value for name, value in overrides.items()})
    outcome = run_case(changed, directory, figures=False)
    assert outcome.summary["energy_balance_error"] < 1e-5
    (found,) = ChainRun.among([(directory.name, directory, outcome.summary)])
    return found


def one(name: str, runs: list[ChainRun]) -> Study:
    (study,) = make_studies({name: runs})
    return study


def row(study: Study, *words: str) -> Row:
    found = [one for one in study.rows if all(word in one.quantity for word in words)]
    assert len(found) == 1, [one.quantity for one in found]
    return found[0]


# elastoplastic chains


@pytest.fixture(scope="module")
def plastic(tmp_path_factory) -> list[ChainRun]:
    folder = tmp_path_factory.mktemp("plastic")
    size = {"packing__size": 60, "run__end_time": 9e-4, "output__history": 450}
    loads = [(20e3, 1e-5, "elastoplastic"), (40e3, 5e-6, "elastoplastic"), (2e3, 1e-5, "elastoplastic"),
             (20e3, 1e-5, "hertz")]  # fmt: skip
    return [
        run("elastoplastic-pulse", folder / str(n), load__amplitude=p, load__duration=t, contact__law=law, **size)
        for n, (p, t, law) in enumerate(loads)
    ]


def pulses_of(runs: list[ChainRun]) -> Pulses:
    (found,) = elastoplastic_pulse.select(runs)
    return found


def test_chains_are_grouped_by_impulse(plastic):
    pulses = pulses_of(plastic)
    assert [len(group) for group in pulses.groups] == [2, 1]
    assert [wave.impulse for wave in pulses.chosen] == pytest.approx([0.4598, 0.04598], rel=1e-3)
    assert pulses.elastic is not None and pulses.elastic[0].run.case.contact.law == "hertz"
    assert pulses.elastic[1] is pulses.chosen[0]
    assert from_thesis(pulses.weakest.run, yielding=True)


def test_decay_and_collapse_of_elastoplastic_chains(plastic):
    """Peak forces of an independent solver at contacts 1, 3, 5, 9; runs of one impulse agree; the wave is overtaken."""
    pulses = pulses_of(plastic)
    strong, weak = pulses.chosen
    assert strong.largest[[0, 2, 4, 8]] == pytest.approx([6989, 3229, 2002, 1306], rel=2e-3)
    assert weak.largest[[0, 2, 4, 8]] == pytest.approx([624, 382, 257, 124], rel=5e-3)
    same = next(wave for wave in pulses.groups[0] if wave is not strong)
    assert same.largest[:10] == pytest.approx(strong.largest[:10], rel=0.03)
    assert (strong.transition, weak.transition) == (4, 10)
    assert weak.normalised[0] == pytest.approx(0.0374, rel=0.02)


def test_inverse_regime_speed_and_dissipation(plastic):
    pulses = pulses_of(plastic)
    for wave in pulses.chosen:
        last = wave.contacts
        assert wave.inverse_constant(8, last) == pytest.approx(0.268, rel=0.15)
        assert wave.force_power(8, last).exponent == pytest.approx(-1, abs=0.2)
        total = float(np.sum(wave.run.of_contacts("dissipated_energy")))
        assert wave.dissipated[-1] <= total
        assert total == pytest.approx(wave.run.summary["energy_dissipated_J"], rel=1e-6)
    strong = pulses.chosen[0]
    assert [fit.exponent for fit in strong.speed_powers(8, strong.contacts)] == pytest.approx([-0.18, 0.18], abs=0.03)
    contact = np.arange(15.0, pulses.contacts - 5)
    assert pulses.impulse_power(contact).exponent == pytest.approx(1 / 6, abs=0.03)


def test_the_study_of_elastoplastic_chains(plastic, tmp_path):
    study = one("elastoplastic-pulse", plastic)
    elastic = row(study, "Elastic chain")
    assert elastic.ours == pytest.approx(elastic.theory, rel=0.03)
    assert row(study, "a: ").source == 0.0374
    fitted = row(study, "d2")
    assert fitted.ours is None and fitted.theory == pytest.approx(fitted.source, rel=0.02)
    powers = [found for found in study.rows if found.quantity.startswith("Power of the leading speed")]
    assert len(powers) == 5 and {found.digits for found in powers} == {2}
    assert len({found.quantity.split(", ")[1] for found in powers}) == 1  # one range for all
    assert "contradicts itself" in powers[-1].remark
    assert row(study, "Dissipated up to", "0.46").deviation == pytest.approx(0, abs=0.06)
    assert len(study.pictures) == 5 and all(picture.drawing.columns for picture in study.pictures)
    (file,) = draw_studies([dataclasses.replace(study, pictures=study.pictures[-1:])], tmp_path)
    assert file.is_file() and file.with_suffix(".csv").stat().st_size > 1000


def test_other_beads_stand_alone(tmp_path):
    """Constants of the source are those of its brass: no source values are shown for another material."""
    found = run("elastoplastic-pulse", tmp_path / "soft", material="aluminium", packing__size=60, run__end_time=2e-3,
                output__history=400)  # fmt: skip
    study = one("elastoplastic-pulse", [found])
    assert study.rows and all(row.source is None and not row.remark for row in study.rows)
    assert [picture.name.split("_")[1] for picture in study.pictures] == ["peaks", "speed", "dissipation"]
    assert make_studies({"elastoplastic-pulse": []}) == []


def test_the_models_of_dissipation():
    """Sum and integral of peak forces: the sum uses those of the source, the integral the same curve over contacts."""
    n = np.arange(1.0, 88)
    peak = 0.4598 * 357915.4
    d0, d1, d2 = QUADRATIC
    forces = peak * peak_force(n)
    assert summed_dissipation(87, peak)[-1] == pytest.approx(np.sum(d0 + d1 * forces + d2 * forces**2))
    parts = [quad(lambda x: d0 + d1 * peak * float(peak_force(np.array(x))) + d2 * (peak * float(peak_force(np.array(x)))) ** 2,
                  a, b, limit=200)[0] for a, b in ((1, 7), (7 + 1e-9, 87))]  # fmt: skip
    assert integrated_dissipation(87, peak)[-1] == pytest.approx(sum(parts), rel=1e-6)
    assert integrated_dissipation(87, peak)[0] == pytest.approx(0, abs=1e-12)


def test_the_quadratic_of_the_law():
    law = sphere_contact(load_case("elastoplastic-pulse"))
    assert quadratic_of(law) == pytest.approx((1.10e-4, -7.7e-7, 1.840e-8), rel=0.01)
    overlap = np.array([50.0]) * law.yield_overlap
    assert dissipation_at(law, law.loading_force(overlap)) == pytest.approx(law.dissipated_energy(overlap), rel=1e-5)


def test_the_elastic_peak_of_an_impulse():
    """Thesis 4.5 in its own units: 0.0298 for the impulse of Fig. 2.11."""
    assert pytest.approx(0.0298, abs=1e-4) == IMPULSE_LIMIT * 0.4598**1.2
