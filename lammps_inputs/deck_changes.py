"""Detection of decks that were edited by hand: digests of the files as granwave wrote them."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Iterable
from pathlib import Path

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.ownership import read_marker
from granwave.lammps_inputs.run_directory import DATA_FILE, DUMPS, RECORD_FILE

logger = logging.getLogger(__name__)

_FROM_LAMMPS = "Times, energies, forces and snapshots are those that LAMMPS computed"
_FROM_DATA = "positions, diameters and densities are those of the file"
_FROM_CASE = (
    "material, law, load, walls, timestep and lattice are those of case.toml, and with them which contacts count as "
    "yielded, the size of the plastic zone, and normalised values: where the change alters one of these, they are wrong"
)


def note_deck(directory: Path, names: Iterable[str]) -> None:
    """Store the digests of the files of a deck in the marker, so that `changed_files` detects edits."""
    marker = read_marker(directory)
    if marker is not None:
        marker.digests |= {name: _digest(directory / name) for name in names}
        marker.write(directory)


def changed_files(directory: Path) -> list[str]:
    """Return the names of the files of a deck that are not as granwave wrote them; missing ones do not count."""
    marker = read_marker(directory)
    noted = marker.digests if marker else {}
    return [
        name for name, digest in noted.items() if (directory / name).is_file() and _digest(directory / name) != digest
    ]


def check_deck(directory: Path) -> None:
    """Warn if the deck was edited by hand before LAMMPS was run on it.

    Raises
    ------
    InputError
        The data file was changed after granwave ran the case.
    """
    by_hand = not (directory / RECORD_FILE).exists()
    for name in changed_files(directory):
        path, is_data = directory / name, name == DATA_FILE
        if by_hand:
            taken = f"{_FROM_LAMMPS}; {f'{_FROM_DATA}; ' if is_data else ''}{_FROM_CASE}"
            late = "; it is newer than the output of LAMMPS, so the run may have been of another" * _is_newer(path)
            logger.warning("%s: was changed after granwave wrote it%s. %s", path, late, taken)
        elif is_data:
            raise InputError(
                f"{path}: was changed after the run, and the positions of the spheres are read from it: put back what "
                f"was run, or run the case again with --force. A deck to be edited is made by granwave write"
            )
        else:
            logger.warning("%s: was changed after the run; the results are of what was run", path)


def _is_newer(path: Path) -> bool:
    """Return True if a file was changed after LAMMPS wrote its last output."""
    written = [one.stat().st_mtime for one in (path.parent / DUMPS).glob("*") if one.is_file()]
    return bool(written) and path.stat().st_mtime > max(written)


def _digest(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, lambda: hashlib.blake2b(digest_size=16)).hexdigest()
