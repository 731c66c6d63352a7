"""Tables of contacts, wall contacts and spheres in ``result.h5``, made of parts of the spheres.

A part contains all contacts of its spheres. Contacts between spheres of two parts are in both, and
the part of the sphere with the lower id writes them. Each part is therefore processed
independently, in its own memory, and its values do not depend on the division.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.lammps_output import dumps
from granwave.analysis.lammps_output.frame import AGAIN, Frame
from granwave.analysis.result import contacts as pairs
from granwave.analysis.result import hdf5_file as hdf5
from granwave.analysis.result.contacts import Contacts
from granwave.analysis.result.hdf5_file import Encoded
from granwave.analysis.result.start import DentRecord, Start, periodic
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import walls
from granwave.lammps_inputs.packing_kind import TOUCHING
from granwave.lammps_inputs.processes import ALONE, Processes
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import INITIAL_WALL_FORCES_FILE

COLUMN = "initial_force"
_OF_WALL_CONTACTS = (
    "overlap", "force", "peak_overlap", "peak_force", "time_first", "time_peak", "time_yield",
    "dissipated_energy", "friction_energy", "tangential_force", "initial_overlap",
)  # fmt: skip


class AfterStaticStage(NamedTuple):
    """Forces of contacts after the static stage: of pairs of particles (i, j, force), and by plane
    (id, force).
    """

    contacts: DentRecord
    planes: Mapping[str, Frame]
    folder: Path


def after_static_stage(
    results: ResultDirectory, start: Start, scratch: Callable[[], Path], processes: Processes
) -> AfterStaticStage | None:
    """Read the forces after the static stage; None if there was none."""
    dump = dumps.contacts_after_static_stage(results)
    if dump is None:
        return None
    folder = dump.path.parent
    planes = dumps.read_wall_contacts(results, after_static_stage=True)
    for name, frame in planes.items():
        start.check_ids(folder / INITIAL_WALL_FORCES_FILE.format(name), frame)
    return AfterStaticStage(DentRecord(start, dump, scratch, processes), planes, folder)


def _force_of_pairs(frame: Frame, contacts: Contacts) -> NDArray[np.float64]:
    """Return the forces of contacts from rows (i, j, force): (n_contacts,), N; 0 for contacts
    without a row.
    """
    i, j = frame.pairs.T
    stride = 1 + max(j.max(initial=0), contacts["j"].max(initial=0))
    known, rows = np.unique(i * stride + j, return_inverse=True)
    forces = np.append(np.bincount(rows, frame["force"], minlength=len(known)), 0.0)
    keys = contacts["i"] * stride + contacts["j"]
    found = np.searchsorted(known, keys)
    return np.asarray(np.where(np.append(known, -1)[found] == keys, forces[found], 0.0))


def _force_on_wall(
    initial: AfterStaticStage, wall: str, ids: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return the forces of spheres, ids rising, on a plane: (n_ids,), N; raise OutputFormatError if
    one is missing.
    """
    pressing = initial.planes[wall]["id"].astype(np.int64)
    if len(strange := np.setdiff1d(pressing, ids)):
        raise OutputFormatError(
            f"{initial.folder / INITIAL_WALL_FORCES_FILE.format(wall)}: found sphere "
            f"{strange[0]}, which never touched the wall {wall}: the files belong to different "
            f"runs, or one of them is damaged; {AGAIN}"
        )
    forces = np.zeros(len(ids))
    forces[np.searchsorted(ids, pressing)] = initial.planes[wall]["force"]
    return forces


def write_tables(
    file: h5py.File,
    assembly: Assembly,
    start: Start,
    dents: DentRecord,
    planes: Mapping[str, Frame],
    initial: AfterStaticStage | None,
    processes: Processes = ALONE,
) -> None:
    """Write the groups ``contacts``, ``wall_contacts`` and ``spheres``.

    Parameters
    ----------
    planes
        Contacts with each plane, by its name.
    initial
        Forces after the static stage; None: there was none.
    processes
        Processes that make the parts.
    """
    wall_contacts = _wall_contacts(assembly, planes, dents.at_bars, initial)
    pairs.leave_out_rounding(wall_contacts, start.box)
    hdf5.write_group(file, "wall_contacts", wall_contacts)
    at_walls = start.rows(wall_contacts["id"])
    losses = _losses_at_walls(assembly, wall_contacts)
    forces = wall_contacts["peak_force"]

    def task(part: int) -> _Part:
        first, stop = start.range(part)
        here = (at_walls >= first) & (at_walls < stop)
        return _Part(
            part,
            dents.of_part(part),
            initial and initial.contacts.of_part(part),
            at_walls[here] - first,
            {name: lost[here] for name, lost in losses.items()},
            forces[here],
        )

    if start.n_parts == 1:
        for name, columns in zip(
            ("contacts", "spheres"), _tables(assembly, start, task(0)), strict=True
        ):
            hdf5.write_group(file, name, columns)
        return
    n_contacts = 0
    for begin in range(
        0, start.n_parts, processes.number
    ):  # so that no process holds more than one part
        parts = range(begin, min(begin + processes.number, start.n_parts))
        places = []
        made = processes.map(partial(_make, assembly, start), map(task, parts))
        for part, (n_rows, spheres) in zip(parts, made, strict=True):
            hdf5.append_columns(file, "spheres", spheres, start.range(part)[1])
            places.append(n_contacts)
            n_contacts += n_rows
        for n_rows, contacts in processes.map(_encode, places):
            hdf5.append_columns(file, "contacts", contacts, n_rows)


