"""Figures of chains: forces of contacts, peaks, velocities of beads, bars and sensors."""

from __future__ import annotations

import dataclasses
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from granwave.analysis.figures.series import (
    LINES,
    against_time,
    are_relative,
    energy_unit,
    label,
    label_log_axis,
    panels,
    scale_by_peaks,
    velocity_unit,
)
from granwave.analysis.figures.style import (
    BLUE,
    GREY,
    Drawing,
    legend_above,
)
from granwave.analysis.formatting.numbers import instant, quantity_in
from granwave.analysis.measures.dynamic_force import BEFORE_END
from granwave.analysis.measures.leading_wave import FirstWave, first_wave, known_peaks
from granwave.analysis.measures.lines import sensor_forces
from granwave.analysis.measures.signals import maxima
from granwave.analysis.result.reader import Result

_KILO = 1e-3
_MOST_CURVES = 5
_ABOVE_ONE = 1.05  # end of the axis of relative forces
_N_INSTANTS = 4
_FRONT = 0.5  # fraction of the largest speed of a bead: earlier maxima are not the front
_LEAST_SPEED = 1e-3  # fraction of the largest speed: beads that the front has reached
_FEWEST = 2  # fewest contacts along which forces are drawn
_SAME = 1e-3  # relative difference of equal forces
_LEAST_FORCE = 1e-4  # fraction of the largest force: contacts that the wave reached
_WIDE_FORCES = 30.0  # largest over smallest value from which on an axis is logarithmic


def force_histories(result: Result) -> Drawing | None:
    """Draw the force histories of some of the contacts that the wave reached, evenly spaced along
    the chain. If their peaks differ much, each is divided by its peak, which the legend gives.
    """
    if "chain" not in result:
        return None
    force = result["chain/contact_force"]
    time = result["chain/time"]
    peaks = force.max(axis=0, initial=0.0)
    loaded = np.flatnonzero((peaks > 0) & (peaks >= _LEAST_FORCE * peaks.max(initial=0.0)))
    if not len(loaded):
        return None
    chosen = np.unique(
        np.linspace(0, loaded[-1], min(_MOST_CURVES, loaded[-1] + 1)).round().astype(int)
    )
    figure, axes = panels(2.9)
    scale, unit = _unit(force)
    is_relative = are_relative(peaks[chosen])
    for n, line in zip(chosen, LINES, strict=False):
        name = _name(result, n)
        size = scale
        if is_relative:
            name = f"{name}: {quantity_in(float(peaks[n]), 'N')}"
            size = 1 / peaks[n] if peaks[n] > 0 else 0.0
        against_time(axes, time, force[:, n] * size, line, label=name, linewidth=0.9)
    if is_relative:
        label(axes, y="Contact force / its peak", ylim=(0, _ABOVE_ONE))
        legend_above(axes, 2, title="Contact: peak force")
    else:
        label(axes, y=f"Contact force ({unit})")
        scale_by_peaks(axes, scale * peaks[chosen])
        legend_above(axes, 3, title="Contact")
    return Drawing(
        figure, {"time_s": time} | {f"contact_{_name(result, n)}_N": force[:, n] for n in chosen}
    )


def along_chain(result: Result) -> Drawing | None:
    """Draw peak force and dissipated energy of every contact along the chain.

    The forces are those of the first wave, before the reflection from the end, above the static
    force; open circles are contacts at which a larger pulse may still arrive, open squares contacts
    at which a larger force followed, and triangles contacts whose force still rose when the
    reflection came, or the run ended. Grey marks are the largest forces of the run where they are
    larger. Under a load that keeps oscillating they are the largest of the run only. None for a
    single contact.
    """
    if "chain" not in result:
        return None
    peak = result.along_chain("peak_force")
    lost = result.along_chain("dissipated_energy")
    if len(peak) < _FEWEST or not np.any(peak):
        return None
    number = np.arange(1, len(peak) + 1)
    is_first = not result.case.load.keeps_oscillating
    wave = first_wave(result) if is_first else None
    has_panel_of_loss = bool(np.any(lost > 0))
    n_panels = 1 + has_panel_of_loss
    figure, upper, *lower = panels(1.0 + 1.4 * n_panels, rows=n_panels, sharex=True)
    _draw_peaks_along(upper, result, wave)
    for axes in lower:
        energy, name = energy_unit(float(lost.max()))
        _dots(axes, number, lost * energy, "dissipated")
        _scale_axis(axes, lost * energy, f"Dissipated ({name})")
    label(figure.axes[-1], f"Contact, {_counted(result)}")
    figure.axes[-1].xaxis.set_major_locator(MaxNLocator("auto", integer=True))
    ids = {"i": result["chain/contact_i"], "j": result["chain/contact_j"]}
    columns = {"contact": number, **ids, "peak_force_N": peak, "dissipated_energy_J": lost}
    if wave is not None:
        columns["first_wave_peak_force_N"] = known_peaks(wave)
        columns["first_wave_is_passing"] = wave.is_passing.astype(int)
        columns["first_wave_recorded_force_N"] = wave.peak
    return Drawing(figure, columns)


