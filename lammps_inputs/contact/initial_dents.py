"""Dents that contacts have before the run, ``contact.initial_overlap``: by value, by region, or left by an earlier run.

A dent is the largest overlap that a contact ever had. Of a given force it is the overlap at which the contact, loaded
for the first time, bears that force: up to it the contact stays elastic from then on. Overlaps below first yield leave
no dent, nor do contacts whose law knows no yielding.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.case.sections import Dents
from granwave.lammps_inputs.contact.law import law_between
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.lattices import TOUCHING
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import wall_fixes, walls

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw
    from granwave.lammps_inputs.case.case import Case
    from granwave.lammps_inputs.case.material import Material

LARGEST = 0.2  # of R*: the elasto-plastic law was fitted up to it
KEY = "contact.initial_overlap"

_REACH = 0.1  # diameters: contacts whose gap is at most this have the dents of a region; no second neighbours
_INSIDE = 1 - 1e-6  # of the gap at which a dent is forgotten
_HALVINGS = 60
_RESULT = "result.h5"


@dataclasses.dataclass(frozen=True, eq=False)
class Meetings:
    """Contacts that there are, or may soon be, at the start: rows of one kind.

    Attributes
    ----------
    law
        Between the materials, of an effective radius of its own.
    first
        What the spheres meet: ids of other spheres or faces, or the name of a fix, of a wall: (n,).
    second
        Ids of the spheres: (n,).
    effective_radius
        (n,), m.
    place
        Of the contacts: (n, 3), m.
    """

    law: ContactLaw
    first: NDArray
    second: NDArray[np.int64]
    effective_radius: NDArray[np.float64]
    place: NDArray[np.float64]

    def overlap_at(self, force: float) -> NDArray[np.float64]:
        """At which first loading reaches a force (N): (n,), m. The law is one function of F/R*^2 and alpha/R*."""
        radius = self.law.effective_radius
        wanted = force * (radius / self.effective_radius) ** 2
        low, high = np.zeros_like(wanted), np.full_like(wanted, 2 * radius)
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            below = self.law.loading_force(middle) < wanted
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        return high * self.effective_radius / radius

    @property
    def yields_from(self) -> NDArray[np.float64]:
        """Overlap at first yield: (n,), m."""
        return self.law.elastic_limit * self.effective_radius / self.law.effective_radius

    def rows(self, peak: NDArray[np.float64]) -> list[str]:
        """Lines of the table of dents."""
        dented = peak > self.yields_from
        columns = (column[dented].tolist() for column in (self.first, self.second, peak))
        return [f"{first} {second} {value:.17g}\n" for first, second, value in zip(*columns, strict=True)]


def dents_table(assembly: Assembly) -> str:
    """The dents before the run, as ``gran/dents read`` takes them: spheres i and j, or a wall's fix and a sphere.

    Raises
    ------
    InputError
        An earlier result cannot be read, or is that of another packing.
    """
    case = assembly.case
    given = case.contact.initial_overlap
    rows: list[str] = ["# spheres i and j, or the fix of a wall and a sphere; largest overlap so far, m\n"]
    if isinstance(given, str):
        known = _read_result(assembly, Path(given))
        for meetings in contacts_at_start(assembly):
            keys = zip(meetings.first.tolist(), meetings.second.tolist(), strict=True)
            rows += meetings.rows(np.array([known.get(key, 0.0) for key in keys]))
        return "".join(rows)
    for meetings in contacts_at_start(assembly):
        peak = np.zeros(len(meetings.second))
        for region in _regions(case):
            peak = np.where(_inside(meetings, region), _size(meetings, region), peak)
        rows += meetings.rows(peak)
    return "".join(rows)


def fault_of_dents(assembly: Assembly) -> str:
    """Why dents given by value cannot be; empty if they can. A result.h5 is read only when the deck is written."""
    case = assembly.case
    given = case.contact.initial_overlap
    if not given:
        return ""
    kinds = [species.material for species in assembly.species if species.role == "sphere"]
    between = [(one, other) for n, one in enumerate(kinds) for other in kinds[n:]]
    yielding = [(case.contact_between(*pair), pair) for pair in between if case.contact_between(*pair).yields]
    if not yielding:
        return f'found dents with contact.law = "{case.contact.law}", which cannot yield; take another law, or no dents'
    if isinstance(given, str):
        return ""
    smallest = float(assembly.sphere_diameters().min()) / 2
    for contact, pair in yielding:
        law = law_between(contact, pair, (smallest, smallest))
        deepest = _deepest(case, law)
        limit = LARGEST * law.effective_radius
        if deepest > limit:
            return (
                f"found a dent of {deepest:.3g} m, expected at most {LARGEST} R* = {limit:.3g} m, "
                "as far as the contact law holds"
            )
    boxes = [region for region in _regions(case) if region.low or region.high]
    found = contacts_at_start(assembly) if boxes else []
    for box in boxes:
        if not any(_inside(meetings, box).any() for meetings in found):
            bounds = {name: list(end) for name, end in (("low", box.low), ("high", box.high)) if end}
            return f"found no contact in the box {show(bounds)}, expected one that holds contacts (m)"
    return ""


def largest_dent(case: Case, law: ContactLaw) -> float:
    """The largest that a contact of this law may have before the run, m; of a file that cannot be read, none."""
    given = case.contact.initial_overlap
    if not given or not law.entry.yields:
        return 0.0
    if not isinstance(given, str):
        return _deepest(case, law)
    path = Path(given)
    try:
        with h5py.File(path / _RESULT if path.is_dir() else path, "r") as file:
            return max(file[f"{table}/peak_overlap"][()].max(initial=0.0) for table in ("contacts", "wall_contacts"))
    except (OSError, KeyError):  # told when the deck is written
        return 0.0


def contacts_at_start(assembly: Assembly) -> list[Meetings]:
    """Contacts between spheres, and with walls and faces of bars, whose gap at the start is small: by kind."""
    case = assembly.case
    ids, positions, radii = assembly.ids, assembly.positions(), assembly.sphere_diameters() / 2
    kind = _materials(assembly)
    materials = list(dict.fromkeys(species.material for species in assembly.species if species.role == "sphere"))
    reach = _INSIDE * min(case.boundary.forget_gap, _REACH) * case.packing.diameter
    found = []

    def add(pair: tuple[Material, Material | None], first: NDArray, row: NDArray, *radius_and_place: NDArray) -> None:
        contact = case.contact_between(*pair)
        if contact.yields and len(row):
            found.append(Meetings(law_between(contact, pair, (1.0, 1.0)), first, ids[row], *radius_and_place))

    one, two, step = _near(assembly, positions, radii, reach)
    place = positions[one] + step * (radii[one] / (radii[one] + radii[two]))[:, None]
    radius = radii[one] * radii[two] / (radii[one] + radii[two])
    for n, first in enumerate(materials):
        for m, second in enumerate(materials[n:], start=n):
            rows = (np.minimum(kind[one], kind[two]) == n) & (np.maximum(kind[one], kind[two]) == m)
            add((first, second), ids[one[rows]], two[rows], radius[rows], place[rows])
    for wall in walls(assembly):
        inner = positions[:, wall.axis] * wall.outward + radii
        near = np.flatnonzero((wall.coordinate * wall.outward - inner <= reach) & (ids <= assembly.lattice.n_spheres))
        for name, _, material in [] if wall.held_layer else wall_fixes(assembly, wall):
            own = near[kind[near] == materials.index(material)]
            touching = positions[own].copy()
            touching[:, wall.axis] = wall.coordinate
            add((material, wall.material), np.full(len(own), name, dtype=object), own, radii[own], touching)
    for bar in assembly.bars:
        row = np.searchsorted(ids, [bar.touches])
        face = np.array([[0.0, 0.0, bar.position[bar.face - bar.first]]])
        add((assembly.material_of(bar.touches), bar.material), np.array([bar.face]), row, radii[row], face)
    return found


def _regions(case: Case) -> tuple[Dents, ...]:
    """Where dents that are given by value are."""
    given = case.contact.initial_overlap
    return given if isinstance(given, tuple) else (Dents(overlap=float(given)),)


def _inside(meetings: Meetings, region: Dents) -> NDArray[np.bool_]:
    """Which of the contacts are in a region: (n,)."""
    inside = np.ones(len(meetings.second), dtype=bool)
    if region.low is not None:
        inside &= (meetings.place >= np.array(region.low)).all(axis=1)
    if region.high is not None:
        inside &= (meetings.place <= np.array(region.high)).all(axis=1)
    return inside


def _deepest(case: Case, law: ContactLaw) -> float:
    """The largest dent given by value, of a contact of one law, m."""
    one = np.array([law.effective_radius])
    meetings = Meetings(law, one, one.astype(np.int64), one, np.zeros((1, 3)))
    return max(float(_size(meetings, region)[0]) for region in _regions(case))


def _size(meetings: Meetings, region: Dents) -> NDArray[np.float64]:
    if region.force is not None:
        return meetings.overlap_at(region.force) if region.force else np.zeros(len(meetings.second))
    return np.full(len(meetings.second), region.overlap or 0.0)


def _near(
    assembly: Assembly, positions: NDArray[np.float64], radii: NDArray[np.float64], reach: float
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Pairs of rows (i < j) whose surfaces are at most ``reach`` apart, and the step from one centre to the other."""
    box, origin = None, positions.min(axis=0)
    if assembly.lattice.periodic:
        box = np.array([*assembly.lattice.lengths, 0.0])
        box[2] = 2 * (np.ptp(positions[:, 2]) + 4 * radii.max())
        origin = np.array([0.0, 0.0, origin[2]])
        tree = KDTree(np.mod(positions - origin, box), boxsize=box)
    else:
        tree = KDTree(positions)
    pairs = tree.query_pairs(2 * radii.max() + reach, output_type="ndarray")
    one, two = pairs.min(axis=1), pairs.max(axis=1)
    step = positions[two] - positions[one]
    if box is not None:
        step[:, :2] -= box[:2] * np.round(step[:, :2] / box[:2])
    near = np.linalg.norm(step, axis=1) - radii[one] - radii[two] <= reach
    return one[near], two[near], step[near]


