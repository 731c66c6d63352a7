"""The source on lateral constraints: its own numbers, whether they stand up, and a list of its errors."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.document.model import Column, Note, Table
from granwave.analysis.studies.lateral.runs import LateralRun, lateral_runs
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Row
from granwave.analysis.studies.tables import table_of
from granwave.lammps_inputs.contact.law import pair_contact

TITLE = "The source on lateral constraints: what it prints, and what holds"
TEXT = (
    '"Influence of Lateral Constraints on Wave Propagation in Finite Granular Crystals", J. Appl. Mech., 2020: '
    "crystals of "
    "polyurethane cylinders between rigid walls, struck by a falling plate, watched by a camera. What follows from "
    "its printed formulas is worked out here; its figures are not used."
)
_SOURCE = "lateral constraints"
_LONG, _TERMS = 15.7, ((253.1, 2.64), (1320.4, 0.55))  # MPa and s, equation 7
_MODULI = (150.0, 530.0, 740.0, 480.0)  # MPa, of contacts 1 to 4
_PULSES = (1e-3, 2e-3, 4e-3, 6e-3)  # s


def select(runs: Sequence[FinishedRun]) -> list[list[LateralRun]]:
    """All runs of such crystals, if there are any of polyurethane with the loss of the reference."""
    found = [run for run in lateral_runs(runs) if run.loss_time]
    return [found] if found else []


def rows(group: list[LateralRun]) -> Iterator[Row]:
    """Moduli and impulses that follow from equation 7, and the restitution of the contacts that are used here."""
    where = f"{_SOURCE}, 3"
    remark = (
        f"By its equation 7 pulses of up to 6 ms have {_relaxed(6e-3):.0f} to {_relaxed(0.0):.0f} MPa, whatever their "
        "rate: 150 to 740 MPa would take seconds."
    )
    for contact, modulus in enumerate(_MODULI, start=1):
        yield Row(f"Effective modulus at contact {contact}", "MPa", modulus, None, where, remark, _relaxed(6e-3))
    lost, remark = [_impulse_lost(time) for time in _PULSES], "Half-sine strains of 1 to 6 ms with its equation 7."
    for word, source, theory in (("least", 1.65, min(lost)), ("most", 2.2, max(lost))):
        quantity = f"Difference of impulses, elastic and viscoelastic, {word}"
        yield Row(quantity, "%", source, None, f"{_SOURCE}, Fig. 3", remark, theory)
    run = next((one for one in group if math.isclose(one.loss_time, 12e-6)), group[0])
    if math.isclose(run.loss_time, 12e-6) and math.isclose(run.case.material.youngs_modulus, 70e6):
        law, mass = pair_contact(run.assembly, 1, 2), run.assembly.mass_of(1) / 2
        for speed, expected in ((1.0, 0.7468), (6.0, 0.7141)):
            found = float(law.collide(mass, speed, loss_time=run.loss_time, steps=4000)["restitution"])
            yield Row(f"Restitution of two grains at {speed:g} m/s, loss time 12 us", "", None, found,
                      "our second program", "The source: a spring and dashpot has the same restitution at all speeds.",
                      expected, True, 4)  # fmt: skip


def tables(_: list[LateralRun]) -> Iterator[Table | Note]:
    """The errors of the source, one a line."""
    yield Note(
        "Region 1 exists, its border moves with the width, the lateral force falls at the same depth, upper rows "
        "move out and then in, and the centred-square crystal needs its walls: all that holds. That both crystals "
        "carry waves at one speed, and that its moduli give 125 m/s, does not; and region 1 is where no signal of "
        "the sides has arrived yet, not where reflected waves compress."
    )
    columns = (Column("Where"), Column("Printed"), Column("What holds, and why"))
    yield table_of("Errors of the source", columns, _ERRATA)


def _relaxed(time: float) -> float:
    """Return the relaxation modulus of equation 7, MPa."""
    return _LONG + sum(size * math.exp(-time / tau) for size, tau in _TERMS)


def _impulse_lost(duration: float) -> float:
    """Return how much less the impulse of a half-sine pulse of strain is than at the modulus of time 0, per cent."""
    time = np.linspace(0.0, duration, 4001)
    strain, rate = np.sin(np.pi * time / duration), np.pi / duration * np.cos(np.pi * time / duration)
    step = time[1]
    stress = _LONG * strain
    for size, tau in _TERMS:
        held, values = 0.0, np.zeros_like(time)
        for n in range(1, len(time)):
            held = held * math.exp(-step / tau) + size * 0.5 * (rate[n] + rate[n - 1]) * step
            values[n] = held
        stress = stress + values
    return float(100 * (1 - np.trapezoid(stress, time) / np.trapezoid(_relaxed(0.0) * strain, time)))


_ERRATA = (
    ("3, effective moduli", "150, 530, 740, 480 MPa; impulses differ by 1.65 to 2.2 %",
     "By equation 7 the stress of any strain that rises within 6 ms is between 1574 and 1589 MPa times it; impulses "
     "differ by "
     "0.5 % at most. 740 to 150 MPa would take pulses of 1.2 to 10 s."),
    ("Equation 7", "253.1 and 1320.4 MPa, times in seconds",
     "E(1 s) = 403 MPa; Shore A 80 read after a second means 9.4 MPa. The long-time modulus, 15.7 MPa, is plausible."),
    ("Fig. 9, 125 m/s", "with equation 7, or the effective moduli",
     "An ideal crystal needs 76 MPa (BCC) or 25 MPa (HCP) for it: long waves run at D/sqrt(2) sqrt((k_n + k_t)/m) "
     "and at "
     "sqrt(3)/2 D sqrt((1.5 k_n + 0.5 k_t)/m)."),
    ("Equation 8", "a sum without the long-time modulus, the strain rate before the integral",
     "Add it; what is printed holds for a constant rate alone. In general sigma = integral of E(t - tau) d eps."),
    ("Equation 4", "sum of x x f = m x_c x a_c",
     "Plus I alpha, which the rotations that the source itself reports make felt: 3 to 5 % of the forces."),
    ("Equation 6", "V sigma + m x_c a_c",
     "Plus m R^2/4 (alpha eps - omega^2 1), of the acceleration within the grain."),
    ("Equation 9", "Hertz's law; its solution is an exponential function",
     "That is the law of spheres; cylinders have a line contact. It conserves energy, and its pulses keep their "
     "height. With "
     "displacements downwards both brackets have the other sign."),
    ("Fig. 7, 1.6 to 1.8 1/m", "an exponential over region 1",
     "It is 2.0 to 2.3 % a diameter and 15 % over all: no straight line can be told from it, least of all with "
     "frames that "
     "miss up to a third of the largest speeds. The size is right for a plate."),
    ("3, broadening", "a power law, i.e. faster than exponential", "A power law is slower in the end."),
    ("3, Fig. 10", "exp(v/v0)^2, exp(v/v0)^1.5", "exp(-(v/v0)^2), exp(-(v/v0)^1.5)."),
    ("3", "a tensile lateral load on the upper rows", "Grains that do not stick bear none: the lateral load falls."),
    ("3", "forces in Fig. 7, a huge peak in Fig. 8", "They are in Fig. 8 and Fig. 9."),
    ("1", "the cost of discrete elements grows exponentially", "It grows linearly with lists of neighbours."),
    ("1", "a spring and dashpot assumes a constant restitution",
     "The linear one alone: with a loss time the restitution falls from 0.75 at 1 m/s to 0.71 at 6 m/s."),
    ("Conclusions", "reflected waves compress region 1, which is as deep as the crystal is wide",
     "The width sets it, but region 1 is where no signal of the sides has arrived: free sides give the same depth, "
     "W/2 in BCC "
     "and 0.87 W in HCP."),
)  # fmt: skip
