"""Switch: cylinders that open the gaps of a chain, or lie loose at them (thesis 8).

A chain of 27 steel spheres ends on an aluminium block; the impact on the first sphere is at 0.8
m/s. There are 0 to 10 aluminium cylinders between two aluminium plates. If the plates are 15.975 mm
apart, the cylinders open gaps behind spheres 14 to 18 and transmit the wave across the gaps. If the
plates are 16.5 mm apart, the gaps are closed, and the cylinders lie loose on the sphere before
(upstream) or behind them (downstream). A sensor in a sphere measures the mean of its two contact
forces. The friction of the plates is 0.185, which the source fitted. Here friction has Mindlin's
spring and Coulomb's limit; in the second solver it follows the sign of the velocity, which explains
the differences with friction. Cylinders do not rotate.
"""

from itertools import product

import numpy as np
from matplotlib.figure import Figure
from switch_row import FRICTION, SENSORS, SOLVER, STATES, SwitchRow, second_solver

import granwave as gw

NUMBERS = (2, 4, 6, 8, 10)
NONE, OPEN, UPSTREAM, DOWNSTREAM = STATES
KEYS = list(product(STATES[1:], (0.0, FRICTION)))
SPHERES = 27
SPEED = 0.8  # m/s
AXES = {
    2: (70.0, "8.7a"),
    4: (60.0, "8.7b"),
    8: (30.0, "8.8b"),
    10: (30.0, "8.8c"),
}  # ends, N, of the same; figure
SHEARED = (
    "Friction here has Mindlin's spring; in the second solver it follows the sign of the velocity."
)
INPUT_AXIS = 140.0  # N: end of Fig. 8.5b
WINDOWS = ((OPEN, FRICTION, 600.0, "8.5a"), (DOWNSTREAM, 0.0, 500.0, "8.5b"))  # us, of the axes


def select(runs):
    """Rows by state and friction, in order of the number of cylinders, and the row without
    cylinders; empty for a single scan.
    """
    found = {(row.state, row.friction, row.n): row for row in map(SwitchRow, runs)
             if len(row.ids) == SPHERES and row.speed == SPEED}  # fmt: skip
    if not found.keys() >= {(NONE, 0.0, 0), *((*key, n) for key in KEYS for n in NUMBERS)}:
        return []
    return [({key: [found[*key, n] for n in NUMBERS] for key in KEYS}, found[NONE, 0.0, 0])]


def rows(measured):
    found, none = measured
    checked = {"where": "thesis 8", "verification": True}
    # fmt: off
    solved = second_solver()
    for state, friction in KEYS:
        remark = f"{SOLVER} {SHEARED}" if friction else SOLVER
        for row in found[state, friction]:
            theory = solved[state, friction, row.n, SPHERES, SPEED]
            time, force = row.first
            yield gw.Row(f"First peak at sphere 21, {row.name}", "N", ours=force, theory=theory["sphere_21_first_N"],
                         remark=remark, **checked)
            if state != OPEN:
                continue
            yield gw.Row(f"Time of the first peak at sphere 21, {row.name}", "us", ours=1e6 * time, theory=1e6 * theory["sphere_21_first_s"],
                         remark=SOLVER, **checked)
            if friction:
                yield gw.Row(f"Largest force at sphere 21, {row.name}", "N", ours=row.sensor(SENSORS[1])[1].max(),
                             theory=theory["sphere_21_largest_N"], remark=remark, **checked)
            if friction and row.n in AXES:
                end, figure = AXES[row.n]
                yield gw.Row(f"First peak at sphere 21, {row.name}, at most", "N", end, force, bound=True,
                             where=f"thesis Fig. {figure}", remark=(
                                 "The bound is the end of the axis."))
    loose = [row.first[1] for row in found[DOWNSTREAM, 0.0]]
    yield gw.Row("First peak at sphere 21, loose, downstream: spread over the numbers of cylinders", "N", 0.0,
                 max(loose) - min(loose), "thesis 8.4, Fig. 8.10b",
                     "According to the source the peak is independent of the number.")
    # fmt: on
    yield from both_sensors(found, none)


