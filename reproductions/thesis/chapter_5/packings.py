"""Packings: scaling, quadratic law and loading area.

Impacts along [111] at 0.03 to 40 m/s act on an FCC packing of 36 × 36 × 18 spheres. In the
quadratic law velocities are normalised (thesis 5.11), and the unit of energy makes the input v0²/2.
The law is fitted to the fast impacts, with equal relative weights. The constants printed in the
source do not fit its figure: at a normalised velocity of 94.9 they give more dissipation than
input. No change of units resolves this: units of energy and velocity that give D0 and D1 make D2
ten times as large. The printed constants are therefore not compared.
"""

import numpy as np

import granwave as gw

BRASS = {"packing.diameter": 0.01, "material.density": 8500, "material.youngs_modulus": 115e9,
         "material.yield_strength": 550e6}  # fmt: skip
WORDS = {"packing.diameter": ("diameter", 1e-3, "mm"), "material.density": ("density", 1, "kg/m³"),
         "material.youngs_modulus": ("modulus", 1e9, "GPa"),
         "material.yield_strength": ("yield strength", 1e6, "MPa")}  # fmt: skip
NORMALISED = {4: (37.9, ""), 10: (94.9, "; exactly 94.85"), 40: (379, "")}  # by velocity, m/s
SAME = 1e-4  # relative difference of normalised velocities and energies that are meant to be equal
FAST = 0.1  # fraction of the largest velocity; below, too many peak forces are near F_y
CONSTANTS = (
    ("D0", None, 2, "The constant is undetermined, since its standard deviation is as large as "
                    "its value."),
    ("D1", None, 3, "The constant depends on the range of the fit (see the next rows)."),
    ("D2", 0.5, 5, "Fast impacts dissipate nearly all of their energy, so that every correct code "
                   "gives 0.5, the input v0^2/2."),
)  # fmt: skip
LAW_ENDS = 0.2  # overlap over the effective radius R*, a quarter of the diameter
RANGES = ((4.0, 16.0), (10.0, 40.0))  # m/s, of further fits


def measured(runs):
    """Runs with one impacted brass sphere of 10 mm by velocity, runs with other spheres by name,
    and all runs with brass.
    """
    brass = []
    others = {}
    for run in (
        run for run in runs if "load.velocity" in run.labels and "packing.size" not in run.labels
    ):
        name = ", ".join(f"{word} {run.labels[key] / unit:.4g} {of}" for key, (word, unit, of) in WORDS.items()
                         if run.labels.get(key, BRASS[key]) != BRASS[key])  # fmt: skip
        (others.setdefault(name, []) if name else brass).append(run)
    reference = sorted(
        (run for run in brass if run.case.load.spheres == 1),
        key=lambda run: run["velocity_normalised"],
    )
    return reference, others, brass


def quadratic_law(chosen):
    """Quadratic law of runs with one impacted sphere."""
    velocity = np.array([run["velocity_normalised"] for run in chosen])
    share = np.array([run["dissipated_fraction"] for run in chosen])
    return gw.measures.quadratic_law(velocity, share * 0.5 * velocity**2)


def fast_runs(reference):
    """Runs whose peak forces are mostly far above F_y."""
    least = FAST * reference[-1]["velocity_normalised"] * (1 - SAME)
    return [run for run in reference if run["velocity_normalised"] >= least]


def rows(runs):
    reference, others, brass = measured(runs)
    for run in reference:
        if known := NORMALISED.get(run.case.load.velocity):
            yield gw.Row("Velocity, normalised", source=known[0], theory=run["velocity_normalised"],
                         where="thesis 5.3.2, Fig. 5.8", remark=(
                             f"The normalisation is thesis 5.11{known[1]}."))  # fmt: skip
    yield from constants(reference)
    for name, group in others.items():
        gaps = [abs(run["dissipated_fraction"] - twin["dissipated_fraction"]) for run in group for twin in reference
                if abs(run["velocity_normalised"] / twin["velocity_normalised"] - 1) < SAME]  # fmt: skip
        what = (
            f"Largest difference in dissipated fraction at {len(gaps)} equal normalised "
            f"velocities: {name}"
        )
        overlap = max(run["peak_overlap_m"] / (run.case.packing.diameter / 4) for run in group)
        yield gw.Row(what, ours=max(gaps), theory=0.0, where="thesis Fig. 5.5", digits=2,
                     remark=f"The source has one curve. Overlaps reach {overlap:.2g} R*; the "
                            f"contact law is valid up to {LAW_ENDS:g} R*.")  # fmt: skip
    for run in reference:
        equal = {one.case.load.spheres: one["dissipated_fraction"] for one in brass
                 if abs(one["energy_input_J"] / run["energy_input_J"] - 1) < SAME}  # fmt: skip
        for count in sorted(equal.keys() - {1}):
            what = f"Dissipated fraction, impact on {count} spheres / on one, input "
            energy = float(f"{run['energy_input_normalised']:.2g}")
            yield gw.Row(
                what + f"{energy:g} F_y alpha_y",
                source=1.0,
                digits=3,
                ours=equal[count] / equal[1],
                where="thesis Fig. 5.7",
                remark="The curves of the source overlap. An impact on one sphere dissipates "
                f"{equal[1]:.3f} of the energy.",
            )


def constants(reference):
    """Rows of the constants of the quadratic law, and of D1 by the range of the fit."""
    law = quadratic_law(fast_runs(reference))
    for (name, theory, digits, text), ours, deviation in zip(
        CONSTANTS, law.constants, law.deviations, strict=True
    ):
        remark = f"The standard deviation is {deviation:.2g}. {text}"
        yield gw.Row(
            f"{name} of the quadratic law, where the input is v0²/2",
            ours=ours,
            theory=theory,
            where="thesis 5.17",
            remark=remark,
            verification=theory is not None,
            digits=digits,
        )
    for least, most in RANGES:
        chosen = [run for run in reference if least <= run.case.load.velocity <= most]
        law = quadratic_law(chosen)
        yield gw.Row(
            f"D1 of the quadratic law, fitted from {least:g} to {most:g} m/s",
            ours=law.constants[1],
            where="thesis 5.17",
            remark=f"The standard deviation is {law.deviations[1]:.1g}.",
            digits=3,
        )
