"""From the files that LAMMPS left to ``result.h5``.

    /spheres/{id, position, radius, mass, peak_force, ...}      a row a sphere, by id
    /contacts/{i, j, peak_overlap, peak_force, ...}             a row a pair, sorted by (i, j)
    /wall_contacts/{wall, id, peak_overlap, ...}                a row for each sphere that pressed on a wall
    /energy/{time, kinetic, elastic, dissipated, input, ...}    the ledger
    /walls/NAME/{time, force}   /probes/{time, ...}             at their own rate
    /h5md, /particles/spheres                                   the trajectory, see `granwave.analysis.h5md`

The root carries ``name``, ``case`` (TOML), ``run`` and ``versions`` (JSON) as attributes; every data set a
``unit``.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

import granwave
from granwave.analysis.contacts import Contacts, list_contacts, merge_dents, sphere_values
from granwave.analysis.dumps import Frame, read_contacts, read_data, read_frames, read_wall_contacts
from granwave.analysis.errors import MissingOutputError
from granwave.analysis.h5md import COMPRESSION, write_metadata, write_trajectory
from granwave.analysis.plasticity import yields_from
from granwave.analysis.tables import Table, read_energy, read_probes, read_walls
from granwave.lammps_inputs.case import Case, load_case
from granwave.lammps_inputs.files import replacing
from granwave.lammps_inputs.laws import sphere_contact
from granwave.lammps_inputs.packings import build_packing
from granwave.lammps_inputs.script_output import WALL_COLUMNS

RESULT_FILE, RECORD_FILE = "result.h5", "run.json"
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
    start = read_data(directory)
    record = read_record(directory)
    file.attrs["name"] = case.name
    file.attrs["case"] = text
    file.attrs["run"] = json.dumps(record)
    versions = {"granwave": granwave.__version__} | record.get("versions", {})
    file.attrs["versions"] = json.dumps(versions)
    write_metadata(file, versions["granwave"])

    write_trajectory(file, start, read_frames(directory), _timestep(text, ledger), _periodic(case))
    _write_contacts(file, case, start, dents, read_wall_contacts(directory))
    write_group(file, "energy", ledger)
    walls = read_walls(directory)
    for name in walls.keys() - {"step", "time"}:
        write_group(file, f"walls/{name}", {"time": walls["time"], "force": walls[name]})
    if probes := read_probes(directory):
        write_group(file, "probes", probes)


def _read_case(directory: Path) -> tuple[str, Case]:
    path = directory / "case.toml"
    if not path.exists():
        raise MissingOutputError(f"{path} is missing: {directory} is not the directory of a run")
    return path.read_text(encoding="utf-8"), load_case(path)


def _timestep(text: str, ledger: Table) -> float:
    given = tomllib.loads(text).get("resolved", {}).get("timestep")
    if given is None:
        return float(ledger["time"][-1] / max(ledger["step"][-1], 1))
    return float(given)


def _periodic(case: Case) -> tuple[bool, bool, bool]:
    sides = case.boundary.sides == "periodic"
    return sides, sides, False


def _write_contacts(file: h5py.File, case: Case, start: Frame, dents: Frame, walls: Mapping[str, Frame]) -> None:
    law = sphere_contact(case)
    contacts = list_contacts(merge_dents(dents), build_packing(case).contacts, law.yield_overlap)
    contacts["yielded"] = contacts["peak_overlap"] > yields_from(case.contact.law, law.yield_overlap)
    write_group(file, "contacts", contacts)

    wall_contacts = _wall_contacts(walls)
    write_group(file, "wall_contacts", wall_contacts)
    spheres: dict[str, NDArray] = {
        "id": start["id"].astype(np.int64),
        "position": start.vector("x", "y", "z"),
        "radius": start["diameter"] / 2,
        "mass": start["density"] * np.pi / 6 * start["diameter"] ** 3,
        **sphere_values(len(start), contacts, contacts["yielded"]),
    }
    # a rigid wall does not yield: all that is lost there belongs to the sphere
    spheres["dissipated_energy_wall"] = np.bincount(
        wall_contacts["id"] - 1, wall_contacts["dissipated_energy"], minlength=len(start)
    )
    spheres["dissipated_energy"] = spheres["dissipated_energy"] + spheres["dissipated_energy_wall"]
    write_group(file, "spheres", spheres)


def _wall_contacts(walls: Mapping[str, Frame]) -> Contacts:
    """The wall contacts as one table; times in s (NaN: never)."""
    names = {"dissipated": "dissipated_energy"}
    parts = [frame.vector(*WALL_COLUMNS) for frame in walls.values()]
    values = np.concatenate([np.empty((0, len(WALL_COLUMNS))), *parts])
    table: Contacts = {
        "wall": np.array([name for name, frame in walls.items() for _ in range(len(frame))], dtype=object),
        "id": np.concatenate(
            [np.empty(0, dtype=np.int64), *(frame["id"].astype(np.int64) for frame in walls.values())]
        ),
    }
    for n, name in enumerate(WALL_COLUMNS):
        column = values[:, n]
        table[names.get(name, name)] = np.where(column < 0, np.nan, column) if name.startswith("time") else column
    return table


def write_group(file: h5py.File, name: str, columns: Mapping[str, NDArray]) -> None:
    """Write columns as data sets of one group, each with its unit."""
    group = file.create_group(name)
    for column, values in columns.items():
        options: dict[str, Any] = dict(COMPRESSION) if values.size >= _COMPRESSED_FROM else {}
        if values.dtype == object:
            options["dtype"] = h5py.string_dtype()
        group.create_dataset(column, data=values, **options).attrs["unit"] = _unit(name, column)


def _unit(group: str, column: str) -> str:
    if group == "probes" and column not in ("step", "time"):
        quantity = column.rsplit("_", 1)[1]
        return _UNITS.get(quantity) or _PROBE_UNITS[quantity[0]]
    return _UNITS.get(column, "1")
