"""Speed of small longitudinal waves along [111] of fcc and along c of hcp against the static pressure.

The mean velocity of a layer of a periodic packing obeys the line of layers of `theory` exactly as long as everything is
linear, whichever spheres of the top layer were struck; in a packing with free sides until the wave is back from them.
The times of its crests then give omega, and the speed of long waves c0.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, Drawing, new_figure
from granwave.analysis.measures.signals import first_peak, power
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.precompression import theory
from granwave.analysis.studies.precompression.runs import PastRun
from granwave.analysis.studies.precompression.theory import Array
from granwave.analysis.studies.study import Picture, Row, Study
from granwave.lammps_inputs.packing.assembly import assemble

SMALL = 0.1  # impact velocity over omega alpha0 up to which everything is linear enough
_FIRST = 3  # layer from which on crests are followed
_FEWEST = 3  # layers
_BEFORE_END = 3  # layers left out at the bottom
_BEFORE_SIDES = 0.8  # of half the width: how deep a wave is followed in a packing with free sides
_FINE = 10  # points put between two snapshots
_MARKERS = {
    ("fcc", "uniaxial"): ("o", BLUE, 7),
    ("hcp", "uniaxial"): ("s", ORANGE, 4),
    ("fcc", "uniform"): ("x", GREEN, 7),
    ("hcp", "uniform"): ("+", PURPLE, 7),
}


def packing_speeds(runs: Sequence[PastRun]) -> Iterator[Study]:
    """One study of all precompressed fcc and hcp packings of like elastic spheres with a small impact."""
    series: dict[tuple[str, str], list[tuple[PastRun, float, float]]] = {}
    for run in runs:
        if not fits(run):
            continue
        speed = long_wave_speed(run)
        stage = run.case.precompression
        if stage is not None and np.isfinite(speed):
            theirs = theory.line_of(run.case, run.law).speed
            series.setdefault((run.case.packing.kind, stage.kind), []).append((run, speed, theirs))
    if not series:
        return
    rows: list[Row] = []
    for (kind, how), found in sorted(series.items()):
        found.sort(key=lambda one: pressure_of(one[0]))
        where = f"{kind}, {how}"
        if len({pressure_of(run) for run, _, _ in found}) > 1:
            fit = power(np.array([pressure_of(run) for run, _, _ in found]), np.array([speed for _, speed, _ in found]))
            rows.append(Row(f"Power of the speed with the pressure, {where}", "", None, fit.exponent, "Hertz lattice",
                            "", 1 / 6))  # fmt: skip
        for run, speed, theirs in found:
            remark = ""
            if abs(speed / theirs - 1) > 0.01:
                remark = "Free sides: the static forces are not even." if how == "uniform" else "Not small enough."
            rows.append(
                Row(f"Speed of small waves, {where}, {pressure_of(run):.4g} Pa", "m/s", None, speed,
                    "Hertz lattice", remark, theirs)
            )  # fmt: skip
    yield Study(
        "precompressed-packing-speed",
        "Precompressed packings: speed of small waves",
        "Small impacts on packings under static pressure, along the stacking of their layers. c0 by the times of the "
        "crests of the layers' mean velocities, over the places that layers had before the load. Theory: "
        "c0 = h sqrt((2 k - f/D)/m), layers h = D sqrt(2/3) apart, k = 3/2 f/alpha, and f = p D^2/(2 sqrt 2) the force "
        "of a contact, by balance on a layer (uniaxial) as by the virial (uniform).",
        tuple(rows),
        (Picture("precompressed_packing_speed", "Speed of small waves against pressure", _draw(series)),),
    )


def fits(run: PastRun) -> bool:
    """A small impact along the stacking of like elastic spheres under pressure."""
    case = run.case
    stage = case.precompression
    if stage is None or stage.kind == "gravity" or case.packing.kind not in ("fcc", "hcp"):
        return False
    if not assemble(case).plain or case.contact.law != "hertz" or case.load.angle:
        return False
    return case.load.velocity < SMALL * theory.line_of(case, run.law).velocity


def pressure_of(run: PastRun) -> float:
    """On the faces, by the force of a contact, Pa."""
    return float(2 * np.sqrt(2) * run.static_force / run.case.packing.diameter**2)


def long_wave_speed(run: PastRun) -> float:
    """c0, m/s; NaN where the run has too few layers, or is too short."""
    nx, ny, nz = run.assembly.lattice.shape
    with Result(run.directory) as result:
        time = result.frame_times
        layer = (result["spheres/id"] - 1) // (nx * ny)
        mean = np.stack([
            np.bincount(layer, result.frame(frame, "velocity")[:, 2], nz) / (nx * ny)
            for frame in range(result.n_frames)
        ])  # fmt: skip
    deepest = nz - _BEFORE_END
    if run.case.boundary.sides != "periodic":
        half = min(nx, ny * np.sqrt(3) / 2) / 2
        deepest = min(deepest, int(_BEFORE_SIDES * half / theory.SPACING[run.case.packing.kind]))
    numbers, times = crests(time, mean[:, :deepest])
    if len(numbers) < _FEWEST:
        return np.nan
    spacing = theory.line_of(run.case, run.law).spacing
    return spacing / (2 * float(np.polyfit(theory.crest_times(numbers), times, 1)[0]))


def crests(time: Array, mean: Array) -> tuple[NDArray[np.int64], Array]:
    """Layers, from 1, that the crest has passed, and when.

    Parameters
    ----------
    mean
        Velocity of the layers: (n_times, n_layers), m/s.
    """
    fine = np.linspace(time[0], time[-1], _FINE * (len(time) - 1) + 1)
    found = [first_peak(fine, CubicSpline(time, one)(fine), floor=0.5)[0] for one in mean.T]
    numbers = np.arange(1, len(found) + 1)
    times = np.array(found)
    good = (numbers >= _FIRST) & np.isfinite(times) & (times < time[-2])
    return numbers[good], times[good]


def _draw(series: dict[tuple[str, str], list[tuple[PastRun, float, float]]]) -> Drawing:
    figure = new_figure(2.6)
    axes = figure.subplots()
    columns: dict[str, Array] = {}
    for (kind, how), found in sorted(series.items()):
        pressure = np.array([pressure_of(run) for run, _, _ in found])
        speed, theirs = (np.array([one[n] for one in found]) for n in (1, 2))
        axes.loglog(pressure, theirs, "-", color=GREY)
        marker, colour, size = _MARKERS[kind, how]
        axes.loglog(
            pressure, speed, marker, color=colour, markersize=size, markerfacecolor="none", label=f"{kind}, {how}"
        )
        columns |= {f"{kind}_{how}_pressure_Pa": pressure, f"{kind}_{how}_speed_m_s": speed,
                    f"{kind}_{how}_theory_m_s": theirs}  # fmt: skip
    axes.plot([], [], "-", color=GREY, label="theory")
    axes.set_xlabel("Pressure (Pa)")
    axes.set_ylabel("Speed of small waves (m/s)")
    axes.legend(loc="upper left")
    return Drawing(figure, columns)
