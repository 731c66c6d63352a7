"""LAMMPS input of a case: a directory in which ``lmp -in in.granwave`` runs, with the data file of
spheres and nodes.
"""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs import run_directory
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import density_as_sphere
from granwave.lammps_inputs.case.stl_walls import stl_text
from granwave.lammps_inputs.contact.bed_state import bed_table, bed_velocities
from granwave.lammps_inputs.contact.initial_dents import dents_table
from granwave.lammps_inputs.contact.static_load import directions
from granwave.lammps_inputs.deck.dead_load import load_tables
from granwave.lammps_inputs.deck.output import output_files
from granwave.lammps_inputs.deck.script import input_script
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import (
    DISK_IS_FULL,
    naming,
    read_toml,
    replacing,
)
from granwave.lammps_inputs.load_case import stored_case
from granwave.lammps_inputs.own_files import AnyPath
from granwave.lammps_inputs.packing.assembly import Assembly, Species
from granwave.lammps_inputs.packing.clumps import together
from granwave.lammps_inputs.packing.motion import own_spins, own_velocities, struck_of
from granwave.lammps_inputs.packing.places import Places
from granwave.lammps_inputs.packing.walls import walls
from granwave.lammps_inputs.planning.schedule import Schedule, make_schedule
from granwave.lammps_inputs.processes import ALONE, Processes
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.script_words import joined, num
from granwave.lammps_inputs.statics.balance import balanced_displacements

_STILL = (0.0, 0.0, 0.0)
_BATCH = 100_000  # spheres formatted at once
_PERIODIC_LOW = (
    -0.1
)  # lower faces of a periodic box, diameters; no plane of centres coincides with a face
_PLAIN_TITLE = "Atoms # sphere: id type diameter density x y z"
_BAR_TITLE = "Atoms # hybrid: id type x y z diameter density molecule"


def write_data(assembly: Assembly, path: Path, processes: Processes = ALONE) -> None:
    """Write the LAMMPS data file of ``atom_style sphere``, with 17 significant digits.

    With bars it is ``atom_style hybrid sphere bond``; a node has diameter 0 and its mass in the
    density column. Rows of equal spheres are written by all processes; dissimilar spheres would
    have to be stored by each process.
    """
    bars = assembly.bars
    n = assembly.lattice.n_spheres
    box = "".join(
        f"{a:.17g} {b:.17g} {x}lo {x}hi\n"
        for (a, b), x in zip(box_of(assembly), "xyz", strict=True)
    )
    n_bonds = sum(bar.section.elements for bar in bars)
    bonds = f"{n_bonds} bonds\n{len(bars)} bond types\n2 extra bond per atom\n" if bars else ""
    writers = processes if assembly.plain else ALONE
    batch = partial(_batch, assembly)
    with path.open("w", encoding="ascii", newline="\n") as file:
        file.write(
            f"{_title(assembly)}\n\n"
            f"{assembly.n_particles} atoms\n{len(assembly.species)} atom types\n{bonds}\n{box}\n"
            f"{_BAR_TITLE if bars else _PLAIN_TITLE}\n\n"
        )
        file.writelines(writers.map(batch, range(1, n + 1, _BATCH)))
        if assembly.strikers:
            centres = np.array([centre for _, centre in assembly.strikers])
            centres -= assembly.deck_origin
            file.write(_rows(assembly, np.arange(n + 1, assembly.last_sphere + 1), centres))
        if assembly.clumps:
            file.write("\nMolecules # id, number of its clump\n\n")
            file.writelines(f"{number} {clump}\n" for number, clump in _clump_of_each(assembly))
        for bar in bars:
            roles = (Species(bar.material, role, bar.name) for role in ("node", "face"))
            node, face = (1 + assembly.species.index(one) for one in roles)
            for number, z, mass in zip(
                range(bar.first, bar.last + 1),
                bar.position - assembly.deck_origin[2],
                bar.mass,
                strict=True,
            ):
                file.write(
                    f"{number} {face if number == bar.face else node} 0 0 {z:.17g} 0 {mass:.17g} 0\n"
                )
        file.writelines(_velocity_lines(assembly))
        if bars:
            file.write("\nBonds\n\n")
            joints = list[tuple[int, int]]()
            for kind, bar in enumerate(bars, start=1):
                joints += [(kind, a) for a in range(bar.first, bar.last)]
            file.writelines(
                f"{number} {kind} {a} {a + 1}\n" for number, (kind, a) in enumerate(joints, start=1)
            )


def _velocity_lines(assembly: Assembly) -> Iterator[str]:
    """Return the velocities of the data file, if grains have initial velocities, or continue from a
    bed.
    """
    title = "\nVelocities # id, velocity, angular velocity\n\n"
    bed = bed_velocities(assembly)
    moving = own_velocities(assembly)
    turning = own_spins(assembly)
    if bed is not None:
        yield title
        rows = np.hstack(bed).tolist()
        none = [0.0] * 6
        for number in assembly.ids.tolist():
            row = rows[number - 1] if number <= len(rows) else none
            yield f"{number} {joined(map(num, row))}\n"
    elif moving or turning:
        yield title
        for number in assembly.ids.tolist():
            velocity = joined(map(num, moving.get(number, _STILL)))
            spin = joined(map(num, turning[number])) if number in turning else "0 0 0"
            yield f"{number} {velocity} {spin}\n"


