"""Record of the force on the target: arrival, peak, impulse and momentum of given curves."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from granwave.analysis.measures.target_record import Reached


def test_a_static_load_is_no_part_of_what_the_impact_brings():
    time = np.linspace(0, 1, 101)
    found = Reached(
        time, 10 + np.where(time < 0.5, 0, 4 * np.sin(math.pi * (time - 0.5))), None, None
    )
    assert found.peak_force == pytest.approx(14)
    assert found.arrival == pytest.approx(0.5 + math.asin(0.01) / math.pi, abs=1e-5)
    assert found.impulse[-1] == pytest.approx(10 + 4 / math.pi, rel=1e-3)
    assert Reached(time, np.full_like(time, 10.0), None, None).arrival is None


def test_the_arrival_does_not_depend_on_the_interval_of_records():
    """1 % of the peak of a force of 3/2 power, with records of half the arrival, and shorter."""
    onset = 4.13e-7
    for step in (2e-7, 1e-8):
        time = np.arange(0.0, 1e-5, step)
        force = np.minimum(0.01 * (time / onset) ** 1.5, 1.0)
        found = Reached(time, force, None)
        assert found.arrival == pytest.approx(onset, rel=0.02)


def test_the_noise_of_a_static_stage_is_no_peak():
    """A rise of 1.4e-7 of the static force is no force of the wave; a rise of 1e-5 is one."""
    time = np.linspace(0.0, 1.0, 11)
    noise = np.full_like(time, 20.0)
    noise[4] += 2.8e-6
    resting = Reached(time, noise, noise)
    assert not resting.is_reached
    assert resting.dynamic_peak_force == 0.0
    assert not resting.rises_at_end
    rising = Reached(time, 20.0 + 2e-4 * time, None)
    assert rising.is_reached
    assert rising.rises_at_end
    assert rising.dynamic_peak_force == pytest.approx(2e-4)


def test_a_front_that_begins_to_arrive_has_not_reached_the_bottom():
    """The front of a chain of elastic spheres has no sharp edge: 2.5e-10 N at the end of the run,
    of a momentum of 1 N s. A wave that has passed is a wave, however small it is.
    """
    time = np.linspace(0.0, 1.0, 11)
    rising = np.where(time > 0.85, 2.5e-10 * time, 0.0)
    record = Reached(time, rising, rising, momentum=1.0)
    assert not record.is_reached
    assert record.dynamic_peak_force == 0.0
    assert record.arrival is None
    passed = 2.5e-10 * np.sin(math.pi * time)
    assert Reached(time, passed, passed, momentum=1.0).is_reached


def test_the_arrival_of_a_force_that_still_rises_is_not_known():
    """1 % of the largest force so far is a level that rises with the end of the record."""
    time = np.linspace(0.0, 1.0, 1001)
    cut = [Reached(time[:n], time[:n] ** 2, None) for n in (500, 1001)]
    first, second = (record.arrival for record in cut)
    assert second > 1.9 * first
    assert [record.known_arrival for record in cut] == [None, None]
    whole = Reached(time, np.sin(math.pi * time), None)
    assert whole.known_arrival == whole.arrival


def test_the_dynamic_impulse_excludes_the_static_force():
    time = np.linspace(0.0, 2.0, 2001)
    record = Reached(time, 20.0 + np.sin(math.pi * time) ** 2, None)
    assert record.has_static_force
    assert record.impulse[-1] == pytest.approx(41.0)
    assert record.dynamic_impulse[-1] == pytest.approx(1.0)
    assert not Reached(time, np.sin(math.pi * time) ** 2, None).has_static_force


def test_the_peak_of_one_contact_is_exact():
    """Between records the force was larger; without a contact of its own only records are known."""
    time = np.linspace(0, 1, 11)
    force = 20 + np.sin(math.pi * time) * 100 * (1 - 1e-4)
    exact = Reached(time, force, force, largest_force=120.0)
    assert exact.peak_force == exact.ground_peak_force == 120.0
    assert exact.dynamic_peak_force == exact.ground_dynamic_peak_force == pytest.approx(100.0)
    assert Reached(time, force, force).peak_force == force.max() < 120.0


def pulses(*strengths: float) -> Reached:
    """Half-sine pulses of some impulses, N s, one a millisecond, on a bottom that an impact of
    1 kg m/s loads; the record ends 10 % of a pulse after the last one.
    """
    time = np.linspace(0.0, len(strengths) + 0.1, 2000 * len(strengths)) * 1e-3
    number = np.minimum((time * 1e3).astype(int), len(strengths) - 1)
    phase = math.pi * np.minimum(time * 1e3 - number, 1.0)
    force = 500 * math.pi * np.array(strengths)[number] * np.sin(phase)
    return Reached(time, force, force, momentum=1.0, momentum_down=1.0)


def test_a_peak_is_known_once_most_of_the_momentum_has_arrived():
    """After 15 % of the momentum, 85 % have yet to arrive, in a pulse that may be larger."""
    early = pulses(0.15)
    assert early.arrived_momentum == pytest.approx(0.15, rel=1e-5)
    assert early.awaits_momentum and not early.rises_at_end and not early.has_known_peak
    late = pulses(0.15, 1.2)
    assert late.arrived_momentum == pytest.approx(1.35, rel=1e-5)
    assert not late.awaits_momentum and late.has_known_peak
    assert late.dynamic_peak_force > 5 * early.dynamic_peak_force
    unknown = dataclasses.replace(early, momentum_down=None)
    assert unknown.arrived_momentum is None and unknown.has_known_peak


@pytest.mark.parametrize(("late", "grows"), [(0.0, False), (0.008, False), (0.012, True)])
def test_an_impulse_grows_if_a_hundredth_belongs_to_the_last_tenth(late, grows):
    """A pulse of 1 N s above a static force of 3 N in the first half, and a late impulse, N s."""
    time = np.linspace(0.0, 1.0, 10001)
    pulse = np.where((time > 0) & (time <= 0.5), 2.0, 0.0)
    tail = np.where(time > 0.9, 10 * late, 0.0)
    assert Reached(time, 3.0 + pulse + tail, None).has_growing_impulse is grows


@pytest.mark.parametrize(
    ("arrived", "text"),
    [(0.15, "15 %"), (0.797, "79.7 %"), (0.79864, "79.9 %"), (0.79999, "79.9 %")],
)
def test_a_fraction_below_80_per_cent_is_not_rounded_to_it(arrived, text):
    time = np.array([0.0, 1.0, 2.0])
    record = Reached(time, np.array([0.0, arrived, 0.0]), None, momentum=1.0, momentum_down=1.0)
    assert record.awaits_momentum
    assert record.arrived_in_words == text
