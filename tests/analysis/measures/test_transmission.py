"""Transmission of chains: fits of synthetic signals, and driven chains compared with the linear
chain.
"""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from granwave.analysis.figures.histories import target
from granwave.analysis.measures.driven import (
    AmplitudeSweep,
    amplitude_sweep_of,
    fitted_amplitudes,
    steady_amplitudes,
    transfer,
    transmission_of,
)
from granwave.analysis.result.reader import Result
from granwave.extensions.waves.small_waves import steady
from granwave.lammps_inputs.contact.static_load import static_stiffness
from granwave.lammps_inputs.contact.travel_time import row_of
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows import load_case, run_case

pytestmark = pytest.mark.xdist_group("transmission")  # its fixtures are made once

SWEEP = {
    "shape": "sweep",
    "amplitude": 0.02,
    "frequency": 4e3,
    "last_frequency": 2.4e4,
    "duration": 6e-3,
    "kind": "force",
}
LIFTED = {"kind": "force", "shape": "up-and-down", "amplitude": 0.02, "frequency": 5e3}


def test_steady_amplitudes_of_made_up_signals():
    time = np.linspace(0, 1e-2, 1201)
    signals = np.stack(
        [0.3 * np.cos(2 * np.pi * 1234.0 * time - 0.7), 2 + np.sin(2 * np.pi * 1234.0 * time)],
        axis=1,
    )
    found = steady_amplitudes(time, signals, 1234.0)
    assert found is not None
    assert found[0] == pytest.approx([0.3 * np.exp(-0.7j), -1j], abs=1e-12) and found[
        1
    ] == pytest.approx(0, abs=1e-12)
    growing = steady_amplitudes(time, signals * np.exp(300 * time)[:, None], 1234.0)
    assert growing is not None and min(growing[1]) > 0.1
    assert steady_amplitudes(time, signals, 500.0) is None  # two periods in half of the time


def test_transfer_of_a_delayed_and_weakened_signal():
    time = np.arange(4096) * 1e-6
    pulse = np.exp(-(((time - 5e-4) / 2e-5) ** 2))
    later = 0.4 * np.exp(-(((time - 9e-4) / 2e-5) ** 2))
    frequency, ratio = transfer(time, pulse, later)
    assert frequency[0] > 0 and np.abs(ratio) == pytest.approx(0.4, rel=1e-6)
    assert ratio == pytest.approx(0.4 * np.exp(-2j * np.pi * frequency * 4e-4), abs=1e-6)


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """The case of a driven chain, shortened, under a sweep across its cut-off frequency."""
    folder = tmp_path_factory.mktemp("swept") / "run"
    case = load_case("driven-row", {"packing.size": 40, "load": SWEEP, "run.end_time": 9e-3})
    run_case(case, folder, figures=False)
    return folder


def test_a_row_passes_all_below_its_cut_off(swept):
    """An infinite linear chain: 1 below omega_c = 2 sqrt(k/m), small above it."""
    with Result(swept) as result:
        found = transmission_of(result)
        assembly = result.assembly
        balance = np.abs(result["energy/kinetic"] + result["energy/elastic"] + result["energy/dissipated"]
                         - result["energy/input"]).max() / result.energy_input  # fmt: skip
    assert balance < 1e-5 and (found.first, found.last) == (1, 10)
    cut_off = math.sqrt(static_stiffness(assembly) / assembly.case.sphere_mass) / math.pi
    inside = (found.frequency > 8e3) & (found.frequency < 0.95 * cut_off)
    assert np.abs(found.ratio[inside]) == pytest.approx(1, abs=0.02)
    assert np.abs(found.ratio[found.frequency > 1.04 * cut_off]).max() < 0.05


def test_values_that_mean_nothing_under_a_load_that_goes_on(swept):
    summary = json.loads((swept / "summary.json").read_text())
    absent = (
        "wave_speed_m_s",
        "peak_reduction",
        "ground_peak_reduction",
        "unprotected_peak_force_N",
    )
    assert [summary[name] for name in absent] == [None] * len(absent) and summary[
        "wall_peak_force_N"
    ] > 0
    with Result(swept) as result:
        assert target(result) is None  # what bottom_force shows


