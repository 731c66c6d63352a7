"""Confined chains: sizes, constants and static balance.

Each contact of a chain of 15 mm brass beads has a ring of n small spheres, which touch the beads,
their neighbours and the tube. Check values are computed from the same formulas without granwave.
The legends of the source give precompressions a. The static balance of a small sphere then gives
its inward displacement, which turns out to be the same fraction of D for every n.
"""

import math

from confined_rows import BEAD, DENSITY, FORCE, K_BEADS, MODULUS, TIME, VELOCITY, Rows

import granwave as gw

NAMES = (
    "Diameter of the small spheres / D", "Radius of the tube / D", "cos(theta)", "eps", "eta",
    "gamma with the source's factor", "gamma in the tube",
)  # fmt: skip
SIZES = {
    6: (0.66667, 1.00000, 0.60000, 0.2963, 0.2494, 2.0785, 2.5645),
    7: (0.46383, 0.76642, 0.68314, 0.0998, 0.3071, 1.7337, 2.1136),
    8: (0.34315, 0.61991, 0.74452, 0.0404, 0.3419, 1.4912, 1.8006),
    9: (0.26495, 0.51980, 0.79055, 0.0186, 0.3596, 1.3103, 1.5698),
}
UNITS = (
    ("E* of two beads", "Pa", MODULUS / 2, 63.187e9),
    ("E* R*^2 of two beads", "N", FORCE, 888567.0),
    ("Unit of time sqrt(m_b/k_bb), in SI", "", TIME, 1.7063e-6),
    ("v sqrt(pi/2 rho (1 - nu^2)/E) of 1 m/s, on which the response depends", "",
     math.sqrt(math.pi / 2 * DENSITY / MODULUS), 3.2504e-4),
)  # fmt: skip
LEGENDS = {  # a of figures 6.2 and 6.3, for inward motions of the small spheres of these parts of D
    6: (5.2e-4, 1.3e-3, 2.1e-3),
    7: (5.0e-4, 1.3e-3, 2.0e-3),
    8: (4.8e-4, 1.2e-3, 1.9e-3),
    9: (4.6e-4, 1.2e-3, 1.9e-3),
}
INWARD = (1.6e-4, 4.0e-4, 6.4e-4)


def balance(row, part):
    """Values of a for inward displacements of small spheres by a fraction of D: with the ring as
    printed, with the correct ring, and without a ring.
    """
    inward = part * BEAD
    angle = math.pi / row.n[0]
    sine = math.sqrt(1 - row.cosine[0] ** 2)
    beads = 2 * row.k_side[0] * (inward * sine) ** 1.5 * sine
    printed = 2 * K_BEADS * (2 * inward * math.cos(angle)) ** 1.5 * math.sin(angle)
    for ring in (printed, row.from_ring(inward)[0], 0.0):
        yield 2 / BEAD * (inward + ((beads + ring) / row.k_thesis_wall[0]) ** (2 / 3))


def rows(runs):
    check = {
        "verification": True,
        "remark": "The check value follows from the same formulas, computed without granwave.",
    }
    of_ratios = {"where": "thesis 6.8"}
    # fmt: off
    found = {n: Rows.fitting(n) for n in SIZES}
    for n, known in SIZES.items():
        row = found[n]
        ours = (row.small / BEAD, row.tube / BEAD, row.cosine, row.eps, row.eta, row.k_thesis_wall / K_BEADS,
                row.k_wall / K_BEADS)
        for name, value, theory in zip(NAMES, ours, known, strict=True):
            yield gw.Row(f"{name}, n = {n}", ours=value[0], theory=theory, where="thesis 6.1 to 6.8", **check)
    for name, unit, ours, theory in UNITS:
        yield gw.Row(name, unit, ours=ours, theory=theory, where="thesis 6.1", **check)
    row = found[8]
    yield gw.Row("eps = m_s/m_b, n = 8", source=0.04, ours=row.eps[0], **of_ratios)
    yield gw.Row("eta, n = 8", source=0.34, ours=row.eta[0], **of_ratios)
    yield gw.Row("gamma = k_w/k_bb, n = 8", source=1.53, ours=(row.k_wall / K_BEADS)[0],
                 theory=(row.k_thesis_wall / K_BEADS)[0], **of_ratios,
                 remark="The theory is the formula of the source, with the factor 1.2. Our value "
                        "is for the elliptic contact in the tube; for a flat wall it is 1.657.")
    yield gw.Row("Impact velocity of 1 m/s in the source's unit", source=1.35e-4, theory=1 / VELOCITY,
                 where="thesis 6.1",
                 remark="The unit D sqrt(k_bb/m_b) of the source is not dimensionless (m^(-1/4)). "
                        "1.3528e-4 holds for D = 30 mm; figures 6.2 and 6.5 are for 15 mm.")
    for n, legends in LEGENDS.items():
        for printed, part in zip(legends, INWARD, strict=True):
            with_printed, with_right, without = balance(found[n], part)
            remark = (f"The printed balance requires {with_printed:.3g}, the correct balance {with_right:.3g}")
            remark += "; the legends follow from the balance without the ring." if part == INWARD[0] else "."
            yield gw.Row(f"a of the legends, n = {n}, small spheres moved inwards by {part:g} D", source=printed,
                         theory=without, where="thesis figures 6.2, 6.3", remark=remark)
    # fmt: on
