"""Waves along lines of like bodies under a static force, a struck chain or the layers of a packing.

The waves found are compared with `granwave.analysis.measures.precompressed.loaded_line`: in the units of the static
state (speeds over c0, forces over F0, velocities over omega alpha0) every line of like Hertz contacts is one curve.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from granwave.analysis.measures.precompressed import loaded_line as theory
from granwave.analysis.measures.signals import Array, first_peak

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw
    from granwave.analysis.result.reader import Result
    from granwave.lammps_inputs.case.case import Case

FIRST_BEAD = 10  # from which on the crests of small pulses are followed
_DISTURBED = 1e-3  # of the largest force added: the far end has felt the wave
_STEADY = 0.01  # by which the crest may fall while its speed is measured
_FIRST_LAYER = 3  # from which on crests are followed
_FEWEST = 3  # layers
_BEFORE_END = 3  # layers left out at the bottom
_BEFORE_SIDES = 0.8  # of half the width: how deep a wave is followed in a packing with free sides
_FINE = 10  # points put between two snapshots


class Wave:
    """The wave of the struck first bead of a precompressed chain, measured far down the chain.

    Attributes
    ----------
    static, c0
        F0, N, and the speed of long waves by theory, m/s.
    velocity, reduced_velocity
        Of the struck bead, m/s, and over omega alpha0.
    last
        Contact, from 1, up to which the crest has passed before the far end felt the wave.
    window, middle
        Contacts, from 0, that the speed is from, and the one half-way between them.
    added, ratio
        Force of the crest there beyond F0, N, and F_m/F0, F_m with F0 in it.
    speed
        Of the crest there, m/s.
    steady
        The crest hardly falls there: it is a solitary wave.
    """

    def __init__(self, case: Case, law: ContactLaw, time: Array, force: Array, velocity: Array) -> None:
        """Measure it.

        Parameters
        ----------
        law
            Between two beads.
        time, force, velocity
            (n_times,), s; of the contacts, (n_times, n_contacts), N; of the beads, (n_times, n_beads), m/s.
        """
        self.case, self.velocity, self.line = case, case.load.velocity, theory.line_of(case, law)
        self.static, self.c0 = self.line.force, self.line.speed
        self.reduced_velocity = self.velocity / self.line.velocity
        added = force - self.static
        far = np.flatnonzero(np.abs(added[:, -1]) > _DISTURBED * added.max())
        until = slice(int(far[0]) if len(far) else len(time))
        self._time, self._bead_velocity = time[until], velocity[until]
        crests = np.array([first_peak(time[until], one, floor=0.5) for one in added[until].T])
        running = (crests[:, 0] < time[until][-1]) & (np.diff(crests[:, 0], prepend=-1) > 0)
        self.last = int(np.argmin(np.append(running, False)))
        if self.last < 2:
            return
        self.window = window = slice(self.last // 2, self.last)
        self.middle = (window.start + window.stop) // 2
        when, height = crests[window].T
        self.speed = self.line.spacing / float(np.polyfit(np.arange(len(when)), when, 1)[0])
        self.added = float(crests[self.middle, 1])
        self.ratio = 1 + self.added / self.static
        self.steady = float(height[-1] / height[0]) > 1 - _STEADY

    @property
    def printed(self) -> float:
        """Speed of a solitary wave of that crest by the composite source's (3), m/s."""
        return theory.printed_speed(self.case, self.static) * float(theory.solitary_speed(np.array(self.ratio)))

    @property
    def of_lattice(self) -> float:
        """Speed of the travelling wave of the lattice with that crest, m/s."""
        return self.c0 * float(theory.lattice_speed(np.array(self.ratio)))

    @property
    def long_wave_speed(self) -> float:
        """c0 by the crests of the beads' velocities, whose dispersion in a linear chain is known, m/s."""
        numbers = np.arange(FIRST_BEAD, self.last)
        times = np.array([first_peak(self._time, self._bead_velocity[:, n - 1], floor=0.5)[0] for n in numbers])
        return _speed(self.line, numbers, times)

    @property
    def linear_speed(self) -> float:
        """Speed of the crest there if the chain were linear, m/s."""
        return theory.crest_speed(self.line, np.arange(self.window.start, self.window.stop) + 1)

    @property
    def linear_ratio(self) -> float:
        """F_m/F0 at that contact if the chain were linear."""
        return 1 + 1.5 * self.reduced_velocity * float(theory.crest_force(np.array([self.middle + 1]))[0])


def speed_along_layers(result: Result, line: theory.Line) -> float:
    """c0 along the stacking of a packing, m/s; NaN where the run has too few layers, or is too short.

    The mean velocity of a layer of a periodic packing obeys the line of layers exactly as long as everything is linear,
    whichever spheres of the top layer were struck; in a packing with free sides until the wave is back from them. The
    times of its crests then give omega, and the speed of long waves.

    Parameters
    ----------
    line
        The line that the layers are.
    """
    case, time = result.case, result.frame_times
    nx, ny, nz = case.packing.size
    layer = (result["spheres/id"] - 1) // (nx * ny)
    frames = (result.frame(frame, "velocity")[:, 2] for frame in range(result.n_frames))
    mean = np.stack([np.bincount(layer, frame, nz) / (nx * ny) for frame in frames])
    deepest = nz - _BEFORE_END
    if case.boundary.sides != "periodic":
        half = min(nx, ny * np.sqrt(3) / 2) / 2
        deepest = min(deepest, int(_BEFORE_SIDES * half / theory.SPACING[case.packing.kind]))
    numbers, times = _crests(time, mean[:, :deepest])
    return _speed(line, numbers, times) if len(numbers) >= _FEWEST else np.nan


def _crests(time: Array, mean: Array) -> tuple[NDArray[np.int64], Array]:
    """Layers, from 1, that the crest of their velocities (n_times, n_layers) has passed, and when."""
    fine = np.linspace(time[0], time[-1], _FINE * (len(time) - 1) + 1)
    times = np.array([first_peak(fine, CubicSpline(time, one)(fine), floor=0.5)[0] for one in mean.T])
    numbers = np.arange(1, len(times) + 1)
    good = (numbers >= _FIRST_LAYER) & np.isfinite(times) & (times < time[-2])
    return numbers[good], times[good]


def _speed(line: theory.Line, numbers: NDArray[np.int64], times: Array) -> float:
    """c0 by the times of the crests at numbered bodies of a linear line, m/s."""
    return line.spacing / (2 * float(np.polyfit(theory.crest_times(numbers), times, 1)[0]))
