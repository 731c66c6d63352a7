"""``[[grains]]``: grains at places given by a formula, next to a lattice or to the grains of a file.

    at = [[0, 0, 0.01], ...]                     places, m
    ring = {n = 6, radius = 0.01, z = 0.005}     n places around the axis x = y = 0; angle: of the first
    repeat = {times = 10, step = [0, 0, 0.015]}  these places again and again, each time moved on by a step

A case with such grains is one of ``packing.kind = "file"``: the sites of the lattice come first and keep their ids.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.grains import Grains
from granwave.lammps_inputs.case.material import Material, presets
from granwave.lammps_inputs.case.packing import PackingSection
from granwave.lammps_inputs.case.schema import (
    ErrorList,
    ValidationError,
    custom,
    finite,
    number,
    parse_point,
    text,
    whole,
)
from granwave.lammps_inputs.case.shape import Vector, axis_field, check_shape, length_field, shape_field, shape_of
from granwave.lammps_inputs.case.si_values import DIAMETER
from granwave.lammps_inputs.lattices import FILE

_POINT = "[x, y, z] in m"
_PLACES = f"places, {_POINT} each"
_RING = "{n = 6, radius = 0.01, z = 0.005}, and perhaps angle = 30 (degrees from x)"
_REPEAT = "{times = 10, step = [0, 0, 0.015]}"
_OF_SITES = ("diameter_scatter", "vacancies")  # keys of a lattice that such a packing does not have


@dataclasses.dataclass(frozen=True)
class Ring:
    """Places around the axis x = y = 0."""

    n: int
    radius: float
    z: float
    angle: float = 0.0


@dataclasses.dataclass(frozen=True)
class Repeat:
    """Number of copies, the first among them, and the step from one to the next, m."""

    times: int
    step: tuple[float, float, float]


def _parse_places(value: Any) -> tuple[tuple[float, float, float], ...]:
    if not isinstance(value, list | tuple) or not value:
        raise ValidationError(_PLACES)
    return tuple(parse_point(place, _PLACES) for place in value)


def _parse_ring(value: Any) -> Ring:
    if not isinstance(value, Mapping) or not {"n", "radius", "z"} <= set(value) <= {"n", "radius", "z", "angle"}:
        raise ValidationError(_RING)
    radius = finite(value["radius"], _RING)
    if radius <= 0:
        raise ValidationError(f"{_RING}, with a radius above 0")
    return Ring(whole(value["n"], _RING), radius, finite(value["z"], _RING), finite(value.get("angle", 0.0), _RING))


def _parse_repeat(value: Any) -> Repeat:
    if not isinstance(value, Mapping) or set(value) != {"times", "step"}:
        raise ValidationError(_REPEAT)
    return Repeat(whole(value["times"], _REPEAT), parse_point(value["step"], _REPEAT))


@dataclasses.dataclass(frozen=True, kw_only=True)
class AddedGrains:
    """``[[grains]]``: grains of one size and material at places given by a formula."""

    at: tuple[tuple[float, float, float], ...] | None = custom("places", _parse_places, unit="m", default=None)
    ring: Ring | None = custom("places around the axis x = y = 0", _parse_ring, default=None)  # noqa: RUF009
    repeat: Repeat | None = custom("copies of these places, each a step on", _parse_repeat, default=None)  # noqa: RUF009
    diameter: float = number("diameter of these grains", unit="m", above=0, usual=DIAMETER)
    shape: str = shape_field()
    length: float | None = length_field()
    axis: Vector | None = axis_field()  # noqa: RUF009 (axes are not changed)
    material: Material | None = None
    group: str | None = text("name of their group, for [[hold]]", default=None)

    def places(self) -> NDArray[np.float64]:
        """Return the places: (n, 3), m."""
        if self.ring is not None:
            angle = np.deg2rad(self.ring.angle) + 2 * np.pi * np.arange(self.ring.n) / self.ring.n
            across = self.ring.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
            places = np.column_stack([across, np.full(self.ring.n, self.ring.z)])
        else:
            places = np.array(self.at)
        if self.repeat is not None:
            steps = np.arange(self.repeat.times)[:, None, None] * np.array(self.repeat.step)
            places = (places + steps).reshape(-1, 3)
        return places


def with_added_grains(
    packing: PackingSection, added: Sequence[AddedGrains], materials: dict[str, Material], errors: ErrorList
) -> PackingSection:
    """Return the packing with its added grains, as one of grains of a file.

    Parameters
    ----------
    materials
        Further materials of the case, by name; those of the grains are added.
    errors
        Takes the faults.
    """
    before = len(errors.lines)
    for place, entry in enumerate(added, start=1):
        if (entry.at is None) == (entry.ring is None):
            found = "neither at nor ring" if entry.at is None else "both at and ring"
            errors.add(f"grains.{place}", f"found {found}, expected one of them")
        check_shape(entry, f"grains.{place}", errors)
    for name in _OF_SITES:
        if getattr(packing, name):
            errors.add(f"packing.{name}", "found beside [[grains]], whose packing is no lattice; take one of them out")
    if len(errors.lines) > before:
        return packing
    own = packing.grains
    if own is None:
        lattice = packing.lattice()
        n = lattice.n_spheres
        own = Grains(
            lattice.positions(1, n),
            np.full(n, packing.diameter),
            [""] * n,
            [""] * n,
            np.zeros((n, 3)),
            [packing.of_grain] * n,
        )
    position, diameter, material, group = [own.position], [own.diameter], [*own.material], [*own.group]
    shape = [*own.shape]
    for entry in added:
        places = entry.places()
        position.append(places)
        diameter.append(np.full(len(places), entry.diameter))
        material += [_name_of(entry.material, materials)] * len(places)
        group += [entry.group or ""] * len(places)
        shape += [shape_of(entry)] * len(places)
    still = np.zeros((sum(map(len, position[1:])), 3))
    grains = Grains(
        np.concatenate(position),
        np.concatenate(diameter),
        material,
        group,
        np.concatenate([own.velocity, still]),
        shape,
    )
    return PackingSection(kind=FILE, size=(len(grains),), diameter=packing.diameter, grains=grains)


def _name_of(material: Material | None, materials: dict[str, Material]) -> str:
    """Return the name by which a material is found, and add one that has none to the further materials."""
    if material is None:
        return ""
    known = presets() | materials
    name = next((name for name, one in known.items() if one == material), None)
    if name is None:
        stem = material.name or "grains"
        name = next(one for one in (stem, *(f"{stem} ({n})" for n in range(2, len(known) + 3))) if one not in known)
        materials[name] = dataclasses.replace(material, name=name)
    return name
