"""Simple hexagonal lattice: hexagonal layers straight on top of each other."""

import math

from granwave.lammps_inputs.packing_kind import PackingKind

HEIGHT = math.sqrt(3) / 2  # of a row, diameters


def site(i, j, k):
    """Return x, y and z of sphere (i, j, k), diameters."""
    return i + (j % 2) / 2, j * HEIGHT, k * 1.0


LATTICES = {
    "simple-hexagonal": PackingKind(
        label="Simple hexagonal",
        layers="hexagonal, on top of each other",
        axes="xyz",
        row_period=2,
        pitch=(1.0, HEIGHT),
        site=site,
    )
}