def test_attenuation_above_the_cut_off(tmp_path):
    """(q - sqrt(q^2 - 1))^2 for every bead, with q = f/f_c: the evanescent wave of a linear
    chain.
    """
    load = {
        "kind": "force",
        "shape": "harmonic",
        "amplitude": 0.02,
        "frequency": 2.1e4,
        "ramp": 1e-3,
    }
    changes = {
        "packing.size": 16,
        "load": load,
        "absorb": [{"layers": 10, "rate": 3e4}],
        "run.end_time": 5e-3,
    }
    run_case(load_case("driven-row", changes), tmp_path / "run", figures=False)
    with Result(tmp_path / "run") as result:
        found = transmission_of(result)
        assembly = result.assembly
    q = math.pi * 2.1e4 / math.sqrt(static_stiffness(assembly) / assembly.case.sphere_mass)
    due = (q - math.sqrt(q**2 - 1)) ** 2
    size = np.abs(found.velocity)
    assert size[2:5] / size[1:4] == pytest.approx(due, rel=0.02)
    assert found.ratio is None or found.ratio == pytest.approx(
        due ** (found.last - found.first), rel=0.1
    )


def test_a_matched_end_reflects_little(tmp_path):
    """Impedance sqrt(k m) on the last bead: at a third of the cut-off frequency the reflection is
    some 3 %.
    """
    changes = {"packing.size": 20, "boundary.bottom": "free", "absorb": [{"layers": 1, "impedance": "matched"}], "run.end_time": 4e-3,
               "load": {"kind": "force", "shape": "harmonic", "amplitude": 0.02, "frequency": 3e3, "ramp": 5e-4}}  # fmt: skip
    outcome = run_case(load_case("driven-row", changes), tmp_path / "run", figures=False)
    with Result(tmp_path / "run") as result:
        found = transmission_of(result)
        case = result.case
        stiffness = static_stiffness(result.assembly)
    size = np.abs(found.velocity[:18])
    reflected = (size.max() - size.min()) / (size.max() + size.min())
    phase = math.asin(math.pi * 3e3 * math.sqrt(case.sphere_mass / stiffness))  # k a/2
    impedance = math.sqrt(stiffness * case.sphere_mass)
    omega = 2 * math.pi * 3e3
    # the last bead: m v' = force of the row - Z v, with a wave exp(+-i k a n)
    step = np.exp(2j * phase)
    end = 1j * omega * case.sphere_mass + impedance + stiffness / (1j * omega)
    due = abs((stiffness / (1j * omega) * step - end) / (stiffness / (1j * omega) / step - end))
    assert due < 0.2 and reflected == pytest.approx(due, abs=0.01)
    assert (
        outcome.summary["absorbed_fraction"] > 0.5
        and outcome.summary["energy_balance_error"] < 1e-5
    )
    power = impedance * abs(found.velocity[-1]) ** 2 / 2
    assert outcome.summary["absorbed_power_W"] == pytest.approx(power, rel=0.02)
    assert outcome.summary["load_power_W"] == pytest.approx(power, rel=0.02)


def test_power_and_losses_of_small_motions(tmp_path):
    """In the band gap of a damped chain: motion and power of the steady response, K - i omega C."""
    frequency = np.array([2.1e4])
    impedance = 500.0
    amplitude = 1e-9
    load = {
        "kind": "displacement",
        "shape": "harmonic",
        "amplitude": amplitude,
        "frequency": 2.1e4,
        "ramp": 1e-3,
    }
    changes = {"packing.size": 5, "boundary.bottom": "free", "absorb": [{"index": [5], "impedance": impedance}],
               "run.end_time": 4e-3, "load": load}  # fmt: skip
    case = load_case("driven-row", changes | {"contact.loss": {"time": 2e-6}})
    summary = run_case(case, tmp_path / "run", figures=False).summary
    lossy, lossless = (
        steady(assemble(one), None, drive=1, sensors=[5], frequencies=frequency)[0].found.amplitude[
            0, 0
        ]
        for one in (case, load_case("driven-row", changes))
    )
    with Result(tmp_path / "run") as result:
        found = transmission_of(result)
    assert abs(found.velocity[4] / found.velocity[0]) == pytest.approx(lossy, rel=2e-3)
    assert abs(lossless / lossy - 1) > 0.02
    power = impedance * (lossy * 2 * math.pi * frequency[0] * amplitude) ** 2 / 2
    assert summary["absorbed_power_W"] == pytest.approx(power, rel=4e-3)
    assert summary["load_power_W"] > 2 * power  # most is lost in the contacts