class _Part(NamedTuple):
    """Input of a process that makes the tables of a part."""

    number: int
    dents: Callable[[], Frame]
    initial: Callable[[], Frame] | None
    at_walls: NDArray[np.int64]  # rows of the spheres of wall contacts, in the part
    losses: dict[str, NDArray[np.float64]]  # dissipation in these spheres, J
    forces: NDArray[np.float64]  # peak forces of these wall contacts, N


_made: list[
    Contacts
] = []  # contacts of the part that this process has made, whose place in the file is not known yet


def _make(assembly: Assembly, start: Start, part: _Part) -> tuple[int, dict[str, Encoded]]:
    """Make the tables of a part; return the number of its contacts, which `_encode` then encodes,
    and its spheres.
    """
    contacts, spheres = _tables(assembly, start, part)
    _made[:] = [contacts]
    return len(contacts["i"]), hdf5.encoded_columns(spheres, start.range(part.number)[0])


def _encode(first: int) -> tuple[int, dict[str, Encoded]]:
    """Encode the contacts of the part that was made, from row ``first`` on; return also the row
    after their last.
    """
    contacts = _made.pop()
    return first + len(contacts["i"]), hdf5.encoded_columns(contacts, first)


def _tables(assembly: Assembly, start: Start, part: _Part) -> tuple[Contacts, dict[str, NDArray]]:
    """Make the tables of the contacts and spheres of a part."""
    contacts, share = _contacts_of(assembly, start, part.number, part.dents)
    if part.initial is not None:
        contacts[COLUMN] = _force_of_pairs(part.initial(), contacts)
    rows = slice(*start.range(part.number))
    ids = start.ids(rows.start, rows.stop)
    spheres = start.read(rows)
    everyone = (
        ids
        if start.n_parts == 1
        else hdf5.sorted_once(np.concatenate([ids, contacts["i"], contacts["j"]]))
    )
    own = slice(*np.searchsorted(everyone, [ids[0], ids[-1] + 1]))
    columns: dict[str, NDArray] = {
        "id": ids,
        "position": spheres.vector("x", "y", "z") + assembly.deck_origin,
        "radius": spheres["diameter"] / 2,
        "mass": spheres["density"] * np.pi / 6 * spheres["diameter"] ** 3,
        **{
            name: values[own]
            for name, values in pairs.sphere_values(everyone, contacts, share).items()
        },
    }
    for name, lost in part.losses.items():
        columns[name] = np.bincount(part.at_walls, lost, minlength=len(ids)) + columns.get(
            name, 0.0
        )
    columns["dissipated_energy"] = columns["dissipated_energy"] + columns["dissipated_energy_wall"]
    columns["peak_force_with_walls"] = columns["peak_force"].copy()
    np.maximum.at(columns["peak_force_with_walls"], part.at_walls, part.forces)
    if start.n_parts > 1:
        listed = (contacts["i"] >= ids[0]) & (contacts["i"] <= ids[-1])
        contacts = {name: contacts.pop(name)[listed] for name in list(contacts)}
    return contacts, columns


