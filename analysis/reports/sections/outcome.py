"""Outcome of a run in sentences: impacts, chains, protected targets, inferred forces, small waves."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.analysis.formatting.numbers import plain
from granwave.analysis.reports.inputs import Run
from granwave.analysis.reports.sections.setting import target_of
from granwave.analysis.result.histories import along
from granwave.analysis.result.reader import Result
from granwave.analysis.scans.keys import WORTH
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.run_directory import SPECTRA_FILE

_FEW = 0.5  # of the contacts
_KEPT = 0.1  # relative change of a peak force along a chain that is none
_REACHED = 1e-3  # of the largest peak force: contacts that the wave has reached
_PASSES = 0.5  # of the driven grain's amplitude
_MOST_STRETCHES = 3  # of frequency, in a sentence
_EXACT = 1e-9  # below which what is unexplained is rounding


def in_words(run: Run) -> str:
    """Return what came out of a run; the answer that it was made for comes first."""
    if run.is_inference:
        return _of_inference(run)
    if run.kind == "spectra":
        return _OF_SPECTRA[str(run.summary.get("kind"))](run)
    target = bool(target_of(run.case))
    bottom, chain = _bottom(run, target=target), _chain(run)
    energy = [*_energies(run), *_transmission(run)]
    parts = [*([bottom] if target else []), *chain, *energy]
    force = run.number("peak_force_N") or run.number("max_force_N")
    if force is not None:
        parts.append(f"The largest contact force was {_four(force)} N.")
    depth, radius = run.number("zone_depth_90_m"), run.number("zone_radius_90_m")
    if depth and radius is not None:
        parts.append(
            f"90 % of the energy of yielding stays within {1e3 * depth:.4g} mm below the impact and "
            f"{1e3 * radius:.4g} mm beside it."
        )
    plate = run.number("plate_velocity_m_s")
    if plate is not None:
        parts.append(f"The plate {'rebounds' if plate < 0 else 'still goes in'} with {abs(plate):.4g} m/s.")
    parts += [_line(run, name) for name in _lines(run)]
    parts += [_loaded(run), _sensors(run)]
    parts += [] if target else [bottom]
    return " ".join(part for part in parts if part)


def share(value: float) -> str:
    """Return a share in per cent, with three digits."""
    return f"{plain(f'{100 * value:.3g}')} %"


def _four(value: float) -> str:
    """Return a number with four digits, without an exponent for common magnitudes."""
    return plain(f"{float(f'{value:.4g}'):g}")


def _bottom(run: Run, *, target: bool) -> str:
    """Return what the bottom or the target bore, and how much less than without the packing."""
    force, bare = run.number("wall_peak_force_N"), run.number("unprotected_peak_force_N")
    if not force:
        return ""
    text = f"The {'target' if target else 'bottom'} bore {_four(force)} N at most"
    reduction = run.number("peak_reduction")
    if bare and reduction:
        text += f", {_less(force, bare)} {_four(bare)} N without the packing"
    ground, without = run.number("ground_peak_force_N"), run.number("unprotected_ground_peak_force_N")
    if target and ground and without and ground != force:
        text += f"; the ground bore {_four(ground)} N, {_less(ground, without)} {_four(without)} N without it"
    return f"{text}."


def _less(force: float, bare: float) -> str:
    change = force / bare - 1
    return f"{share(abs(change))} {'less' if change < 0 else 'more'} than the"


def _chain(run: Run) -> list[str]:
    """Return speed and decay of the wave along a chain."""
    if run.case.get("packing.kind") != "chain" or run.number("transmission") is not None:
        return []
    speed, text = run.number("wave_speed_m_s"), _decay(run)
    parts = [f"The wave ran at {_four(speed)} m/s."] if speed is not None else []
    return [*parts, text] if text else parts


def _decay(run: Run) -> str:
    """Return how the peak force of a wave changes along a chain; empty where that is not known."""
    peaks = _peaks(run)
    reached = np.flatnonzero(peaks > _REACHED * peaks.max(initial=0.0))
    if len(reached) < 2:
        return ""
    numbers, forces = reached + 1, peaks[reached]
    first, last = f"{_four(forces[0])} N in contact {numbers[0]}", f"{_four(forces[-1])} N in contact {numbers[-1]}"
    if abs(forces[-1] / forces[0] - 1) < _KEPT:
        return f"Its peak force is about the same at both ends: {first}, {last}."
    if forces[-1] > forces[0]:
        return f"Its peak force grows from {first} to {last}."
    below = [(words, numbers[forces <= part * forces[0]]) for words, part in (("half", 0.5), ("a tenth", 0.1))]
    steps = [f"{words} of it in contact {found[0]}" for words, found in below if len(found)]
    return f"Its peak force falls from {first} to {' and '.join(steps) if len(steps) > 1 else last}."


def _peaks(run: Run) -> NDArray[np.float64]:
    """Return the largest force of each contact along a chain beyond the static one: (n_contacts,), N; or nothing."""
    try:
        with Result(run.directory) as result:
            if "chain" not in result:
                return np.empty(0)
            static = result["chain/contact_force"][0] if result.case.precompression is not None else 0.0
            return np.maximum(along(result, "peak_force") - static, 0.0)
    except (GranwaveError, KeyError, ValueError, IndexError):
        return np.empty(0)


def _energies(run: Run) -> list[str]:
    given, lost = run.number("energy_input_J"), run.number("dissipated_fraction")
    if given is None or lost is None:
        return []
    absorbed = run.number("absorbed_fraction") or 0.0
    of_it = f"of the {plain(f'{given:.4g}')} J put in"
    dissipated = share(lost - absorbed) if lost - absorbed > WORTH else "Nothing"
    if absorbed <= WORTH:
        return [f"{dissipated} {of_it} was dissipated."]
    rest = f", and {dissipated} was dissipated" if lost - absorbed > WORTH else ""
    return [f"{share(absorbed)} {of_it} was taken by absorbing spheres{rest}."]


def _transmission(run: Run) -> list[str]:
    passed, driven = run.number("transmission"), run.number("driven_velocity_m_s")
    if passed is None or driven is None:
        return []
    return [f"{share(passed)} of the driven end's velocity, {plain(f'{driven:.4g}')} m/s, came through."]


def _loaded(run: Run) -> str:
    """Return how many contacts bore a force, where most did not."""
    loaded, contacts = run.number("n_loaded_contacts"), run.number("n_contacts")
    few = loaded is not None and contacts and loaded < _FEW * contacts and run.case.get("packing.kind") != "chain"
    return f"{loaded:.0f} of {contacts:.0f} contacts bore a force." if few else ""


def _sensors(run: Run) -> str:
    """Return the largest and the smallest peak velocity of the sensors."""
    start, end = "sensor_", "_peak_velocity_m_s"
    seen = {key[len(start) : -len(end)]: run.number(key) or 0.0 for key in run.summary if key.endswith(end)}
    if len(seen) < 2:
        return ""
    most, least = max(seen, key=lambda name: seen[name]), min(seen, key=lambda name: seen[name])
    return f"Sensors saw at most {seen[most]:.4g} m/s ({most}) and at least {seen[least]:.4g} m/s ({least})."


def _lines(run: Run) -> list[str]:
    """Return the names of the lines of grains along which a wave was followed."""
    ending = "_front_speed_m_s"
    return [key[5 : -len(ending)] for key in run.summary if key.startswith("line_") and key.endswith(ending)]


def _line(run: Run, name: str) -> str:
    speed, decay = (run.number(f"line_{name}_{what}") for what in ("front_speed_m_s", "decay_per_m"))
    if speed is None:
        return ""
    text = f"Along the line {name} the front runs at {_four(speed)} m/s"
    if decay is None or decay <= 0:
        return f"{text}."
    return f"{text}, and the peak speed falls by half in {1e3 * np.log(2) / decay:.3g} mm."


# ---------------------------------------------------------------------- inferred forces


def _of_inference(run: Run) -> str:
    """Return how many contacts bear how large forces, how far these are off, and what they leave unexplained."""
    found, contacts, largest = (_numbers(run, key) for key in ("n_loaded_contacts", "n_contacts", "largest_force_N"))
    clear = _numbers(run, "n_significant_contacts")
    parts = []
    if found and contacts and largest:
        above = " above two standard errors" if clear else ""
        verb = "bears" if (clear or found) == [1.0] else "bear"
        parts.append(
            f"{_span(clear or found, 'd')} of {_span(contacts, 'd')} contacts {verb} a force{above}, at most "
            f"{_span(largest, '.4g')} N."
        )
    noise, true = _numbers(run, "noise"), _numbers(run, "true_force_error")
    if true:
        of_noise = f", for noise of {_span([100 * one for one in noise], '.3g')} %" if any(noise) else ""
        parts.append(f"These forces are off by {_error(true)} of the true ones{of_noise}.")
    elif errors := _numbers(run, "standard_error_fraction"):
        parts.append(f"Their standard error is {_error(errors)} of the forces.")
    else:
        parts.append("Their standard errors are not known, for no noise is given.")
    residual = _numbers(run, "residual_fraction")
    if residual:
        parts.append(f"What these forces leave unexplained is {_error(residual)} of the data.")
    return " ".join(parts)


def _numbers(run: Run, key: str) -> list[float]:
    """Return the numbers of a value of the summary, of all instants; empty without any."""
    value = run.summary.get(key)
    values = value if isinstance(value, list) else [value]
    return [float(one) for one in values if isinstance(one, int | float) and not isinstance(one, bool)]


def _span(values: Sequence[float], form: str) -> str:
    low, high = (format(round(one) if form == "d" else one, form) for one in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def _error(values: Sequence[float]) -> str:
    """Return shares in per cent, with two digits; rounding is none."""
    return f"{_span([100 * one for one in values], '.2g')} %" if max(values) > _EXACT else "less than 1e-7 %"


# ---------------------------------------------------------------------- small waves


def _of_bands(run: Run) -> str:
    gap, width = run.summary.get("widest_gap_Hz"), run.number("widest_gap_relative")
    top, decay = run.number("highest_frequency_Hz"), run.number("attenuation_in_widest_gap")
    plane, speeds = run.number("attenuation_spacing_m"), _numbers(run, "speeds_m_s")
    parts = []
    if isinstance(gap, list) and width is not None:
        text = f"No wave passes from {1e-3 * gap[0]:.4g} to {1e-3 * gap[1]:.4g} kHz, the widest gap ({share(width)} of "
        text += "its middle)"
        if decay is not None and plane is not None:
            text += f"; there amplitudes fall by up to {share(1 - float(np.exp(-decay)))} every {1e3 * plane:.4g} mm"
        parts.append(f"{text}.")
    else:
        parts.append("There is no gap between the bands.")
    lowest = [edges[0] for edges in run.summary.get("band_edges_Hz") or [] if edges and edges[0] is not None]
    if lowest and min(lowest) > 0:
        parts.append(f"Nothing passes below {1e-3 * min(lowest):.4g} kHz.")
    if top is not None and (run.number("n_bands") or 0) >= (run.number("n_freedoms") or 0):
        parts.append(f"Nothing passes above {1e-3 * top:.4g} kHz.")
    if speeds:
        listed = " and ".join(dict.fromkeys(f"{one:.4g}" for one in speeds))
        parts.append(f"Long waves run at {listed} m/s.")
    return " ".join(parts)


def _of_modes(run: Run) -> str:
    low, high, ratio = (
        run.number(key) for key in ("lowest_frequency_Hz", "highest_frequency_Hz", "least_participation_ratio")
    )
    count, grains = run.number("n_modes"), run.number("n_grains")
    if low is None or count is None:
        return ""
    text = f"{count:.0f} modes from {1e-3 * low:.4g}" + (f" to {1e-3 * high:.4g} kHz." if high else " kHz up.")
    if ratio is not None and grains:
        text += f" The most localised moves as {ratio * grains:.2g} of {grains:.0f} grains would alike."
    return text


def _of_transmission(run: Run) -> str:
    """Return at which frequencies the motion of the drive comes through."""
    drive = run.summary.get("drive")
    try:
        with h5py.File(run.directory / SPECTRA_FILE, "r") as file:
            names = ("frequency", "amplitude_ratio", "sensor")
            frequency, ratio, sensors = (file[f"transmission/{name}"][()] for name in names)
    except (OSError, KeyError):
        return ""
    parts = []
    for sensor, amplitude in zip(sensors, ratio.T, strict=True):
        stretches = _stretches(1e-3 * frequency, amplitude >= _PASSES)
        passes = (
            f"at least half as much as grain {drive} {stretches}" if stretches else f"less than half of grain {drive}"
        )
        peak = int(np.argmax(amplitude))
        most = f"{amplitude[peak]:.4g} times at {1e-3 * frequency[peak]:.4g} kHz"
        parts.append(f"Grain {sensor} moves {passes}, at most {most}.")
    return " ".join(parts)


def _stretches(frequency: NDArray[np.float64], passes: NDArray[np.bool_]) -> str:
    """Return where a motion passes: ``at 0.5 to 16.4 kHz``; empty where it never does."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], passes, [False]]).astype(int)))
    found = [f"{frequency[start]:.4g} to {frequency[stop - 1]:.4g}" for start, stop in edges.reshape(-1, 2)]
    if not found:
        return ""
    more = " and elsewhere" if len(found) > _MOST_STRETCHES else ""
    return f"at {', '.join(found[:_MOST_STRETCHES])} kHz{more}"


_OF_SPECTRA: dict[str, Callable[[Run], str]] = {
    "bands": _of_bands,
    "modes": _of_modes,
    "transmission": _of_transmission,
}
