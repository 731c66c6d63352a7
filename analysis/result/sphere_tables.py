"""Tables of contacts, wall contacts and spheres in ``result.h5``, made of parts of the spheres.

A part knows all contacts of its spheres. Those of a sphere of this part with one of another are known to both, and the
part of the sphere with the lower id writes them. So each part is made by itself, in the memory that it takes, and its
values do not depend on how the spheres were parted.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.lammps_output.dump_files import initial_forces_path
from granwave.analysis.lammps_output.dumps import WALL_COLUMNS, read_initial_forces_in_parts, read_initial_wall_forces
from granwave.analysis.lammps_output.frame import AGAIN, Frame
from granwave.analysis.result.contacts import (
    Contacts,
    PairLaws,
    dissipated_share,
    list_contacts,
    merge_dents,
    pair_laws,
    sphere_values,
    touching_pairs,
)
from granwave.analysis.result.hdf5_file import PartwiseGroup, write_group
from granwave.analysis.result.start import Buckets, Dents, Start
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.packing.assembly import assemble, gap_tolerance
from granwave.lammps_inputs.packing.walls import walls
from granwave.lammps_inputs.run_directory import INITIAL_WALL_FORCES_FILE

COLUMN = "initial_force"


class InitialForces:
    """Forces of contacts after the static stage.

    Parameters
    ----------
    pairs
        Contacts of particles: i, j, force.
    planes
        Contacts with each plane, by its name: id, force.
    directory
        Directory of the run, for messages.
    """

    def __init__(self, pairs: Dents, planes: Mapping[str, Frame], directory: Path) -> None:
        self._pairs, self._planes, self._directory = pairs, planes, directory

    def of_part(self, part: int, first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the forces of pairs of spheres, one of each in this part, i < j: (n_pairs,), N."""
        return force_of_pairs(self._pairs.of_part(part), first, second)

    def at_bars(self, first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the forces of spheres on the faces of bars: (n_pairs,), N."""
        return force_of_pairs(self._pairs.at_bars(), first, second)

    def on_wall(self, wall: str, ids: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the forces of spheres, ids rising, on a plane: (n_ids,), N.

        Raises
        ------
        OutputFormatError
            A sphere pressed on the plane that is not among these.
        """
        found = self._planes[wall]
        pressing = found["id"].astype(np.int64)
        if len(strange := np.setdiff1d(pressing, ids)):
            raise OutputFormatError(
                f"{self._directory / INITIAL_WALL_FORCES_FILE.format(wall)}: found sphere {strange[0]}, which never "
                f"touched the wall {wall}: the files belong to different runs, or one is damaged; {AGAIN}"
            )
        forces = np.zeros(len(ids))
        forces[np.searchsorted(ids, pressing)] = found["force"]
        return forces


def read_initial_forces(directory: Path, start: Start, rows: Buckets, at_once: int | None) -> InitialForces | None:
    """Read the forces after the static stage; None if there was none, or if an early version ran it.

    Parameters
    ----------
    rows
        Contacts by part of either sphere.
    at_once
        Largest number of contacts that are read at once.

    Raises
    ------
    MissingOutputError, OutputFormatError
        A file is missing or damaged, or belongs to another run.
    """
    path = initial_forces_path(directory)
    if path is None:
        return None
    pairs, planes = Dents(start, rows), read_initial_wall_forces(directory)
    for frame in read_initial_forces_in_parts(directory, at_once):
        start.check_ids(path, frame)
        pairs.add(frame)
    for name, frame in planes.items():
        start.check_ids(path.with_name(INITIAL_WALL_FORCES_FILE.format(name)), frame)
    return InitialForces(pairs, planes, path.parent)


def force_of_pairs(frame: Frame, first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the forces of pairs: (n_pairs,), N; 0 for those that are not among the rows.

    Parameters
    ----------
    frame
        Contacts: i, j, force.
    first, second
        Ids of the pairs, i < j: (n_pairs,).
    """
    i, j = np.sort(frame.vector("i", "j").astype(np.int64), axis=1).T
    stride = 1 + max(j.max(initial=0), second.max(initial=0))
    known, rows = np.unique(i * stride + j, return_inverse=True)
    forces = np.append(np.bincount(rows, frame["force"], minlength=len(known)), 0.0)
    keys = first * stride + second
    found = np.searchsorted(known, keys)
    known = np.append(known, -1)
    return np.asarray(np.where(known[found] == keys, forces[found], 0.0))


_OF_WALL_CONTACTS = (
    "overlap", "force", "peak_overlap", "peak_force", "time_first", "time_peak", "time_yield",
    "dissipated_energy", "friction_energy", "tangential_force", "initial_overlap",
)  # fmt: skip


def write_tables(
    file: h5py.File,
    case: Case,
    start: Start,
    dents: Dents,
    planes: Mapping[str, Frame],
    initial: InitialForces | None,
) -> None:
    """Write the groups ``contacts``, ``wall_contacts`` and ``spheres``.

    Parameters
    ----------
    planes
        Contacts with each plane, by its name.
    initial
        Forces after the static stage; None: there was none.
    """
    bars = _bar_contacts(case, dents.at_bars(), initial)
    wall_contacts = _wall_contacts(planes, bars, initial, has_loss=case.has_loss)
    write_group(file, "wall_contacts", wall_contacts)
    at_walls = start.rows(wall_contacts["id"])
    losses = _losses_at_walls(case, wall_contacts)
    contact_rows, sphere_rows = (PartwiseGroup(file, name, start.n_parts) for name in ("contacts", "spheres"))
    for part in range(start.n_parts):
        first, stop = start.range(part)
        here = (at_walls >= first) & (at_walls < stop)
        lost = {
            name: np.bincount(at_walls[here] - first, values[here], minlength=stop - first)
            for name, values in losses.items()
        }
        contacts, shares = _contacts_of(case, start, part, dents.of_part(part))
        if initial is not None:
            contacts[COLUMN] = initial.of_part(part, contacts["i"], contacts["j"])
        sphere_rows.append(_write_contacts(contact_rows, start, part, contacts, shares, lost))


def _write_contacts(
    group: PartwiseGroup,
    start: Start,
    part: int,
    contacts: Contacts,
    shares: NDArray[np.float64],
    lost: dict[str, NDArray],
) -> dict[str, NDArray]:
    """Write the contacts of a part; return the columns of its spheres.

    Parameters
    ----------
    shares
        Share of the first sphere in what each contact dissipated.
    lost
        Dissipation at walls by sphere of the part, by the column that it is part of, J.
    """
    rows = start.range(part)
    ids = start.ids(*rows)
    group.append(contacts, (contacts["i"] >= ids[0]) & (contacts["i"] <= ids[-1]))
    everyone = ids if start.n_parts == 1 else np.union1d(ids, np.concatenate([contacts["i"], contacts["j"]]))
    summed = sphere_values(everyone, contacts, contacts["yielded"], shares)
    own = slice(*np.searchsorted(everyone, [ids[0], ids[-1] + 1]))
    spheres = start.read(*rows)
    columns: dict[str, NDArray] = {
        "id": ids,
        "position": spheres.vector("x", "y", "z"),
        "radius": spheres["diameter"] / 2,
        "mass": spheres["density"] * np.pi / 6 * spheres["diameter"] ** 3,
        **{name: values[own] for name, values in summed.items()},
    }
    for name, values in lost.items():
        columns[name] = values + columns.get(name, 0.0)
    columns["dissipated_energy"] = columns["dissipated_energy"] + columns["dissipated_energy_wall"]
    return columns


def _contacts_of(case: Case, start: Start, part: int, dents: Frame) -> tuple[Contacts, NDArray[np.float64]]:
    """Return all contacts of the spheres of a part, and the share of the first sphere in what each dissipated."""
    tolerance, sides = gap_tolerance(case), periodic(case)
    merged = merge_dents(dents)
    near = start.around(part, np.concatenate([merged["i"], merged["j"]]), tolerance, sides)
    near_ids, radii = near["id"].astype(np.int64), near["diameter"] / 2

    def laws_of(contacts: Contacts) -> PairLaws:
        rows = near.rows(np.stack([contacts["i"], contacts["j"]], axis=1))
        return pair_laws(case, near["type"].astype(np.int64)[rows], radii[rows])

    lengths = start.box[:, 1] - start.box[:, 0]
    periods = tuple(length * goes_on for length, goes_on in zip(lengths, sides, strict=True))
    if assemble(case).has_cylinders:  # they touch at other distances
        touching = np.unique(assemble(case).contacts(), axis=0)
    else:
        touching = touching_pairs(near_ids, near.vector("x", "y", "z"), radii, tolerance, periods, start.low)
    if start.n_parts > 1:
        ids = start.ids(*start.range(part))
        touching = touching[((touching >= ids[0]) & (touching <= ids[-1])).any(axis=1)]
    contacts = list_contacts(merged, touching, laws_of(merged).yield_overlap)
    laws = laws_of(contacts)
    contacts["yielded"] = contacts.pop("grown_overlap") > laws.yielded_from
    contacts |= {"yield_overlap": laws.yield_overlap, "effective_radius": laws.effective_radius}
    return contacts, laws.share


def periodic(case: Case) -> tuple[bool, bool, bool]:
    """Return True for the periodic axes of a packing."""
    sides = case.boundary.sides == "periodic"
    return sides, sides, False


def _losses_at_walls(case: Case, wall_contacts: Contacts) -> dict[str, NDArray[np.float64]]:
    """Return the dissipation in the sphere of each wall contact; a rigid wall dissipates nothing."""
    materials: dict[str, Material | None] = {bar.name: bar.material for bar in assemble(case).bars}
    materials |= {wall.name: wall.material for wall in walls(case)}
    partners = [materials[wall] for wall in wall_contacts["wall"].tolist()]
    spheres = [assemble(case).material_of(sphere) for sphere in wall_contacts["id"].tolist()]
    plastic_share = np.array([dissipated_share(*pair) for pair in zip(spheres, partners, strict=True)])
    friction_share = np.array([0.5 if partner else 1.0 for partner in partners])
    others = {name: wall_contacts[name] for name in ("friction_energy", "viscous_energy") if name in wall_contacts}
    plastic = plastic_share * (wall_contacts["dissipated_energy"] - sum(others.values()))
    own: dict[str, NDArray[np.float64]] = {name: friction_share * lost for name, lost in others.items()}
    return {"dissipated_energy_wall": plastic + sum(own.values()), **own}


def _bar_contacts(case: Case, dents: Frame, initial: InitialForces | None) -> dict[str, Contacts]:
    """Return the contacts of beads with the faces of bars, by name of the bar."""
    merged = merge_dents(dents)
    if initial is not None:
        merged[COLUMN] = initial.at_bars(merged["i"], merged["j"])
    return {
        bar.name: {name: column[merged["j"] == bar.face] for name, column in merged.items()}
        for bar in assemble(case).bars
    }


def _wall_contacts(
    planes: Mapping[str, Frame], bars: Mapping[str, Contacts], initial: InitialForces | None, *, has_loss: bool
) -> Contacts:
    """Return the contacts with walls and bars as one table; times in s (NaN: never)."""
    parts: list[Contacts] = []
    columns = (*_OF_WALL_CONTACTS, *(["viscous_energy"] if has_loss else []), *([COLUMN] if initial else []))
    for wall, frame in planes.items():
        values: Contacts = {name: frame[name] for name in WALL_COLUMNS if name != "dissipated"}
        for name in values:
            if name.startswith("time"):
                values[name] = np.where(values[name] < 0, np.nan, values[name])
        values |= {
            "dissipated_energy": frame["dissipated"] + frame.get("friction") + frame.get("viscous"),
            "friction_energy": frame.get("friction"),
            "tangential_force": frame.get("tangential_force"),
            "initial_overlap": frame.get("initial"),
        }
        values |= {"viscous_energy": frame["viscous"]} if has_loss else {}
        values |= {COLUMN: initial.on_wall(wall, frame["id"].astype(np.int64))} if initial else {}
        parts.append({"wall": np.full(len(frame), wall, dtype=object), "id": frame["id"].astype(np.int64)} | values)
    for bar, found in bars.items():
        part: Contacts = {"wall": np.full(len(found["i"]), bar, dtype=object), "id": found["i"]}
        parts.append(part | {name: found[name] for name in columns})
    empty: Contacts = {"wall": np.empty(0, dtype=object), "id": np.empty(0, dtype=np.int64)}
    empty |= {name: np.empty(0) for name in columns}
    return {name: np.concatenate([part[name] for part in (empty, *parts)]) for name in empty}
