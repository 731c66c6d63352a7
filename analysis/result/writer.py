"""Writer of ``result.h5`` from the output of LAMMPS.

    /spheres/{id, position, radius, mass, peak_force, ...}      a row for each sphere, by id
    /contacts/{i, j, peak_overlap, peak_force, ...}             a row for each pair, sorted by (i, j)
    /wall_contacts/{wall, id, peak_overlap, ...}                a row for each sphere that touched a wall or bar;
                                                                both with initial_force, N, where a
                                                                static stage was
    /energy/{time, kinetic, elastic, dissipated, input, ...}    energy record
    /walls/NAME/{time, force, impulse}   /probes/{time, ...}    walls and bars, and probes, at their own rates; for a
                                                                moving wall also displacement,
                                                                velocity, ground_force
    /prestage/{residual, stored, ...}                           static stage of precompressed runs, one value each
    /chain/...   /bars/NAME/...                                 chains, see `granwave.analysis.result.histories`
    /lines/NAME/...                                             lines of grains, `granwave.analysis.result.histories`
    /h5md, /particles/spheres                                   trajectory, see `granwave.analysis.result.trajectory`

The root has the attributes ``name``, ``case`` (TOML), ``run`` and ``versions`` (JSON); every data
set has a ``unit``. Ids count the sites of the lattice; vacancies have no row, see
`granwave.analysis.result.reader.Result.rows`.
"""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import h5py
import numpy as np

import granwave
from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.lammps_output.dumps import (
    contacts_at_end,
    frames_path,
    read_frames,
    read_wall_contacts,
)
from granwave.analysis.lammps_output.frame import CUT
from granwave.analysis.lammps_output.time_series import Table, read_energy, read_record, read_table
from granwave.analysis.result.hdf5_file import new_hdf5, write_group
from granwave.analysis.result.histories import Groups, line_groups, read_chain
from granwave.analysis.result.sphere_tables import after_static_stage, write_tables
from granwave.analysis.result.start import DentRecord, Start
from granwave.analysis.result.trajectory import write_metadata, write_trajectory
from granwave.analysis.versions import RESULTS_FORMAT
from granwave.lammps_inputs import run_directory as files
from granwave.lammps_inputs.deck.columns import MOVING_WALL, names
from granwave.lammps_inputs.files import regular, scratch_files
from granwave.lammps_inputs.load_case import read_stored_case
from granwave.lammps_inputs.own_files import AnyPath
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.planning.cost import spheres_of_part
from granwave.lammps_inputs.processes import ALONE, Processes
from granwave.lammps_inputs.result_directory import ResultDirectory

BALANCE_REFUSED = "energy balance refused"  # end_reason of a run whose energies do not add up
_OF_MOVING_WALLS = names(MOVING_WALL)  # columns of walls.txt, after the wall's name


def write_result(
    directory: AnyPath,
    *,
    at_once: int | None = None,
    assembly: Assembly | None = None,
    processes: Processes = ALONE,
) -> Path:
    """Write the output of a run to ``result.h5``; an older file is replaced when the new file is
    complete.

    Packings of more spheres than ``at_once`` are read in parts, which exchange data through scratch
    files: memory does not grow with the number of spheres, only with the number in a cross-section.

    Parameters
    ----------
    directory
        Directory of the run, with case.toml, data.granwave and dumps/, and optionally run.json.
    at_once
        Largest number of spheres in a part; None: as `spheres_of_part` says. The values do not
        depend on it.
    assembly
        All bodies of the case that was run, if it was read before.
    processes
        Processes that share the work. The values do not depend on them.

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
    results = ResultDirectory.at(directory)
    directory = results.path
    path = results / files.RESULT_FILE
    results.check_case()
    results.claim([files.RESULT_FILE])
    with scratch_files(path) as scratch, new_hdf5(path, libver="v110") as file:
        case_file = directory / files.CASE_FILE
        if not case_file.exists():
            raise MissingOutputError(
                f"{case_file} is missing: {directory} is not the directory of a run"
            )
        text = regular(case_file).read_text(encoding="utf-8")
        if assembly is None:
            assembly = assemble(read_stored_case(case_file))
        if at_once is None:
            at_once = spheres_of_part(assembly.n_particles)
        case = assembly.case
        resolved = tomllib.loads(text).get("resolved", {})
        ledger = read_energy(directory)
        contacts = contacts_at_end(
            results
        )  # the last file to be written: without it the run is not finished
        start = Start(directory, at_once, scratch(), processes)
        record = read_record(directory)
        file.attrs["name"] = case.name
        file.attrs["case"] = text
        file.attrs["run"] = json.dumps(record)
        versions = (
            {"granwave": granwave.__version__}
            | record.get("versions", {})
            | {RESULTS_FORMAT: str(files.FORMAT)}
        )
        file.attrs["versions"] = json.dumps(versions)
        write_metadata(file, versions["granwave"])

        n_steps = int(ledger["step"][-1])
        snapshots = frames_path(results)
        timestep = resolved.get("timestep")
        timestep = float(ledger["time"][-1] / max(n_steps, 1) if timestep is None else timestep)
        frames = read_frames(
            results, at_once, partial=False, unread=start.n_particles == start.n_spheres
        )
        # a file in parts has the rows of each rank as it holds them
        unsorted = files.RANK in snapshots.name and start.n_parts > 1
        end = write_trajectory(
            file,
            assembly,
            start,
            frames,
            timestep,
            snapshots,
            processes,
            scratch if unsorted else None,
        )
        if end < n_steps:  # the end of a run is always a snapshot
            last = f"{files.shown_dump(snapshots)} ends with the snapshot of step {end}"
            raise OutputFormatError(f"{last}, the run at step {n_steps}: {CUT}")
        if every := resolved.get("history_every"):
            _write_groups(
                file,
                read_chain(directory, assembly, start.read(), timestep, n_steps - n_steps % every),
            )
        if every := resolved.get("line_every"):
            _write_groups(
                file, line_groups(directory, assembly, timestep, n_steps - n_steps % every)
            )
        planes = read_wall_contacts(results)
        for name, frame in planes.items():
            start.check_ids(directory / files.DUMPS / files.WALL_CONTACTS_FILE.format(name), frame)
        dents = DentRecord(start, contacts, scratch, processes)
        initial = (
            after_static_stage(results, start, scratch, processes) if case.precompression else None
        )
        write_tables(file, assembly, start, dents, planes, initial, processes)
        tables = {"energy": ledger, "prestage": read_table(directory, files.STATIC_STAGE_FILE)}
        tables |= {"probes": read_table(directory, files.PROBES_FILE)}
        _write_groups(file, tables | _walls(read_table(directory, files.WALLS_FILE)))
    return path


def _write_groups(file: h5py.File, groups: Groups) -> None:
    for name, columns in groups.items():
        if columns:
            write_group(file, name, columns)


def _walls(table: Table) -> Groups:
    """Return the group of each wall: the force on it, and the motion of a moving one."""
    names = [
        name
        for name in table
        if name not in ("step", "time") and not name.endswith(_OF_MOVING_WALLS)
    ]
    found: Groups = {}
    for name in names:
        time = table["time"]
        force = table[name]
        impulse = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(time))])
        moving = {
            own: table[f"{name}_{own}"] for own in _OF_MOVING_WALLS if f"{name}_{own}" in table
        }
        found[f"walls/{name}"] = {"time": time, "force": force, "impulse": impulse} | moving
    return found
