"""Files that are written elsewhere first and put into place once all of them are complete."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import discard, naming
from granwave.lammps_inputs.ownership import claim, clear, read_marker


class Staging:
    """A scratch directory inside of the output directory.

    Attributes
    ----------
    scratch
        Where to write; it does not outlive `staged`.
    placed
        The files that were put into place, in the order of their making.
    """

    def __init__(self, output: Path, scratch: Path) -> None:
        self.output = output
        self.scratch = scratch
        self.placed: list[Path] = []
        self._names: list[str] = []

    def path(self, name: str) -> Path:
        """Where to write the file that is to be called so."""
        self._names.append(name)
        return self.scratch / name

    @contextmanager
    def naming(self) -> Iterator[None]:
        """Within it, an error of the system that names no file names the one that was begun last."""
        try:
            with naming(self.output):
                yield
        except OSError as error:
            if error.filename == str(self.output) and self._names:
                error.filename = str(self.output / self._names[-1])
            elif error.filename is not None:
                error.filename = str(error.filename).replace(str(self.scratch), str(self.output))
            raise

    def place(self, outdated: str) -> None:
        """Put the files into place, the last one last, and remove what an earlier export left.

        Parameters
        ----------
        outdated
            A regular expression; files of earlier exports whose whole names match, and that were not written now, are
            removed.

        Raises
        ------
        InputError
            A file of such a name is there, and granwave did not write it; none was put into place.
        """
        claim(self.output, self._names)
        for name in self._names:
            os.replace(self.scratch / name, self.output / name)
            self.placed.append(self.output / name)
        marker = read_marker(self.output)
        own = [name for name in (marker.files if marker else ()) if name not in self._names]
        clear(self.output, [name for name in own if re.fullmatch(outdated, name)])


@contextmanager
def staged(output: Path, outdated: str = "(?!)") -> Iterator[Staging]:
    """Within it, files are written to scratch; at its end they are put into ``output``, or none if it failed.

    Parameters
    ----------
    output
        A directory; made if need be, and removed again on failure if it was made here.
    outdated
        As in `Staging.place`.

    Raises
    ------
    InputError
        Nothing can be written there, or a file is there that granwave did not write.
    """
    made = [path for path in (output, *output.parents) if not path.exists()]
    try:
        output.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=".granwave-export-", dir=output))
    except OSError as error:
        _remove_empty(made)
        raise InputError(
            f"{output}: cannot be written to ({error.strerror}); choose another directory with -o"
        ) from None
    staging = Staging(output, scratch)
    try:
        with staging.naming():
            yield staging
            staging.place(outdated)
    finally:
        for path in scratch.iterdir():
            discard(path)
        shutil.rmtree(scratch, ignore_errors=True)
        if not staging.placed:
            _remove_empty(made)


def _remove_empty(directories: list[Path]) -> None:
    for directory in directories:
        try:
            directory.rmdir()
        except OSError:
            return
