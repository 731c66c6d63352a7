"""Filter: cylinders pressed on the gaps of a row, before the wave (thesis 7.1).

Steel spheres, with an aluminium cylinder on either side of every gap and a rigid wall on either
side of these, which moves in. Contacts with the walls follow the law of a half-space, all others
Hertz's.
"""

import math

from filter_row import WHERE, FilterRow

import granwave as gw

#: K, N/m^1.5, force of a wall on a cylinder, N, overlap there and lateral shift, um, at a = 8e-4, by gamma.
STATIC = {
    0.56: (4.198584e9, 29.668, 0.20347, 3.60653),
    0.90: (4.455122e9, 39.736, 0.25928, 3.55072),
}
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
    for gamma, known in STATIC.items():
        row = found[gamma]
        law = row.law_between(row.ids[0], row.beside[0])
        diameter = row.case.packing.diameter
        for name, unit, ours, theory in zip(
            ("K of sphere and cylinder", "Force of a wall on a cylinder", "Overlap of wall and cylinder",
             "Lateral shift of a cylinder"),
            ("N/m^1.5", "N", "um", "um"),
            (4 / 3 * law.effective_modulus * math.sqrt(law.effective_radius), row.wall_force,
             1e6 * (row.a * diameter / 2 - row.inward), 1e6 * row.inward),
            known, strict=True,
        ):  # fmt: skip
            yield gw.Row(
                f"{name} before the wave, {row.name}", unit, ours=ours, theory=theory, where=WHERE, verification=True,
                remark="Check value of the equations of the static state.",
            )  # fmt: skip
    yield gw.Row(
        "Smallest gamma whose cylinders reach the walls", source=0.25, theory=0.25, where=WHERE,
        remark="Theory: sqrt(gamma^2 + 2 gamma) + gamma = 1.",
    )  # fmt: skip


def tables(runs):
    columns = zip(("where", "printed", "right, and why"), zip(*ERRATA, strict=True), strict=True)
    yield "Errata of the source, chapter 7.1", dict(columns)
