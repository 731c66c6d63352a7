"""Initial dents of contacts, ``contact.initial_overlap``: by value, by region, or from an earlier
run.

A dent is given by the largest overlap that a contact had before the run, or by the force that it
carried at this overlap on first loading; up to this overlap the contact is then elastic. Overlaps
below first yield leave no dent, and neither do contacts whose law does not yield.
"""

from __future__ import annotations

from itertools import combinations_with_replacement
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact.tables import Dents
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.contact.law import law_between
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import regular
from granwave.lammps_inputs.packing.assembly import Assembly, kept_by_assembly
from granwave.lammps_inputs.packing.cylinders import nearest_image
from granwave.lammps_inputs.packing.places import near_pairs
from granwave.lammps_inputs.packing.walls import touched_by, walls
from granwave.lammps_inputs.packing_kind import TOUCHING

LARGEST = 0.2  # largest overlap / R* in the fit of the elasto-plastic law
KEY = "contact.initial_overlap"

_REACH = 0.1  # diameters; largest gap of a contact with a dent, too small for second neighbours
_INSIDE = 1 - 1e-6  # largest gap over the gap at which a dent is erased
_HALVINGS = 60  # halvings of the interval of bisection, beyond double precision
_RESULT = "result.h5"


class NearContacts(NamedTuple):
    """Contacts with a small gap at the start, between two given materials.

    Attributes
    ----------
    law
        Contact law of the two materials, for an arbitrary effective radius.
    first
        Partners of the spheres: ids of spheres or faces of bars, or names of wall fixes: (n,).
    second
        Ids of the spheres: (n,).
    effective_radius
        Effective radii R* of the contacts: (n,), m.
    place
        Positions of the contacts: (n, 3), m.
    """

    law: ContactLaw
    first: NDArray
    second: NDArray[np.int64]
    effective_radius: NDArray[np.float64]
    place: NDArray[np.float64]

    def inside(self, region: Dents) -> NDArray[np.bool_]:
        """Return True for each contact that lies in a region: (n,)."""
        low = -np.inf if region.low is None else np.array(region.low)
        high = np.inf if region.high is None else np.array(region.high)
        return np.asarray(((self.place >= low) & (self.place <= high)).all(axis=1))


