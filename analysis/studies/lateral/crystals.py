"""The two crystals of the source with and without side walls: speeds, decay, widths, lateral forces, distributions."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, ORANGE, Drawing, legend_above
from granwave.analysis.studies.lateral.motion import (
    later_peak,
    mirrored,
    row_shift,
    seen_by_camera,
    turned,
)
from granwave.analysis.studies.lateral.runs import LateralRun, lateral_runs
from granwave.analysis.studies.runs import FinishedRun, grouped
from granwave.analysis.studies.study import Picture, Row

TITLE = "Plane crystals of soft cylinders under a plate"
TEXT = (
    "A centred-square (BCC in the source) and a hexagonal crystal (HCP) of polyurethane cylinders between rigid "
    "walls, struck by a rigid plate at 6 m/s. The source prints neither the modulus at that rate, nor density, "
    "friction, loss, the mass of the plate, nor how many grains there are: 70 MPa, 1130 kg/m3, 0.3, 12 us, 20 kg/m, "
    "88 and 105 grains are chosen. What it does print is compared; values of our second program for the "
    "same crystals test the code."
)
_SOURCE = "lateral constraints"
_CHECK = "our second program"
_WIDE = 40  # grains a row: the sides do not reach the middle line
_EACH: dict[str, tuple[float | None, float | None]] = {  # values of our second program: BCC, HCP
    "front": (120.0, 204.0),
    "first": (8.8, 3.0),
    "second": (4.7, 10.7),
    "border": (7.1, 7.9),
    "width_first": (0.98, 0.68),
    "width_last": (0.25, 0.22),
    "lateral_second": (6848.0, 3432.0),
    "lateral_late": (4425.0, 2683.0),
    "mean": (4.08, 4.65),
    "deviation": (1.51, 1.12),
    "friction": (0.52, 0.32),
    "loss": (0.08, 0.14),
    "rebound": (3.4, 4.0),
    "turned_walls": (45.0, 22.0),
    "shift": (59.0, None),
}


@dataclasses.dataclass(frozen=True, eq=False)
class Crystals:
    """The runs with side walls and without, and of crystals that are much wider, by the name of the crystal."""

    walls: dict[str, LateralRun]
    free: dict[str, LateralRun]
    wide: dict[str, LateralRun]


def select(runs: Sequence[FinishedRun]) -> list[Crystals]:
    """Both crystals that differ in kind and sides alone and recorded all of their grains."""
    found, recorded = [], lateral_runs(runs)
    wide = {run.crystal: run for run in recorded if run.case.packing.size[0] >= _WIDE and not run.case.boundary.gap}
    for group in grouped(recorded, "packing.kind", "packing.size", "boundary.sides"):
        whole = [run for run in group if "all" in run.lines and not run.case.boundary.gap]
        walls = {run.crystal: run for run in whole if run.case.boundary.has_planes("x")}
        free = {run.crystal: run for run in whole if not run.case.boundary.has_planes("x")}
        if walls:
            found.append(Crystals(walls, free, wide))
    return found


def rows(group: Crystals) -> Iterator[Row]:
    """Rows of what the source prints, then our second program's values, then what only the runs tell."""
    yield from _printed(group)
    for name, run in group.walls.items():
        yield from _verified(run, 0 if name == "BCC" else 1)
    yield from _alone(group)


