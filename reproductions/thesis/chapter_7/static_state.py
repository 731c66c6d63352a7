"""Filter: static state of a chain with cylinders pressed onto its gaps (thesis 7.1).

A chain of steel spheres has an aluminium cylinder on either side of every gap. Rigid walls on both
sides of the cylinders move in. Contacts with the walls follow the law of a half-space, all others
Hertz's law.
"""

import math

from filter_row import DENSITY, SOLVER, WHERE, FilterRow, second_solver

import granwave as gw

A = 8e-4
GAMMAS = (0.56, 0.90)


def rows(runs):
    found = {row.gamma: row for row in map(FilterRow, runs)}
    solved = second_solver()
    # fmt: off
    for gamma in GAMMAS:
        row = found[gamma]
        theory = solved[DENSITY, gamma, A]
        law = row.law_between(row.ids[0], row.beside[0])
        approach = row.a * row.case.packing.diameter / 2
        for name, unit, ours, value in (
            ("K of sphere and cylinder", "N/m^1.5", 4 / 3 * law.effective_modulus * math.sqrt(law.effective_radius),
             theory["side_stiffness"]),
            ("Force of a wall on a cylinder", "N", row.wall_force, theory["wall_force_N"]),
            ("Overlap of wall and cylinder", "um", 1e6 * (approach - row.inward), 1e6 * (approach - theory["shift_m"])),
            ("Lateral shift of a cylinder", "um", 1e6 * row.inward, 1e6 * theory["shift_m"]),
        ):
            yield gw.Row(f"{name} before the wave, {row.name}", unit, ours=ours, theory=value, where=WHERE,
                         verification=True, remark=SOLVER)
    # fmt: on
    yield gw.Row(
        "Smallest gamma whose cylinders reach the walls",
        source=0.25,
        theory=0.25,
        where=WHERE,
        remark="Theory: sqrt(gamma^2 + 2 gamma) + gamma = 1.",
    )  # fmt: skip
