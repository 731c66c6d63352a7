"""Forces, stiffnesses and energies of many contacts at once, by the laws of the plugin.

The law of a point contact with the effective radius R* follows from the law for R* = 1 m: overlaps
are proportional to R*, forces to R*^2, stiffnesses to R*, energies to R*^3. Line contacts and
powers of the overlap do not scale: each size has a separate law, which is used in the same formulas
with a scale of 1 m.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact.tables import Dents, Resistance
from granwave.lammps_inputs.case.material import Material, Shape
from granwave.lammps_inputs.contact.initial_dents import dents_in, regions_of
from granwave.lammps_inputs.contact.law import law_between
from granwave.lammps_inputs.packing.cylinders import cylinder_pair
from granwave.lammps_inputs.packing.walls import Wall, wall_friction

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
_STEP = 1e-6  # relative step of the overlap, for the slope of a loading curve beyond first yield
Body = tuple["Material", "Shape"]
Partner = tuple["Material | None", "Shape"]  # material and shape of a wall, which may be rigid


@dataclasses.dataclass(frozen=True, eq=False)
class Touches:
    """Contacts with the same law.

    Attributes
    ----------
    law
        The law at the scale of 1 m, see the module.
    friction
        Coefficient of friction.
    dents
        Largest earlier overlaps, uniform; None without.
    scaled
        True if the law scales with R*, False if it holds for one size.
    rolling, twisting
        Resistances; None without.
    """

    law: ContactLaw
    friction: float
    dents: Dents | None = None
    scaled: bool = True
    rolling: Resistance | None = None
    twisting: Resistance | str | None = None

    def evaluate(self, overlap: Array, scale: Array) -> tuple[Array, Array, Array]:
        """Return force, N, slope of the force, N/m, and work, J, at overlaps (n,), m, on first
        loading.

        Parameters
        ----------
        scale
            Effective radii; 1 for laws that are not scaled: (n,), m.
        """
        a = np.maximum(overlap, 0.0) / scale
        dent = self._dent(scale)
        peak = np.maximum(a, dent)
        force = self.law.force(a, peak)
        work = self.law.elastic_energy(a, peak) + self.law.dissipated_energy(peak)
        loading = (a >= dent) & (a > self.law.elastic_limit)
        slope = self._unloading(a, peak)
        if loading.any():
            loaded = a[loading]
            slope[loading] = (
                self.law.loading_force(loaded * (1 + _STEP))
                - self.law.loading_force(loaded * (1 - _STEP))
            ) / (2 * _STEP * loaded)
        return scale**2 * force, scale * slope, scale**3 * work

    def small(self, overlap: Array, peak: Array, scale: Array) -> tuple[Array, Array, Array]:
        """Return force, N, and normal and tangential stiffness of small motions, N/m, at a state
        with a load history.

        Parameters
        ----------
        overlap, peak
            Overlaps now and the largest so far: (n,), m.
        scale
            As in `evaluate`.
        """
        a = np.maximum(overlap, 0.0) / scale
        most = np.maximum.reduce([a, peak / scale, self._dent(scale)])
        tangential = self.law.tangential_stiffness(a, most) if self.friction else np.zeros_like(a)
        return (
            scale**2 * self.law.force(a, most),
            scale * self._unloading(a, most),
            scale * tangential,
        )

    def resisting(self, overlap: Array, peak: Array, scale: Array) -> tuple[Array, Array]:
        """Return the stiffnesses of small motions against rolling and against twisting, N m; see
        `small`.
        """
        a = np.maximum(overlap, 0.0) / scale
        most = np.maximum.reduce([a, peak / scale, self._dent(scale)])
        none = np.zeros_like(a)
        rolling = none
        twisting = none
        follows = scale * self.law.tangential_stiffness(a, most)  # the contact circle
        if self.rolling is not None:
            arm = scale * self.law.effective_radius
            fixed = self.rolling.stiffness
            rolling = (follows if fixed is None else fixed) * arm**2
        if isinstance(self.twisting, Resistance) and self.twisting.stiffness is not None:
            twisting = none + self.twisting.stiffness
        elif self.twisting is not None:
            twisting = follows * (scale * self.law.contact_radius(a, most)) ** 2 / 2
        return np.asarray(rolling), np.asarray(twisting)

    def _dent(self, scale: Array) -> Array:
        """Return the largest earlier overlaps divided by R*."""
        if self.dents is None:
            return np.zeros_like(scale)
        sizes, which = np.unique(scale, return_inverse=True)
        return np.asarray((dents_in(self.dents, self.law, sizes) / sizes)[which.ravel()])

    def _unloading(self, a: Array, peak: Array) -> Array:
        """Slope of the branch of unloading and reloading: n F/(alpha - alpha_R), N/m at R* =
        1.
        """
        if not self.scaled:  # no power of the overlap, or one of its own; elastic
            return np.where(a > 0, self.law.tangent_stiffness(a, a), 0.0)
        above = a - self.law.residual_overlap(peak)
        slope: Array = (
            self.law.unloading_exponent(peak)
            * self.law.force(a, peak)
            / np.where(above > 0, above, 1.0)
        )
        return np.where(above > 0, slope, 0.0)


Part = tuple[
    Touches, Ints, Array
]  # a law, the rows that it belongs to, and their scales (n_rows,), m


@dataclasses.dataclass(frozen=True, eq=False)
class PairLaws:
    """Laws of all pairs of grains of a case, and of its walls.

    Attributes
    ----------
    bodies
        Kinds of grains: material and shape.
    """

    case: Case
    bodies: tuple[tuple[Material, Shape], ...]
    _known: dict[Any, Touches] = dataclasses.field(default_factory=dict, init=False)

    @property
    def shapes(self) -> list[Shape]:
        """Shapes by kind."""
        return [shape for _, shape in self.bodies]

    @property
    def has_cylinders(self) -> bool:
        """True if there are cylinders."""
        return any(self.shapes)

    def pairs(self, kind: Ints, other_kind: Ints, radii: Array) -> list[Part]:
        """Return the laws of pairs of kinds of grains (n,), each with its rows and their scales.

        Parameters
        ----------
        radii
            Radii of both grains: (n, 2), m.
        """
        swap = kind > other_kind
        low = np.where(swap, other_kind, kind)
        high = np.where(swap, kind, other_kind)
        radii = np.where(swap[:, None], radii[:, ::-1], radii)
        parts: list[Part] = []
        code = low * len(self.bodies) + high
        for number in np.unique(code).tolist():
            rows = np.flatnonzero(code == number)
            first, second = (self.bodies[n] for n in divmod(number, len(self.bodies)))
            contact = self.case.contact_between(first[0], second[0])
            scale = None
            if not contact.entry.is_power:
                scale = _effective_radii(first[1], second[1], radii[rows])
            parts += self._parts(first, second, contact.friction, rows, radii[rows], scale)
        return parts

    def wall(self, wall: Wall, kind: Ints, radius: Array) -> list[Part]:
        """Return the laws of grains of kinds (n,) and radii (n,), m, at a wall, each with its rows
        and their scales.
        """
        parts: list[Part] = []
        flat: Partner = (wall.material, None)
        for n, (material, shape) in enumerate(self.bodies):
            rows = np.flatnonzero(kind == n)
            if not len(rows):
                continue
            contact = self.case.contact_between(material, wall.material)
            scale = None
            if shape is None and not contact.entry.is_power:
                scale = wall.effective_radii(radius[rows])
            radii = np.stack([radius[rows], np.full(len(rows), math.inf)], axis=1)
            friction = wall_friction(self.case, wall, material)
            parts += self._parts(self.bodies[n], flat, friction, rows, radii, scale)
        return parts

    def _parts(
        self,
        first: Body,
        second: Partner,
        friction: float,
        rows: Ints,
        radii: Array,
        scale: Array | None,
    ) -> Iterator[Part]:
        """Yield the law at R* = 1 m of two bodies with its scales, or, without scales, one law for
        each pair of radii.
        """
        sizes = np.full((1, 2), 2.0)
        which = np.zeros(len(rows), dtype=np.int64)
        scaled = scale is not None
        if scale is None:
            sizes, which = np.unique(radii, axis=0, return_inverse=True)
        else:
            first = (first[0], None)
            second = (second[0], None)
        scales = np.ones(len(rows)) if scale is None else scale
        for number, size in enumerate(sizes.tolist()):
            key = first, second, *size, friction, scaled
            if key not in self._known:
                self._known[key] = self._touches(
                    first, second, (size[0], size[1]), friction, scaled=scaled
                )
            own = which.ravel() == number
            yield self._known[key], rows[own], scales[own]

    def _touches(
        self,
        first: Body,
        second: Partner,
        radii: tuple[float, float],
        friction: float,
        *,
        scaled: bool,
    ) -> Touches:
        """Return the law of two bodies of these radii, m, with its initial dents."""
        case = self.case
        bodies = (first[0], second[0])
        shapes = (first[1], second[1])
        line = case.contact.line == "plane-strain"
        law = law_between(
            case.contact_between(*bodies), bodies, radii, shapes=shapes, plane_strain=line
        )
        dented = scaled and case.contact.initial_overlap and law.entry.yields
        dents = regions_of(case)[-1] if dented else None
        contact = case.contact_between(*bodies)
        return Touches(
            law, friction, dents, scaled, _acting(contact.rolling), _acting(contact.twisting)
        )


def _acting(resistance: Resistance | str | None) -> Any:
    """Return a resistance, or None if its coefficient is zero."""
    none = isinstance(resistance, Resistance) and not resistance.coefficient
    return None if none else resistance


def _effective_radii(shape: Shape, partner: Shape, radii: Array) -> Array | None:
    """Return the effective radii of pairs of shapes with some radii (n, 2), m: (n,).

    None for parallel cylinders, whose law does not scale.
    """
    if not shape and not partner:
        return np.asarray(radii.prod(axis=1) / radii.sum(axis=1))
    geometry = cylinder_pair(shape, partner)
    if geometry.parallel:
        return None
    sizes, which = np.unique(radii, axis=0, return_inverse=True)
    effective = np.array([geometry.effective_radius(*size) for size in sizes.tolist()])
    return effective[which.ravel()]
