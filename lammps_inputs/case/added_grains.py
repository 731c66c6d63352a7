"""``[[grains]]``: grains at positions given by a formula, next to a lattice or to the grains of a
file.

    at = [[0, 0, 0.01], ...]
        positions, m
    at = "octahedral"
        all holes of an fcc or hcp packing between six spheres, or between four ("tetrahedral")
    ring = {n = 6, radius = 0.01, z = 0.005}
        n positions around the axis x = y = 0; angle: of the first
    ring = {n = 2, radius = "touching", gap = 3}
        where they touch both spheres of a gap of a chain: 3 and 4
    repeat = {times = 10, step = [0, 0, 0.015]}
        copies of these positions, each displaced by one more step

Such a case is treated as ``packing.kind = "file"``: the sites of the lattice come first and
keep their ids.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.hints import DIAMETER
from granwave.lammps_inputs.case.ids import INDEX, INDEX_FORM
from granwave.lammps_inputs.case.material import (
    Material,
    Shape,
    Vector,
    axis_field,
    check_shape,
    length_field,
    material_field,
    presets,
    shape_field,
    shape_of,
)
from granwave.lammps_inputs.case.packing.grains import Grains
from granwave.lammps_inputs.case.packing.packing import (
    PackingSection,
    check_memory_of_sites,
    check_size,
)
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.files import available_memory
from granwave.lammps_inputs.lattices import FILE, Lattice, lattice_kinds

_POINT = "[x, y, z] in m"
_PLACES = (
    f'positions, {_POINT} each, or "octahedral" or "tetrahedral" for the interstitial sites of '
    "fcc and hcp"
)
_HOLES = {
    "octahedral": (1 / math.sqrt(2), 6),
    "tetrahedral": (math.sqrt(3 / 8), 4),
}  # distance, diameters; neighbours
_HOLES_OF_SPHERE = 2  # tetrahedral interstices; there is one octahedral interstice
_NEAR = 1e-6  # diameters
_UP = np.array([0.0, 0.0, 1.0])
_RING = (
    "{n = 6, radius = 0.01, z = 0.005}, with angle = 30 (degrees from x) if needed; z may be "
    "replaced by gap = 3, "
    '[3, 5] or "all" (the spheres of a chain before each gap), in which case the radius may '
    'be "touching"'
)
_REPEAT = "{times = 10, step = [0, 0, 0.015]}"
# bytes per grain while the case is read; 1100 to 1600 in rows of spheres and cylinders
_MEMORY_OF_GRAIN = 1000.0
# keys of a lattice that cannot be used with added grains
_OF_SITES = ("diameter_scatter", "vacancies")


_CHAIN = "chain"
_ADDED = "with added grains"  # end of the source of such a packing
_TOUCHING = "touching"
_ALL_GAPS = "all"
_RADIUS = schema.or_word(_TOUCHING, schema.NumberType(above=0, unit="m"), finish=lambda _: None)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Ring:
    """Positions around the axis x = y = 0."""

    n: int = schema.count("number of positions")
    radius: float | None = schema.typed(
        'radius of the ring; "touching": the grains touch both spheres next to a gap of a chain',
        _RADIUS,
        unit="m",
    )
    z: float | None = schema.number("height of the ring", "m", default=None)
    gap: tuple[int, ...] | None = schema.typed(
        'gaps of a chain, numbered by the sphere before each gap; "all": every gap',
        schema.or_word(
            _ALL_GAPS, INDEX, form=f'{INDEX_FORM}; or "{_ALL_GAPS}"', finish=lambda _: ()
        ),
        default=None,
    )
    angle: float = schema.number("angle of the first position from x", "degrees", default=0.0)

    def checked(self) -> Ring:
        """Return the ring; raise `ValidationError` unless it has a height or gaps."""
        at_height = self.z is not None
        is_touching = self.radius is None
        wrong = at_height == (self.gap is not None) or (is_touching and at_height)
        form = f'{_RING}, with z or gap, and a gap for a radius "{_TOUCHING}"'
        schema.refuse_if(wrong, form)
        return self


@dataclasses.dataclass(frozen=True, kw_only=True)
class Repeat:
    """Copies of positions, each displaced by one more step."""

    times: int = schema.count("number of copies, including the first positions")
    step: tuple[float, float, float] = schema.typed(
        "displacement from one copy to the next", schema.vector_type(3, _POINT), unit="m"
    )


_AT = schema.EitherType(
    types=(
        schema.ChoiceType(tuple(_HOLES)),
        schema.ListType(item=schema.vector_type(3, _PLACES), expected=_PLACES),
    ),
    form=_PLACES,
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class AddedGrains:
    """``[[grains]]``: grains of one size and material at positions given by a formula."""

    at: str | tuple[tuple[float, float, float], ...] | None = schema.typed(
        "positions, or the interstitial sites of an fcc or hcp packing", _AT, unit="m", default=None
    )
    ring: Ring | None = schema.typed(
        "positions around the axis x = y = 0",
        schema.TableType(section=Ring, expected=_RING, finish=Ring.checked),
        default=None,
    )
    repeat: Repeat | None = schema.typed(
        "copies of these positions, each displaced by one more step",
        schema.TableType(section=Repeat, expected=_REPEAT),
        default=None,
    )
    diameter: float = schema.number("diameter of these grains", DIAMETER, above=0)
    shape: str = shape_field()
    length: float | None = length_field()
    axis: Vector | None = axis_field()
    material: Material | None = material_field()
    group: str | None = schema.typed(
        "name of their group, for [[hold]]", schema.LABEL, default=None
    )
    clump: int | None = schema.typed(
        "number of the clump of these grains: all grains with the same number move as one rigid "
        "body; with repeat, the number of the first positions, increased by one for each copy",
        schema.CountType(form="a whole number from 1 up"),
        default=None,
    )

    def clumps(self, n: int) -> NDArray[np.int64]:
        """Return the numbers of the clumps of ``n`` grains at these positions: (n,); 0 without
        one.
        """
        if self.clump is None:
            return np.zeros(n, dtype=np.int64)
        times = 1 if self.repeat is None else self.repeat.times
        return self.clump + np.repeat(np.arange(times, dtype=np.int64), n // times)

    def most_places(self, n_own: int) -> int:
        """Return an upper bound on the number of positions, given the number of grains."""
        if isinstance(self.at, str):
            found = _HOLES_OF_SPHERE * n_own
        elif self.ring is not None:
            found = self.ring.n * (
                1 if self.ring.z is not None else len(self.ring.gap or ()) or n_own
            )
        else:
            found = len(self.at or ())
        return found * (1 if self.repeat is None else self.repeat.times)

    def places(self, lattice: Lattice | None, own: Grains) -> NDArray[np.float64]:
        """Return the positions: (n, 3), m.

        Parameters
        ----------
        lattice
            Lattice of the packing, if there is one.
        own
            Grains that they are next to.

        Raises
        ------
        ValueError
            There is no such gap, or no position in it where they touch both spheres.
        """
        if isinstance(self.at, str):
            assert lattice is not None
            places = holes(lattice, self.at)
        elif self.ring is not None:
            angle = np.deg2rad(self.ring.angle) + 2 * np.pi * np.arange(self.ring.n) / self.ring.n
            around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
            rings = (
                [(self.ring.radius or 0.0, self.ring.z)]
                if self.ring.z is not None
                else self._at_gaps(own)
            )
            places = np.concatenate(
                [np.column_stack([radius * around, np.full(self.ring.n, z)]) for radius, z in rings]
            )
        else:
            places = np.array(self.at)
        if self.repeat is not None:
            steps = np.arange(self.repeat.times)[:, None, None] * np.array(self.repeat.step)
            places = (places + steps).reshape(-1, 3)
        return places

    def _at_gaps(self, own: Grains) -> list[tuple[float, float]]:
        """Return the radii and positions along the row of the rings at gaps, m."""
        assert self.ring is not None
        found = []
        for first in self.ring.gap or range(1, len(own)):
            if first >= len(own):
                raise ValueError(
                    f"found gap {first}, expected one from 1 to {len(own) - 1}, between two spheres"
                )
            (x1, y1, z1), (x2, y2, z2) = own.position[first - 1 : first + 1].tolist()
            slack = _NEAR * self.diameter
            if max(abs(x1), abs(y1), abs(x2), abs(y2)) > slack or z2 <= z1:
                raise ValueError(
                    f"found gap {first} between spheres that are not consecutive along x = y = 0"
                )
            if self.ring.radius is not None:
                found.append((self.ring.radius, (z1 + z2) / 2))
                continue
            one, other = (own.diameter[first - 1 : first + 1] + self.diameter) / 2
            step = (one**2 - other**2 + (z2 - z1) ** 2) / (2 * (z2 - z1))
            if step**2 >= one**2:
                raise ValueError(
                    f"found gap {first} of {z2 - z1:g} m between centres, too wide to touch both spheres"
                )
            found.append((math.sqrt(one**2 - step**2), z1 + step))
        return found


def holes(lattice: Lattice, kind: str) -> NDArray[np.float64]:
    """Return the centres of the holes of a lattice between six spheres ("octahedral") or four
    ("tetrahedral").

    Sites at the faces, which lack some of these spheres, are omitted. Returns an array (n, 3), m,
    in the order of z, y and x; empty if the lattice has no such holes.
    """
    from scipy.spatial import KDTree  # imported on demand: slow to load

    distance, n_around = _HOLES[kind]
    spheres = lattice.positions(1, lattice.n_spheres) / lattice.diameter
    periods = np.array([*lattice.lengths, 0.0]) / lattice.diameter
    images = spheres
    if lattice.periodic:
        shifts = [(i, j, 0) * periods for i, j in itertools.product((0, -1, 1), repeat=2)]
        images = np.concatenate([spheres + shift for shift in shifts])
    tree = KDTree(images)
    if kind == "octahedral":  # three pairs of spheres are opposite to each other
        centres = _middles(spheres, images, tree, 2 * distance)
    else:  # a hole is above or below a sphere
        centres = np.concatenate([spheres + distance * _UP, spheres - distance * _UP])
    if not len(centres):
        return np.empty((0, 3))
    if lattice.periodic:
        low = spheres.min(axis=0)[:2]
        beyond = np.mod(centres[:, :2] - low + _NEAR, periods[:2])
        centres[:, :2] = low + beyond - _NEAR
    same = KDTree(centres).query_ball_point(centres, 100 * _NEAR)
    is_first = [min(rows) == row for row, rows in enumerate(same)]
    centres = centres[is_first]
    places = np.round(centres / (100 * _NEAR))
    centres = centres[np.lexsort(places.T)]
    counts = tree.query_ball_point(centres, distance + 10 * _NEAR, return_length=True)
    return np.asarray(centres[counts == n_around] * lattice.diameter)


def _middles(
    spheres: NDArray[np.float64], images: NDArray[np.float64], tree: Any, apart: float
) -> NDArray[np.float64]:
    """Return the middles between spheres and images at a distance: (n, 3), in diameters.

    Parameters
    ----------
    tree
        Tree of the images.
    """
    near = tree.query_ball_point(spheres, apart + _NEAR)
    first = np.repeat(np.arange(len(spheres)), [len(others) for others in near])
    second = np.fromiter(itertools.chain.from_iterable(near), dtype=np.int64)
    distance = np.linalg.norm(images[second] - spheres[first], axis=1)
    is_opposite = np.abs(distance - apart) <= _NEAR
    return (images[second[is_opposite]] + spheres[first[is_opposite]]) / 2


def with_added_grains(
    packing: PackingSection,
    added: Sequence[AddedGrains],
    materials: dict[str, Material],
    errors: ErrorList,
    *,
    periodic: bool = False,
    stored: bool = False,
) -> PackingSection:
    """Return the packing with its added grains, as a packing of kind "file".

    Parameters
    ----------
    periodic
        True if the lattice is periodic along x and y.
    materials
        Further materials of the case, by name; the materials of the grains are added.
    errors
        Takes the faults.
    stored
        True for the case of an existing run, for which the memory of this machine does not matter.
    """
    if not check_size(packing, ErrorList(errors.source)):
        return packing  # `check_together` tells why
    before = len(errors.items)
    _check_added(packing, added, errors)
    if len(errors.items) > before:
        return packing
    own = packing.grains
    lattice = None
    period = packing.period
    if own is None:
        lattice = packing.lattice(periodic=periodic)
        n = lattice.n_spheres
        if not (stored or check_memory_of_sites(packing, n, _MEMORY_OF_GRAIN, errors)):
            return packing
        period = lattice.lengths if periodic else None
        own = _grains_at(lattice.positions(1, n), packing.diameter, shape=packing.of_grain)
        for sphere, width in packing.gaps:  # all spheres after a gap are shifted by its width
            own.position[sphere:, 2] += width
    parts = [own]
    for key, entry in schema.numbered("grains", added).items():
        if stored or _check_memory(entry, len(own), key, errors):
            places = _places_of(entry, packing, lattice, own, key, errors)
            if places is not None:
                name = _name_of(entry.material, materials)
                group = entry.group or ""
                part = _grains_at(places, entry.diameter, name, group, shape_of(entry))
                parts.append(dataclasses.replace(part, clump=entry.clumps(len(places))))
    grains = _joined(parts)
    return PackingSection(
        kind=FILE,
        size=(len(grains),),
        diameter=packing.diameter,
        grains=grains,
        source=packing.source or _lattice_in_words(packing),
        period=period,
        cell=packing.cell,
        restart=packing.restart,
        enclosure=packing.enclosure,
        contacts=packing.contacts,
        touch_tolerance=packing.touch_tolerance,
        springs=packing.springs,
        relaxation=packing.relaxation,
    )


def _lattice_in_words(packing: PackingSection) -> str:
    """Return kind and size of a lattice to which grains are added."""
    size = " \N{MULTIPLICATION SIGN} ".join(map(str, packing.size))
    return f"{packing.kind} {size} {_ADDED}"


def has_added_to_chain(source: str) -> bool:
    """Return True for the source of a packing, ``packing.source``, that is a chain with added
    grains.
    """
    return source.startswith(f"{_CHAIN} ") and source.endswith(_ADDED)


def _check_added(packing: PackingSection, added: Sequence[AddedGrains], errors: ErrorList) -> None:
    """Check the keys of ``[[grains]]``, and of the packing that they are added to."""
    holed = " or ".join(name for name, rule in lattice_kinds().items() if rule.is_close_packed)
    for key, entry in schema.numbered("grains", added).items():
        both = entry.at is not None
        holes_of = show(entry.at) if isinstance(entry.at, str) else ""
        errors.check_first(
            (
                both == (entry.ring is not None),
                key,
                Mismatch(f"{'both at and ring' if both else 'neither at nor ring'}", "one of them"),
            ),
            (
                holes_of and not packing.rule.is_close_packed,
                f"{key}.at",
                Mismatch(
                    f"{holes_of} with packing.kind = {show(packing.kind)}", f"{holed}, or positions"
                ),
            ),
            (
                holes_of and entry.repeat,
                f"{key}.repeat",
                Mismatch(f"together with at = {holes_of}, which already selects all such sites"),
            ),
        )
        check_shape(entry, key, errors)
    last = packing.size[0] - 1
    beyond = [sphere for sphere, _ in packing.gaps if sphere > last]
    errors.check_first(
        (
            packing.gaps and not packing.rule.is_chain,
            "packing.gaps",
            Mismatch(f"with packing.kind = {show(packing.kind)}", "a chain"),
        ),
        (
            beyond,
            "packing.gaps",
            Mismatch(f"a gap after sphere {max(beyond, default=0)}", f"after one from 1 to {last}"),
        ),
    )
    no_lattice = "together with [[grains]], whose packing is not a lattice"
    beside = Mismatch(no_lattice, remedy="remove one of them")
    errors.check(*((getattr(packing, name), f"packing.{name}", beside) for name in _OF_SITES))


def _check_memory(entry: AddedGrains, n_own: int, key: str, errors: ErrorList) -> bool:
    """Check that the memory suffices for some grains; return True if it does."""
    n = entry.most_places(n_own)
    needed = n * _MEMORY_OF_GRAIN
    available = available_memory()
    found = f"up to {n} positions{'' if entry.repeat is None else ' with grains.repeat'}"
    room = f"{needed / 2**30:.1f} GiB of memory; available: {available / 2**30:.1f} GiB"
    what = "at" if entry.ring is None else "ring"
    fault = Mismatch(f"{found}, which require more than {room}", "fewer")
    return errors.check_first((needed > available, f"{key}.{what}", fault))


def _places_of(
    entry: AddedGrains,
    packing: PackingSection,
    lattice: Lattice | None,
    own: Grains,
    key: str,
    errors: ErrorList,
) -> NDArray[np.float64] | None:
    """Return the positions of some grains: (n, 3), m; None if a ring has none."""
    try:
        places = entry.places(lattice, own)
    except ValueError as error:
        errors.add(f"{key}.ring", str(error))
        return None
    if not len(places):
        hole = f"no {entry.at} site in a packing of {show(packing.size)} spheres"
        errors.add(f"{key}.at", Mismatch(hole))
    return places


def _joined(parts: Sequence[Grains]) -> Grains:
    """Return grains as one table, starting with the original grains."""
    own = parts[0]
    materials = itertools.chain.from_iterable(part.material for part in parts)
    groups = itertools.chain.from_iterable(part.group for part in parts)
    shapes = itertools.chain.from_iterable(part.shape for part in parts)
    return Grains(
        np.concatenate([part.position for part in parts]),
        np.concatenate([part.diameter for part in parts]),
        list(materials),
        list(groups),
        np.concatenate([part.velocity for part in parts]),
        list(shapes),
        file=own.file,
        lines=own.lines,
        added_from=np.cumsum([1, *map(len, parts)]).tolist()[1:-1],
        clump=np.concatenate([part.clump for part in parts]),
        spin=np.concatenate([part.spin for part in parts]),
    )


def _grains_at(
    places: NDArray[np.float64],
    diameter: float,
    material: str = "",
    group: str = "",
    shape: Shape = None,
) -> Grains:
    """Return equal grains at rest at positions (m)."""
    n = len(places)
    return Grains(
        places, np.full(n, diameter), [material] * n, [group] * n, np.zeros((n, 3)), [shape] * n
    )


def _name_of(material: Material | None, materials: dict[str, Material]) -> str:
    """Return the name of a material, and add a material without a name to the further
    materials.
    """
    if material is None:
        return ""
    known = presets() | materials
    name = next((name for name, one in known.items() if one == material), None)
    if name is None:
        stem = material.name or "grains"
        name = next(
            one
            for one in (stem, *(f"{stem} ({n})" for n in range(2, len(known) + 3)))
            if one not in known
        )
        materials[name] = dataclasses.replace(material, name=name)
    return name
