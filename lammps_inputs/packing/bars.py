"""Elastic bars at the ends of a chain.

A bar is a row of point masses, half a mass at either end, joined by springs E A / (element length). The node at the
chain's end is its face: a particle without radius, which the contact law takes as a flat (R* = R).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.bodies import Bar
from granwave.lammps_inputs.case.material import Material

INCIDENT_BAR, BAR = "incident_bar", "bar"  # names, as in the case


@dataclasses.dataclass(frozen=True)
class PlacedBar:
    """A bar in its place.

    Attributes
    ----------
    name
        ``incident_bar`` or ``bar``.
    first, last
        Ids of its nodes; z rises with the id.
    face
        Id of the node that touches the chain.
    touches
        Id of the sphere that the face touches.
    position
        Of the nodes along z: (n_nodes,), m.
    mass
        Of the nodes: (n_nodes,), kg.
    """

    name: str
    section: Bar
    material: Material
    first: int
    face: int
    touches: int
    position: NDArray[np.float64]
    mass: NDArray[np.float64]

    @property
    def last(self) -> int:
        """Id of the last node."""
        return self.first + len(self.position) - 1

    @property
    def far(self) -> int:
        """Id of the node at the end away from the chain."""
        return self.first if self.face == self.last else self.last

    @property
    def pitch(self) -> float:
        """Length of an element, m."""
        return self.section.length / self.section.elements

    @property
    def stiffness(self) -> float:
        """Stiffness of an element, N/m."""
        return self.material.youngs_modulus * self.section.area / self.pitch

    @property
    def wave_speed(self) -> float:
        """sqrt(E/rho), m/s."""
        return math.sqrt(self.material.youngs_modulus / self.material.density)


def place_bar(name: str, section: Bar, material: Material, first: int, face: float, touches: int) -> PlacedBar:
    """Place the nodes of a bar, which ends at the chain or begins there.

    Parameters
    ----------
    first
        Id of the first node.
    face
        Where the bar touches the chain, along z, m.
    touches
        Id of the sphere that the face touches.
    """
    n, ahead = section.elements, name == INCIDENT_BAR
    position = face + np.linspace(-section.length if ahead else 0.0, 0.0 if ahead else section.length, n + 1)
    mass = np.full(n + 1, material.density * section.area * section.length / n)
    mass[[0, -1]] /= 2
    return PlacedBar(name, section, material, first, first + n if ahead else first, touches, position, mass)


def echoes(bars: Iterable[PlacedBar]) -> dict[str, float]:
    """Return the earliest time at which an echo from the far end of each bar reaches the chain, by name, s."""
    found, arrival = {}, 0.0
    for bar in bars:
        crossing = bar.section.length / bar.wave_speed
        if bar.name == INCIDENT_BAR:
            arrival = crossing  # time at which the load reaches the chain
        found[bar.name] = arrival + 2 * crossing
    return found