def dents_in(region: Dents, law: ContactLaw, radius: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the largest overlaps so far, given by a region, of contacts with effective radii (n,):
    (n,), m.

    A force (N) gives the overlap at which first loading reaches it; F/R*^2 depends only on
    alpha/R*.
    """
    if not region.force:
        return np.full(len(radius), (region.overlap or 0.0) if region.force is None else 0.0)
    wanted = region.force * (law.effective_radius / radius) ** 2
    low = np.zeros_like(wanted)
    high = np.full_like(wanted, 2 * law.effective_radius)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        below = law.loading_force(middle) < wanted
        low = np.where(below, middle, low)
        high = np.where(below, high, middle)
    return high * radius / law.effective_radius


def dents_table(assembly: Assembly) -> str:
    """Return the initial dents as input of ``gran/dents read``: spheres i and j, or a wall's fix
    and a sphere.

    Raises
    ------
    InputError
        An earlier result cannot be read, or is of another packing.
    """
    rows = ["# spheres i and j, or a wall fix and a sphere; largest overlap so far, m\n"]
    known = None if earlier_result(assembly.case) is None else dents_of_result(assembly)
    for near in contacts_at_start(assembly):
        law = near.law
        radius = near.effective_radius
        peak = np.zeros(len(near.second))
        for region in regions_of(assembly.case) if known is None else ():
            peak = np.where(near.inside(region), dents_in(region, law, radius), peak)
        if known is not None:
            keys = zip(near.first.tolist(), near.second.tolist(), strict=True)
            peak = np.array([known.get(key, 0.0) for key in keys])
        dented = peak > law.elastic_limit * radius / law.effective_radius  # beyond first yield
        columns = (column[dented].tolist() for column in (near.first, near.second, peak))
        rows += [
            f"{first} {second} {value:.17g}\n"
            for first, second, value in zip(*columns, strict=True)
        ]
    return "".join(rows)


def error_in_dents(assembly: Assembly) -> str:
    """Describe the fault in dents given by value; empty if none. A result.h5 is not read: it may
    have been removed.
    """
    case = assembly.case
    given = case.contact.initial_overlap
    if not given:
        return ""
    kinds = [species.material for species in assembly.species if species.role == "sphere"]
    yielding = [
        pair
        for pair in combinations_with_replacement(kinds, 2)
        if case.contact_between(*pair).yields
    ]
    if not yielding:
        return (
            f'found plastic indentations with contact.law = "{case.contact.law}", which cannot '
            "yield; use another law, or remove them"
        )
    if isinstance(given, str):
        return ""
    smallest = float(assembly.sphere_diameters().min()) / 2
    for pair in yielding:
        law = law_between(case.contact_between(*pair), pair, (smallest, smallest))
        deepest = _deepest(case, law)
        limit = LARGEST * law.effective_radius
        if deepest > limit:
            found = (
                f"found an overlap of {deepest:.3g} m, expected at most {LARGEST} R* = "
                f"{limit:.3g} m"
            )
            return f"{found}, the limit of the contact law"
    boxes = [region for region in regions_of(case) if region.low or region.high]
    there = contacts_at_start(assembly) if boxes else []
    for box in boxes:
        if not any(near.inside(box).any() for near in there):
            bounds = {
                name: list(getattr(box, name)) for name in ("low", "high") if getattr(box, name)
            }
            return (
                f"found no contact in the box {show(bounds)}, expected one that holds contacts (m)"
            )
    return ""


def largest_dent(assembly: Assembly, law: ContactLaw) -> float:
    """Return the largest initial dent of contacts of this law, m; 0 for a file that cannot be
    read.
    """
    case = assembly.case
    given = case.contact.initial_overlap
    if not given or not law.entry.yields:
        return 0.0
    if earlier_result(case) is None:
        return _deepest(case, law)
    try:
        earlier = _earlier(assembly)
    except _UNREADABLE:  # reported by `dents_of_result`
        return 0.0
    return float(
        max(
            earlier[name]["peak_overlap"].max(initial=0.0) for name in ("contacts", "wall_contacts")
        )
    )


def earlier_result(case: Case) -> Path | None:
    """Return the path of the result.h5 with the dents of a case; None for dents given by value."""
    if not isinstance(case.contact.initial_overlap, str):
        return None
    path = Path(case.contact.initial_overlap)
    return path / _RESULT if path.is_dir() else path


def contacts_at_start(assembly: Assembly) -> list[NearContacts]:
    """Return the yielding contacts of spheres, walls and bars with a small gap at the start, by
    pair of materials.
    """
    case = assembly.case
    ids = assembly.ids
    positions = assembly.positions()
    radii = assembly.sphere_diameters() / 2
    of_types = [species.material for species in assembly.species if species.role == "sphere"]
    materials = list(dict.fromkeys(of_types))
    kind = np.array([materials.index(one) for one in of_types])[assembly.body[assembly.present]]
    reach = _INSIDE * min(case.boundary.forget_gap, _REACH) * case.packing.diameter
    found = []

    def add(
        pair: tuple[Material, Material | None],
        first: NDArray,
        row: NDArray,
        *radius_and_place: NDArray,
    ) -> None:
        contact = case.contact_between(*pair)
        if contact.yields and len(row):
            found.append(
                NearContacts(
                    law_between(contact, pair, (1.0, 1.0)), first, ids[row], *radius_and_place
                )
            )

    period = assembly.lattice.lengths if assembly.lattice.periodic else None
    one, two = near_pairs(positions, radii, reach, period).T
    step = nearest_image(positions[two] - positions[one], period)
    near = np.linalg.norm(step, axis=1) - radii[one] - radii[two] <= reach
    one = one[near]
    two = two[near]
    step = step[near]
    place = positions[one] + step * (radii[one] / (radii[one] + radii[two]))[:, None]
    radius = radii[one] * radii[two] / (radii[one] + radii[two])
    low, high = np.sort([kind[one], kind[two]], axis=0)
    for n, m in combinations_with_replacement(range(len(materials)), 2):
        rows = (low == n) & (high == m)
        add((materials[n], materials[m]), ids[one[rows]], two[rows], radius[rows], place[rows])
    for wall in walls(assembly):
        near = np.flatnonzero(
            (wall.gaps(positions, radii) <= reach) & (ids <= assembly.lattice.n_spheres)
        )
        if (chosen := touched_by(assembly, wall)) is not None:
            near = near[chosen[ids[near] - 1]]
        for name, _, material in wall.fixes:
            own = near[kind[near] == materials.index(material)]
            radius = wall.effective_radii(radii[own])
            place = wall.nearest(positions[own])
            add(
                (material, wall.material), np.full(len(own), name, dtype=object), own, radius, place
            )
    for bar in assembly.bars:
        row = np.searchsorted(ids, [bar.touches])
        face = np.array([[0.0, 0.0, bar.position[bar.face - bar.first]]])
        add(
            (assembly.material_of(bar.touches), bar.material),
            np.array([bar.face]),
            row,
            radii[row],
            face,
        )
    return found


def regions_of(case: Case) -> tuple[Dents, ...]:
    """Return the regions of dents that are given by value; where regions overlap, the last one
    applies.
    """
    given = case.contact.initial_overlap
    return given if isinstance(given, tuple) else (Dents(overlap=float(given)),)


def _deepest(case: Case, law: ContactLaw) -> float:
    """Return the largest dent given by value, for contacts of one law, m."""
    return max(
        float(dents_in(region, law, np.array([law.effective_radius]))[0])
        for region in regions_of(case)
    )


_UNREADABLE = (
    OSError,
    KeyError,
    TypeError,
    ValueError,
    AttributeError,
)  # errors of h5py for a damaged or unrelated file
_COLUMNS: dict[
    str, dict[str, tuple[type, int]]
] = {  # type and width of columns by group; columns of width 0 are arrays of numbers
    "spheres": {"id": (np.int64, 0), "position": (np.float64, 3), "radius": (np.float64, 0)},
    "contacts": {"i": (np.int64, 0), "j": (np.int64, 0), "peak_overlap": (np.float64, 0)},
    "wall_contacts": {"wall": (object, 0), "id": (np.int64, 0), "peak_overlap": (np.float64, 0)},
}


def dents_of_result(assembly: Assembly) -> dict[tuple[int | str, int], float]:
    """Return the dents left by the `earlier_result`, m; keys are two ids, or the fix of a wall and
    an id.

    Raises
    ------
    InputError
        The result.h5 is missing, damaged or of another packing.
    """
    case = assembly.case
    source = f"{case.name}: {KEY}: {earlier_result(case)}"
    try:
        earlier = _earlier(assembly)
    except FileNotFoundError:
        hint = "expected the result.h5 of a run, or its directory"
        raise InputError(f"{source}: no such file; {hint}") from None
    except _UNREADABLE as error:
        raise InputError(
            f"{source}: is not the result.h5 of a run ({' '.join(str(error).split())})"
        ) from None
    if fault := _other_packing(assembly, earlier["spheres"]):
        raise InputError(f"{source}: belongs to another packing: {fault}")
    first, second, peaks = (column.tolist() for column in earlier["contacts"].values())
    dents: dict[tuple[int | str, int], float] = {}
    for sphere_1, sphere_2, peak in zip(first, second, peaks, strict=True):
        dents[sphere_1, sphere_2] = peak
    faces = {bar.name: bar.face for bar in assembly.bars}
    fixes = {}
    for wall in walls(assembly):
        fixes.update({(wall.name, material): name for name, _, material in wall.fixes})
    for wall_name, sphere, peak in zip(
        *(column.tolist() for column in earlier["wall_contacts"].values()), strict=True
    ):
        surface = faces.get(wall_name) or fixes.get((wall_name, assembly.material_of(sphere)))
        if surface is not None:
            dents[surface, sphere] = max(peak, dents.get((surface, sphere), 0.0))
    return dents


@kept_by_assembly
def _earlier(assembly: Assembly) -> dict[str, dict[str, NDArray]]:
    """Read `_COLUMNS` of the `earlier_result`; raise one of `_UNREADABLE` for other files."""
    path = earlier_result(assembly.case)
    assert path is not None  # needed only where dents are read from a file
    path.stat()  # raises FileNotFoundError, where h5py would raise another OSError
    import h5py  # imported on demand: slow to load

    found: dict[str, dict[str, NDArray]] = {}
    with h5py.File(regular(path), "r") as file:
        for group, columns in _COLUMNS.items():
            table = found[group] = {}
            for name, (kind, width) in columns.items():
                data = file[f"{group}/{name}"]
                values = table[name] = np.asarray(
                    data.asstr()[()] if kind is object else data[()], dtype=kind
                )
                row_shape = (width,) if width else ()
                if values.shape[1:] != row_shape or not values.ndim:
                    raise ValueError(f"{group}/{name}: found the shape {values.shape}")
                least = 0.0 if name == "peak_overlap" else -np.inf
                if kind is not object and not (np.isfinite(values) & (values >= least)).all():
                    raise ValueError(
                        f"{group}/{name}: found values that are not finite, or negative"
                    )
            lengths = [len(values) for values in table.values()]
            if len(set(lengths)) > 1:
                raise ValueError(
                    f"{group}: found columns of {' and '.join(map(str, lengths))} rows"
                )
    return found


def _other_packing(assembly: Assembly, earlier: dict[str, NDArray]) -> str:
    """Describe the difference to the spheres of an earlier result; empty if none."""
    limit = TOUCHING * assembly.case.packing.diameter
    ids = assembly.ids
    if len(earlier["id"]) != len(ids):
        return f"found {len(earlier['id'])} spheres, expected {len(ids)}"
    if (missing := np.setdiff1d(ids, earlier["id"])).size:
        return f"found no sphere {missing[0]}"
    away = np.linalg.norm(earlier["position"] - assembly.positions(), axis=1)
    if away.max() > limit:
        return (
            f"found sphere {ids[away.argmax()]} at a distance of {away.max():.3g} m from its "
            "position in this case"
        )
    other = np.abs(2 * earlier["radius"] - assembly.sphere_diameters())
    if other.max() > limit:
        return (
            f"found sphere {ids[other.argmax()]} with a diameter that differs by "
            f"{other.max():.3g} m"
        )
    return ""
