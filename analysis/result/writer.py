"""Writer of ``result.h5`` from the output of LAMMPS.

    /spheres/{id, position, radius, mass, peak_force, ...}      a row for each sphere, by id
    /contacts/{i, j, peak_overlap, peak_force, ...}             a row for each pair, sorted by (i, j)
    /wall_contacts/{wall, id, peak_overlap, ...}                a row for each sphere that touched a wall or bar
    /energy/{time, kinetic, elastic, dissipated, input, ...}    energy ledger
    /walls/NAME/{time, force}   /probes/{time, ...}             walls and bars, and probes, at their own rates; for a
                                                                moving wall also displacement, velocity, ground_force
    /prestage/{residual, stored, ...}                           static stage of precompressed runs, one value each
    /chain/...   /bars/NAME/...                                 chains, see `granwave.analysis.result.chain`
    /h5md, /particles/spheres                                   trajectory, see `granwave.analysis.result.trajectory`

The root has the attributes ``name``, ``case`` (TOML), ``run`` and ``versions`` (JSON); every data set has a ``unit``.
Ids are those of the lattice; vacancies have no row, see `granwave.analysis.result.reader.Result.rows`.
"""

from __future__ import annotations

import dataclasses
import json
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

import granwave
from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.lammps_output.dumps import (
    WALL_COLUMNS,
    check_ids,
    frames_path,
    read_contacts,
    read_data,
    read_frames,
    read_wall_contacts,
)
from granwave.analysis.lammps_output.frame import Frame
from granwave.analysis.lammps_output.number_rows import CUT
from granwave.analysis.lammps_output.run_record import read_record
from granwave.analysis.lammps_output.time_series import Table, read_energy, read_probes, read_static_stage, read_walls
from granwave.analysis.result.chain import Groups, read_chain
from granwave.analysis.result.contacts import Contacts, list_contacts, merge_dents, sphere_values, touching_pairs
from granwave.analysis.result.hdf5_file import new_hdf5
from granwave.analysis.result.pair_laws import PairLaws, dissipated_share, pair_laws
from granwave.analysis.result.trajectory import COMPRESSION, write_metadata, write_trajectory
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.deck.columns import (
    CONTACTS,
    HOLDER,
    LEDGER,
    MOVING_WALL,
    ROTATION,
    SUPPORT,
    TANGENTIAL,
    TIMESTEP,
    WALL_CONTACTS,
    names,
)
from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.ownership import claim
from granwave.lammps_inputs.packing.assembly import assemble, gap_tolerance
from granwave.lammps_inputs.packing.walls import walls
from granwave.lammps_inputs.run_directory import CASE_FILE, RESULT_FILE
from granwave.lammps_inputs.run_state import check_case

BALANCE_REFUSED = "energy balance refused"  # end_reason of a run whose energies do not add up
_COMPRESSED_FROM = 4096  # values; smaller data sets are not compressed

# units of columns that LAMMPS writes, and of derived ones
_UNITS = {
    column.name: column.unit
    for table in (LEDGER, TIMESTEP, SUPPORT, ROTATION, TANGENTIAL, HOLDER, MOVING_WALL, WALL_CONTACTS, CONTACTS)
    for column in table
} | {
    "initial_overlap": "m",
    "position": "m",
    "radius": "m",
    "mass": "kg",
    "elastic_energy": "J",
    "dissipated_energy": "J",
    "dissipated_energy_wall": "J",
    "friction_energy": "J",
    "stored": "J",
    "bar": "J",
    "incident_bar": "J",
    "yield_overlap": "m",
    "effective_radius": "m",
}
_PROBE_UNITS = {"u": "m", "v": "m s-1", "f": "N"}
_OF_MOVING_WALLS = names(MOVING_WALL)  # columns of walls.txt, after the wall's name
_OF_WALL_CONTACTS = (
    "overlap", "force", "peak_overlap", "peak_force", "time_first", "time_peak", "time_yield",
    "dissipated_energy", "friction_energy", "tangential_force", "initial_overlap",
)  # fmt: skip


def write_result(directory: str | Path) -> Path:
    """Write the output of a run to ``result.h5``; an older file is replaced when the new one is complete.

    Parameters
    ----------
    directory
        Directory of the run, with case.toml, data.granwave and dumps/, and optionally run.json.

    Returns
    -------
    Path
        Path of result.h5.

    Raises
    ------
    MissingOutputError
        A required output file is missing.
    OutputFormatError
        A file is damaged.
    InputError
        A result.h5 exists that granwave did not write, or case.toml was changed after the run.
    """
    directory = Path(directory)
    path = directory / RESULT_FILE
    check_case(directory)
    claim(directory, [RESULT_FILE])
    with new_hdf5(path, libver="v110") as file:
        _write(file, directory)
    return path


