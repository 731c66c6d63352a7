"""Square packing that a striker hits through a sphere at rest: chains from the impacted spheres,
pulses and energies.

Sphere (X, Y) of the packing, from 1, has the id X + nx (Y - 1). A chain begins at an impacted
sphere, which is its sphere 1, and contains no other impacted sphere. Chains along the impact are
central chains, chains across it edge chains.
"""

from functools import cached_property

import numpy as np

from granwave.measures import energy_by_region, line_velocity, pulse_lengths, pulse_peaks
from granwave.theory import solitary_lengths

MEASURES = tuple(solitary_lengths())  # measures of the length of a pulse
COLOURS = {
    "central chains": "C0", "edge chains": "C9", "impacted spheres": "C1", "strikers": "C4", "other spheres": "black",
    "walls": "0.5", "dissipated": "C2",
}  # fmt: skip


VELOCITY = {"in-plane": 0.29, "out-of-plane": 0.65}  # velocities of the source's striker, m/s


def source_impacts(runs):
    """Elastic impacts at the velocities of the source."""
    elastic = [Packing(run) for run in runs if run.case.contact.law == "hertz"]
    return [one for one in elastic if one.speed == VELOCITY[one.way]]


class Packing:
    """An impacted packing; values of a group of chains are taken from its first chain, because all
    are equal by symmetry.
    """

    def __init__(self, run):
        self.run = run
        self.case = run.case
        self.diameter = run.case.packing.diameter
        at_rest, striker = run.case.striker
        # m/s
        self.struck = at_rest.touches
        self.speed = max(striker.velocity)
        self.way = "out-of-plane" if striker.velocity[2] else "in-plane"
        self.size = run.case.packing.size

    @cached_property
    def chains(self):
        """Ids of the spheres of all chains, by group."""
        (nx, ny), found = self.size, {"central chains": [], "edge chains": []}
        for one in self.struck:
            y, x = divmod(one - 1, nx)
            for count, step, group in (
                (nx - x, 1, "central chains"), (x + 1, -1, "central chains"),
                (ny - y, nx, "edge chains"), (y + 1, -nx, "edge chains"),
            ):  # fmt: skip
                ids = one + step * np.arange(count)
                if count > 1 and len(np.intersect1d(ids, self.struck)) == 1:
                    found["central chains" if self.way == "out-of-plane" else group].append(ids)
        return {group: chains for group, chains in found.items() if chains}

    @cached_property
    def time(self):
        return self.run.result.frame_times

    @cached_property
    def velocity(self):
        """Velocities along the first chain of each group, (n_times, n_spheres), m/s."""
        return {
            group: line_velocity(self.run.result, chains[0])
            for group, chains in self.chains.items()
        }

    @cached_property
    def peaks(self):
        return {
            group: pulse_peaks(self.time, found, self.diameter)
            for group, found in self.velocity.items()
        }

    @cached_property
    def lengths(self):
        return {
            group: pulse_lengths(self.time, found, self.diameter)
            for group, found in self.velocity.items()
        }

    @cached_property
    def energies(self):
        """Fractions of the input against time; impacted spheres are separate from their chains."""
        n = self.size[0] * self.size[1]
        chains = self.chains.items()
        regions = {group: np.concatenate([ids[1:] for ids in members]) for group, members in chains}
        return energy_by_region(
            self.run.result, regions | {"impacted spheres": self.struck, "strikers": [n + 1, n + 2]}
        )

    @cached_property
    def settled(self):
        """Fractions of the input: chains at their maximum, impacted spheres and strikers after
        their rebound, dissipation at the end.

        The rebound is complete when the energy of the impacted spheres, after its minimum, has its
        next maximum.
        """
        struck = self.energies["impacted spheres"]
        least = struck[struck.argmax() :].argmin() + struck.argmax()
        rebounded = least + struck[least:].argmax()
        at = {"impacted spheres": rebounded, "strikers": rebounded}
        return {
            name: share.max() if name in self.chains else share[at.get(name, -1)]
            for name, share in self.energies.items()
        }
