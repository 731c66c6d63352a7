"""The source on lateral constraints: what it prints, and what holds.

"Influence of Lateral Constraints on Wave Propagation in Finite Granular Crystals", J. Appl. Mech.,
2020: crystals of polyurethane cylinders between rigid walls, struck by a falling plate, watched by
a camera. What follows from its printed formulas is worked out here; its figures are not used.
"""

import numpy as np
from crystal import OURS, SOURCE, not_kept
from scipy.signal import lfilter

import granwave as gw
from granwave.measures import Chain

# MPa and s, equation 7
LONG = 15.7
TERMS = ((253.1, 2.64), (1320.4, 0.55))
MODULI = (150.0, 530.0, 740.0, 480.0)  # MPa, of contacts 1 to 4
PULSES = (1e-3, 2e-3, 4e-3, 6e-3)  # s
ERRATA = (
    ("3, effective moduli", "150, 530, 740, 480 MPa; impulses differ by 1.65 to 2.2 %",
     "By equation 7 the stress of any strain that rises within 6 ms is between 1574 and 1589 MPa times it; impulses "
     "differ by 0.5 % at most. 740 to 150 MPa would take pulses of 1.2 to 10 s."),
    ("Equation 7", "253.1 and 1320.4 MPa, times in seconds",
     "E(1 s) = 403 MPa; Shore A 80 read after a second means 9.4 MPa. The long-time modulus, 15.7 MPa, is plausible."),
    ("Fig. 9, 125 m/s", "with equation 7, or the effective moduli",
     "An ideal crystal needs far less for it, see the rows of the modulus: long waves run at D/sqrt(2) sqrt((k_n + k_t)/m) "
     "and at sqrt(3)/2 D sqrt((1.5 k_n + 0.5 k_t)/m)."),
    ("Equation 8", "a sum without the long-time modulus, the strain rate before the integral",
     "Add it; what is printed holds for a constant rate alone. In general sigma = integral of E(t - tau) d eps."),
    ("Equation 4", "sum of x x f = m x_c x a_c",
     "Plus I alpha, which the rotations that the source itself reports make felt."),
    ("Equation 6", "V sigma + m x_c a_c",
     "Plus m R^2/4 (alpha eps - omega^2 1), of the acceleration within the grain."),
    ("Equation 9", "Hertz's law; its solution is an exponential function",
     "That is the law of spheres; cylinders have a line contact. It conserves energy, and its pulses keep their "
     "height. With displacements downwards both brackets have the other sign."),
    ("Fig. 7, 1.6 to 1.8 1/m", "an exponential over region 1",
     "It is so small that no straight line can be told from it, least of all with frames that miss a part of the "
     "largest speeds. The size is right for a plate."),
    ("3, broadening", "a power law, i.e. faster than exponential", "A power law is slower in the end."),
    ("3, Fig. 10", "exp(v/v0)^2, exp(v/v0)^1.5", "exp(-(v/v0)^2), exp(-(v/v0)^1.5)."),
    ("3", "a tensile lateral load on the upper rows", "Grains that do not stick bear none: the lateral load falls."),
    ("3", "forces in Fig. 7, a huge peak in Fig. 8", "They are in Fig. 8 and Fig. 9."),
    ("1", "the cost of discrete elements grows exponentially", "It grows linearly with lists of neighbours."),
    ("1", "a spring and dashpot assumes a constant restitution",
     "The linear one alone: with a loss time the restitution falls with the velocity, see the rows."),
    ("Conclusions", "reflected waves compress region 1, which is as deep as the crystal is wide",
     "The width sets it, but region 1 is where no signal of the sides has arrived: free sides give the same depth, "
     "W/2 in BCC and 0.87 W in HCP."),
)  # fmt: skip


def relaxed(time):
    """Relaxation modulus of equation 7, MPa."""
    return LONG + sum(size * np.exp(-time / tau) for size, tau in TERMS)


def impulse_lost(duration):
    """Impulse that a half-sine pulse of strain lacks of that at the modulus of time 0, per cent."""
    time = np.linspace(0.0, duration, 4001)
    strain = np.sin(np.pi * time / duration)
    rate = np.pi / duration * np.cos(np.pi * time / duration)
    added = np.append(0.0, 0.5 * (rate[1:] + rate[:-1])) * time[1]
    stress = LONG * strain
    for size, tau in TERMS:
        stress = stress + lfilter([size], [1.0, -np.exp(-time[1] / tau)], added)
    return 100 * (1 - np.trapezoid(stress, time) / np.trapezoid(relaxed(0.0) * strain, time))


def rows(runs):
    slow = relaxed(6e-3)
    lost = [impulse_lost(time) for time in PULSES]
    remark = f"By its equation 7 pulses of up to 6 ms have {slow:.0f} to {relaxed(0.0):.0f} MPa, whatever their rate: "
    remark += "150 to 740 MPa would take seconds."
    for n, modulus in enumerate(MODULI, start=1):
        yield gw.Row(f"Effective modulus at contact {n}", "MPa", modulus, theory=slow, where=f"{SOURCE}, 3",
                     remark=remark)  # fmt: skip
    for word, source, theory in (("least", 1.65, min(lost)), ("most", 2.2, max(lost))):
        quantity = f"Difference of impulses, elastic and viscoelastic, {word}"
        remark = "Half-sine strains of 1 to 6 ms with its equation 7."
        yield gw.Row(quantity, "%", source, theory=theory, where=f"{SOURCE}, Fig. 3", remark=remark)
    law = Chain(runs[0]).law_between(1, 2)
    mass = runs[0].spheres["mass"].iloc[0] / 2
    for speed, expected in ((1.0, 0.7468), (6.0, 0.7141)):
        found = law.collide(mass, speed, loss_time=runs[0].case.contact.loss.time, steps=4000)
        yield gw.Row(f"Restitution of two grains at {speed:g} m/s, loss time 12 us", ours=found["restitution"],
                     where=OURS, digits=4, remark=not_kept(expected, "The source: a spring and dashpot has the same "
                                                           "restitution at all speeds."))  # fmt: skip


def tables(_):
    yield (
        "Region 1 exists, its border moves with the width, the lateral force falls at the same depth, upper rows "
        "move out and then in, and the centred-square crystal needs its walls: all that holds. That both crystals "
        "carry waves at one speed, and that its moduli give 125 m/s, does not; and region 1 is where no signal of "
        "the sides has arrived yet, not where reflected waves compress."
    )
    columns = zip(
        ("Where", "Printed", "What holds, and why"), zip(*ERRATA, strict=True), strict=True
    )
    yield "Errors of the source", dict(columns)