def _contacts_of(
    assembly: Assembly, start: Start, part: int, dents: Callable[[], Frame]
) -> tuple[Contacts, NDArray[np.float64]]:
    """Return all contacts of the spheres of a part, and the fraction of the dissipation of each
    that belongs to its first sphere.
    """
    tolerance = TOUCHING * assembly.case.packing.diameter
    sides = periodic(assembly.case)
    merged = pairs.merge_dents(dents())
    near = start.around(part, np.concatenate([merged["i"], merged["j"]]), tolerance, sides)
    near_ids = near["id"].astype(np.int64)
    radii = near["diameter"] / 2

    def laws_of(contacts: Contacts) -> dict[str, NDArray[np.float64]]:
        rows = hdf5.rows_of(near_ids, np.stack([contacts["i"], contacts["j"]], axis=1))
        return pairs.pair_laws(assembly, near["type"].astype(np.int64)[rows], radii[rows])

    low, high = start.box.T
    periods = tuple(length * goes_on for length, goes_on in zip(high - low, sides, strict=True))
    if assembly.has_cylinders or assembly.clumps:  # they touch at other distances, or never
        touching = np.unique(assembly.contacts(), axis=0)
    else:
        touching = pairs.touching_pairs(
            near_ids, near.vector("x", "y", "z"), radii, tolerance, periods, start.low
        )
    if start.n_parts > 1:
        ids = start.ids(*start.range(part))
        touching = touching[((touching >= ids[0]) & (touching <= ids[-1])).any(axis=1)]
    contacts = pairs.list_contacts(merged, touching, laws_of(merged)["yield_overlap"])
    pairs.leave_out_rounding(contacts, start.box)
    laws = laws_of(contacts)
    contacts["yielded"] = contacts.pop("grown_overlap") > laws["yielded_from"]
    return contacts | {name: laws[name] for name in ("yield_overlap", "effective_radius")}, laws[
        "share"
    ]


def _losses_at_walls(assembly: Assembly, wall_contacts: Contacts) -> dict[str, NDArray[np.float64]]:
    """Return the dissipation in the sphere of each wall contact; a rigid wall dissipates nothing."""
    materials: dict[str, Material | None] = {bar.name: bar.material for bar in assembly.bars}
    materials |= {wall.name: wall.material for wall in walls(assembly)}
    partners = [materials[wall] for wall in wall_contacts["wall"].tolist()]
    spheres = [assembly.material_of(sphere) for sphere in wall_contacts["id"].tolist()]
    plastic_share = np.array(
        [pairs.dissipated_share(*pair) for pair in zip(spheres, partners, strict=True)]
    )
    friction_share = np.array([0.5 if partner else 1.0 for partner in partners])
    others = {
        name: wall_contacts[name]
        for name in ("friction_energy", "viscous_energy")
        if name in wall_contacts
    }
    plastic = plastic_share * (wall_contacts["dissipated_energy"] - sum(others.values()))
    own: dict[str, NDArray[np.float64]] = {
        name: friction_share * lost for name, lost in others.items()
    }
    return {"dissipated_energy_wall": plastic + sum(own.values()), **own}


def _wall_contacts(
    assembly: Assembly,
    planes: Mapping[str, Frame],
    at_bars: Frame,
    initial: AfterStaticStage | None,
) -> Contacts:
    """Return the contacts with walls, and of beads with the faces of bars, as one table; times in s
    (NaN: never).
    """
    columns = (
        *_OF_WALL_CONTACTS,
        *(["viscous_energy"] if assembly.case.has_loss else []),
        *([COLUMN] if initial else []),
    )
    empty: Contacts = {"wall": np.empty(0, dtype=object), "id": np.empty(0, dtype=np.int64)}
    parts = [empty | {name: np.empty(0) for name in columns}]
    for wall, frame in planes.items():
        ids = frame["id"].astype(np.int64)
        values: Contacts = {
            name: frame[name] for name in dumps.WALL_COLUMNS if name != "dissipated"
        }
        for name in values:
            if name.startswith("time"):
                values[name] = np.where(values[name] < 0, np.nan, values[name])
        values |= {
            "wall": np.full(len(frame), wall, dtype=object),
            "id": ids,
            "dissipated_energy": frame["dissipated"] + frame.get("friction") + frame.get("viscous"),
            "friction_energy": frame.get("friction"),
            "tangential_force": frame.get("tangential_force"),
            "initial_overlap": frame.get("initial"),
            "viscous_energy": frame.get("viscous"),
            COLUMN: _force_on_wall(initial, wall, ids) if initial else np.zeros(len(frame)),
        }
        parts.append(values)
    merged = pairs.merge_dents(at_bars)
    if initial is not None:
        merged[COLUMN] = _force_of_pairs(initial.contacts.at_bars, merged)
    for bar in assembly.bars:
        part = {name: column[merged["j"] == bar.face] for name, column in merged.items()}
        parts.append(
            part | {"wall": np.full(len(part["i"]), bar.name, dtype=object), "id": part["i"]}
        )
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
