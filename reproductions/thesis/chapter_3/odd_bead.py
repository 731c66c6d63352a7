"""A chain that ends on an elastic bar, under a force; one bead may differ from the others.

Transmitted energy is the strain and kinetic energy of the bar at the end of the run; transmitted
force is the largest contact force on the bar, which equals the force at a section of a bar without
reflections.
"""


class OddBead:
    """Position of the odd bead from the impacted end, the materials of this bead and of the others,
    transmitted energy (J), and transmitted force divided by the load.

    ``alike`` is True for a chain of identical beads; ``properties`` are the properties of the odd
    bead, SI.
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
