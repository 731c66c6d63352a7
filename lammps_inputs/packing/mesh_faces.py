"""Patches of surfaces of triangles: distances of spheres from them, as computed by the wall fix."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import TriangleMesh
from granwave.lammps_inputs.run_directory import MESH_FILE

Floats = NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class MeshFace:
    """Smooth patch of a surface of triangles that is a wall.

    Attributes
    ----------
    number
        Number of the entry of ``[[wall]]``.
    patch
        Number of the patch, from 1.
    angle
        Largest turn at an edge inside of a patch, degrees.
    mesh
        The surface.
    """

    number: int
    patch: int
    angle: float
    mesh: TriangleMesh = dataclasses.field(repr=False, compare=False)

    @property
    def region(self) -> str:
        """Name of the surface."""
        return f"wall{self.number}"

    @property
    def definition(self) -> str:
        """Command that defines the shape: none, as the fix reads the file."""
        return ""

    @property
    def style(self) -> str:
        """Words of the wall fix."""
        return f"mesh {MESH_FILE.format(self.number)} {self.angle:.17g} {self.patch}"

    def distances(self, positions: Floats) -> Floats:
        """Return the distances of positions (n, 3) from the patch, infinite where its nearest point
        belongs to another patch: (n,), m.
        """
        return np.asarray(self.mesh.nearest(positions, self.patch)[0])

    def nearest(self, positions: Floats) -> Floats:
        """Return the nearest points of the patch to positions (n, 3): (n, 3), m."""
        return np.asarray(self.mesh.nearest(positions, self.patch)[1])

    def effective_radii(self, radii: Floats) -> Floats:
        """Return the radii of spheres that are as stiff on a plane: the radii of the given spheres,
        (n,), m.
        """
        return radii
