"""Plane crystals of cylinders with a line of grains down their middle; widths and depths in
diameters D.

The source calls the centred-square crystal BCC and the hexagonal one HCP. The front of the wave and
the signals of the top corners travel down together along the close-packed lines, at 45 degrees in
BCC and at 30 degrees from the vertical in HCP: they meet on the middle line at W/2 and at sqrt(3)/2
W.
"""

import math

from granwave.measures import lines_of, two_region_decay

NAMES = {"centred-square": "BCC", "hexagonal": "HCP"}
SOURCE = "lateral constraints"
OURS = "ours"


class Crystal:
    """A struck crystal."""

    def __init__(self, run):
        self.run = run
        self.case = run.case
        packing = run.case.packing
        self.name, (self.count, self.layers) = NAMES[packing.kind], packing.size
        self.width = (
            (self.count - 1) * math.sqrt(2) + 1 if self.name == "BCC" else float(self.count)
        )
        self.meeting = {"BCC": 0.5, "HCP": math.sqrt(3) / 2}[self.name] * self.width
        self.lines = {line.name: line for line in lines_of(run.result)}
        self.down = self.lines["down"]
        self.depth, self.peak = self.down.distance / packing.diameter, self.down.peak_speed
        self.decay = two_region_decay(
            self.down.distance, self.peak
        )  # including the grains that the floor holds
        self.border = self.decay.border / packing.diameter
        self.walls = self.case.boundary.sides == "wall"


def by_name(crystals):
    return {name: one for name in NAMES.values() for one in crystals if one.name == name}
