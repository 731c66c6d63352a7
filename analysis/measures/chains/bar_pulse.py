"""A pulse in a slender elastic bar: speed, shape, impedance and energy (thesis 3.2.1).

A pulse F(t) that enters a slender bar goes on unchanged at c = sqrt(E/rho); force over velocity is Z = A sqrt(E rho)
and its energy is the integral of F^2/Z. Two-node elements of length h with lumped masses carry a wave number q at the
frequency (2c/h) sin(qh/2) instead of cq, so that what is short beside h lags behind, and a front spreads over a
length of (c t h^2/8)^(1/3) (Airy). Hence the error of the shape falls with h^(2/3) where the pulse has a kink, as a
half-sine has at its ends, and not at all at a step, which overshoots by 27 %. The pulse's centroid moves at c on
every mesh.

What enters the incident bar is the load, what enters the other one is its contact force.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from functools import cached_property

import numpy as np

from granwave.analysis.measures.chains.record import ChainRecord
from granwave.analysis.measures.signals import Array, arrival
from granwave.lammps_inputs.packing.bars import BAR, INCIDENT_BAR, PlacedBar

_NEAR, _FAR = 0.25, 0.75  # sections, in lengths of the bar from where the pulse enters
_HALF = 0.5  # of a pulse, whose passing is its arrival
_AHEAD = 3.0  # widths of a front, that it is felt before it comes
_THROUGH = 0.02  # of its largest force: a pulse below has passed
_FINER = 20  # times the instants of the history, for integrals of the load


@dataclasses.dataclass(frozen=True, eq=False)
class Passage:
    """Wave that entered a bar, and its passage of two sections before any reflection.

    Attributes
    ----------
    time
        Of the history: (n_times,), s.
    entered
        Force at the end where it enters, N, at given times.
    sections
        Distances of two sections from that end, m.
    force, velocity
        At both: (2, n_times), N, m/s away from that end; NaN from the first echo on.
    energy
        In the bar at the end of the run over that of the pulse that entered until then.
    """

    run: ChainRecord
    bar: PlacedBar
    time: Array
    entered: Callable[[Array], Array]
    sections: tuple[float, float]
    force: Array
    velocity: Array
    energy: float

    @property
    def impedance(self) -> float:
        """A sqrt(E rho), N s/m."""
        return impedance(self.bar)

    @cached_property
    def peak(self) -> float:
        """Largest force that entered, N."""
        return float(self.entered(self.time).max())

    @property
    def speed(self) -> float:
        """Between the sections: of the centroid of a pulse that passed both, else of its rise through half, m/s.

        NaN where nothing reached one of them.
        """
        forces = [force[np.isfinite(force)] for force in self.force]
        times = [self.time[: len(force)] for force in forces]
        if not all(force.any() for force in forces):
            return math.nan
        if all(abs(force[-1]) < _THROUGH * self.peak for force in forces):
            near, far = (float(t @ force / force.sum()) for t, force in zip(times, forces, strict=True))
        else:
            near, far = (arrival(t, force, _HALF * self.peak) for t, force in zip(times, forces, strict=True))
        return (self.sections[1] - self.sections[0]) / (far - near)

    @property
    def measured_impedance(self) -> float:
        """Force over velocity at the far section, by least squares, N s/m."""
        force, velocity = (values[1][np.isfinite(self.force[1])] for values in (self.force, self.velocity))
        return float(force @ velocity / (velocity @ velocity))

    @property
    def deviation(self) -> float:
        """Largest difference at the far section from the pulse that entered, late by x/c, over the pulse's peak."""
        return float(np.nanmax(np.abs(self.force[1] - self.late(1))) / self.peak)

    @property
    def overshoot(self) -> float:
        """Largest force at the far section over the largest that entered."""
        return float(np.nanmax(self.force[1]) / self.peak)

    @property
    def errors(self) -> dict[str, float]:
        """Errors against the closed forms."""
        return {
            "speed": abs(self.speed / self.bar.wave_speed - 1),
            "impedance": abs(self.measured_impedance / self.impedance - 1),
            "shape": self.deviation,
            "energy": abs(self.energy - 1),
        }

    def late(self, section: int) -> Array:
        """The pulse that entered, as it would pass a section in a perfect bar: (n_times,), N."""
        return self.entered(self.time - self.sections[section] / self.bar.wave_speed)


def passage(run: ChainRecord, bar: PlacedBar) -> Passage:
    """Return the wave through a bar of a recorded run."""
    time = run.time
    place, force, velocity = (run.array(f"bars/{bar.name}/{name}") for name in ("position", "force", "velocity"))
    velocity = 0.5 * (velocity[:, 1:] + velocity[:, :-1])  # of elements
    depth = 0.5 * (place[1:] + place[:-1]) - place[0]
    if bar.name == INCIDENT_BAR:
        energy = run.value("energy_input_J")
        instants = np.linspace(0, time[-1], _FINER * len(time))
        values = run.case.load.at(instants)
    else:
        energy = run.value(f"energy_{BAR}_J")
        instants, values = (run.array(f"walls/{bar.name}/{name}") for name in ("time", "force"))

    def entered(at: Array) -> Array:
        if bar.name == INCIDENT_BAR:
            return run.case.load.at(at)
        return np.interp(at, instants, values, left=0.0)

    elements = [int(np.abs(depth - share * bar.section.length).argmin()) for share in (_NEAR, _FAR)]
    sections = depth[elements]
    start = instants[max(0, int((values != 0).argmax()) - 1)]
    length = bar.section.length
    ahead = _AHEAD * (2 * length * bar.pitch**2 / 8) ** (1 / 3)
    clear = np.stack([time < start + (2 * length - ahead - x) / bar.wave_speed for x in sections])
    closed = float(np.trapezoid(values**2, instants)) / impedance(bar)
    return Passage(
        run, bar, time, entered, (float(sections[0]), float(sections[1])),
        np.where(clear, force[:, elements].T, np.nan), np.where(clear, velocity[:, elements].T, np.nan),
        energy / closed if closed else np.nan,
    )  # fmt: skip


def impedance(bar: PlacedBar) -> float:
    """A sqrt(E rho), N s/m."""
    return bar.section.area * float(np.sqrt(bar.material.youngs_modulus * bar.material.density))
