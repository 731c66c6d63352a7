"""Rectification and switching by a row with a light bead: power through it against the amplitude of its drive.

A row under a static force does not pass frequencies above its cut-off f_c. A light bead near one end has a mode of its
own above f_c. A drive between the two excites it if it is near, the more the larger the motion, for Hertz's contacts
soften; above some amplitude this motion is not stable, and feeds two frequencies that the row passes and whose sum is
that of the drive. From the other end the drive hardly reaches the light bead, and the row stays shut up to a larger
amplitude (Boechler, Theocharis, Daraio, Nature Materials 10, 665, 2011). Small amplitudes: the steady response of the
static state with its losses and dampers, whose power goes as the square of the amplitude.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import Drawing, legend_above
from granwave.analysis.measures.driven.transmission import motion_of
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result
from granwave.analysis.spectra.bands import solve_modes
from granwave.analysis.spectra.states import packing_state
from granwave.analysis.spectra.stiffness import stiffness_of
from granwave.analysis.spectra.transmission import dampers_of, losses_of, transmission
from granwave.analysis.studies.runs import FinishedRun, grouped, rising
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.contact.static_load import force_of_contact, static_stiffness

TITLE = "Row with a light bead: rectification and switching"
TEXT = (
    "A row under a static force with a light bead near one end, driven at its first bead at a frequency that the row "
    "does not pass. The mean power that its absorbing end takes in the last half of each run is drawn against the "
    "amplitude of the drive, with the light bead near the drive and near the other end. Dashed: the steady response of "
    "small motions, with the losses of contacts. Next to the amplitude at which the row opens, what opens it "
    "grows or dies so slowly that the mean is that of a state which still changes."
)
_Z = 2
_OPEN = 10.0  # power over that of small motions: above it the row has switched


class Driven(FinishedRun):
    """A run of a row that is driven by a displacement."""

    @property
    def amplitude(self) -> float:
        """Amplitude of the drive, m."""
        return self.case.load.amplitude or 0.0

    @property
    def frequency(self) -> float:
        """Frequency of the drive, Hz."""
        return self.case.load.frequencies[1]

    @property
    def through(self) -> float:
        """Mean power that the end takes, W."""
        return self.value("absorbed_power_W")

    @cached_property
    def light(self) -> int:
        """Id of the lightest bead."""
        return min(range(1, self.assembly.lattice.n_spheres + 1), key=self.assembly.mass_of)

    @property
    def near(self) -> bool:
        """True if the light bead is nearer to the drive than to the other end."""
        return 2 * self.light <= self.assembly.lattice.n_spheres

    @property
    def overlap(self) -> float:
        """Static overlap of two like beads, m."""
        return 1.5 * force_of_contact(self.assembly) / static_stiffness(self.assembly)

    @property
    def cut_off(self) -> float:
        """Highest frequency that the row passes without its light bead, Hz."""
        return math.sqrt(static_stiffness(self.assembly) / self.case.sphere_mass) / math.pi

    @cached_property
    def of_small(self) -> float:
        """Power through the row over the square of the amplitude, for small motions, W/m^2."""
        network = packing_state(self.case).network
        dampers = dampers_of(self.assembly, network)
        damped = np.flatnonzero(dampers[:, _Z] > 0)
        found = transmission(
            stiffness_of(network), 1, network.ids[damped].tolist(), np.array([self.frequency]), dampers=dampers,
            losses=losses_of(self.assembly, network),
        )  # fmt: skip
        velocity = 2 * math.pi * self.frequency * found.amplitude[0]
        return float(np.sum(dampers[damped, _Z] * velocity**2) / 2)

    @cached_property
    def mode(self) -> float:
        """Frequency of the mode of the light bead, with the driven and the last bead held, Hz."""
        network = packing_state(self.case).network
        moves = network.moves.copy()
        moves[np.isin(network.ids, (1, self.assembly.lattice.n_spheres))] = False
        return float(solve_modes(stiffness_of(dataclasses.replace(network, moves=moves))).frequency[-1])

    @cached_property
    def below(self) -> float:
        """Share of the last bead's motion at frequencies below the cut-off, in the last half; NaN if not recorded."""
        with Result(self.directory) as result:
            found = motion_of(result)
        if found is None:
            return math.nan
        _, time, velocity = found
        last = velocity[time >= time[-1] / 2, -1]
        power = np.abs(np.fft.rfft((last - last.mean()) * np.hanning(len(last)))) ** 2
        frequency = np.fft.rfftfreq(len(last), (time[-1] - time[0]) / (len(time) - 1))
        return float(power[frequency < self.cut_off].sum() / power.sum())

    @property
    def gain(self) -> float:
        """Power through the row over that of small motions of this amplitude."""
        return self.through / (self.of_small * self.amplitude**2)


def select(runs: Sequence[FinishedRun]) -> list[list[Driven]]:
    """Rows with a light bead that differ in its place and in the amplitude alone, at least two of them."""
    found = grouped((run.seen_as(Driven) for run in runs if _fits(run)), "load.amplitude", "replace")
    return [group for group in found if len(group) > 1]


