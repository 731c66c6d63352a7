"""A chain on an elastic bar, under a force, in which one bead may be of another kind.

Transmitted energy is what the bar holds at the end of the run, strain and kinetic; transmitted
force is the largest contact force on the bar, which is that of a section of a bar in which nothing
comes back.
"""


class OddBead:
    """Place of the odd bead from the struck end, its material and that of the others, energy (J),
    force over the load.

    ``alike`` is True of a chain of like beads; ``properties`` are those of the odd bead, SI.
    """

    def __init__(self, run):
        (odd,), case = run.case.replace, run.case
        (self.place,), self.material, self.base = odd.index, odd.material, case.material
        self.alike = self.material == self.base and odd.diameter is None
        self.energy = run["energy_bar_J"]
        self.peak = run["wall_peak_force_N"] / case.load.largest
        self.properties = {
            "yield strength": self.material.yield_strength,
            "density": self.material.density,
            "radius": (odd.diameter or case.packing.diameter) / 2,
            "modulus": self.material.youngs_modulus,
        }
