"""27 spheres on a block, and cylinders between two plates that open the gaps of the row or lie
loose (thesis 8).
"""

import csv
from pathlib import Path

import numpy as np

from granwave.measures import GrainRow, first_peak

# distance of the plates, m; friction of the plates, from the source's fit
SPHERE = 9.5e-3
CYLINDER = 5.14e-3
FRICTION = 0.185
SENSORS = (6, 21)  # spheres
STATES = ("no cylinders", "open gaps", "loose, upstream", "loose, downstream")
SOLVER = "The theoretical value is from a second solver that assumes symmetric motion."
TABLE = Path(__file__).with_name("second_solver.csv")


def second_solver():
    """Values of the second solver by state, friction, number of cylinders and of spheres, and
    velocity; written by ``python -m tests.helpers.second_solver``.
    """
    with TABLE.open(encoding="utf-8", newline="") as stream:
        texts = list(csv.DictReader(stream))
    solved = {}
    for text in texts:
        state = text.pop("state")
        row = {name: float(value) for name, value in text.items()}
        key = (row["friction"], row["cylinders"], row["spheres"], row["velocity_m_s"])
        solved[state, *key] = row
    return solved


class SwitchRow(GrainRow):
    """A run of the chain, the state of its cylinders, and its first peak (s, N) at sphere 21."""

    def __init__(self, run):
        super().__init__(run)
        place = self.array("spheres/position")
        self.spheres, self.cylinders = place[self.ids - 1, 2], place[self.beside - 1]
        self.n, self.speed, self.state = len(self.beside), self.case.load.velocity, STATES[0]
        self.friction = self.case.boundary.friction
        if self.n:
            z = self.cylinders[0, 2]
            before = z - self.spheres[self.spheres < z][-1]
            behind = self.spheres[self.spheres > z][0] - z
            same = np.isclose(before, behind, rtol=1e-3)
            self.state = STATES[1] if same else STATES[2] if before < behind else STATES[3]
            self.height = (
                2 * np.abs(self.cylinders[:, 0]).max() + CYLINDER
            )  # distance of the plates
        self.name = (
            f"{self.state}, {self.n} cylinders, friction {self.friction:g}"
            if self.n
            else self.state
        )
        self.first = self.first_peak_at(SENSORS[1])

    def sensor(self, sphere):
        """Time, s, and the mean of the two contact forces of a sphere, N."""
        return self.array("probes/time"), (
            self.contact_forces[sphere - 1] + self.contact_forces[sphere]
        ) / 2

    def first_peak_at(self, sphere):
        """Time, s, and height, N, of the first peak at a sensor."""
        return first_peak(*self.sensor(sphere), floor=0.05)
