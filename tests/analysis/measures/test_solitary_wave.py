"""Solitary wave of a material and a diameter, compared with a computed chain."""

from __future__ import annotations

import pytest

from granwave.analysis.measures.hertz_lattices import discrete_width, solitary_wave
from granwave.analysis.notebook.run import Run
from granwave.lammps_inputs.errors import InputError
from granwave.workflows import load_case, run_case


def test_the_wave_of_a_computed_chain(tmp_path):
    """Speed and bead velocity at the peak force of a contact in the middle of the chain."""
    case = load_case("homogeneous-chain")
    run_case(case, tmp_path, figures=False)
    run = Run(tmp_path)
    middle = 8
    force = run.contacts["peak_force"].iloc[middle]
    wave = solitary_wave(case.material, case.packing.diameter, force=force)
    assert wave.speed == pytest.approx(run["wave_speed_m_s"], rel=1e-3)
    velocity = run.result["chain/velocity"][:, middle].max()
    assert wave.velocity == pytest.approx(velocity, rel=2e-3)


def test_force_and_speed_are_inverse():
    wave = solitary_wave("steel", 0.01, force=50.0)
    again = solitary_wave("steel", 0.01, speed=wave.speed)
    assert again.force == pytest.approx(50.0)
    assert wave.width == pytest.approx(0.01 * discrete_width())
    assert wave.duration * wave.speed == pytest.approx(wave.width)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({}, "one of force"),
        ({"force": 1.0, "speed": 1.0}, "one of force"),
        ({"force": -1.0}, "force: found -1.0"),
        ({"speed": float("inf")}, "speed: found inf"),
    ],
)
def test_wrong_values(values, words):
    with pytest.raises(InputError, match=words):
        solitary_wave("steel", 0.01, **values)
