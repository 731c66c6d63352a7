"""The source on lateral constraints: printed values and their verification.

"Influence of Lateral Constraints on Wave Propagation in Finite Granular Crystals", J. Appl. Mech.,
2020: crystals of polyurethane cylinders between rigid walls are hit by a falling plate and observed
by a camera. The consequences of its printed formulas are computed here; its figures are not used.
"""

import numpy as np
from crystal import OURS, SOURCE
from relaxation import LONG, MEGA, TERMS, secant
from scipy.optimize import brentq

import granwave as gw
from granwave.measures import Chain

MODULI = (150.0, 530.0, 740.0, 480.0)  # MPa, of contacts 1 to 4
EVENT = 6.0  # ms, the longest duration that the source gives for its experiment
INSTANTS = 4001
FRAMES = 9  # steps of a rise; the history is exact for any number
STRAIN = 0.01
MILLI = 1e3  # from s


def rise_of(modulus):
    """Time, ms, after which the secant modulus of a linear rise has this value in MPa."""
    return brentq(lambda rise: secant(rise) - modulus, 1e-3, 1e3)


def secant_of_history(rise):
    """Ratio of stress to strain, MPa, at the end of a linear rise, whose duration is in ms, from
    the stress history.
    """
    time = np.linspace(0.0, rise / MILLI, FRAMES)
    terms = [(size * MEGA, tau / MILLI) for size, tau in TERMS]
    strain = STRAIN * time / time[-1]
    stress = gw.stress_history(time, strain, LONG * MEGA, terms)
    return stress[-1] / strain[-1] / MEGA


def impulse_gained(rise):
    """Impulse of a linear rise of the strain relative to the impulse of a linear law, minus 1, per
    cent.

    The linear law has the modulus that fits the stress best, by least squares.
    """
    time = np.linspace(0.0, rise, INSTANTS)[1:]
    strain = time / rise
    stress = secant(time) * strain
    fitted = (stress * strain).sum() / (strain**2).sum()
    return 100 * (np.trapezoid(stress, time) / np.trapezoid(fitted * strain, time) - 1)


def pulse(duration):
    """Time, ms, strain, and stress, MPa, of a half-sine pulse of the strain, without tensile
    stress.
    """
    time = np.linspace(0.0, duration, INSTANTS)
    terms = [(size * MEGA, tau / MILLI) for size, tau in TERMS]
    strain = STRAIN * np.sin(np.pi * time / duration)
    stress = gw.stress_history(time / MILLI, strain, LONG * MEGA, terms) / MEGA
    return time, strain, np.maximum(stress, 0.0)


def modulus_of_pulse(duration):
    """Modulus, MPa, of the linear law that fits a pulse best, by least squares."""
    _, strain, stress = pulse(duration)
    return (stress * strain).sum() / (strain**2).sum()


def impulse_of_pulse(modulus):
    """Duration, ms, of the pulse with this modulus, and its impulse relative to the impulse of the
    linear law, minus 1, per cent.
    """
    duration = brentq(lambda trial: modulus_of_pulse(trial) - modulus, 0.1, 1e2)
    time, strain, stress = pulse(duration)
    gained = np.trapezoid(stress, time) / np.trapezoid(modulus * strain, time) - 1
    return duration, 100 * gained


def impulse_rows():
    """Rows of the difference of impulses, for pulses that rise and fall."""
    found = [impulse_of_pulse(modulus) for modulus in MODULI]
    short = [(duration, abs(gained)) for duration, gained in found if duration <= EVENT]
    times = " to ".join(f"{duration:.2g}" for duration in (min(short)[0], max(short)[0]))
    differences = [gained for _, gained in short]
    for word, source, theory in (
        ("smallest", 1.65, min(differences)),
        ("largest", 2.2, max(differences)),
    ):
        yield gw.Row(
            f"Difference of impulses, elastic and viscoelastic, half-sines, {word}", "%", source,
            theory=theory, where=f"{SOURCE}, Fig. 3", digits=3,
            remark=f"Strains that rise and fall within {times} ms, for the printed moduli of "
            "contacts 2 to 4 by the linear law that fits each best. Impulses are nearly equal "
            "then, as printed, because the stress leads while the strain rises and lags while it "
            "falls. A pulse with 150 MPa would last longer than the experiment.",
        )  # fmt: skip


def rows(runs):
    slow = secant(EVENT, MILLI)
    for contact, modulus in enumerate(MODULI, start=1):
        rise = float(f"{rise_of(modulus):.3g}")
        remark = (
            f"Theory: stress divided by strain after a uniform rise of the strain in {rise:g} "
            "ms, by equation 7 with time "
        )
        remark += (
            "constants in ms. The rise time is chosen to fit the printed modulus, since the "
            "source does not print it; its experiment lasts 5 to 6 ms. "
        )
        remark += (
            f"With time constants in seconds, as printed, no rise within 6 ms gives less than "
            f"{slow:.0f} MPa."
        )
        if rise > EVENT:
            remark += " This rise time exceeds the duration of the experiment."
        yield gw.Row(f"Effective modulus at contact {contact}", "MPa", modulus, theory=secant(rise), digits=3,
                     where=f"{SOURCE}, 3", remark=remark)  # fmt: skip
        yield gw.Row(f"Stress / strain from the stress history, uniform rise within {rise:g} ms", "MPa", theory=secant(rise),
                     ours=secant_of_history(rise), where="equation 7, integrated", verification=True)  # fmt: skip
    gained = [impulse_gained(rise_of(modulus)) for modulus in MODULI]
    for word, source, theory in (("smallest", 1.65, min(gained)), ("largest", 2.2, max(gained))):
        quantity = f"Difference of impulses, elastic and viscoelastic, {word}"
        remark = (
            "Theory: uniform rises of the strain in the times of the rows above, compared "
            "with the linear law that fits each best. "
        )
        remark += (
            "The strains of the source are measured and not printed. Pulses that decrease again "
            "give differences of the printed size (next rows)."
        )
        yield gw.Row(
            quantity, "%", source, theory=theory, where=f"{SOURCE}, Fig. 3", remark=remark, digits=3
        )
    yield from impulse_rows()
    law = Chain(runs[0]).law_between(1, 2)
    mass = runs[0].spheres["mass"].iloc[0] / 2
    for speed in (1.0, 6.0):
        found = law.collide(mass, speed, loss_time=runs[0].case.contact.loss.time, steps=4000)
        yield gw.Row(f"Restitution of two grains at {speed:g} m/s, relaxation time 12 us", ours=found["restitution"],
                     where=OURS, digits=4,
                     remark="According to the source a spring with a dashpot has the same "
                            "restitution at all speeds.")  # fmt: skip


def tables(_):
    yield (
        "These statements of the source hold: region 1 exists, its border moves with the width, "
        "the lateral force falls at the same depth, upper rows move outwards and then inwards, "
        "and the centred-square crystal needs its walls. Two statements do not hold: that both "
        "crystals carry waves at one speed, and that the printed moduli give 125 m/s. Region 1 is "
        "the region that no signal of the sides has reached yet; it is not compressed by "
        "reflected waves."
    )