def _materials(assembly: Assembly) -> NDArray[np.int64]:
    """Which of the spheres' materials each sphere has, in the order of their types: (n_spheres,)."""
    case = assembly.case
    kinds = [species.material for species in assembly.species if species.role == "sphere"]
    own, sites = np.zeros(assembly.lattice.n_spheres, dtype=np.int64), assembly.sites
    if sites is not None:
        own = np.array([kinds.index(one) for one in sites.materials])[sites.kind[sites.present]]
    strikers = [kinds.index(striker.material or case.material) for striker, _ in assembly.strikers]
    return np.append(own, np.array(strikers, dtype=np.int64))


def _read_result(assembly: Assembly, path: Path) -> dict[tuple[int | str, int], float]:
    """The dents that an earlier run left: by two ids, or the fix of a wall and an id, m."""
    case = assembly.case
    source = f"{case.name}: {KEY}"
    path = path / _RESULT if path.is_dir() else path
    if not path.exists():
        raise InputError(f"{source}: {path}: there is no such file; expected the result.h5 of a run, or its directory")
    try:
        with h5py.File(path, "r") as file:
            spheres = {name: file[f"spheres/{name}"][()] for name in ("id", "position", "radius")}
            between = [file[f"contacts/{name}"][()].tolist() for name in ("i", "j", "peak_overlap")]
            on_walls = [file[f"wall_contacts/{name}"] for name in ("wall", "id", "peak_overlap")]
            at, ids, peaks = on_walls[0].asstr()[()].tolist(), *(column[()].tolist() for column in on_walls[1:])
    except (OSError, KeyError) as error:
        raise InputError(f"{source}: {path}: is not the result.h5 of a run ({' '.join(str(error).split())})") from None
    if fault := _other_packing(assembly, spheres):
        raise InputError(f"{source}: {path}: is of another packing: {fault}")
    found: dict[tuple[int | str, int], float] = {(i, j): peak for i, j, peak in zip(*between, strict=True)}
    faces = {bar.name: bar.face for bar in assembly.bars}
    fixes = {(wall.name, material): name for wall in walls(assembly) if not wall.held_layer
             for name, _, material in wall_fixes(assembly, wall)}  # fmt: skip
    for wall, sphere, peak in zip(at, ids, peaks, strict=True):
        what = faces.get(wall) or fixes.get((wall, assembly.material_of(sphere)))
        if what is not None:
            found[what, sphere] = max(peak, found.get((what, sphere), 0.0))
    return found


def _other_packing(assembly: Assembly, spheres: dict[str, NDArray]) -> str:
    """What is different in the packing of an earlier result; empty if nothing is."""
    case = assembly.case
    limit = TOUCHING * case.packing.diameter
    if len(spheres["id"]) != assembly.n_spheres:
        return f"found {len(spheres['id'])} spheres, expected {assembly.n_spheres}"
    missing = np.setdiff1d(assembly.ids, spheres["id"])
    if missing.size:
        return f"found no sphere {missing[0]}"
    away = np.linalg.norm(spheres["position"] - assembly.positions(), axis=1)
    if away.max() > limit:
        return f"found sphere {assembly.ids[away.argmax()]} in a place {away.max():.3g} m away from the one here"
    other = np.abs(2 * spheres["radius"] - assembly.sphere_diameters())
    if other.max() > limit:
        return f"found sphere {assembly.ids[other.argmax()]} with a diameter off by {other.max():.3g} m"
    return ""
