"""An elastic chain of like beads under a steady force that lasts to the end of the run (thesis 4.1.3, Fig. 4.2).

A force A makes a plateau of force A whose speed is, by momentum and the virial 4 K = 5 P, c_l = D sqrt(A/(m alpha_A))
(4.16), at most c_u = sqrt(10/9) c_l (4.12); the bead velocity is then D A/(m c) (4.9).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.curves import key_of_lines, label, panels
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing
from granwave.analysis.measures.hertz_chain import ChainScales
from granwave.analysis.measures.signals import arrival
from granwave.analysis.studies.chains.runs import ChainRun, chain_runs, uniform
from granwave.analysis.studies.chains.scales import from_thesis, passed, undisturbed
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

_FEWEST_CONTACTS = 200
_WHERE = "thesis 4.1.3"
#: Speeds that the thesis prints are too large by this.
_TOO_LARGE = 10 ** (1 / 6)


def select(runs: Sequence[FinishedRun]) -> list[ChainRun]:
    """Chains whose end the wave has not reached, each by itself."""
    return [
        run for run in uniform(chain_runs(runs), "hertz")
        if run.load.kind == "force" and run.load.shape == "rectangle" and run.load.lasts >= 0.999 * run.time[-1]
        and undisturbed(run) and passed(run) >= _FEWEST_CONTACTS
    ]  # fmt: skip


def title(run: ChainRun) -> str:
    """With the force."""
    return f"Long loading of an elastic chain, {run.load.largest:g} N"


def text(run: ChainRun) -> str:
    """Describe the runs."""
    return (
        f"A steady force of {run.load.largest:g} N on the first of {run.velocity.shape[1]} elastic beads for "
        f"{1e3 * run.time[-1]:.4g} ms; the front is then at contact {passed(run)}. Peak force there; speed of "
        "the front at half the force, over the last nine tenths of its way; plateau: the first quarter of it."
    )


def rows(run: ChainRun) -> Iterator[Row]:
    """Peak, plateau and speeds, with their bounds."""
    scales, amplitude, last = ChainScales(run), run.load.largest, passed(run)
    thesis = from_thesis(run) and math.isclose(amplitude, 40.0, rel_tol=1e-3)
    peak, (lower, upper), (speed, front) = float(run.of_contacts("peak_force")[last - 1]), _bounds(run), _front(run)

    def row(what: str, unit: str, source: float | None, ours: float, remark: str = "", expected: float | None = None,
            where: str = _WHERE) -> Row:  # fmt: skip
        return Row(what, unit, source if thesis else None, ours, where, remark, expected)

    yield row("Peak force", "N", 92.7, peak, f"At contact {last}; it still rises slowly.",
              None if thesis else 92.7 / 40 * amplitude)  # fmt: skip
    for which, source, bound in (("Lower", 78.15, lower), ("Upper", 107.2, upper)):
        yield row(f"{which} bound of the peak force", "N", source, scales.force_at_speed(bound),
                  "By its formula alone: the force whose speed by Nesterenko is the bound.")  # fmt: skip
    printed = "The printed speed is 10^(1/6) too large. " if thesis else ""
    for which, source, bound in (("Lower bound of the speed (4.16)", 668.0, lower),
                                 ("Upper bound of the speed (4.12)", 704.0, upper)):  # fmt: skip
        yield row(which, "m/s", source, bound, printed, source / _TOO_LARGE if thesis else None)
    yield row("Speed of the front", "m/s", 687.2, speed,
              f"{printed}Theory: Nesterenko's of our peak force; the discrete wave is 1.2 % faster.",
              scales.nesterenko(peak))  # fmt: skip
    late, plateau = slice(-len(run.time) // 10, None), slice(last // 50, last // 4)
    yield row("Force of the plateau", "N", 40.0, float(run.force[late, plateau].mean()), expected=amplitude)
    low, high, of_front = (scales.diameter * amplitude / (run.mass * c) for c in (upper, lower, speed))
    yield row("Bead velocity of the plateau", "m/s", None, float(run.velocity[late, plateau].mean()),
              "Theory: (4.9) with the lower bound of the speed, for which the virial holds; with the upper one "
              f"{low:.4g} m/s.", high, "thesis (4.9)")  # fmt: skip
    yield row("Mean velocity of all beads behind the front", "m/s", None, float(run.velocity[-1].sum()) / front,
              "Theory: (4.9) with the speed of the front, which is the balance of momentum.", of_front,
              "thesis (4.9)")  # fmt: skip
    half = run.array("energy/time") > 0.5 * run.array("energy/time")[-1]
    virial = 0.8 * run.array("energy/kinetic")[half].mean() / run.array("energy/elastic")[half].mean()
    yield Row("Virial 4 K / 5 P of the chain", "", 1.0, float(virial), "thesis (4.14)",
              "Average of the second half of the run.")  # fmt: skip


def pictures(run: ChainRun) -> Iterator[Picture]:
    """Force and velocity along the chain at the end."""
    lower, upper = (ChainScales(run).force_at_speed(speed) for speed in _bounds(run))
    force, velocity, largest = run.force[-1], run.velocity[-1], run.of_contacts("peak_force")
    contact, bead = np.arange(1, len(force) + 1), np.arange(1, len(velocity) + 1)
    figure, top, bottom = panels(4.2, rows=2, sharex=True)
    top.plot(contact, force, color=BLUE, linewidth=0.7, label=f"at {1e3 * run.time[-1]:.3g} ms")
    top.plot(contact[: passed(run)], largest[: passed(run)], color=ORANGE, label="largest so far")
    lines = [{"color": GREY, "linestyle": line, "linewidth": 0.8} for line in ("--", ":")]
    for bound, line in zip((lower, upper), lines, strict=True):
        top.axhline(bound, **line)
    key_of_lines(top, zip(("lower bound", "upper bound"), lines, strict=True))
    label(top, y="Contact force (N)", ylim=(0, 1.65 * upper))
    top.legend(ncols=2, loc="upper left")
    bottom.plot(bead, velocity, color=BLUE, linewidth=0.7)
    label(bottom, "Contact, bead", "Bead velocity (m/s)", ylim=(0, None), xlim=(0, len(bead)))
    data = {"contact": contact, "force_N": force, "largest_force_N": largest, "bead": bead, "velocity_m_s": velocity}
    caption = "Force and bead velocity along the chain under a steady force (thesis Fig. 4.2)"
    yield Picture("elastic_long_load", caption, Drawing(figure, data))


def _bounds(run: ChainRun) -> tuple[float, float]:
    """Speeds (4.16) and (4.12), m/s."""
    scales, force = ChainScales(run), run.load.largest
    lower = scales.diameter * math.sqrt(force / (run.mass * float(scales.overlap(np.array(force)))))
    return lower, math.sqrt(10 / 9) * lower


def _front(run: ChainRun) -> tuple[float, float]:
    """Speed of the front, m/s, and the contact that it has reached at the end."""
    last, level = passed(run), 0.5 * run.load.largest
    numbers = np.arange(last // 10, last + 1)
    times = [arrival(run.time, run.force[:, n - 1], level) for n in numbers]
    per_contact = float(np.polyfit(numbers, times, 1)[0])
    return run.case.packing.diameter / per_contact, last + (float(run.time[-1]) - times[-1]) / per_contact