def test_a_row_on_a_damper(tmp_path):
    """The damper carries the 20 N; behind the contact with its plate it absorbs waves with the
    impedance of the chain.
    """
    impedance = 255.0
    changes = {"packing.size": 20, "boundary.bottom": {"damper": {"damping": impedance}}, "absorb": [],
               "run.end_time": 4e-3,
               "load": {"kind": "force", "shape": "harmonic", "amplitude": 0.02, "frequency": 4e3, "ramp": 5e-4}}  # fmt: skip
    outcome = run_case(load_case("driven-row", changes), tmp_path / "run", figures=False)
    with Result(tmp_path / "run") as result:
        found = transmission_of(result)
        assembly = result.assembly
        pressed = result["walls/bottom/force"]
        lost = result["energy/support_lost"][-1] / result.energy_input
    assert pressed[0] == pytest.approx(20, rel=1e-4) and np.abs(pressed / 20 - 1).max() < 0.05
    assert outcome.summary["energy_balance_error"] < 1e-5 and lost > 0.7
    assert outcome.summary["absorbed_power_W"] == pytest.approx(
        outcome.summary["load_power_W"], rel=0.02
    )
    stiffness = static_stiffness(assembly)
    mass = assembly.case.sphere_mass
    omega = 2j * math.pi * 4e3
    at_plate = (
        2 * stiffness
    )  # Hertz: K of a rigid plane is 2 sqrt(2) times that of two spheres, and k ~ K^(2/3)
    end = omega * mass + 1 / (1 / impedance + omega / at_plate) + stiffness / omega
    step = np.exp(2j * math.asin(abs(omega) / 2 * math.sqrt(mass / stiffness)))
    due = abs((stiffness / omega * step - end) / (stiffness / omega / step - end))
    size = np.abs(found.velocity[:18])
    assert (size.max() - size.min()) / (size.max() + size.min()) == pytest.approx(due, abs=0.01)


@pytest.mark.parametrize(
    "changes",
    [
        {"load.frequency": 2.1e4, "run.end_time": 2e-3},  # stopped, nothing travels
        {"load.frequency": 1.97e4, "load.amplitude": 50.0},  # opens contacts: not a small wave
        {"load": SWEEP},  # up to the cut-off, where the last part is late
        {"run.end_time": 4e-4, "output.history": 0},  # nothing is measured
    ],
)
def test_runs_that_may_be_too_short_are_not_refused(caplog, changes):
    """Some of these cases cause a warning, as small waves near the cut-off do."""
    assembly = assemble(load_case("driven-row", changes))
    assert assembly.n_spheres == 60
    warned = "run.end_time: found" in caplog.text
    assert warned == ("load.amplitude" in changes or "load" in changes)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (
            {"run.end_time": 1e-3},
            "run.end_time: found 0.001 s, expected 0.0012 s or more: the steady motion",
        ),
        (
            {"load.frequency": 1.97e4},
            "run.end_time: found 0.008 s, expected 0.0117 s or more: at 19700 Hz waves take",
        ),
        (
            {"load": LIFTED | {"duration": 3e-3}},
            "load.duration: found 0.003 s, expected 0.0064 s or more",
        ),
        (
            {"load": LIFTED | {"duration": 9e-3}},
            "run.end_time: found 0.008 s, expected 0.009 s or more: this is the duration of the "
            "load",
        ),
        ({"output.history": 200}, "output.history: found 200 instants, expected 241 or more"),
    ],
)
def test_what_is_measured_badly_is_warned_of(caplog, changes, says):
    assemble(load_case("driven-row", changes))
    assert says in caplog.text


