"""Depth to which a plane crystal is as one without sides: where its first pulse parts from that of a much wider one."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.document.model import Table
from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing, legend_above
from granwave.analysis.measures.lines.decay import parted_at
from granwave.analysis.studies.lateral.runs import LateralRun, lateral_runs
from granwave.analysis.studies.runs import FinishedRun, all_but, rising
from granwave.analysis.studies.study import Picture, Row
from granwave.analysis.studies.tables import numeric, table_of

TITLE = "Region 1 of a plane crystal ends where its sides begin to be felt"
TEXT = (
    "Crystals of 4 to 16 grains a row beside one of 40, with the same mass of the plate per width, with side walls "
    "and with free sides. Peak speed of the first pulse down the middle line over that of the wide crystal; the two "
    "part where it differs by 3 %. The source holds that reflected waves compress the upper part laterally (region "
    "1), as deep as the crystal is wide. The front and what the top corners send run down together along the "
    "close-packed lines and meet on the middle line at W/2 (45 degrees) and sqrt(3)/2 W (30 degrees): above, "
    "nothing of the sides has arrived, and free sides part at the same depth."
)
_SOURCE, _CHECK = "lateral constraints", "our second program"
_LEAST = 2  # widths
# Depth where crystals part with walls and without, D, by our second program.
_TRIAL: dict[str, dict[int, tuple[float | None, float | None]]] = {
    "BCC": {4: (2.8, 2.8), 6: (2.8, 4.2), 8: (5.7, 5.7), 10: (5.7, 7.1), 12: (7.1, 8.5), 16: (9.9, 11.3)},
    "HCP": {4: (1.7, 1.7), 6: (3.5, 3.5), 8: (6.9, 5.2), 10: (8.7, 8.7), 12: (10.4, 10.4), 16: (None, 13.9)},
}
_OF_WIDTH = ("packing.size", "load.mass", "boundary.sides")


@dataclasses.dataclass(frozen=True, eq=False)
class Widths:
    """Crystals of one kind, narrow ones with walls and with free sides, and the wide one."""

    crystal: str
    wide: LateralRun
    walls: list[LateralRun]
    free: list[LateralRun]

    def parted(self, run: LateralRun) -> float | None:
        """Return the depth at which a crystal parts from the wide one, D; None: not at all."""
        n = min(run.down.fitted.stop, self.wide.down.fitted.stop)
        return parted_at(run.depth[:n], run.down.peak_speed[:n], self.wide.down.peak_speed[:n])


def select(runs: Sequence[FinishedRun]) -> list[Widths]:
    """Series of crystals by all but their width, with one that is much wider than the others."""
    series: dict[str, list[LateralRun]] = {}
    for run in lateral_runs(runs):
        series.setdefault(run.crystal + all_but(run.case, *_OF_WIDTH) + str(run.case.packing.size[1]), []).append(run)
    found = []
    for group in series.values():
        wide = max(group, key=lambda run: run.width)
        narrow = [run for run in group if run.width <= 0.5 * wide.width and not run.case.boundary.gap]
        walls = rising((run for run in narrow if run.case.boundary.has_planes("x")), lambda run: run.width)
        free = rising((run for run in narrow if not run.case.boundary.has_planes("x")), lambda run: run.width)
        if len(walls) > 2:
            found.append(Widths(wide.crystal, wide, walls, free))
    return found


def name(group: Widths) -> str:
    """Return a short name."""
    return f"lateral-width-{group.crystal.lower()}"


def title(group: Widths) -> str:
    """Return the title of the part."""
    return f"{TITLE}: {group.crystal}"


def rows(group: Widths) -> Iterator[Row]:
    """The source's depths, the decay above, the geometric law, and our second program's depths."""
    pitch = 1 / np.sqrt(2) if group.crystal == "BCC" else np.sqrt(3) / 2
    n, source = (7, 7.0) if group.crystal == "BCC" else (8, 8.5)
    width = (n - 1) * np.sqrt(2) + 1 if group.crystal == "BCC" else float(n)
    slope = _slope(group, group.walls)
    if slope is not None:
        remark = (
            f"Not a test: the source does not print how wide its crystals are. {n} a row was inferred from these "
            "layers, which it then explains."
        )
        yield Row(f"Layers of region 1, {group.crystal}", "layers", source, slope * width / pitch,
                  f"{_SOURCE}, Fig. 4 to 7", remark, digits=2)  # fmt: skip
        law = group.wide.meeting / group.wide.width
        yield Row(f"Depth of region 1 over the width, {group.crystal}", "", 1.0, slope, f"{_SOURCE}, conclusions",
                  "Theory: where the signals of both top corners meet on the middle line.", law, digits=2)  # fmt: skip
    line = group.wide.down
    peaks = line.peak_speed[line.fitted]
    alpha = float(-np.polyfit(line.distance[line.fitted], np.log(peaks), 1)[0])
    remark = "In the wide crystal, by one exponential; plate and loss are not printed: the size alone tells."
    printed = 1.6 if group.crystal == "BCC" else 1.8
    yield Row(f"Decay of the peak speed in region 1, {group.crystal}", "1/m", printed, alpha,
              f"{_SOURCE}, Fig. 7", remark, digits=2)  # fmt: skip
    for runs, which, word in ((group.walls, 0, "walls"), (group.free, 1, "free sides")):
        for run in runs:
            parted, count = group.parted(run), run.case.packing.size[0]
            trial = _TRIAL[group.crystal].get(count, (None, None))[which]
            if parted is not None and trial is not None:
                quantity = (
                    f"Depth where {count} a row part from {group.wide.case.packing.size[0]}, {word}, {group.crystal}"
                )
                yield Row(quantity, "D", None, parted, _CHECK, "", trial, True, 2)
    spacing = float(np.diff(group.wide.depth).mean())
    away = [
        abs(d - run.meeting) / spacing for run in (*group.walls, *group.free) if (d := group.parted(run)) is not None
    ]
    if away:
        remark = "Of all widths, with walls and with free sides; they can only part at a grain."
        quantity = f"Depth where crystals part less that of the law, at most, {group.crystal}"
        yield Row(quantity, "grains", None, max(away), _SOURCE, remark, digits=2)


def pictures(group: Widths) -> Iterator[Picture]:
    """Peak speed over that of the wide crystal against depth over the depth of the law; and depth against width."""
    figure, left, right = panels(2.6, 2)
    columns: dict[str, NDArray] = {}
    for runs, line, word in ((group.walls, "-", "walls"), (group.free, "--", "free")):
        for run in runs:
            n = min(len(run.depth), len(group.wide.depth))
            ratio = run.down.peak_speed[:n] / group.wide.down.peak_speed[:n]
            shade = 0.25 + 0.75 * run.width / group.walls[-1].width
            colour = BLUE if word == "walls" else ORANGE
            left.plot(run.depth[:n] / run.meeting, ratio, line, color=colour, alpha=shade, linewidth=0.9)
            key = f"{word}_{run.case.packing.size[0]}"
            columns |= {f"{key}_depth_diameters": run.depth[:n], f"{key}_over_wide": ratio}
        known = [(run.width, group.parted(run)) for run in runs if group.parted(run) is not None]
        if known:
            right.plot(*zip(*known, strict=True), "o" if word == "walls" else "^", markersize=4,
                       color=BLUE if word == "walls" else ORANGE, label=word)  # fmt: skip
            columns |= {f"{word}_width_diameters": np.array([w for w, _ in known]),
                        f"{word}_parted_diameters": np.array([d for _, d in known])}  # fmt: skip
    widths = np.array([0.0, group.walls[-1].width])
    right.plot(widths, widths * group.wide.meeting / group.wide.width, color=GREY, label="sides are felt from here")
    right.plot(widths, widths, ":", color=GREY, label="depth = width (source)")
    left.axvline(1.0, color=GREY, linestyle=":", linewidth=0.8)
    label(
        left, "Depth / depth where the sides' signals meet", "Peak speed / that of the wide", ylim=(0, 1.3), xlim=(0, 3)
    )
    label(right, "Width (diameters)", "Depth where they part (diameters)", xlim=(0, None), ylim=(0, None))
    legend_above(right, 2)
    yield Picture("", f"Where the sides of a crystal are felt, {group.crystal}", Drawing(figure, columns))


def tables(group: Widths) -> Iterator[Table]:
    """Depths by width: the geometric law, and where crystals part."""
    columns = numeric(
        "Grains a row", ("W", "D"), ("Signals of the sides meet", "D"), ("Part, walls", "D"), ("Part, free", "D")
    )
    free = {run.case.packing.size[0]: run for run in group.free}
    rows_ = [
        (
            run.case.packing.size[0], run.width, run.meeting, group.parted(run),
            group.parted(free[run.case.packing.size[0]]) if run.case.packing.size[0] in free else None,
        )
        for run in group.walls
    ]  # fmt: skip
    yield table_of(f"Depth of region 1 by width, {group.crystal}", columns, rows_)


def _slope(group: Widths, runs: list[LateralRun]) -> float | None:
    """Return depth over width, by a line through the origin."""
    known = [(run.width, group.parted(run)) for run in runs]
    pairs = [(w, d) for w, d in known if d is not None]
    if len(pairs) < _LEAST:
        return None
    w, d = np.array(pairs).T
    return float(np.sum(w * d) / np.sum(w**2))
