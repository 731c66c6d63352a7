"""Values that the end of a run limits: fractions and numbers that still grow in its last tenth."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from granwave.analysis.measures.incomplete_values import (
    BOTTOM_PEAKS,
    COUNTS,
    growing_values,
    incomplete_in,
    incomplete_values,
)

TIME = np.linspace(0.0, 1.0, 1001)
LATE = np.clip((TIME - 0.9) / 0.1, 0.0, 1.0)  # rises from 0 to 1 in the last tenth


class Record(dict):
    """An energy record without a bottom."""

    @property
    def yield_ledger(self):
        return self["energy/dissipated"] - self["energy/friction"]


@pytest.fixture(autouse=True)
def _no_bottom(monkeypatch):
    module = "granwave.analysis.measures.incomplete_values.reached"
    monkeypatch.setattr(module, lambda result: result.get("bottom"))


def record(plastic_late=0.0, friction=0.1, friction_late=0.0, yielded_late=0.0, **bottom):
    """Energies of an input of 2 J, and 1000 contacts, of which some come in the last tenth."""
    given = np.full(len(TIME), 2.0)
    lost_by_friction = 2.0 * (friction + friction_late * LATE)
    return Record({
        "energy/time": TIME,
        "energy/input": given,
        "energy/friction": lost_by_friction,
        "energy/dissipated": lost_by_friction + 2.0 * (0.7 + plastic_late * LATE),
        "energy/contacts_yielded": 1000.0 + yielded_late * LATE,
        **bottom,
    })  # fmt: skip


def test_a_settled_run_is_complete():
    assert incomplete_values(record()) == []


@pytest.mark.parametrize(("late", "grows"), [(0.0009, False), (0.0011, True)])
def test_a_fraction_grows_by_more_than_a_thousandth_of_the_input(late, grows):
    names = incomplete_values(record(plastic_late=late))
    expected = (
        {"dissipated_fraction", "plastic_fraction", "energy_dissipated_J"} if grows else set()
    )
    assert set(names) == expected


def test_a_small_part_grows_by_half_a_per_cent_of_itself():
    """Friction of 12.1 % gained 0.096 % in the last tenth, and 1.2 % in twice the time."""
    assert incomplete_values(record(friction=0.12, friction_late=0.00096)) == ["friction_fraction"]
    assert incomplete_values(record(friction=0.12, friction_late=0.0005)) == []
    assert incomplete_values(record(friction=0.0, friction_late=9e-5)) == []


@pytest.mark.parametrize(("late", "grows"), [(4.0, False), (6.0, True)])
def test_numbers_of_yielded_contacts_grow(late, grows):
    assert incomplete_values(record(yielded_late=late)) == (list(COUNTS) if grows else [])


def test_a_later_pulse_may_be_larger():
    awaits = SimpleNamespace(is_reached=True, has_known_peak=False, has_growing_impulse=False)
    assert set(BOTTOM_PEAKS) < set(incomplete_values(record(bottom=awaits)))
    final = SimpleNamespace(is_reached=True, has_known_peak=True, has_growing_impulse=False)
    assert incomplete_values(record(bottom=final)) == []


def test_sizes_of_a_growing_zone_are_incomplete():
    summary = {"zone_growing": ["radius"], "zone_radius_90_m": 1.0, "zone_depth_90_m": 1.0}
    assert list(incomplete_in(summary)) == ["zone_radius_90_m"]
    assert not incomplete_in({})


def test_energies_of_growing_fractions_are_incomplete():
    summary = {
        "incomplete_values": ["dissipated_fraction", "friction_fraction", "wall_peak_force_N"],
        "dissipated_fraction": 0.5,
        "friction_fraction": 0.1,
        "energy_dissipated_friction_J": 0.2,
        "energy_dissipated_wall_J": 0.1,
        "wall_peak_force_N": 10.0,
    }
    energies = {"energy_dissipated_friction_J", "energy_dissipated_wall_J"}
    assert energies <= set(incomplete_in(summary))
    assert growing_values(summary) == ["dissipated_fraction", "friction_fraction"]
