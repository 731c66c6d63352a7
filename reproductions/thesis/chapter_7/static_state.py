"""Filter: cylinders pressed on the gaps of a row, before the wave (thesis 7.1).

Steel spheres, with an aluminium cylinder on either side of every gap and a rigid wall on either
side of these, which moves in. Contacts with the walls follow the law of a half-space, all others
Hertz's.
"""

import math

from filter_row import DENSITY, SOLVER, WHERE, FilterRow, second_solver

import granwave as gw

A = 8e-4
GAMMAS = (0.56, 0.90)
ERRATA = (
    ("7.2", "2 kcs (beta - beta)",
     "a factor cos theta is missing (7.3 has it); the mass on the left is that of a sphere"),
    ("7.4", "kcs sin (beta_(i+1/4) - beta_(i+3/4))",
     "plus: both spheres push the cylinder outward; with minus there is no static balance"),
    ("7.1, materials", "aluminium of 2100 kg/m^3",
     "2700: with 2100 neither the first nor the last curve of Fig. 7.4 is what the text says of it (rows of the peak "
     "forces); chapter 8 has 2800"),
    ("7.1", "the diameter of the spheres is missing", "9.525 mm, that of 7.2, fits the axis of Fig. 7.4"),
    ("Fig. 7.3", "caption: ratio of decay rates; text: ratio of peak forces",
     "decay rates, by the range of -10 to 10"),
    ("Figs 7.2, 7.5", "sign and size of the decay rate",
     "positive is decay in 7.2, negative in 7.5, whose values are -50 times those of 7.2"),
    ("7.1, text", "the map at a = 0 is highly irregular at large gamma, for the wave spreads over ten beads",
     "it is smooth below gamma = 0.9; the line law makes overlaps of 1e-300 m at the foot of a wave, where a logarithm "
     "fails: 0 below 1e-25 m"),
)  # fmt: skip


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


def tables(runs):
    columns = zip(("where", "printed", "right, and why"), zip(*ERRATA, strict=True), strict=True)
    yield "Errata of the source, chapter 7.1", dict(columns)
