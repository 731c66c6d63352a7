"""A row of spheres with a cylinder on either side of every gap, between two rigid walls (thesis
7.1).

gamma and eta are the diameter and the length of the cylinders, and a is the approach of the walls,
all divided by the diameter of the spheres. Contact n is between spheres n and n + 1. The decay is
the decrease of ln(peak force) per contact.
"""

import csv
from pathlib import Path

import numpy as np

from granwave.measures import GrainRow, decay_rate

# density of the cylinders, kg/m^3: the value required by Fig. 7.4, and the printed value
DENSITY = 2700.0
PRINTED_DENSITY = 2100.0
SOLVER = "The theoretical value is from a second solver that assumes symmetric motion."
TABLE = Path(__file__).with_name("second_solver.csv")
WHERE = "thesis 7.1"
KILO = 1e3


def second_solver():
    """Values of the second solver by density, gamma and a; written by ``python -m
    tests.helpers.second_solver``.
    """
    with TABLE.open(encoding="utf-8", newline="") as stream:
        texts = list(csv.DictReader(stream))
    solved = {}
    for text in texts:
        row = {name: float(value) for name, value in text.items()}
        solved[row["density_kg_m3"], row["gamma"], row["a"]] = row
    return solved


class FilterRow(GrainRow):
    """A run of a row with cylinders, and its parameters in the thesis."""

    def __init__(self, run):
        super().__init__(run)
        case = self.case
        grains = self.case.packing.grains
        diameter = case.packing.diameter
        moved = case.precompression.moves["x"] if case.precompression else 0.0
        self.gamma, self.eta = (
            round(x / diameter, 9) for x in (grains.diameter[-1], grains.shape[-1].length)
        )
        self.a = round(2 * moved / diameter, 12)
        self.density = case.named_material(grains.material[-1]).density
        self.key = (self.density, self.gamma, self.a)
        self.speed = case.load.velocity
        self.yields = case.contact.law != "hertz"
        self.peaks = self.of_contacts("peak_force")
        density = "" if self.density == DENSITY else f", density {self.density:g} kg/m3"
        self.name = f"gamma {self.gamma:g}, a = {self.a:g}{density}"
        if self.a:
            wall = self.array("walls/xlo/force")
            self.wall_force = wall[0] / (len(self.beside) / 2)
            self.kept = wall[-1] / wall[0]

    def decay(self, first=71, last=201):
        """Decay of the peak force between two contacts."""
        return decay_rate(np.arange(first, last + 1), self.peaks[first - 1 : last])


def column(name):
    """Name of a column from words: ``a = 0.0008`` becomes ``a_0_0008``."""
    return "_".join("".join(letter if letter.isalnum() else " " for letter in name).split())