def _printed(group: Crystals) -> Iterator[Row]:
    for crystals, name, remark in (
        (
            group.wide,
            f"crystals of {_WIDE} a row and more",
            "BCC bears less, and line contacts are the softer for it: 2 %.",
        ),
        (
            group.walls,
            "of the sizes here",
            "In BCC the sides slow the front on the middle line below W/2; in HCP hardly.",
        ),
    ):
        if {"BCC", "HCP"} <= crystals.keys():
            square, hexagonal = (crystals[one].down.front_speed for one in ("BCC", "HCP"))
            if square and hexagonal:
                material, friction = crystals["BCC"].case.material, crystals["BCC"].case.contact.friction
                stuck = 2 * (1 - material.poisson_ratio) / (2 - material.poisson_ratio)
                remark += (
                    f" Theory: long waves, whose contacts slide in both; if they stuck it were "
                    f"{long_waves(stuck, math.inf):.3f}, without friction 2/3."
                )
                yield Row(f"Front speed of BCC over that of HCP, {name}", "", 1.0, square / hexagonal,
                          f"{_SOURCE}, Fig. 9", remark, long_waves(stuck, friction), digits=3)  # fmt: skip
    for name, run in group.walls.items():
        where = f"{_SOURCE}, Fig. 9"
        later = later_peak(run)
        if later is not None:
            remark = "After the start of the impact; the zero of the source's camera is not known."
            yield Row(f"Second, small peak of the speed in deep grains, {name}", "ms", 4.0, 1e3 * later, where, remark,
                      digits=2)  # fmt: skip
    for name, run in group.walls.items():
        low, high = seen_by_camera(run, 8000.0)
        quantity = f"Largest speeds as 8000 frames/s show them over the true ones, least, {name}"
        remark = f"Up to {high:.2f}; the source's largest speeds are low by this."
        yield Row(quantity, "", None, low, f"{_SOURCE}, camera", remark, digits=2)


def _verified(run: LateralRun, which: int) -> Iterator[Row]:
    line, decay, values = run.down, run.whole_decay, run.lines["all"].distribution
    diameter, length = run.case.packing.diameter, run.case.packing.length or 1.0
    lateral = line.lateral_force / length
    found: list[tuple[str, str, str, float | None, int]] = [
        ("front", "Front speed along the middle line", "m/s", line.front_speed, 4),
        ("first", "Decay of the peak speed, first region, all grains", "1/m", decay.first if decay else None, 2),
        ("second", "Decay of the peak speed, second region, all grains", "1/m", decay.second if decay else None, 2),
        ("border", "Border of the two regions, all grains", "D", decay.border / diameter if decay else None, 2),
        ("width_first", "Half width of the pulse at the first grain", "ms", 1e3 * line.width[0], 2),
        ("width_last", "Half width of the pulse at the last grain", "ms", 1e3 * line.width[-1], 2),
        ("lateral_second", "Lateral force at the peak, second grain", "N/m", lateral[1], 3),
        ("lateral_late", "Lateral force at the peak, last grain but one", "N/m", lateral[-2], 3),
        ("mean", "Largest speeds, mean", "m/s", values.mean if values else None, 3),
        (
            "deviation",
            "Largest speeds, standard deviation",
            "m/s",
            values.deviation if values else None,
            3,
        ),
        ("friction", "Dissipated by friction over the input", "", run.value("friction_fraction"), 2),
        ("loss", "Dissipated by the loss of contacts over the input", "", run.value("viscous_fraction"), 2),
        ("turned_walls", "Largest rotation of a grain at a side wall", "degrees", turned(run)[0], 2),
        ("shift", "Left half of the second row, outwards at 0.3 ms", "um", row_shift(run, 0.3e-3), 2),
        ("rebound", "Speed at which the plate rebounds", "m/s", -run.value("plate_velocity_m_s"), 2),
    ]
    soft = (
        "There the tangential spring stays as stiff as at P = 0.01 E* R, here it follows the contact; with that a "
        "second solver gives 8.8 and 4.5 1/m for BCC."
    )
    for key, quantity, unit, ours, digits in found:
        if ours is not None and np.isfinite(ours):
            remark = soft if key in ("first", "second", "lateral_late", "friction") else ""
            theory = _EACH[key][which]
            if theory is None:
                continue
            yield Row(f"{quantity}, {run.crystal}", unit, None, float(ours), _CHECK, remark, theory, True, digits)


