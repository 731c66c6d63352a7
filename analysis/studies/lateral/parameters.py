"""Height, gap, friction, loss, plate, modulus and grain size of the crystals: what each does to speed and decay."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.document.model import Table
from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing, legend_above
from granwave.analysis.studies.lateral.runs import NAMES, LateralRun, lateral_runs
from granwave.analysis.studies.runs import FinishedRun, rising
from granwave.analysis.studies.study import Picture, Row
from granwave.analysis.studies.tables import numeric, table_of

TITLE = "What speed and decay in plane crystals depend on"
TEXT = (
    "The two crystals between walls with one thing changed: height, a gap at the walls, friction, the loss of "
    "contacts, the mass of the plate, the modulus, the size of the grains, or diameters that scatter. First pulses "
    "alone are compared: without friction the centred-square crystal has no shear stiffness, and what follows is "
    "chaotic."
)
_SOURCE, _CHECK = "lateral constraints", "our second program"
_SPEED = 125.0  # m/s, printed
_BASE = {"modulus": 70e6, "friction": 0.3, "loss": 12e-6, "plate": 20.0, "diameter": 0.0127}
_COUNT = {"BCC": (6, 16), "HCP": (8, 14)}
_TRIAL: dict[str, dict[float, tuple[float | None, float | None]]] = {  # BCC, HCP
    "height": {1.5: (14.1, 13.9), 2.0: (19.8, 20.8), 3.0: (31.1, 32.9)},
    "gap": {1e-4: (114.0, 204.0), 5e-4: (103.0, 204.0), 2e-3: (71.0, 204.0)},
    "friction": {0.6: (2.7, None)},
    "loss": {0.0: (9.2, -0.4), 3e-6: (8.7, 1.0), 48e-6: (0.1, 3.1)},
    "plate": {40.0: (3.7, 2.6), 80.0: (2.6, 2.3)},
    "modulus": {150e6: (175.0, 299.0), 480e6: (315.0, 546.0), 1573e6: (587.0, 1043.0)},
}
_FEW = "Two regions of eight or seven grains, whose border jumps from grain to grain: near another minimum of the fit."
_GIVES = {"BCC": 76e6, "HCP": 25e6}  # modulus that gives 125 m/s, by our second program


@dataclasses.dataclass(frozen=True, eq=False)
class Changed:
    """Runs by what was changed, and by crystal, in rising order of its value; and those that a striker hit."""

    series: dict[tuple[str, str], list[tuple[float, LateralRun]]]
    struck: list[LateralRun]


def select(runs: Sequence[FinishedRun]) -> list[Changed]:
    """Runs with walls in which one value differs from those of the reference."""
    series: dict[tuple[str, str], dict[float, LateralRun]] = {}
    for run in lateral_runs(runs):
        if not run.case.boundary.has_planes("x"):
            continue
        changes = _changes(run)
        if len(changes) > 1:
            continue
        for what in [*changes] or [*_TRIAL]:
            value = changes.get(what, _reference(what))
            series.setdefault((what, run.crystal), {}).setdefault(value, run)
    found = {key: [(value, runs_[value]) for value in sorted(runs_)] for key, runs_ in series.items()}
    return [Changed(found, lateral_runs(runs, "striker"))] if any(len(points) > 1 for points in found.values()) else []


def _reference(what: str) -> float:
    return {"height": 1.0, "gap": 0.0}.get(what, _BASE.get(what, 0.0))


def _changes(run: LateralRun) -> dict[str, float]:
    """Return what differs from the reference, by name."""
    case, (count, layers) = run.case, _COUNT[run.crystal]
    found = {
        "height": case.packing.size[1] / layers,
        "count": case.packing.size[0] / count,
        "gap": case.boundary.gap,
        "scatter": case.packing.diameter_scatter,
        "friction": case.contact.friction,
        "loss": run.loss_time,
        "modulus": case.material.youngs_modulus,
        "diameter": case.packing.diameter,
    }
    base = {"height": 1.0, "count": 1.0, "gap": 0.0, "scatter": 0.0} | _BASE
    changed = {name: value for name, value in found.items() if not math.isclose(value, base[name], rel_tol=1e-6)}
    if "diameter" not in changed and not math.isclose(run.plate, base["plate"], rel_tol=1e-3):
        changed["plate"] = round(run.plate, 3)
    return changed


def rows(group: Changed) -> Iterator[Row]:
    """The printed speed at printed moduli, and our second program's values."""
    for name in NAMES.values():
        yield from _of_modulus(group, name)
    yield from _struck(group)
    for which, name in enumerate(NAMES.values()):
        for value, run in group.series.get(("height", name), []):
            decay = run.whole_decay
            trial = _TRIAL["height"].get(value, (None, None))[which]
            if trial and decay:
                remark = "The last two grains, which the floor holds, decide this fit: leave them out."
                yield Row(f"Border of the two regions, all grains, {value:g} times as high, {name}", "D", None,
                          decay.border / run.case.packing.diameter, _CHECK, remark, trial, True, 2)  # fmt: skip
        yield from _simple(group, name, which, "gap", "Front speed, gap of {:g} mm", 1e3)
        for what, words, scale in (
            ("friction", "friction {:g}", 1.0),
            ("loss", "loss time of {:g} us", 1e6),
            ("plate", "plate of {:g} kg/m", 1.0),
        ):
            for value, run in group.series.get((what, name), []):
                decay, trial = run.whole_decay, _TRIAL[what].get(value, (None, None))[which]
                if decay is None:
                    continue
                quantity = f"Decay of the peak speed, first region, {words.format(value * scale)}, {name}"
                if trial is not None:
                    yield Row(quantity, "1/m", None, decay.first, _CHECK, _FEW, trial, True, 2)
                else:
                    yield Row(quantity, "1/m", None, decay.first, _SOURCE, digits=2)
        for what, quantity, trial in (
            ("diameter", "Decay, first region, 1-inch grains, {}", (4.3, 0.9)[which]),
            ("count", "Decay, first region, 8 a row, {}", 4.5),
        ):
            for value, run in group.series.get((what, name), []):
                decay = run.whole_decay
                if decay is not None and value != _reference(what) and value != 1.0:
                    yield Row(quantity.format(name), "1/m", None, decay.first, _CHECK, _FEW, trial, True, 2)
        for value, run in group.series.get(("scatter", name), []):
            if value and run.down.front_speed:
                remark = "One set of random diameters; the program's were others."
                yield Row(f"Front speed, diameters smaller by up to {1e6 * value:g} um, {name}", "m/s", None,
                          run.down.front_speed, _CHECK, remark, (106.0, 180.0)[which], True, 3)  # fmt: skip