def _write(file: h5py.File, directory: Path) -> None:
    text, case = _read_case(directory)
    ledger = read_energy(directory)
    dents = read_contacts(directory)  # the last file to be written: without it the run is not finished
    everything = read_data(directory)
    last = int(everything["id"][everything["diameter"] > 0].max())  # nodes of bars come after the spheres
    start = everything.up_to(last)
    record = read_record(directory)
    file.attrs["name"] = case.name
    file.attrs["case"] = text
    file.attrs["run"] = json.dumps(record)
    versions = {"granwave": granwave.__version__} | record.get("versions", {})
    file.attrs["versions"] = json.dumps(versions)
    write_metadata(file, versions["granwave"])

    timestep = _timestep(text, ledger)
    path = frames_path(directory)
    frames = (frame.up_to(last) for frame in read_frames(directory, partial=False))
    end = write_trajectory(file, start, frames, timestep, _periodic(case), path, friction=case.has_friction).step
    n_steps = int(ledger["step"][-1])
    if end < n_steps:  # the end of a run is always a snapshot
        raise OutputFormatError(f"{path} ends with the snapshot of step {end}, the run at step {n_steps}: {CUT}")
    if every := _resolved(text).get("history_every"):
        for name, columns in read_chain(directory, case, everything, timestep, n_steps - n_steps % every).items():
            write_group(file, name, columns)
    planes = read_wall_contacts(directory)
    for dump, frame in {"contacts": dents, **{f"wall_{name}": frame for name, frame in planes.items()}}.items():
        check_ids(directory / "dumps" / f"{dump}.dump", frame, everything)
    _write_contacts(file, case, start, dents, planes)
    write_group(file, "energy", ledger)
    if prestage := read_static_stage(directory):
        write_group(file, "prestage", prestage)
    for name, columns in _walls(read_walls(directory)).items():
        write_group(file, f"walls/{name}", columns)
    if probes := read_probes(directory):
        write_group(file, "probes", probes)


def _read_case(directory: Path) -> tuple[str, Case]:
    path = directory / CASE_FILE
    if not path.exists():
        raise MissingOutputError(f"{path} is missing: {directory} is not the directory of a run")
    return path.read_text(encoding="utf-8"), load_case(path)


def _resolved(text: str) -> dict[str, Any]:
    return tomllib.loads(text).get("resolved", {})


def _timestep(text: str, ledger: Table) -> float:
    given = _resolved(text).get("timestep")
    if given is None:
        return float(ledger["time"][-1] / max(ledger["step"][-1], 1))
    return float(given)


def _periodic(case: Case) -> tuple[bool, bool, bool]:
    sides = case.boundary.sides == "periodic"
    return sides, sides, False


def _walls(table: Table) -> Groups:
    """Return the force on each wall, and the motion of a moving one, by name of the wall."""
    names = [name for name in table if name not in ("step", "time") and not name.endswith(_OF_MOVING_WALLS)]
    return {
        name: {"time": table["time"], "force": table[name]}
        | {own: table[f"{name}_{own}"] for own in _OF_MOVING_WALLS if f"{name}_{own}" in table}
        for name in names
    }


def _write_contacts(file: h5py.File, case: Case, start: Frame, dents: Frame, planes: Mapping[str, Frame]) -> None:
    ids, radii = start["id"].astype(np.int64), start["diameter"] / 2
    between = dents.vector("i", "j").max(axis=1, initial=0) <= ids[-1]

    def laws_of(contacts: Contacts) -> PairLaws:
        rows = start.rows(np.stack([contacts["i"], contacts["j"]], axis=1))
        return pair_laws(case, start["type"].astype(np.int64)[rows], radii[rows])

    merged = merge_dents(_rows(dents, between))
    contacts = list_contacts(merged, _touching(case, start), laws_of(merged).yield_overlap)
    laws = laws_of(contacts)
    contacts["yielded"] = contacts.pop("grown_overlap") > laws.yielded_from
    contacts |= {"yield_overlap": laws.yield_overlap, "effective_radius": laws.effective_radius}
    write_group(file, "contacts", contacts)

    wall_contacts = _wall_contacts(planes, _bar_contacts(case, _rows(dents, ~between)))
    write_group(file, "wall_contacts", wall_contacts)
    spheres: dict[str, NDArray] = {
        "id": ids,
        "position": start.vector("x", "y", "z"),
        "radius": radii,
        "mass": start["density"] * np.pi / 6 * start["diameter"] ** 3,
        **sphere_values(ids, contacts, contacts["yielded"], laws.share),
    }
    at_walls = start.rows(wall_contacts["id"])
    for name, lost in _losses_at_walls(case, wall_contacts).items():
        spheres[name] = np.bincount(at_walls, lost, minlength=len(ids)) + spheres.get(name, 0.0)
    spheres["dissipated_energy"] = spheres["dissipated_energy"] + spheres["dissipated_energy_wall"]
    write_group(file, "spheres", spheres)