def _title(assembly: Assembly) -> str:
    """Return the first line of the data file, which gives its origin."""
    origin = assembly.deck_origin
    if isinstance(assembly.lattice, Places):
        place = f"origin at {joined(map(num, origin))} m of the file" if origin.any() else ""
    else:
        place = "impacted layer at z = 0"
    return ", ".join(filter(None, [f"granwave: {assembly.lattice.kind} packing, SI units", place]))


def _batch(assembly: Assembly, first: int) -> str:
    last = min(first + _BATCH - 1, assembly.lattice.n_spheres)
    here = np.flatnonzero(assembly.sites.present[first - 1 : last])
    centres = assembly.sites.positions(first, last)
    if assembly.clumps:
        whole = assembly.sites.positions(1, assembly.lattice.n_spheres)
        centres = together(assembly, whole)[first - 1 : last]
    return _rows(assembly, here + first, centres[here] - assembly.deck_origin)


def _clump_of_each(assembly: Assembly) -> Iterator[tuple[int, int]]:
    """Iterate over the ids of all spheres, each with the number of its clump, 0 without one."""
    numbers = np.zeros(assembly.last_sphere, dtype=np.int64)
    for number, ids in assembly.clumps.items():
        numbers[np.array(ids) - 1] = number
    yield from zip(assembly.ids.tolist(), numbers[assembly.ids - 1].tolist(), strict=True)


def _rows(assembly: Assembly, ids: NDArray[np.int64], centres: NDArray[np.float64]) -> str:
    """Return the rows of grains with these ids and centres (n, 3) in the deck, m.

    LAMMPS reads the density of a sphere. The density of a cylinder is chosen so that a sphere of
    its diameter has its mass.
    """
    bodies = list(
        zip(assembly.body[ids - 1].tolist(), assembly.diameter[ids - 1].tolist(), strict=True)
    )
    forms = {}
    for body, diameter in dict.fromkeys(bodies):
        material = assembly.species[body].material
        shape = assembly.species[body].shape
        constants = f"{diameter:.17g} {density_as_sphere(material.density, diameter, shape):.17g}"
        words = (
            ("%.17g %.17g %.17g", constants, "0")
            if assembly.bars
            else (constants, "%.17g %.17g %.17g")
        )
        forms[body, diameter] = f"%d {body + 1} {joined(words)}\n"
    lines = zip(ids.tolist(), *centres.T.tolist(), strict=True)
    return "".join([forms[body] % line for body, line in zip(bodies, lines, strict=True)])


def box_of(assembly: Assembly) -> NDArray[np.float64]:
    """Return the lowest and highest x, y, z of the box in the deck: (3, 2), m."""
    lattice = assembly.lattice
    low, high = assembly.bounds() + np.array([[-0.5], [0.5]]) * lattice.diameter
    if lattice.periodic:
        lowest = lattice.bounds()[0, :2] if isinstance(lattice, Places) else 0.0
        low[:2] = lowest + _PERIODIC_LOW * lattice.diameter
        high[:2] = low[:2] + np.array(lattice.lengths)
    return np.stack([low, high], axis=1) - assembly.deck_origin[:, None]


@dataclasses.dataclass(frozen=True)
class Deck:
    """Deck that was written to a directory.

    Attributes
    ----------
    directory
        Directory of the deck.
    case
        Case that it was written for.
    schedule
        Timestep, and intervals of output.
    struck
        Ids of the spheres that the load acts on, the impacted sphere first.
    written
        Names of the written files; empty for an existing directory.
    """

    directory: Path
    case: Case
    schedule: Schedule
    struck: tuple[int, ...]
    written: tuple[str, ...] = ()

    @property
    def script(self) -> Path:
        """Path of the LAMMPS input script."""
        return self.directory / run_directory.SCRIPT_FILE

    @property
    def data(self) -> Path:
        """Path of the LAMMPS data file."""
        return self.directory / run_directory.DATA_FILE

    @property
    def dumps(self) -> Path:
        """Directory of the output of LAMMPS."""
        return self.directory / run_directory.DUMPS


