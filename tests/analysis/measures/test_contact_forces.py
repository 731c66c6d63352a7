"""Forces of all contacts of a run, and exponential tails: closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from granwave.analysis import Result, write_result
from granwave.analysis.measures.contact_forces import (
    INSTANT,
    PEAK,
    STATIC,
    contact_forces,
    exponential_tail,
)
from granwave.workflows import run_case
from tests.helpers.made_up import synthetic

DECAY = 1.5
START = 1.0


def sample(seed: int, number: int = 2000) -> np.ndarray:
    """Draw exponential values above `START`, and the same number of other values below it."""
    random = np.random.default_rng(seed)
    beyond = START + random.exponential(1 / DECAY, number)
    return np.concatenate([random.uniform(0.0, START, number), beyond])


def test_an_exponential_sample_gives_its_decay():
    """The estimate has no bias: the mean of many deviations, in units of the error, is within
    chance.
    """
    tails = [exponential_tail(sample(seed), START) for seed in range(200)]
    deviations = np.array([(tail.decay - DECAY) / tail.error for tail in tails])
    assert {tail.count for tail in tails} == {2000}
    assert abs(deviations.mean()) < 3 / math.sqrt(len(tails))
    assert 0.8 < deviations.std() < 1.2
    assert sum(not tail.is_exponential for tail in tails) <= 8  # 1 % of them, by chance


def test_even_quantiles_of_an_exponential_are_one():
    """A deterministic sample: its decay is 1.5 up to the width of its steps."""
    levels = (np.arange(5000) + 0.5) / 5000
    tail = exponential_tail(START - np.log1p(-levels) / DECAY, START)
    assert tail.decay == pytest.approx(DECAY, rel=1e-3)
    assert tail.error == pytest.approx(tail.decay / math.sqrt(4998))
    assert tail.is_exponential


@pytest.mark.parametrize("power", [0.5, 2.0])
def test_stretched_values_are_no_exponential(power):
    values = START + np.random.default_rng(1).exponential(1.0, 1000) ** power
    assert not exponential_tail(values, START).is_exponential


def test_nine_values_have_no_tail():
    assert exponential_tail(np.linspace(2.0, 3.0, 9), START) is None
    assert exponential_tail(np.linspace(2.0, 3.0, 10), START).count == 10


def test_largest_forces_of_contacts(tmp_path):
    """Forces of the table, optionally of a part of the spheres."""
    write_result(synthetic.write_run(tmp_path, synthetic.make_case(size=(4, 4, 3))))
    with Result(tmp_path) as result:
        (peak,) = contact_forces(result)
        force = result["contacts/peak_force"]
        assert peak.name == PEAK
        assert peak.time is None
        assert np.array_equal(peak.force, force[force >= 1e-4 * force.max()])
        kept = np.arange(result.n_spheres) < 16  # the top layer
        (part,) = contact_forces(result, kept)
        assert 0 < len(part.force) < len(peak.force)
        assert max(part.i.max(), part.j.max()) <= 16
        assert contact_forces(result, np.zeros(result.n_spheres, dtype=bool)) == []


@pytest.fixture(scope="module")
def pressed_chain(tmp_path_factory):
    """Run of a pressed chain with the forces of all contacts at its snapshots."""
    case = synthetic.make_case(
        "chain",
        8,
        law="hertz",
        load={"velocity": 0.1},
        precompression={"kind": "uniaxial", "force": 20.0},
        run={"end_time": 5e-5, "frames": 11},
        output={"contact_forces": True},
    )
    directory = tmp_path_factory.mktemp("pressed")
    run_case(case, directory, figures=False)
    return directory


def test_forces_at_rest_and_at_the_instant_of_the_largest_energy(pressed_chain):
    """Each contact of a pressed chain carries the static force; the instant has the elastic energy
    of the energy record.
    """
    with Result(pressed_chain) as result:
        static, instant, peak = contact_forces(result)
        assert (static.name, instant.name, peak.name) == (STATIC, INSTANT, PEAK)
        assert static.force == pytest.approx(20.0, rel=1e-6)
        elastic = np.interp(result.frame_times, result["energy/time"], result["energy/elastic"])
        assert instant.time == result.frame_times[elastic.argmax()]
        largest = dict(zip(zip(peak.i, peak.j, strict=True), peak.force, strict=True))
        for i, j, force in zip(instant.i, instant.j, instant.force, strict=True):
            assert force <= largest[i, j] * (1 + 1e-9)
