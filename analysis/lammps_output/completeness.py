"""Are the files of a run whole? What was cut or lost afterwards would give wrong numbers without a word."""

from __future__ import annotations

import json
from pathlib import Path

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.lammps_output.time_series import read_energy, read_walls
from granwave.analysis.result.writer import RECORD_FILE
from granwave.lammps_inputs.deck.deck import read_deck
from granwave.lammps_inputs.packing.walls import walls


def check_complete(directory: Path) -> None:
    """Compare the tables of a run with each other and with its record.

    Raises
    ------
    MissingOutputError, OutputFormatError
        A file is missing, or ends before the run did.
    """
    deck = read_deck(directory)
    last = int(read_energy(directory)["step"][-1])
    recorded = _recorded_steps(directory)
    if recorded is not None and last < recorded - deck.schedule.ledger_every:
        raise OutputFormatError(
            f"{directory / 'dumps' / 'energy.txt'} ends at step {last}, the run at step {recorded}: "
            "the file was cut; run the case again with --force"
        )
    found = walls(deck.case)
    if not found:
        return
    forces = read_walls(directory)
    if not forces:
        raise MissingOutputError(f"{directory / 'dumps' / 'walls.txt'} is missing; run the case again with --force")
    if forces["step"][-1] < last - deck.schedule.ledger_every:
        raise OutputFormatError(
            f"{directory / 'dumps' / 'walls.txt'} ends at step {forces['step'][-1]:.0f}, the ledger at step {last}: "
            "the file was cut; run the case again with --force"
        )
    for wall in found:
        path = directory / "dumps" / f"wall_{wall.name}.dump"
        if not wall.held_layer and not path.exists():
            raise MissingOutputError(f"{path} is missing; run the case again with --force")


def _recorded_steps(directory: Path) -> int | None:
    """Steps that the driver did, or None for a deck that was run by hand."""
    path = directory / RECORD_FILE
    if not path.exists():
        return None
    try:
        return int(json.loads(path.read_text(encoding="utf-8"))["n_steps"])
    except (ValueError, KeyError, TypeError):
        raise OutputFormatError(f"{path} cannot be read: delete it, or run the case again with --force") from None