def test_late_frequencies_of_a_sweep_are_warned_of(caplog):
    load_case("driven-row", {"load": SWEEP | {"last_frequency": 1.97e4, "duration": 7.9e-3}})
    assert "waves of 1.782e+04 to 1.97" in caplog.text


def test_a_wave_packet_takes_its_time():
    """Group velocities of chains with one and two masses, from their dispersion relations."""
    one = row_of(assemble(load_case("driven-row")))
    omega = math.sqrt(one.stiffness[0] / one.mass[0])
    half = np.array([0.1, 0.9, 0.999])  # of the cut-off, sin(q/2)
    due = 1 / (omega * np.sqrt(1 - half**2))
    assert one.per_bead(half * omega / math.pi) == pytest.approx(due, rel=1e-4)
    assert one.of_long_wave == pytest.approx(1 / omega)
    lighter = [{"index": list(range(2, 61, 2)), "material": "aluminium"}]
    two = row_of(assemble(load_case("driven-row", {"replace": lighter})))
    m, other = two.mass
    stiffness = two.stiffness[0]
    top = math.sqrt(2 * stiffness / max(m, other))
    bottom = math.sqrt(2 * stiffness / min(m, other))
    square = (
        2 * math.pi * np.array([4e3, top / 7])
    ) ** 2  # cos q = 1 - w^2 (m + M)/k + w^4 m M/(2 k^2)
    cosine = 1 - square * (m + other) / stiffness + square**2 * m * other / (2 * stiffness**2)
    slope = np.sqrt(square) * (2 * (m + other) / stiffness - 2 * square * m * other / stiffness**2)
    assert two.per_bead(np.sqrt(square) / (2 * math.pi)) == pytest.approx(
        slope / np.sqrt(1 - cosine**2) / 2, rel=1e-4
    )
    assert np.isinf(two.per_bead(np.array([0.5 * (top + bottom) / (2 * math.pi)])))


def test_no_impedance_matches_a_row_without_static_force():
    with pytest.raises(InputError, match="impedance of long waves is undefined"):
        load_case("elastic-impact", {"absorb": [{"layers": 1, "impedance": "matched"}]})


@pytest.mark.parametrize(
    "frequency",
    [9e3, *(pytest.param(value, marks=pytest.mark.validation) for value in (4e3, 1.5e4))],
)
def test_a_run_transmits_what_the_linear_response_says(tmp_path, frequency):
    """Alternating steel and aluminium, driven at one end: amplitudes of runs within 2 % of
    `granwave transmission`.
    """
    load = {
        "kind": "displacement",
        "shape": "harmonic",
        "amplitude": 5e-9,
        "frequency": frequency,
        "ramp": 5e-4,
    }
    lighter = [{"index": list(range(2, 41, 2)), "material": "aluminium"}]
    changes = {"packing.size": 40, "load": load, "replace": lighter, "absorb": [{"layers": 28, "rate": 5e4}],
               "run.end_time": 5e-3}  # fmt: skip
    case = load_case("driven-row", changes)
    run_case(case, tmp_path / "run", figures=False)
    with Result(tmp_path / "run") as result:
        found = transmission_of(result)
    sensors = (4, 7, 12)
    linear, _ = steady(
        assemble(case), None, drive=1, sensors=sensors, frequencies=np.array([frequency])
    )
    measured = np.abs(found.velocity[np.array(sensors) - 1] / found.velocity[0])
    assert measured == pytest.approx(linear.found.amplitude[0], rel=0.02)


