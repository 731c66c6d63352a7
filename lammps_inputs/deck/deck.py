"""Deck of a case: a directory in which ``lmp -in in.granwave`` runs."""

from __future__ import annotations

import contextlib
import dataclasses
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.initial_dents import dents_table
from granwave.lammps_inputs.contact.static_load import directions
from granwave.lammps_inputs.deck.data_file import write_data
from granwave.lammps_inputs.deck.output_files import output_files
from granwave.lammps_inputs.deck.script import input_script
from granwave.lammps_inputs.deck.static_stage import load_tables
from granwave.lammps_inputs.deck_changes import note_deck
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import DISK_IS_FULL, naming, replacing
from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.ownership import claim, clear, read_marker, results_in
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.packing.motion import struck_of
from granwave.lammps_inputs.packing.walls import walls
from granwave.lammps_inputs.planning.schedule import Schedule, make_schedule
from granwave.lammps_inputs.run_directory import (
    CASE_FILE,
    DATA_FILE,
    DEAD_LOAD_FILE,
    DENTS_FILE,
    DUMPS,
    LOAD_FILE,
    LOG_FILE,
    RUN,
    SCRIPT_FILE,
)
from granwave.lammps_inputs.toml_files import read_toml


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
        Ids of the spheres that the load acts on, the struck sphere first.
    written
        Names of the files that were written; empty for a deck that was read.
    """

    directory: Path
    case: Case
    schedule: Schedule
    struck: tuple[int, ...]
    written: tuple[str, ...] = ()

    @property
    def script(self) -> Path:
        """Path of the LAMMPS input script."""
        return self.directory / SCRIPT_FILE

    @property
    def data(self) -> Path:
        """Path of the LAMMPS data file."""
        return self.directory / DATA_FILE

    @property
    def dumps(self) -> Path:
        """Directory of the output of LAMMPS."""
        return self.directory / DUMPS


def write_deck(case: Case | Assembly, directory: str | Path, *, timestep: float | None = None) -> Deck:
    """Write the deck of a case: case.toml, data.granwave, in.granwave, the tables that it reads, and an empty dumps/.

    All files are replaced atomically, the script last. Files that granwave wrote there before are replaced; other
    files in the directory are not touched.

    Parameters
    ----------
    timestep
        Timestep in place of ``run.timestep``, s.

    Raises
    ------
    InputError
        The directory cannot be written to, holds files of such names that granwave did not write, or the initial dents
        cannot be read; see `dents_table`.
    """
    assembly = assemble(case)
    case = assembly.case
    directory = Path(directory)
    tables = _tables(assembly)
    written = (SCRIPT_FILE, CASE_FILE, DATA_FILE, *tables)
    deck = Deck(directory, case, make_schedule(assembly, timestep), struck_of(assembly), written)
    text = case.to_toml(resolved=resolved(deck))
    try:
        directory.mkdir(parents=True, exist_ok=True)
        before = read_marker(directory) if results_in(directory) else None
        claim(directory, deck_files(assembly, deck.schedule), kind=RUN, case=text)
        deck.dumps.mkdir(exist_ok=True)
    except OSError as error:
        if error.errno in DISK_IS_FULL:
            raise
        raise InputError(f"{directory}: cannot be written to: {error.strerror}; choose another with -o") from None
    try:
        _write(assembly, directory, {SCRIPT_FILE: input_script(assembly, deck.schedule), CASE_FILE: text, **tables})
        note_deck(directory, [SCRIPT_FILE, DATA_FILE, *tables])
    except BaseException:
        if before is None:
            clear(directory)
        else:
            before.write(directory)
        raise
    return deck


def _write(assembly: Assembly, directory: Path, texts: dict[str, str]) -> None:
    """Write the data file and texts, given by file name; the first one is moved into place last."""
    with contextlib.ExitStack() as stack:  # contexts are left in reverse order
        names = dict.fromkeys((next(iter(texts)), DATA_FILE, *texts))
        scratch = {name: stack.enter_context(replacing(directory / name)) for name in names}
        for name, path in scratch.items():
            with naming(directory / name):
                if name == DATA_FILE:
                    write_data(assembly, path)
                else:
                    path.write_text(texts[name], encoding="utf-8")


def deck_files(assembly: Assembly, schedule: Schedule) -> list[str]:
    """Return the names of the files of a deck, and of those that LAMMPS will write."""
    case = assembly.case
    tables = [DEAD_LOAD_FILE.format(axis) for axis in directions(assembly)] if case.precompression else []
    tables += [DENTS_FILE] if case.contact.initial_overlap else []
    tables += [LOAD_FILE] if case.load.table else []
    dumps = [f"{DUMPS}/{name}" for name in output_files(assembly, schedule)]
    return [CASE_FILE, DATA_FILE, SCRIPT_FILE, *tables, LOG_FILE, *dumps]


def _tables(assembly: Assembly) -> dict[str, str]:
    """Return the tables that the script reads, by file name: points of the load, dents, dead loads."""
    case = assembly.case
    tables = load_tables(assembly) if case.precompression else {}
    if case.contact.initial_overlap:
        tables[DENTS_FILE] = dents_table(assembly)
    if case.load.table:
        rows = "".join(f"{time!r} {value!r}\n" for time, value in case.load.table)
        tables[LOAD_FILE] = f"# time (s), {case.load.kind}, SI units\n{rows}"
    return tables


_NEW = {
    "history_every": 0,
    "first_step": 1,
    "longest_step": 1,
    "energy_tolerance": 0.0,
    "line_every": 0,
}  # since version 0.1


def read_deck(directory: str | Path) -> Deck:
    """Read the deck that `write_deck` wrote into a directory.

    Raises
    ------
    InputError
        The case.toml is missing, was written by hand, or was changed.
    """
    directory = Path(directory)
    path = directory / CASE_FILE
    case, table = load_case(path), read_toml(path).get("resolved", {})
    try:
        table = _NEW | table
        values = {field.name: table[field.name] for field in dataclasses.fields(Schedule)}
        schedule = Schedule(**values | {"frame_steps": tuple(values["frame_steps"])})
        return Deck(directory, case, schedule, tuple(table["struck"]))
    except KeyError as error:
        raise InputError(f"{path}: resolved.{error.args[0]}: missing; write the deck again") from None


def resolved(deck: Deck) -> dict[str, Any]:
    """Return the derived values: the table ``[resolved]`` of case.toml."""
    case, assembly = deck.case, assemble(deck.case)
    return {
        "n_spheres": assembly.n_spheres,
        "n_contacts": assembly.n_contacts,
        "struck": deck.struck,
        "walls": [wall.name for wall in walls(case)],
        "forget_gap_m": case.boundary.forget_gap * case.packing.diameter,
        **{name: value for name, value in dataclasses.asdict(deck.schedule).items() if name != "line_every" or value},
    }
