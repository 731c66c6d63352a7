"""From the files that LAMMPS left to ``result.h5``.

    /spheres/{id, position, radius, mass, peak_force, ...}      a row a sphere, by id
    /contacts/{i, j, peak_overlap, peak_force, ...}             a row a pair, sorted by (i, j)
    /wall_contacts/{wall, id, peak_overlap, ...}                a row for each sphere that pressed on a wall
    /energy/{time, kinetic, elastic, dissipated, input, ...}    the ledger
    /walls/NAME/{time, force}   /probes/{time, ...}             at their own rate; bars are among the walls
    /chain/...   /bars/NAME/...                                 of chains, see `granwave.analysis.chain_history`
    /h5md, /particles/spheres                                   the trajectory, see `granwave.analysis.h5md`

The root carries ``name``, ``case`` (TOML), ``run`` and ``versions`` (JSON) as attributes; every data set a
``unit``.
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
from granwave.analysis.chain_history import read_chain
from granwave.analysis.contacts import Contacts, list_contacts, merge_dents, sphere_values
from granwave.analysis.dumps import Frame, read_contacts, read_data, read_frames, read_wall_contacts
from granwave.analysis.errors import MissingOutputError
from granwave.analysis.h5md import COMPRESSION, write_metadata, write_trajectory
from granwave.analysis.pairs import dissipated_share, pair_laws
from granwave.analysis.plasticity import yields_from
from granwave.analysis.tables import Table, read_energy, read_probes, read_walls
from granwave.lammps_inputs.case import Case, load_case
from granwave.lammps_inputs.files import replacing
from granwave.lammps_inputs.materials import Material
from granwave.lammps_inputs.packings import build_packing
from granwave.lammps_inputs.script_output import WALL_COLUMNS
from granwave.lammps_inputs.walls import walls

RESULT_FILE, RECORD_FILE = "result.h5", "run.json"
BALANCE_REFUSED = "energy balance refused"  # end_reason of a run whose energies do not add up
_COMPRESSED_FROM = 4096  # values; smaller data sets are kept plain

_UNITS = {
    "time": "s",
    "time_first": "s",
    "time_peak": "s",
    "time_yield": "s",
    "force": "N",
    "peak_force": "N",
    "largest_force": "N",
    "overlap": "m",
    "peak_overlap": "m",
    "position": "m",
    "radius": "m",
    "mass": "kg",
    "elastic_energy": "J",
    "dissipated_energy": "J",
    "dissipated_energy_wall": "J",
    "kinetic": "J",
    "elastic": "J",
    "dissipated": "J",
    "elastic_wall": "J",
    "dissipated_wall": "J",
    "input": "J",
    "struck_velocity": "m s-1",
    "bar": "J",
    "incident_bar": "J",
    "yield_overlap": "m",
    "effective_radius": "m",
    "displacement": "m",
    "velocity": "m s-1",
}
_PROBE_UNITS = {"u": "m", "v": "m s-1", "f": "N"}


def write_result(directory: str | Path) -> Path:
    """Gather what a run left into ``result.h5``; an older one is replaced once the new one is complete.

    Parameters
    ----------
    directory
        Of the run: case.toml, data.granwave and dumps/, and run.json if there is one.

    Returns
    -------
    Path
        Of result.h5.

    Raises
    ------
    MissingOutputError
        The run did not leave a file that is needed.
    OutputFormatError
        A file is damaged.
    """
    directory = Path(directory)
    path = directory / RESULT_FILE
    for left in directory.glob(f".{RESULT_FILE}.*"):
        left.unlink(missing_ok=True)  # of an analysis that was killed
    with replacing(path) as scratch, h5py.File(scratch, "w", libver="v110") as file:
        _write(file, directory)
    return path


def read_record(directory: str | Path) -> dict[str, Any]:
    """What the driver noted of the run (``run.json``); empty when there is nothing."""
    path = Path(directory) / RECORD_FILE
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def _write(file: h5py.File, directory: Path) -> None:
    text, case = _read_case(directory)
    ledger = read_energy(directory)
    dents = read_contacts(directory)  # the last file to be written: without it the run is not finished
    everything = read_data(directory)
    n_spheres = case.assembly.n_spheres
    start = everything.up_to(n_spheres)
    record = read_record(directory)
    file.attrs["name"] = case.name
    file.attrs["case"] = text
    file.attrs["run"] = json.dumps(record)
    versions = {"granwave": granwave.__version__} | record.get("versions", {})
    file.attrs["versions"] = json.dumps(versions)
    write_metadata(file, versions["granwave"])

    timestep = _timestep(text, ledger)
    frames = (frame.up_to(n_spheres) for frame in read_frames(directory))
    write_trajectory(file, start, frames, timestep, _periodic(case))
    if _resolved(text).get("history_every"):
        for name, columns in read_chain(directory, case, everything, timestep).items():
            write_group(file, name, columns)
    _write_contacts(file, case, start, dents, read_wall_contacts(directory))
    write_group(file, "energy", ledger)
    forces = read_walls(directory)
    for name in forces.keys() - {"step", "time"}:
        write_group(file, f"walls/{name}", {"time": forces["time"], "force": forces[name]})
    if probes := read_probes(directory):
        write_group(file, "probes", probes)


def _read_case(directory: Path) -> tuple[str, Case]:
    path = directory / "case.toml"
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


def _write_contacts(file: h5py.File, case: Case, start: Frame, dents: Frame, planes: Mapping[str, Frame]) -> None:
    n_spheres = len(start)
    between = dents.vector("i", "j").max(axis=1, initial=0) <= n_spheres
    merged = merge_dents(_rows(dents, between))
    alone = pair_laws(case, merged["i"], merged["j"]).yield_overlap
    contacts = list_contacts(merged, build_packing(case).contacts, alone)
    laws = pair_laws(case, contacts["i"], contacts["j"])
    contacts["yielded"] = contacts["peak_overlap"] > yields_from(case.contact.law, laws.yield_overlap)
    contacts |= {"yield_overlap": laws.yield_overlap, "effective_radius": laws.effective_radius}
    write_group(file, "contacts", contacts)

    wall_contacts = _wall_contacts(planes, _bar_contacts(case, _rows(dents, ~between)))
    write_group(file, "wall_contacts", wall_contacts)
    spheres: dict[str, NDArray] = {
        "id": start["id"].astype(np.int64),
        "position": start.vector("x", "y", "z"),
        "radius": start["diameter"] / 2,
        "mass": start["density"] * np.pi / 6 * start["diameter"] ** 3,
        **sphere_values(n_spheres, contacts, contacts["yielded"], laws.share),
    }
    lost = wall_contacts["dissipated_energy"] * _shares(case, wall_contacts)
    spheres["dissipated_energy_wall"] = np.bincount(wall_contacts["id"] - 1, lost, minlength=n_spheres)
    spheres["dissipated_energy"] = spheres["dissipated_energy"] + spheres["dissipated_energy_wall"]
    write_group(file, "spheres", spheres)


def _rows(dents: Frame, chosen: NDArray[np.bool_]) -> Frame:
    return dents if chosen.all() else dataclasses.replace(dents, values=dents.values[chosen])


def _shares(case: Case, wall_contacts: Contacts) -> NDArray[np.float64]:
    """Part of the loss in each wall contact that the sphere takes; a rigid wall takes nothing."""
    materials: dict[str, Material | None] = {bar.name: bar.material for bar in case.assembly.bars}
    materials |= {wall.name: wall.material for wall in walls(case)}
    pairs = zip(wall_contacts["id"].tolist(), wall_contacts["wall"].tolist(), strict=True)
    return np.array([dissipated_share(case.assembly.material_of(sphere), materials[wall]) for sphere, wall in pairs])


def _bar_contacts(case: Case, dents: Frame) -> dict[str, Contacts]:
    """Contacts of beads with the faces of bars, by the name of the bar."""
    merged = merge_dents(dents)
    return {
        bar.name: {name: column[merged["j"] == bar.face] for name, column in merged.items()}
        for bar in case.assembly.bars
    }


def _wall_contacts(planes: Mapping[str, Frame], bars: Mapping[str, Contacts]) -> Contacts:
    """The contacts with walls and bars as one table; times in s (NaN: never)."""
    names = {"dissipated": "dissipated_energy"}
    columns = {names.get(name, name): name for name in WALL_COLUMNS}
    parts: list[Contacts] = []
    for wall, frame in planes.items():
        values: Contacts = {name: frame[source] for name, source in columns.items()}
        for name in values:
            if name.startswith("time"):
                values[name] = np.where(values[name] < 0, np.nan, values[name])
        parts.append({"wall": np.full(len(frame), wall, dtype=object), "id": frame["id"].astype(np.int64)} | values)
    for bar, found in bars.items():
        part: Contacts = {"wall": np.full(len(found["i"]), bar, dtype=object), "id": found["i"]}
        parts.append(part | {name: found[name] for name in columns})
    empty: Contacts = {"wall": np.empty(0, dtype=object), "id": np.empty(0, dtype=np.int64)}
    empty |= {name: np.empty(0) for name in columns}
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