def write_deck(
    assembly: Assembly,
    directory: AnyPath,
    *,
    timestep: float | None = None,
    processes: Processes = ALONE,
) -> Deck:
    """Write the deck of a packing: case.toml, data.granwave, in.granwave, the tables that it reads,
    and an empty dumps/.

    All files are replaced atomically, the script last. Files that granwave wrote there before are
    replaced; other files in the directory are not touched.

    Parameters
    ----------
    timestep
        Timestep instead of ``run.timestep``, s.
    processes
        Processes that share the work. The files do not depend on them.

    Raises
    ------
    InputError
        The directory cannot be written to, holds files of such names that granwave did not write,
        or the initial dents cannot be read; see `dents_table`.
    """
    case = assembly.case
    results = ResultDirectory.at(directory)
    tables = _tables(assembly)
    written = (run_directory.SCRIPT_FILE, run_directory.CASE_FILE, run_directory.DATA_FILE, *tables)
    deck = Deck(results.path, case, make_schedule(assembly, timestep), struck_of(assembly), written)
    text = case.to_toml(resolved=resolved(assembly, deck))
    try:
        results.path.mkdir(parents=True, exist_ok=True)
        before = results.marker.copy() if results.result_names() else None
        results.claim(deck_files(assembly, deck.schedule), kind=run_directory.RUN, case=text)
        deck.dumps.mkdir(exist_ok=True)
    except OSError as error:
        if error.errno in DISK_IS_FULL:
            raise
        raise InputError(
            f"{results}: cannot be written to: {error.strerror}; choose another with directory=..."
        ) from None
    texts = {
        deck.script: input_script(assembly, deck.schedule),
        deck.directory / run_directory.CASE_FILE: text,
    }
    texts |= {results / name: table for name, table in tables.items()}
    try:
        with contextlib.ExitStack() as stack:  # moved in reverse order: the script comes last
            paths = dict.fromkeys((deck.script, deck.data, *texts))
            scratch = {path: stack.enter_context(replacing(path)) for path in paths}
            for path, unfinished in scratch.items():
                with naming(path):
                    if path == deck.data:
                        write_data(assembly, unfinished, processes)
                    else:
                        unfinished.write_text(texts[path], encoding="utf-8")
        results.note_deck([run_directory.SCRIPT_FILE, run_directory.DATA_FILE, *tables])
    except BaseException:
        if before is None:
            results.clear()
        else:
            results.write(before)
        raise
    return deck


def deck_files(assembly: Assembly, schedule: Schedule) -> list[str]:
    """Return the names of the files of a deck, and of the files that LAMMPS will write."""
    case = assembly.case
    names = [run_directory.CASE_FILE, run_directory.DATA_FILE, run_directory.SCRIPT_FILE]
    axes = directions(assembly) if case.precompression else ""
    names += [run_directory.DEAD_LOAD_FILE.format(axis) for axis in axes]
    started = bool(case.precompression) and balanced_displacements(assembly) is not None
    names += [run_directory.START_FILE.format(axis) for axis in "xyz" if started]
    names += [run_directory.BED_FILE] if case.packing.has_history else []
    names += [run_directory.DENTS_FILE] if case.contact.initial_overlap else []
    names += [run_directory.LOAD_FILE] if case.load.table else []
    numbers = [n for n, wall in enumerate(case.wall, start=1) if wall.region is None]
    names += [run_directory.MESH_FILE.format(number) for number in numbers]
    dumps = [f"{run_directory.DUMPS}/{name}" for name in output_files(assembly, schedule)]
    return [*names, run_directory.LOG_FILE, *dumps]


def _tables(assembly: Assembly) -> dict[str, str]:
    """Return the tables that the script reads, by file name: points of the load, dents, contacts of
    a bed, dead loads.
    """
    case = assembly.case
    tables = load_tables(assembly) if case.precompression else {}
    if case.contact.initial_overlap:
        tables[run_directory.DENTS_FILE] = dents_table(assembly)
    if case.packing.has_history:
        tables[run_directory.BED_FILE] = bed_table(assembly)
    for number, entry in enumerate(case.wall, start=1):
        if entry.region is None:
            tables[run_directory.MESH_FILE.format(number)] = stl_text(entry.corners)
    if case.load.table:
        rows = "".join(f"{time!r} {value!r}\n" for time, value in case.load.table)
        tables[run_directory.LOAD_FILE] = f"# time (s), {case.load.kind}, SI units\n{rows}"
    return tables


def read_deck(directory: str | Path, case: Case | None = None) -> Deck:
    """Read the deck that `write_deck` wrote into a directory.

    Parameters
    ----------
    case
        Case that it was written for, if it was read before.

    Raises
    ------
    InputError
        The case.toml is missing, was written by hand, or was changed.
    """
    directory = Path(directory)
    path = directory / run_directory.CASE_FILE
    tables = read_toml(path)
    if case is None:
        case = stored_case(tables, path)
    table = tables.get("resolved", {})
    try:
        table = {"line_every": 0} | table  # `resolved` omits it where it is 0
        values = {field.name: table[field.name] for field in dataclasses.fields(Schedule)}
        schedule = Schedule(**values | {"frame_steps": tuple(values["frame_steps"])})
        return Deck(directory, case, schedule, tuple(table["struck"]))
    except KeyError as error:
        raise InputError(
            f"{path}: resolved.{error.args[0]}: missing; write the deck again"
        ) from None


def resolved(assembly: Assembly, deck: Deck) -> dict[str, Any]:
    """Return the derived values: the table ``[resolved]`` of case.toml."""
    case = assembly.case
    return {
        "n_spheres": assembly.n_spheres,
        "n_contacts": assembly.n_contacts,
        "struck": deck.struck,
        "walls": [wall.name for wall in walls(assembly)],
        "forget_gap_m": case.boundary.forget_gap * case.packing.diameter,
        **{
            name: value
            for name, value in dataclasses.asdict(deck.schedule).items()
            if name != "line_every" or value
        },
    }
