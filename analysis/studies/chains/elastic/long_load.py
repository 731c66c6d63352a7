"""An elastic chain of like beads under a steady force that lasts to the end of the run (thesis 4.1.3, Fig. 4.2)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing
from granwave.analysis.measures.chains.steady_load import SteadyLoad
from granwave.analysis.studies.chains.runs import from_thesis, uniform
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

_FEWEST_CONTACTS = 200
_WHERE = "thesis 4.1.3"
_TOO_LARGE = 10 ** (1 / 6)  # factor in the speeds that the thesis prints


def select(runs: Sequence[FinishedRun]) -> list[SteadyLoad]:
    """Chains whose end the wave has not reached, each by itself."""
    return [
        SteadyLoad(run) for run in uniform(runs, "hertz")
        if run.load.kind == "force" and run.load.shape == "rectangle" and run.load.lasts >= 0.999 * run.time[-1]
        and run.undisturbed and run.passed >= _FEWEST_CONTACTS
    ]  # fmt: skip


def title(chain: SteadyLoad) -> str:
    """With the force."""
    return f"Long loading of an elastic chain, {chain.amplitude:g} N"


def text(chain: SteadyLoad) -> str:
    """Describe the runs."""
    run = chain.run
    return (
        f"A steady force of {chain.amplitude:g} N on the first of {run.velocity.shape[1]} elastic beads for "
        f"{1e3 * run.time[-1]:.4g} ms; the front is then at contact {chain.last}. Peak force there; speed of "
        "the front at half the force, over the last nine tenths of its way; plateau: the first quarter of it."
    )


def rows(chain: SteadyLoad) -> Iterator[Row]:
    """Peak, plateau and speeds, with their bounds; the source's values for its case alone."""
    scales, amplitude, peak = chain.scales, chain.amplitude, chain.peak
    thesis = from_thesis(chain.run) and math.isclose(amplitude, 40.0, rel_tol=1e-3)

    def row(what: str, unit: str, source: float | None, ours: float | None, remark: str = "",
            theory: float | None = None, where: str = _WHERE) -> Row:  # fmt: skip
        return Row(what, unit, source, ours, where, remark, theory)

    yield row("Peak force", "N", 92.7 if thesis else None, peak, f"At contact {chain.last}; it still rises slowly.",
              None if thesis else 92.7 / 40 * amplitude)  # fmt: skip
    printed = f"The printed speed is 10^(1/6) = {_TOO_LARGE:.4f} times too large. " if thesis else ""
    if thesis:
        remark = "The force whose speed by Nesterenko is the bound, with the stated constants."
        yield row("Lower bound of the peak force", "N", 78.15, None, remark, scales.force_at_speed(chain.lower))
        yield row("Upper bound of the peak force", "N", 107.2, None, remark, scales.force_at_speed(chain.upper))
        yield row("Lower bound of the speed (4.16)", "m/s", 668.0, None, printed, chain.lower)
        yield row("Upper bound of the speed (4.12)", "m/s", 704.0, None, printed, chain.upper)
    yield row("Speed of the front", "m/s", 687.2 if thesis else None, chain.speed,
              f"{printed}Theory: Nesterenko's of our peak force; the discrete wave is 1.2 % faster.",
              scales.nesterenko(peak))  # fmt: skip
    yield Row("Force of the plateau", "N", None, chain.plateau_force, "balance of forces", "", amplitude, True)
    yield row("Bead velocity of the plateau", "m/s", None, chain.plateau_velocity,
              "Theory: (4.9) with the lower bound of the speed, for which the virial holds; with the upper one "
              f"{chain.bead_velocity(chain.upper):.4g} m/s.", chain.bead_velocity(chain.lower),
              "thesis (4.9)")  # fmt: skip
    yield row("Mean velocity of all beads behind the front", "m/s", None, chain.mean_velocity,
              "Theory: (4.9) with the speed of the front, which is the balance of momentum.",
              chain.bead_velocity(chain.speed), "thesis (4.9)")  # fmt: skip
    yield Row("Virial 4 K / 5 P of the chain", "", None, chain.virial, "thesis (4.14)",
              "Average of the second half of the run.", 1.0)  # fmt: skip


def pictures(chain: SteadyLoad) -> Iterator[Picture]:
    """Force and velocity along the chain at the end."""
    run = chain.run
    lower, upper = (chain.scales.force_at_speed(speed) for speed in (chain.lower, chain.upper))
    force, velocity, largest = run.force[-1], run.velocity[-1], run.of_contacts("peak_force")
    contact, bead = np.arange(1, len(force) + 1), np.arange(1, len(velocity) + 1)
    figure, top, bottom = panels(4.2, rows=2, sharex=True)
    top.plot(contact, force, color=BLUE, linewidth=0.7, label=f"at {1e3 * run.time[-1]:.3g} ms")
    top.plot(contact[: chain.last], largest[: chain.last], color=ORANGE, label="largest so far")
    top.axhline(lower, color=GREY, linestyle="--", label="lower bound")
    top.axhline(upper, color=GREY, linestyle=":", label="upper bound")
    label(top, y="Contact force (N)", ylim=(0, 1.65 * upper))
    top.legend(ncols=2, loc="upper left")
    bottom.plot(bead, velocity, color=BLUE, linewidth=0.7)
    label(bottom, "Contact, bead", "Bead velocity (m/s)", ylim=(0, None), xlim=(0, len(bead)))
    data = {"contact": contact, "force_N": force, "largest_force_N": largest, "bead": bead, "velocity_m_s": velocity}
    caption = "Force and bead velocity along the chain under a steady force (thesis Fig. 4.2)"
    yield Picture("elastic_long_load", caption, Drawing(figure, data))
