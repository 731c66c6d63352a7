"""Check values of the filter of thesis 7.1, of our second solver of symmetric motion, and errata of the source."""

from __future__ import annotations

from collections.abc import Mapping

DENSITY, PRINTED_DENSITY = 2700.0, 2100.0  # of the cylinders, kg/m^3: what figure 7.4 needs, and what is printed

#: K, N/m^1.5, force of a wall on a cylinder, N, overlap there and lateral shift, um, at a = 8e-4, by gamma.
STATIC: Mapping[float, tuple[float, float, float, float]] = {
    0.56: (4.198584e9, 29.668, 0.20347, 3.60653),
    0.90: (4.455122e9, 39.736, 0.25928, 3.55072),
}

_CONTACTS = (21, 31, 61, 101, 151, 201)


def _at_contacts(*peaks: float) -> dict[int, float]:
    return dict(zip(_CONTACTS, peaks, strict=True))


#: Peak forces of figure 7.4, N: what the source says of the curve, and values by contact; by gamma and a.
PEAKS: Mapping[tuple[float, float], tuple[str, dict[int, float]]] = {
    (0.56, 0.0): ("near solitary", _at_contacts(158.9, 91.9, 89.5, 89.2, 88.7, 88.3)),
    (0.56, 8e-4): ("decays rapidly", _at_contacts(140.6, 93.3, 70.0, 49.1, 32.5, 22.9)),
    (0.90, 0.0): ("oscillating, decreasing", _at_contacts(168.6, 120.7, 88.9, 75.6, 64.9, 63.9)),
    (0.90, 8e-4): ("almost constant", _at_contacts(129.0, 66.5, 56.7, 56.6, 56.4, 56.2)),
}
#: The same with the printed density.
PEAKS_OF_PRINTED_DENSITY: Mapping[tuple[float, float], tuple[str, dict[int, float]]] = {
    (0.56, 0.0): (
        "near solitary: not with this density",
        _at_contacts(164.4, 100.9, 96.0, 90.4, 83.7, 77.6),
    ),
    (0.56, 8e-4): ("decays rapidly", _at_contacts(149.5, 115.4, 90.6, 68.9, 52.1, 41.5)),
    (0.90, 0.0): ("oscillating, decreasing", _at_contacts(169.2, 115.5, 66.7, 66.9, 65.3, 64.5)),
    (0.90, 8e-4): (
        "almost constant: not with this density",
        _at_contacts(132.0, 62.4, 61.1, 58.2, 54.4, 50.7),
    ),
}

_GAMMAS = (0.26, 0.34, 0.38, 0.42, 0.46, 0.50, 0.54, 0.58, 0.62, 0.66, 0.70, 0.74, 0.78, 0.82, 0.90)
_BY_APPROACH = {
    0.0: (1.8, 0.13, 0.67, 4.2, 5.9, 2.1, 0.04, 0.92, 2.5, 0.25, 0.20, 1.0, 0.04, 0.23, 1.1),
    4e-4: (0.31, 0.49, 0.10, 2.0, 5.1, 7.9, 9.0, 3.4, 0.09, 0.61, 2.0, 2.1, 0.48, 0.02, 0.57),
    8e-4: (0.05, 0.55, 0.02, 0.68, 2.8, 5.1, 7.2, 8.2, 4.1, 0.32, 0.22, 1.2, 1.8, 1.1, 0.07),
    12e-4: (0.01, 0.44, 0.15, 0.16, 1.5, 3.5, 5.4, 7.1, 7.3, 3.1, 0.24, 0.18, 0.98, 1.5, 0.21),
}
#: Decay per contact of figure 7.5a, 1e-3; by gamma and a.
DECAYS: Mapping[tuple[float, float], float] = {
    (gamma, approach): decay
    for approach, decays in _BY_APPROACH.items()
    for gamma, decay in zip(_GAMMAS, decays, strict=True)
}
#: The same of figure 7.4.
DRAWN: Mapping[tuple[float, float], float] = {(0.56, 8e-4): 8.0}
#: Largest force between spheres of figure 7.4, N.
LARGEST: Mapping[tuple[float, float], float] = {(0.56, 0.0): 207.0}
#: Ends of the axis of figure 7.4, N, of the colours of figure 7.2, 1e-3 a contact, by a, and of those of figure 7.3.
AXIS, COLOURS_END, RATIO = 300.0, {0.0: 7.0, 8e-4: 9.0}, 10.0
#: The same of figure 7.5b.
APPROACHED: Mapping[tuple[float, float], float] = {
    (0.45, 0.0): 6.2,
    (0.45, 3e-3): 0.0,
    (0.54, 5e-4): 8.9,
    (0.54, 3e-3): 2.0,
    (0.67, 0.0): 0.05,
    (0.67, 2.5e-4): 2.1,
    (0.67, 7.5e-4): 0.02,
    (0.67, 2.4e-3): 6.3,
}
#: gamma of the fastest decay, by a.
VALLEYS: Mapping[float, float] = {0.0: 0.46, 4e-4: 0.53, 8e-4: 0.57, 12e-4: 0.60}

ERRATA = (
    (
        "7.2",
        "2 kcs (beta - beta)",
        "a factor cos theta is missing (7.3 has it); the mass on the left is that of a sphere",
    ),
    (
        "7.4",
        "kcs sin (beta_(i+1/4) - beta_(i+3/4))",
        "plus: both spheres push the cylinder outward; with minus there is no static balance",
    ),
    (
        "7.1, materials",
        "aluminium of 2100 kg/m^3",
        "2700: with 2100 neither the first nor the last curve of Fig. 7.4 is what the text says of it (rows above); "
        "chapter 8 has 2800",
    ),
    ("7.1", "the diameter of the spheres is missing", "9.525 mm, that of 7.2, fits the axis of Fig. 7.4"),
    (
        "Fig. 7.3",
        "caption: ratio of decay rates; text: ratio of peak forces",
        "decay rates, by the range of -10 to 10",
    ),
    (
        "Figs 7.2, 7.5",
        "sign and size of the decay rate",
        "positive is decay in 7.2, negative in 7.5, whose values are -50 times those of 7.2",
    ),
    (
        "7.1, text",
        "the map at a = 0 is highly irregular at large gamma, for the wave spreads over ten beads",
        "it is smooth below gamma = 0.9; the line law makes overlaps of 1e-300 m at the foot of a wave, where a "
        "logarithm fails: 0 below 1e-25 m",
    ),
)