def _fits(run: FinishedRun) -> bool:
    case = run.case
    load = case.load
    return (
        case.packing.kind == "chain"
        and case.contact.law == "hertz"
        and case.precompression is not None
        and case.precompression.force is not None
        and (load.kind, load.shape, load.index) == ("displacement", "harmonic", None)
        and len(case.replace) > 0
        and len(case.absorb) > 0
        and case.boundary.bottom_support is None
        and math.isfinite(run.value("absorbed_power_W"))
    )


def sides(runs: Sequence[Driven]) -> dict[str, list[Driven]]:
    """Return the runs with the light bead near the drive, and near the other end, in rising order of amplitude."""
    found = {
        "near the drive": [one for one in runs if one.near],
        "at the far end": [one for one in runs if not one.near],
    }
    return {name: rising(same, lambda one: one.amplitude) for name, same in found.items() if same}


def switch(same: Sequence[Driven]) -> tuple[float, float] | None:
    """Return the amplitudes, m, between which the power rises the most over that of small motions; None if it stays."""
    if len(same) < 2 or max(one.gain for one in same) < _OPEN:
        return None
    size, gain = np.log([one.amplitude for one in same]), np.log([max(one.gain, 1e-300) for one in same])
    place = int(np.argmax(np.diff(gain) / np.diff(size)))
    return same[place].amplitude, same[place + 1].amplitude


def ratios(runs: Sequence[Driven]) -> tuple[Array, Array]:
    """Return amplitudes of which there are both directions, m, and the power of the first over that of the second."""
    both = [{one.amplitude: one.through for one in same} for same in sides(runs).values()]
    if len(both) < 2:
        return np.empty(0), np.empty(0)
    size = np.array(sorted(set(both[0]) & set(both[1])))
    return size, np.array([both[0][one] / both[1][one] for one in size.tolist()])


def rows(runs: Sequence[Driven]) -> Iterator[Row]:
    """Power of small motions, amplitudes at which the row switches, and the largest ratio of both directions."""
    found = sides(runs)
    for name, same in found.items():
        least = same[0]
        quantity = f"Light bead {name}, {least.amplitude:g} m: power through over the square of the amplitude"
        yield Row(quantity, "W/m^2", None, least.through / least.amplitude**2, "last half of the run",
                  "", least.of_small, True)  # fmt: skip
        yield Row(
            f"Light bead {name}: frequency of the drive over that of its mode", "", None,
            least.frequency / least.mode, "modes of the static state",
            f"Mode at {least.mode:.0f} Hz, cut-off of the row at {least.cut_off:.0f} Hz.",
        )  # fmt: skip
    for name, same in found.items():
        if (between := switch(same)) is not None:
            low, high = between
            quantity = f"Light bead {name}: amplitude of the drive at which the row opens"
            yield Row(
                quantity, "m", None, math.sqrt(low * high), "",
                f"Between {low:g} and {high:g} m; static overlap {same[0].overlap:.3g} m.", digits=2,
            )  # fmt: skip
    size, ratio = ratios(runs)
    if len(size):
        for place, which in ((0, "smallest amplitude"), (int(np.argmax(ratio)), "amplitude where it is largest")):
            quantity = f"Power through, light bead near the drive over at the far end, {which}"
            yield Row(quantity, "", None, float(ratio[place]), "", f"At {size[place]:g} m.", digits=3)
        best = float(size[np.argmax(ratio)])
        for name, same in found.items():
            below = next(one for one in same if one.amplitude == best).below
            if math.isfinite(below):
                quantity = f"Light bead {name}, {best:g} m: share of the last bead's motion below the row's cut-off"
                yield Row(quantity, "", None, below, "power spectrum, last half of the run", digits=3)


def pictures(runs: Sequence[Driven]) -> Iterator[Picture]:
    """Power through the row against the amplitude for both places of the light bead, and their ratio."""
    found = sides(runs)
    figure, axes, beside = panels(2.9, 2)
    columns: dict[str, Array] = {}
    for number, (name, same) in enumerate(found.items()):
        size, through = (np.array([getattr(one, key) for one in same]) for key in ("amplitude", "through"))
        small = np.array([one.of_small for one in same]) * size**2
        axes.plot(1e6 * size, through, "os"[number] + "-", markersize=3, color=f"C{number}", label=f"light bead {name}")
        axes.plot(1e6 * size, small, "--", color=f"C{number}", linewidth=0.8)
        short = name.split()[0] if number == 0 else "far"
        columns |= {f"amplitude_m_{short}": size, f"power_W_{short}": through, f"small_W_{short}": small}
        columns[f"load_power_W_{short}"] = np.array([one.value("load_power_W") for one in same])
        if (between := switch(same)) is not None:
            axes.axvspan(*(1e6 * one for one in between), color=f"C{number}", alpha=0.15, linewidth=0)
    label(axes, "Amplitude of the drive (µm)", "Power through (W)", log="xy")
    legend_above(axes, 1)
    size, ratio = ratios(runs)
    beside.axhline(1.0, color="k", linewidth=0.6)
    beside.plot(1e6 * size, ratio, "o-", markersize=3, color="C2")
    label(beside, "Amplitude of the drive (µm)", "Power, near over far", log="xy")
    columns |= {"amplitude_m": size, "near_over_far": ratio}
    yield Picture("_power", "Power through a row against the amplitude of its drive in the gap (dashed: small motions; "
                  "shaded: where the row opens), and the ratio of both places of the light bead",
                  Drawing(figure, columns))  # fmt: skip
