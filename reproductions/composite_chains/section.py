"""A chain of steel with a section of lighter beads, between two sensors that read the mean force of
a bead's contacts.

V is the distance of the sensors divided by the time between their first peaks; lambda is the ratio
of the output peak to the incident peak.
"""

import math

from granwave.measures import Chain, first_peak

# the source's values by the section's material: measured V by the beads in the section (m/s);
# arrival of the reflection from the chain's end (ms); stresses in the section's first and last
# contact (MPa)
SPEEDS = {"brass-composite": {3: 469.0, 24: 424.0}, "ptfe": {}}
FROM_END = {"brass-composite": 1.25, "ptfe": 1.85}
STRESSES = {"brass-composite": (1200.0, 1110.0), "ptfe": (35.0, 20.0)}
# constants of the contact law, mean pressures / yield strength: far beyond yield, at yield
# (2/3 of 1.6), and the factor of their approach / overlap at yield
DEEP_PRESSURE = 2.48
YIELD_PRESSURE = 16 / 15
PRESSURE_RATE = 0.098
WATCHED = 6  # beads of the section whose waves and pressures are shown, as in source Fig. 6


class Section:
    """The section, and the pulse in front of it and behind it."""

    def __init__(self, run):
        self.run = run
        self.case = run.case
        self.chain = Chain(run)
        section, (before, behind) = self.case.replace[0], self.case.sensor
        self.first = section.index[0]
        self.last = section.index[-1]
        self.n = len(section.index)
        self.material, self.light, self.time = (
            section.material,
            section.material.name,
            self.chain.time,
        )
        yields = self.case.contact.law == "elastoplastic"
        self.kind = (
            f"yielding at {1e-6 * self.material.yield_strength:g} MPa" if yields else "elastic"
        )
        self.incident, self.output = (
            self.chain.sensors[sensor.name] for sensor in (before, behind)
        )
        (self.start, incident), (self.arrived, output) = (
            first_peak(self.time, f) for f in (self.incident, self.output)
        )
        self.speed = (run.spheres.position_z[behind.id] - run.spheres.position_z[before.id]) / (
            self.arrived - self.start
        )
        self.ratio = output / incident

    def force(self, bead):
        """Force between this bead and the next: (n_times,), N."""
        return self.chain.force[:, self.chain.contact_between(bead)]

    def peak(self, bead):
        """First peak of the force between this bead and the next, N."""
        return first_peak(self.time, self.force(bead))[1]

    def pressure(self, bead):
        """Largest Hertzian pressure between this bead and the next in the first peak, Pa; for
        elastic chains.
        """
        law = self.chain.law_between(bead, bead + 1)
        return (
            6 * self.peak(bead) * law.effective_modulus**2 / (math.pi**3 * law.effective_radius**2)
        ) ** (1 / 3)

    def yielded_pressure(self, bead):
        """Mean pressure at the largest overlap between this bead and the next, Pa; for yielding
        chains (thesis 2.8).
        """
        law = self.chain.law_between(bead, bead + 1)
        contact = self.chain.contact_between(bead)
        reduced = self.chain.of_contacts("peak_overlap")[contact] / law.yield_overlap
        if reduced < 1:
            raise ValueError(f"found {reduced:g} overlaps at yield, expected a yielded contact")
        drop = (DEEP_PRESSURE - YIELD_PRESSURE) * math.exp(-PRESSURE_RATE * (reduced - 1))
        return self.material.yield_strength * (DEEP_PRESSURE - drop)


def sections(runs):
    """Sections of runs by rising length, elastic runs first."""
    return sorted(map(Section, runs), key=lambda section: (section.kind, section.n))


def by(found, key):
    """Groups of sections with equal values of a function, in the order of their first members."""
    groups = {}
    for section in found:
        groups.setdefault(key(section), []).append(section)
    return groups