def both_sensors(found, none):
    """Rows of the signals of both sensors (Fig. 8.5), compared with the axes and the text."""
    first = [row.first for row in (none, *found[OPEN, FRICTION])]
    times, forces = np.array(first).T
    steps = len(NUMBERS)
    name = f"open gaps, friction {FRICTION:g}"
    changes = {
        "falls": np.sum(np.diff(forces) < 0),
        "is later": np.sum(np.diff(times) > 0),
    }
    for what, ours in changes.items():
        yield gw.Row(
            f"Steps of two cylinders with which the first peak at sphere 21 {what}, {name}",
            source=steps,
            ours=float(ours),
            where="thesis 8.2.2, Fig. 8.5a",
            remark="According to the source, force and speed decrease with the number.",
        )
    yield gw.Row(
        "First peak at sphere 6, no cylinders, at most",
        "N",
        INPUT_AXIS,
        none.first_peak_at(SENSORS[0])[1],
        "thesis Fig. 8.5b",
        "The bound is the end of the axis; the curves are measured.",
        bound=True,
    )
    for state, friction, length, figure in WINDOWS:
        row = found[state, friction][-1]
        apart = 1e6 * (row.first[0] - row.first_peak_at(SENSORS[0])[0])
        yield gw.Row(
            f"Time between the first peaks of both sensors, {row.name}, at most",
            "us",
            length,
            apart,
            f"thesis Fig. {figure}",
            "The bound is the length of the axis; the curves are measured.",
            bound=True,
        )
    for state in (UPSTREAM, DOWNSTREAM):
        row = found[state, FRICTION][-1]
        yield gw.Row(
            f"First peak at sphere 21 relative to the chain without cylinders, {row.name}",
            ours=row.first[1] / none.first[1],
            where="thesis 8.2.2, Fig. 8.5b",
            digits=3,
            remark="According to the source the decay is very small. The source does not state "
            "where loose cylinders rest when the wave arrives.",
        )


def verdict(measured):
    found, _ = measured
    peak = {key: [row.first[1] for row in of] for key, of in found.items()}
    rubbed = peak[OPEN, FRICTION]
    loose = peak[DOWNSTREAM, 0.0] + peak[DOWNSTREAM, FRICTION]
    yield (
        f"With open gaps and friction the first peak falls from {rubbed[0]:.1f} N ({NUMBERS[0]} "
        f"cylinders) to {rubbed[-1]:.1f} N ({NUMBERS[-1]}), without friction only to {peak[OPEN, 0.0][-1]:.1f} "
        "N. The decay in the source is therefore due to its fitted friction."
    )
    ends = dict.fromkeys(f"{force:.2f}" for force in (min(loose), max(loose)))
    yield (
        f"Loose cylinders downstream have no effect ({' to '.join(ends)} N for "
        "any number of cylinders); upstream each pair reduces the peak. In the source the two "
        "states are exchanged."
    )


def pictures(measured):
    found, none = measured
    figure = Figure((7, 2.8), layout="constrained")
    data = {"cylinders": np.array([0, *NUMBERS])}
    left, right = figure.subplots(1, 2)
    for k, ((state, friction), of) in enumerate(found.items()):
        peak = np.array([row.first[1] for row in (none, *of)])
        line = f"{'os^'[k // 2]}{'--' if friction else '-'}"
        left.plot(
            data["cylinders"], peak, line, markersize=3.5, label=f"{state}, friction {friction:g}"
        )
        data[
            f"{state}_friction_{friction:g}_N".replace(", ", "_")
            .replace(" ", "_")
            .replace(".", "_")
        ] = peak
    for row in (none, *found[OPEN, FRICTION]):
        time, force = row.sensor(SENSORS[1])
        right.plot(1e3 * time, force, label=f"{row.n} cylinders")
        data |= {f"open_{row.n}_time_s": time, f"open_{row.n}_N": force}
    left.set(xlabel="Cylinders", ylabel="First peak at sphere 21 (N)", ylim=(0, None))
    right.set(xlabel="Time (ms)", ylabel="Force at sphere 21 (N)", ylim=(0, None))
    for axes in (left, right):
        axes.legend(fontsize=6)
    caption = (
        "First peak behind the cylinders, and forces there with open gaps and friction "
        "(thesis Figs 8.6 to 8.10). "
    )
    caption += (
        "Friction causes the decrease with their number; loose cylinders downstream have no effect"
    )
    yield gw.Picture("switch_peaks", caption, figure, data)
    yield picture_of_both(found, none)


def picture_of_both(found, none):
    """Signals of both sensors with gaps between spheres, and with loose cylinders."""
    figure = Figure((7, 2.8), layout="constrained")
    data = {}
    for axes, (state, friction, *_), title in zip(
        figure.subplots(1, 2, sharey=True),
        WINDOWS,
        ("open gaps, friction", "loose, downstream"),
        strict=True,
    ):
        for k, row in enumerate((none, *found[state, friction])):
            for sensor in SENSORS:
                time, force = row.sensor(sensor)
                label = f"{row.n} cylinders" if sensor == SENSORS[0] else None
                axes.plot(1e3 * time, force, f"C{k}", linewidth=0.9, label=label)
                name = f"{'open' if state == OPEN else 'loose'}_{row.n}_sphere_{sensor}"
                data |= {f"{name}_time_s": time, f"{name}_N": force}
        axes.set(xlabel=f"Time (ms), {title}", xlim=(0, 0.6))
    figure.axes[0].legend(fontsize=6)
    figure.axes[0].set(ylabel="Force (N)", ylim=(0, None))
    caption = "Computed forces at sphere 6 (before the cylinders) and 21 (behind them), which the "
    caption += "source measured (thesis Fig. 8.5). With open gaps, force and speed decrease with "
    caption += "the number of cylinders; loose cylinders downstream have no effect"
    return gw.Picture("switch_both_sensors", caption, figure, data)