def _struck(group: Changed) -> Iterator[Row]:
    for run in group.struck:
        decay = run.whole_decay
        if decay is not None:
            quantity = f"Decay of the peak speed, first region, a rigid cylinder on the middle grain, {run.crystal}"
            remark = "64 to 69 and 27 to 29 1/m for 1 to 20 kg/m: far from the source's, whose load is the whole top."
            trial = 66.5 if run.crystal == "BCC" else 28.0
            yield Row(quantity, "1/m", None, decay.first, _CHECK, remark, trial, True, 2)


def _of_modulus(group: Changed, name: str) -> Iterator[Row]:
    points = [(value, run.down.front_speed) for value, run in group.series.get(("modulus", name), [])]
    known = [(value, speed) for value, speed in points if speed]
    if len(known) < 2:
        return
    moduli, speeds = np.array(known).T
    which = list(NAMES.values()).index(name)
    for value, speed in known:
        trial = _TRIAL["modulus"].get(value, (None, None))[which]
        if trial is None:
            continue
        remark = "The source's modulus and speed exclude each other in an ideal crystal."
        yield Row(f"Front speed at {value / 1e6:g} MPa, {name}", "m/s", _SPEED, speed, f"{_SOURCE}, Fig. 9", remark,
                  digits=3)  # fmt: skip
        yield Row(f"Front speed at {value / 1e6:g} MPa, {name}", "m/s", None, speed, _CHECK, "", trial, True, 3)
    if speeds.min() <= _SPEED <= speeds.max():
        gives = float(np.exp(np.interp(np.log(_SPEED), np.log(speeds), np.log(moduli)))) / 1e6
        yield Row(f"Modulus that gives 125 m/s, {name}", "MPa", 150.0, gives, f"{_SOURCE}, 3",
                  "The least of the printed effective moduli, 150 to 740 MPa.", digits=2)  # fmt: skip
        yield Row(f"Modulus that gives 125 m/s, {name}", "MPa", None, gives, _CHECK, "", _GIVES[name] / 1e6, True, 2)


def _simple(group: Changed, name: str, which: int, what: str, words: str, scale: float) -> Iterator[Row]:
    for value, run in group.series.get((what, name), []):
        trial, speed = _TRIAL[what].get(value, (None, None))[which], run.down.front_speed
        if trial is not None and speed:
            quantity = f"{words.format(value * scale)}, {name}"
            yield Row(quantity, "m/s", None, speed, _CHECK, "", trial, True, 3)


def pictures(group: Changed) -> Iterator[Picture]:
    """Front speed against the modulus, and against the gap at the walls."""
    figure, left, right = panels(2.6, 2)
    columns: dict[str, NDArray] = {}
    for name, colour in zip(NAMES.values(), (BLUE, ORANGE), strict=True):
        for panel, what, scale in ((left, "modulus", 1e-6), (right, "gap", 1e3)):
            points = [(v * scale, run.down.front_speed) for v, run in group.series.get((what, name), [])]
            known = [(value, speed) for value, speed in points if speed]
            if not known:
                continue
            value, speed = np.array(known).T
            panel.plot(value, speed, "-o", color=colour, markersize=3, label=name)
            columns |= {f"{name}_{what}": value, f"{name}_{what}_front_m_s": speed}
    left.axhline(_SPEED, color=GREY, linestyle=":", label="source")
    label(left, "Young's modulus (MPa)", "Front speed (m/s)", log="xy")
    label(right, "Gap at the side walls (mm)", "Front speed (m/s)", ylim=(0, None))
    legend_above(left, 3)
    yield Picture("", "Front speed against the modulus and against the gap at the walls", Drawing(figure, columns))


def tables(group: Changed) -> Iterator[Table]:
    """Front speed and decay of all runs."""
    columns = numeric(
        "Value", ("Front", "m/s"), ("First peak", "m/s"), ("Decay 1", "1/m"), ("Decay 2", "1/m"), ("Border", "D")
    )
    for (what, name), points in sorted(group.series.items()):
        if len(points) < 2:
            continue
        cells = []
        for value, run in rising(points, lambda one: one[0]):
            decay = run.down.decay
            cells.append((
                value, run.down.front_speed, float(run.down.peak_speed[0]), decay.first if decay else None,
                decay.second if decay else None, decay.border / run.case.packing.diameter if decay else None,
            ))  # fmt: skip
        yield table_of(f"{name}, {what} (SI units; height over that of the reference)", columns, cells)