def _alone(group: Crystals) -> Iterator[Row]:
    for name, run in group.walls.items():
        values = run.lines["all"].distribution
        if values is not None:
            remark = "The source: Gaussian. Of the test of Shapiro and Wilk."
            yield Row(f"Largest speeds of all grains, p that they are Gaussian, {name}", "", None, values.normal_p,
                      f"{_SOURCE}, Fig. 10", remark, digits=1)  # fmt: skip
            quantity = f"Largest speeds of all grains, standard deviation over mean, {name}"
            remark = "The source: HCP is narrower."
            yield Row(quantity, "", None, values.deviation / values.mean, f"{_SOURCE}, Fig. 10", remark, digits=2)
        others = turned(run)[1]
        remark = "The source: huge rotations in HCP, at its walls, and none in BCC."
        quantity = f"Largest rotation of a grain that is not at a side wall, {name}"
        yield Row(quantity, "degrees", None, others, _SOURCE, remark, digits=2)
        remark = "The source: the upper rows move outwards, then inwards."
        quantity = f"Left half of the second row, inwards at 0.9 ms, {name}"
        yield Row(quantity, "um", None, -row_shift(run, 0.9e-3), f"{_SOURCE}, Fig. 4", remark, digits=2)
        yield Row(f"Largest deviation from mirror symmetry over a diameter, {name}", "", None, mirrored(run), _SOURCE,
                  "The source: almost perfect.", digits=1)  # fmt: skip
    for name, run in group.free.items():
        inside = run.down.peak_speed[np.isfinite(run.down.peak_speed)]
        beside = group.walls.get(name)
        if beside is not None and len(inside) > 1:
            n = len(inside) - 1
            ratio = inside[n] / beside.down.peak_speed[n]
            quantity = f"Last peak down the line without side walls over that with them, {name}"
            yield Row(quantity, "", None, float(ratio), _SOURCE, f"At a depth of {run.depth[n]:.1f} D.", digits=2)


def long_waves(stiffness: float, friction: float) -> float:
    """Return the speed of long waves in BCC over that in HCP.

    Rows approach each other without moving sideways. Contacts lie 45 degrees (BCC) and 30 degrees (HCP) off the way of
    the wave; where they stick, tangential over normal force is ``stiffness``, tangential over normal, times the tangent
    of that angle.
    """

    def speed(angle: float) -> float:
        tangential = min(stiffness * math.tan(angle), friction)
        return math.cos(angle) * math.sqrt(2 * math.cos(angle) * (math.cos(angle) + tangential * math.sin(angle)))

    return speed(math.pi / 4) / speed(math.pi / 6)


def pictures(group: Crystals) -> Iterator[Picture]:
    """Peak speed, lateral force and half width against depth, with side walls and without."""
    figure, *axes = panels(2.4, 3)
    columns: dict[str, NDArray] = {}
    for runs, line, mark, word in ((group.walls, "-", "o", "walls"), (group.free, "--", "^", "free")):
        for (name, run), colour in zip(runs.items(), (BLUE, ORANGE), strict=False):
            length = run.case.packing.length or 1.0
            curves = (run.down.peak_speed, run.down.lateral_force / length, 1e3 * run.down.width)
            for panel, values in zip(axes, curves, strict=True):
                panel.plot(run.depth, values, line, marker=mark, markersize=3, color=colour, label=f"{name}, {word}")
            columns |= {
                f"{name}_{word}_depth_diameters": run.depth,
                f"{name}_{word}_peak_m_s": curves[0],
                f"{name}_{word}_lateral_N_per_m": curves[1],
                f"{name}_{word}_width_ms": curves[2],
            }
    names = ("Peak speed (m/s)", "Lateral force (N/m)", "Half width (ms)")
    for panel, name in zip(axes, names, strict=True):
        label(panel, "Depth (diameters)", name, ylim=(0, None))
    legend_above(axes[0], 2)
    yield Picture("", "Middle line of both crystals, with side walls and without", Drawing(figure, columns))
