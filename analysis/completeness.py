"""Check that the files of a run are whole: what was cut or lost afterwards would silently give wrong results."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.tables import read_energy, read_walls
from granwave.lammps_inputs.deck import read_deck
from granwave.lammps_inputs.run_directory import DUMPS, ENERGY_FILE, RECORD_FILE, WALL_CONTACTS_FILE, WALLS_FILE
from granwave.lammps_inputs.walls import walls


def check_complete(directory: Path) -> None:
    """Compare the tables of a run with each other and with its record.

    Raises
    ------
    MissingOutputError, OutputFormatError
        A file is missing, or ends before the run did.
    """
    deck = read_deck(directory)
    steps = read_energy(directory)["step"]
    _check_rows(directory / DUMPS / ENERGY_FILE, steps)
    last = int(steps[-1])
    recorded = _recorded_steps(directory)
    if recorded is not None and last < recorded - deck.schedule.ledger_every:
        raise OutputFormatError(
            f"{directory / DUMPS / ENERGY_FILE} ends at step {last}, the run at step {recorded}: "
            "the file was cut; run the case again with --force"
        )
    found = walls(deck.case)
    if not found:
        return
    forces = read_walls(directory)
    if not forces:
        raise MissingOutputError(f"{directory / DUMPS / WALLS_FILE} is missing; run the case again with --force")
    _check_rows(directory / DUMPS / WALLS_FILE, forces["step"])
    if forces["step"][-1] < last - deck.schedule.ledger_every:
        raise OutputFormatError(
            f"{directory / DUMPS / WALLS_FILE} ends at step {forces['step'][-1]:.0f}, the ledger at step {last}: "
            "the file was cut; run the case again with --force"
        )
    for wall in found:
        path = directory / DUMPS / WALL_CONTACTS_FILE.format(wall.name)
        if not wall.held_layer and not path.exists():
            raise MissingOutputError(f"{path} is missing; run the case again with --force")


def _check_rows(path: Path, steps: NDArray[np.float64]) -> None:
    """Raise OutputFormatError where rows are missing between others, as after a disk was full for a while."""
    apart = np.diff(steps)
    if len(apart) and apart.max() > apart.min():
        n = int(apart.argmax())
        raise OutputFormatError(
            f"{path} lacks rows between the steps {steps[n]:.0f} and {steps[n + 1]:.0f}; "
            "run the case again with --force"
        )


def _recorded_steps(directory: Path) -> int | None:
    """Steps that the driver did, or None for a deck that was run by hand."""
    path = directory / RECORD_FILE
    if not path.exists():
        return None
    try:
        return int(json.loads(path.read_text(encoding="utf-8"))["n_steps"])
    except (ValueError, KeyError, TypeError):
        raise OutputFormatError(f"{path} cannot be read: delete it, or run the case again with --force") from None
