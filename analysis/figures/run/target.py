"""Figure of the protected target, with and without the packing."""

from __future__ import annotations

import numpy as np

from granwave.analysis.figures.run.histories import thinned, time_axis
from granwave.analysis.figures.series import energy_unit
from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, Drawing, legend_above, new_figure
from granwave.analysis.measures.bare_target import unprotected
from granwave.analysis.measures.target import reached
from granwave.analysis.result.reader import Result

_MICRO, _MILLI = 1e6, 1e3


def target(result: Result) -> Drawing | None:
    """Draw force, impulse and work on the bottom against time, and the force without the packing.

    None if the bottom does not move and there is no such force: the force on the bottom has a figure of its own.
    """
    found = reached(result)
    if found is None or not np.any(found.force):
        return None
    time, end = found.time, float(result["energy/time"][-1])
    without = unprotected(result.case, end)
    moved, ground = found.displacement, found.ground_force
    moves = moved is not None
    if not moves and without is None:
        return None
    columns = {"time_s": time, "force_N": found.force, "impulse_Ns": found.impulse}
    figure = new_figure(4.8 if moves else 3.5)
    panels = figure.subplots(3 if moves else 2, 1, sharex=True)
    force, impulse = panels[:2]
    shown = thinned(found.force)
    force.plot(time[shown] * _MICRO, found.force[shown], color=BLUE, linewidth=0.9, label="on the target")
    if moved is not None and ground is not None:
        columns |= {"displacement_m": moved, "ground_force_N": ground}
        shown = thinned(ground)
        force.plot(time[shown] * _MICRO, ground[shown], color=GREEN, linewidth=0.9, label="on the ground")
    if without is not None and without.peak_force > 0:
        columns |= {"without_packing_time_s": without.time, "without_packing_force_N": without.force}
        force.plot(without.time * _MICRO, without.force, color=GREY, linestyle="--", label="target without packing")
        force.set_yscale("log")
        least = min(float(found.force.max()), without.peak_force)
        force.set_ylim(1e-2 * least, 2 * max(float(found.force.max()), without.peak_force))
    force.set_ylabel("Force (N)")
    legend_above(force, 2)
    impulse.plot(time * _MICRO, found.impulse * _MILLI, color=ORANGE)
    impulse.set_ylabel("Impulse (mN s)")
    if moves:
        ledger, energy = result["energy/time"], result.get("energy/target")
        if energy is None:
            energy = np.zeros_like(ledger)
        unit, name = energy_unit(float(np.abs(energy).max()))
        panels[2].plot(ledger * _MICRO, energy * unit, color=BLUE)
        panels[2].set_ylabel(f"Work on the\ntarget ({name})")
        columns |= {"energy_time_s": ledger, "energy_J": energy}
    time_axis(panels[-1], time)
    return Drawing(figure, columns)