def words_along_chain(result: Result, _: Path) -> tuple[str, str]:
    """Return caption and look of `along_chain` with only the marks and panels of this run."""
    is_first = not result.case.load.keeps_oscillating
    peaks = _peaks_along(result, first_wave(result) if is_first else None)
    caption = "Peak force of the first wave" if is_first else "Largest force of the run"
    if np.any(peaks.static > 0):
        caption += " above the static force"
    if np.any(result.along_chain("dissipated_energy") > 0):
        caption += ", and dissipation,"
    caption += " along the chain"
    if is_first and np.any(peaks.differs):
        caption += "; crosses: larger forces later in the run"
    look = "Constant values: no decay."
    if np.any(peaks.may_follow):
        look += (
            " Open circles: a larger pulse may follow, after the reflection or the end of the run."
        )
    if np.any(peaks.followed):
        look += " Open squares: a larger force (cross) followed, with or after the reflection."
    if np.any(peaks.rising > 0):
        look += f" Triangles: the first wave still rose when the {_end_of_wave(peaks)}."
    return caption, look


def _end_of_wave(peaks: _PeaksAlong) -> str:
    """Return the end of the record of the first wave in words."""
    return "reflection came" if peaks.is_reflected else "run ended"


@dataclasses.dataclass(frozen=True)
class _PeaksAlong:
    """Peak forces of the contacts along a chain above the static force, N: (n_contacts,); 0 where
    there is no value.

    Attributes
    ----------
    whole
        Of the run.
    known
        Of the first wave.
    passing
        Of the first wave, where a larger pulse may follow.
    rising
        Of the first wave so far, where the force still rises at the end of its record.
    static
        Force before the load.
    is_reflected
        True if the record of the first wave ends with the reflection, False if with the run.
    """

    whole: NDArray[np.float64]
    known: NDArray[np.float64]
    passing: NDArray[np.float64]
    rising: NDArray[np.float64]
    static: NDArray[np.float64]
    is_reflected: bool

    @property
    def differs(self) -> NDArray[np.bool_]:
        """True where the largest force of the run is larger than the known one: (n_contacts,)."""
        return self.whole > (1 + _SAME) * self.known

    @property
    def followed(self) -> NDArray[np.bool_]:
        """True where a larger force followed a first pulse that is not known to be the largest:
        (n_contacts,).
        """
        return (self.passing > 0) & (self.whole > (1 + _SAME) * self.passing)

    @property
    def may_follow(self) -> NDArray[np.bool_]:
        """True where a larger pulse may follow, and did not follow in the run: (n_contacts,)."""
        return (self.passing > 0) & ~self.followed


def _peaks_along(result: Result, wave: FirstWave | None) -> _PeaksAlong:
    """Return the peak forces along a chain.

    Parameters
    ----------
    wave
        None under a load that keeps oscillating.
    """
    peak = result.along_chain("peak_force")
    has_risen = result.along_chain("time_peak") < BEFORE_END * float(result["energy/time"][-1])
    static = np.zeros(len(peak))
    if result.case.precompression is not None:
        static = result["chain/contact_force"][0]
    whole = np.where(has_risen, peak - static, 0.0)
    least = _LEAST_FORCE * whole.max(initial=0.0)
    whole = np.where(whole > least, whole, 0.0)
    known = np.zeros(len(peak))
    passing = np.zeros(len(peak))
    rising = np.zeros(len(peak))
    is_reflected = wave is not None and wave.reflection is not None
    if wave is not None:
        is_reached = wave.peak > least
        known = np.where(wave.is_known, wave.peak, 0.0)
        passing = np.where(wave.is_passing & is_reached, wave.peak, 0.0)
        is_rising = ~(wave.is_known | wave.is_passing)
        rising = np.where(is_rising & is_reached, wave.peak, 0.0)
    return _PeaksAlong(whole, known, passing, rising, static, is_reflected)