def test_amplitudes_at_multiples_of_a_frequency():
    time = np.arange(801) * 1e-6  # eight periods
    angle = 2 * np.pi * 1e4 * time
    signals = np.stack(
        [3 * np.sin(angle) + 0.5 * np.cos(2 * angle + 1) + 0.2 * np.sin(angle / 2), 7 + 0 * time],
        axis=1,
    )
    assert fitted_amplitudes(time, signals, 1e4) == pytest.approx(
        np.array([[3, 0.5, 0, 0.2], [0, 0, 0, 0]]).T, abs=1e-12
    )


def test_branches_of_rising_and_falling_amplitude():
    load = np.array([1.0, 2.0, 3.0, 2.5, 1.5, 0.5])
    rising = np.array([True, True, True, False, False, False])
    alike = AmplitudeSweep(load, rising, np.tile(load, (4, 1)), np.tile(load, (4, 1)))
    assert alike.apart == pytest.approx(0, abs=1e-12)
    two = AmplitudeSweep(load, rising, np.tile(load, (4, 1)), np.tile(load + 2.0 * ~rising, (4, 1)))
    assert two.apart == pytest.approx(2 / 4.5, rel=0.1)


def test_amplitude_of_a_driven_row_rises_and_falls(tmp_path):
    """Under a light load the chain responds proportionally, with one state; the fraction of the
    second harmonic increases with the load.
    """
    load = {
        "kind": "displacement",
        "shape": "up-and-down",
        "amplitude": 4e-8,
        "frequency": 8e3,
        "duration": 8e-3,
    }
    changes = {
        "packing.size": 20,
        "load": load,
        "absorb": [{"layers": 14, "rate": 5e4}],
        "run.end_time": 8.2e-3,
    }
    outcome = run_case(load_case("driven-row", changes), tmp_path / "run", figures=False)
    with Result(tmp_path / "run") as result:
        found = amplitude_sweep_of(result)
    assert found is not None and len(found.load) == 8 and found.rising.sum() == 4
    assert found.first[0] == pytest.approx(2 * np.pi * 8e3 * found.load, rel=1e-2)
    inner = slice(1, 7)
    assert found.last[0][inner] == pytest.approx(found.first[0][inner], rel=0.1)
    assert (
        outcome.summary["amplitude_hysteresis"] == pytest.approx(found.apart) and found.apart < 0.15
    )
    share = found.last[1] / found.last[0]
    assert share[3] > 1.5 * share[1] and share.max() < 0.2


def test_a_driven_packing_transmits_what_the_linear_response_says(tmp_path):
    """The top layer of an FCC packing is driven: amplitudes along a line of a run, compared with
    the springs.
    """
    top = list(range(1, 13))
    down = [1 + 12 * layer for layer in range(16)]
    load = {
        "kind": "displacement",
        "shape": "harmonic",
        "amplitude": 5e-9,
        "frequency": 9e3,
        "ramp": 4e-4,
        "index": top,
    }
    changes = {"packing.size": [3, 4, 16], "load": load, "line": [{"name": "down", "index": down}],
               "absorb": [{"layers": 12, "rate": 5e4}], "run.end_time": 2e-3, "run.timestep": 4e-7, "run.frames": 2}  # fmt: skip
    case = load_case("precompressed-fcc", changes)
    outcome = run_case(case, tmp_path / "run", figures=False)
    with Result(tmp_path / "run") as result:
        found = transmission_of(result)
    assert (found.first, found.last) == (1, 37) and outcome.summary["transmission"] == found.ratio
    linear, _ = steady(
        assemble(case), None, drive=top, sensors=down[1:4], frequencies=np.array([9e3])
    )
    assert np.abs(found.velocity[1:4]) / found.driven == pytest.approx(
        linear.found.amplitude[0], rel=0.02
    )


def test_harmonics_belong_to_a_steady_motion():
    time = np.linspace(0, 1e-2, 1201)
    angle = 2 * np.pi * 1e3 * time
    found = steady_amplitudes(time, (np.cos(angle) + 0.2 * np.cos(2 * angle))[:, None], 1e3)
    assert (
        found is not None
        and found[0][0] == pytest.approx(1)
        and found[1][0] == pytest.approx(0, abs=1e-12)
    )
