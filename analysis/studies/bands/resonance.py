"""Resonance of a bead that is pressed on a plane and shaken: its shift with the amplitude, and its jumps.

A static force F0 makes the overlap alpha0; with the motion x = alpha0 xi of the bead of mass m

    m x'' = F0 - F0 (1 + xi)^(3/2) = -k x (1 + a2 xi + a3 xi^2 + ...),   k = 3 F0/(2 alpha0),   a2 = 1/4, a3 = -1/24

and by perturbation (Landau and Lifshitz, Mechanics, 28) the frequency of vibrations of the amplitude xi is

    omega = omega0 (1 + (3/8 a3 - 5/12 a2^2) xi^2) = omega0 (1 - xi^2/24)

on which the velocity of a weakly damped bead has its largest values. Rows of the scans are compared with it. Above some
force the answer has three branches, two of which are stable: the bead jumps.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import Drawing, legend_above
from granwave.analysis.measures.driven.amplitude_sweep import AmplitudeSweep, amplitude_sweep_of
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.contact.law import flat_contact

TITLE = "Resonance of a bead on a plane"
TEXT = (
    "A bead under a static force, shaken at frequencies about its own. The frequency of the largest velocity falls as "
    "the square of the amplitude; where losses are small, the amplitude jumps as the load rises and falls."
)
_SHIFT = -1 / 24  # of the frequency, for an amplitude of the static overlap
_LEAST = 3  # frequencies, for a largest value


class Shaken(FinishedRun):
    """A run of a bead that is shaken."""

    @cached_property
    def overlap(self) -> float:
        """Static overlap, m."""
        law = flat_contact(self.case, 1)
        stage = self.case.precompression
        assert stage is not None and stage.force is not None
        return (stage.force / (4 / 3 * law.effective_modulus * math.sqrt(law.effective_radius))) ** (2 / 3)

    @cached_property
    def own_frequency(self) -> float:
        """Frequency of small vibrations, Hz."""
        stage = self.case.precompression
        assert stage is not None and stage.force is not None
        return math.sqrt(1.5 * stage.force / self.overlap / self.case.sphere_mass) / (2 * math.pi)

    @property
    def velocity(self) -> float:
        """Amplitude of the velocity, m/s."""
        return float(self.value("driven_velocity_m_s") or 0.0)

    @cached_property
    def sweep(self) -> AmplitudeSweep | None:
        """Answer to a load that rises and falls."""
        with Result(self.directory) as result:
            return amplitude_sweep_of(result)


def select(runs: Sequence[FinishedRun]) -> list[list[Shaken]]:
    """Single beads under a static force that are shaken by a force."""
    found = [run.seen_as(Shaken) for run in runs if _fits(run)]
    return [found] if found else []


def _fits(run: FinishedRun) -> bool:
    case = run.case
    stage = case.precompression
    return (
        case.packing.kind == "chain"
        and case.packing.size[0] == 1
        and case.contact.law == "hertz"
        and case.boundary.bottom == "wall"
        and stage is not None
        and stage.kind == "uniaxial"
        and stage.force is not None
        and case.load.kind == "force"
        and case.load.shape in ("harmonic", "up-and-down")
    )


def peaks(runs: Sequence[Shaken]) -> list[tuple[float, float, float]]:
    """Return force, N, frequency over the own one, and amplitude over the overlap, at each largest velocity."""
    found = []
    for force in sorted({run.case.load.amplitude or 0.0 for run in runs if run.case.load.shape == "harmonic"}):
        same = [one for one in runs if one.case.load.amplitude == force and one.case.load.shape == "harmonic"]
        same.sort(key=lambda one: one.case.load.frequencies[1])
        frequency = np.array([one.case.load.frequencies[1] for one in same])
        velocity = np.array([one.velocity for one in same])
        top = int(np.argmax(velocity))
        if len(same) < _LEAST or not 0 < top < len(same) - 1:
            continue
        curve = np.polyfit(frequency[top - 1 : top + 2] - frequency[top], velocity[top - 1 : top + 2], 2)
        shift = -curve[1] / (2 * curve[0])
        at, largest = frequency[top] + shift, float(np.polyval(curve, shift))
        found.append((force, at / same[0].own_frequency, largest / (2 * math.pi * at * same[0].overlap)))
    return found


def rows(runs: Sequence[Shaken]) -> Iterator[Row]:
    """Frequencies of the largest velocities, their shift over the square of the amplitude, and jumps."""
    found = peaks(runs)
    own = runs[0].own_frequency
    for force, frequency, amplitude in found:
        note = f"amplitude {amplitude:.3f} of the static overlap"
        quantity = f"Bead on a plane, {force:g} N: frequency of the largest velocity"
        yield Row(quantity, "Hz", None, frequency * own, note, "", own * (1 + _SHIFT * amplitude**2), True)
    if len(found) > 1:
        square, shift = np.array([one[2] ** 2 for one in found]), np.array([one[1] - 1 for one in found])
        slope = float(np.polyfit(square, shift, 1)[0])
        quantity = "Bead on a plane: shift of the resonance over the square of the amplitude"
        yield Row(quantity, "", None, slope, "amplitudes over the static overlap", "", _SHIFT, True)
    for run in runs:
        if run.sweep is not None:
            where = f"{run.case.load.frequencies[1] / own:.3f} of its frequency"
            quantity = f"Bead on a plane, shaken at {where}: hysteresis of its amplitude"
            yield Row(quantity, "", None, run.sweep.apart, "", "Beside a load that rises and falls slowly.")


def pictures(runs: Sequence[Shaken]) -> Iterator[Picture]:
    """Velocity against frequency for each force, with the backbone; and against a force that rises and falls."""
    steady = [run for run in runs if run.case.load.shape == "harmonic"]
    if steady:
        figure, axes = panels(2.7)
        columns: dict[str, Array] = {}
        for force in sorted({run.case.load.amplitude or 0.0 for run in steady}):
            same = sorted((one for one in steady if one.case.load.amplitude == force), key=_frequency)
            x = np.array([_frequency(one) / one.own_frequency for one in same])
            y = np.array([one.velocity / (2 * math.pi * _frequency(one) * one.overlap) for one in same])
            axes.plot(x, y, ".-", label=f"{force:g} N", linewidth=0.8)
            columns |= {f"frequency_{force:g}N": x, f"amplitude_{force:g}N": y}
        size = np.linspace(0, max(float(one.max()) for name, one in columns.items() if "amplitude" in name), 50)
        axes.plot(1 + _SHIFT * size**2, size, "k--", linewidth=0.8, label="theory")
        columns |= {"theory_frequency": 1 + _SHIFT * size**2, "theory_amplitude": size}
        label(axes, "Frequency over that of small vibrations", "Amplitude over the static overlap")
        legend_above(axes, 2)
        yield Picture("_resonance", "Answer to a harmonic force, and the backbone of perturbation theory (dashed)",
                      Drawing(figure, columns))  # fmt: skip
    swept = [(run, run.sweep) for run in runs if run.sweep is not None]
    if swept:
        figure, axes = panels(2.7)
        columns = {}
        for number, (run, sweep) in enumerate(swept):
            x, y = sweep.load, sweep.first[0] / (2 * math.pi * _frequency(run) * run.overlap)
            name = f"{_frequency(run) / run.own_frequency:.3f}"
            for chosen, line in ((sweep.rising, "-"), (~sweep.rising, "--")):
                axes.plot(x[chosen], y[chosen], line, color=f"C{number}", linewidth=0.9,
                          label=f"f/f0 = {name}" if line == "-" else None)  # fmt: skip
            columns |= {f"force_N_{name}": x, f"amplitude_{name}": y, f"rising_{name}": sweep.rising.astype(int)}
        label(axes, "Amplitude of the force (N), dashed: falling", "Amplitude over the static overlap")
        legend_above(axes, 2)
        yield Picture("_jumps", "Answer to a force that rises (solid) and falls (dashed)", Drawing(figure, columns))


def _frequency(run: Shaken) -> float:
    return run.case.load.frequencies[1]