def _draw_peaks_along(axes: Axes, result: Result, wave: FirstWave | None) -> None:
    """Draw the peak forces of the first wave along a chain, and of the run where they differ.

    Parameters
    ----------
    wave
        None under a load that keeps oscillating.
    """
    peaks = _peaks_along(result, wave)
    scale, unit = _unit(result.along_chain("peak_force"))
    number = np.arange(1, len(peaks.whole) + 1)
    differs = peaks.differs
    if np.any(differs):
        look: Any = {"color": GREY, "markersize": 3, "label": "largest of the run"}
        axes.plot(number[differs], peaks.whole[differs] * scale, "x", **look)
    if np.any(peaks.known > 0):
        _dots(axes, number, peaks.known * scale, "first wave")
    for forces, shown, marker, name in (
        (peaks.passing, peaks.may_follow, "o", "larger pulse may follow"),
        (peaks.passing, peaks.followed, "s", "larger force followed"),
        (peaks.rising, peaks.rising > 0, "^", "still rising"),
    ):
        if np.any(shown):
            look = {"color": BLUE, "markerfacecolor": "none", "markersize": 3, "label": name}
            axes.plot(number[shown], forces[shown] * scale, marker, **look)
    kind = "Dynamic peak force" if np.any(peaks.static > 0) else "Peak force"
    highest = np.maximum.reduce([peaks.whole, peaks.known, peaks.passing, peaks.rising])
    _scale_axis(axes, highest * scale, f"{kind} ({unit})")
    legend_above(axes, 2)


def _dots(axes: Axes, number: NDArray, values: NDArray[np.float64], name: str) -> None:
    """Draw positive values of contacts as dots."""
    shown = values > 0
    axes.plot(number[shown], values[shown], ".", color=BLUE, markersize=3, label=name)


def _scale_axis(axes: Axes, values: NDArray[np.float64], quantity: str) -> None:
    """Make an axis logarithmic if its positive values span much, otherwise linear from 0."""
    positive = values[values > 0]
    is_wide = len(positive) and positive.max() > _WIDE_FORCES * positive.min()
    label(axes, y=quantity)
    if is_wide:
        axes.set_yscale("log")
        lowest, highest = axes.get_ylim()
        label_log_axis(axes, highest / lowest)
    else:
        axes.set_ylim(0, 1.05 * float(values.max()))


def bead_velocities(result: Result) -> Drawing | None:
    """Draw the velocity along the chain at up to four instants of the passage of the front: when
    the velocity of the bead at a quarter, a half, three quarters and the end of its way is first
    largest. Under a load that keeps oscillating, at four even instants.
    """
    if "chain" not in result:
        return None
    time = result["chain/time"]
    velocity = result["chain/velocity"]
    passed = _instants_of_front(result)
    if not passed:
        chosen = np.unique(np.linspace(0, len(time) - 1, _N_INSTANTS + 1).round().astype(int))[1:]
        passed = dict.fromkeys(chosen.tolist(), "")
    figure, axes = panels(2.6)
    bead = np.arange(1, velocity.shape[1] + 1)
    rows = list(passed)
    scale, unit = velocity_unit(float(np.abs(velocity[rows]).max(initial=0.0)))
    for (n, which), line in zip(passed.items(), LINES, strict=False):
        name = instant(time[n]) + which
        axes.plot(bead, velocity[n] * scale, linestyle=line, linewidth=0.9, label=name)
    axes.axhline(0, color="black", linewidth=0.5)
    label(axes, f"Bead, {_counted(result)}", f"Velocity ({unit})")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    legend_above(axes, 2)
    return Drawing(
        figure, {"bead": bead} | {f"velocity_at_{time[n]:.6g}_s_m_s": velocity[n] for n in rows}
    )