def _touching(case: Case, start: Frame) -> NDArray[np.int64]:
    """Return the pairs of ids that touch at the start: (n, 2)."""
    lengths = start.box[:, 1] - start.box[:, 0]
    periods = tuple(length * goes_on for length, goes_on in zip(lengths, _periodic(case), strict=True))
    positions, radii = start.vector("x", "y", "z"), start["diameter"] / 2
    return touching_pairs(start["id"].astype(np.int64), positions, radii, gap_tolerance(case), periods)


def _rows(dents: Frame, chosen: NDArray[np.bool_]) -> Frame:
    return dents if chosen.all() else dataclasses.replace(dents, values=dents.values[chosen])


def _losses_at_walls(case: Case, wall_contacts: Contacts) -> dict[str, NDArray[np.float64]]:
    """Return the dissipation in the sphere of each wall contact; a rigid wall dissipates nothing."""
    materials: dict[str, Material | None] = {bar.name: bar.material for bar in assemble(case).bars}
    materials |= {wall.name: wall.material for wall in walls(case)}
    partners = [materials[wall] for wall in wall_contacts["wall"].tolist()]
    own = [assemble(case).material_of(sphere) for sphere in wall_contacts["id"].tolist()]
    plastic_share = np.array([dissipated_share(*pair) for pair in zip(own, partners, strict=True)])
    friction_share = np.array([0.5 if partner else 1.0 for partner in partners])
    friction = friction_share * wall_contacts["friction_energy"]
    plastic = plastic_share * (wall_contacts["dissipated_energy"] - wall_contacts["friction_energy"])
    return {"dissipated_energy_wall": plastic + friction, "friction_energy": friction}


def _bar_contacts(case: Case, dents: Frame) -> dict[str, Contacts]:
    """Return the contacts of beads with the faces of bars, by name of the bar."""
    merged = merge_dents(dents)
    return {
        bar.name: {name: column[merged["j"] == bar.face] for name, column in merged.items()}
        for bar in assemble(case).bars
    }


def _wall_contacts(planes: Mapping[str, Frame], bars: Mapping[str, Contacts]) -> Contacts:
    """Return the contacts with walls and bars as one table; times in s (NaN: never)."""
    parts: list[Contacts] = []
    for wall, frame in planes.items():
        values: Contacts = {name: frame[name] for name in WALL_COLUMNS if name != "dissipated"}
        for name in values:
            if name.startswith("time"):
                values[name] = np.where(values[name] < 0, np.nan, values[name])
        values |= {
            "dissipated_energy": frame["dissipated"] + frame.get("friction"),
            "friction_energy": frame.get("friction"),
            "tangential_force": frame.get("tangential_force"),
            "initial_overlap": frame.get("initial"),
        }
        parts.append({"wall": np.full(len(frame), wall, dtype=object), "id": frame["id"].astype(np.int64)} | values)
    for bar, found in bars.items():
        part: Contacts = {"wall": np.full(len(found["i"]), bar, dtype=object), "id": found["i"]}
        parts.append(part | {name: found[name] for name in _OF_WALL_CONTACTS})
    empty: Contacts = {"wall": np.empty(0, dtype=object), "id": np.empty(0, dtype=np.int64)}
    empty |= {name: np.empty(0) for name in _OF_WALL_CONTACTS}
    return {name: np.concatenate([part[name] for part in (empty, *parts)]) for name in empty}


def write_group(file: h5py.File, name: str, columns: Mapping[str, NDArray]) -> None:
    """Write columns as data sets of one group, each with its unit."""
    group = file.create_group(name)
    for column, values in columns.items():
        options: dict[str, Any] = dict(COMPRESSION) if values.size >= _COMPRESSED_FROM else {}
        if values.dtype == object:
            options["dtype"] = h5py.string_dtype()
        group.create_dataset(column, data=values, **options).attrs["unit"] = _unit(name, column)


def _unit(group: str, column: str) -> str:
    if group == "chain" or group.startswith("bars/"):
        return _UNITS.get(column.removeprefix("contact_"), "1")
    if group == "probes" and column not in ("step", "time"):
        quantity = column.rsplit("_", 1)[1]
        return _UNITS.get(quantity) or _PROBE_UNITS[quantity[0]]
    return _UNITS.get(column, "1")