def _instants_of_front(result: Result) -> dict[int, str]:
    """Return the records at which the front is at a bead, with the words of the bead, for up to
    four beads on its way; empty under a load that keeps oscillating, and without a front.

    The front is at a bead when its speed is first largest, before the reflection.
    """
    if result.case.load.keeps_oscillating or not len(result["chain/contact_i"]):
        return {}
    time = result["chain/time"]
    start = first_wave(result).reflection
    n_rows = len(time) if start is None else int(np.searchsorted(time, start, side="right"))
    speed = np.abs(result["chain/velocity"][:n_rows])
    if not speed.any():
        return {}
    largest = speed.max(axis=0)
    crests = [maxima(one, _FRONT * float(one.max())) for one in speed.T]
    is_passed = np.array([len(crest) > 0 for crest in crests]) & (
        largest > _LEAST_SPEED * largest.max()
    )
    passed = np.flatnonzero(is_passed)
    if len(passed):
        first = min(passed.tolist(), key=lambda bead: int(crests[bead][0]))
        passed = passed[passed >= first]
    if len(passed) < _N_INSTANTS:
        return {}
    way = np.arange(1, _N_INSTANTS + 1) / _N_INSTANTS
    beads = passed[np.ceil(way * len(passed)).astype(int) - 1]
    return {int(crests[bead][0]): f", bead {bead + 1}" for bead in beads.tolist()}


def bars(result: Result) -> Drawing | None:
    """Draw the contact force on each bar, and its energy."""
    bars_of_run = result.assembly.bars
    if not bars_of_run:
        return None
    figure, upper, lower = panels(3.4, rows=2, sharex=True)
    columns: dict[str, NDArray] = {"energy_time_s": result["energy/time"]}
    forces = {bar.name: result[f"walls/{bar.name}/force"] for bar in bars_of_run}
    energies = {bar.name: result[f"energy/{bar.name}"] for bar in bars_of_run}
    scale, unit = _unit(np.array([np.max(force, initial=0.0) for force in forces.values()]))
    joules, energy_name = energy_unit(
        max(float(np.max(energy, initial=0.0)) for energy in energies.values())
    )
    for (name, force), line in zip(forces.items(), cycle(LINES), strict=False):
        time = result[f"walls/{name}/time"]
        energy = energies[name]
        against_time(upper, time, force * scale, line, linewidth=0.9)
        shown = name.replace("_", " ")
        against_time(lower, result["energy/time"], energy * joules, line, label=shown)
        columns |= {
            f"{name}_time_s": time,
            f"{name}_contact_force_N": force,
            f"{name}_energy_J": energy,
        }
    label(upper, y=f"Contact force\non the bar ({unit})")
    label(lower, y=f"Energy in the bar ({energy_name})")
    lower.legend()
    return Drawing(figure, columns)


def words_on_bars(result: Result, _: Path) -> tuple[str, str]:
    """Return caption and look of `bars` with the time in which a pulse crosses each bar twice."""
    returns = [
        f"{instant(2 * bar.section.length / bar.wave_speed)} ({bar.name.replace('_', ' ')})"
        for bar in result.assembly.bars
    ]
    return (
        "Bars: contact force and energy",
        "Each peak is a pulse at the contact with the chain. A pulse in a bar returns from the far "
        f"end after {' and '.join(returns)}; other peaks come from the chain.",
    )


def sensors(result: Result) -> Drawing | None:
    """Draw the mean contact force of the beads with a sensor."""
    if "chain" not in result or not result.case.sensor:
        return None
    time = result["chain/time"]
    forces = sensor_forces(result)
    scale, unit = _unit(np.stack(list(forces.values())))
    figure, axes = panels(2.2)
    for (name, force), line in zip(forces.items(), cycle(LINES), strict=False):
        against_time(axes, time, force * scale, line, label=name, linewidth=0.9)
    label(axes, y=f"Sensor force ({unit})")
    axes.legend()
    return Drawing(
        figure, {"time_s": time} | {f"{name}_N": force for name, force in forces.items()}
    )


def _name(result: Result, contact: int) -> str:
    """Return the label of a contact from the labels of its bodies, such as ``3-4``."""
    first = _name_of_body(result, int(result["chain/contact_i"][contact]))
    second = _name_of_body(result, int(result["chain/contact_j"][contact]))
    return f"{first}-{second}"


def _name_of_body(result: Result, number: int) -> str:
    """Return the number of a bead, ``S`` with its number for a striker, or ``bar``."""
    n_beads = result.assembly.lattice.n_spheres
    if number <= n_beads:
        return str(number)
    if number <= result.assembly.n_spheres:
        return f"S{number - n_beads}"
    return "bar"


def _counted(result: Result) -> str:
    """Return the end from which contacts and beads are counted."""
    return f"from the {'loaded' if result.case.load.driven else 'impacted'} end"


def _unit(force: NDArray[np.float64]) -> tuple[float, str]:
    return (_KILO, "kN") if np.max(force, initial=0.0) >= 1e4 else (1.0, "N")
