"""Staging of output files: written to a scratch directory, and moved into place when all are complete."""

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
    """Scratch directory inside the output directory.

    Attributes
    ----------
    scratch
        Directory to write to; removed at the end of `staged`.
    placed
        Paths of the files moved into place, in the order of creation.
    """

    def __init__(self, output: Path, scratch: Path) -> None:
        self.output = output
        self.scratch = scratch
        self.placed: list[Path] = []
        self._names: list[str] = []

    def path(self, name: str) -> Path:
        """Return the scratch path for a file of this name."""
        self._names.append(name)
        return self.scratch / name

    @contextmanager
    def naming(self) -> Iterator[None]:
        """Make system errors that name no file name the last one begun."""
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
        """Move the files into place, in order, and remove those left by earlier exports.

        Parameters
        ----------
        outdated
            Regular expression; files of earlier exports whose full names match, and that were not written now, are
            removed.

        Raises
        ------
        InputError
            A file of such a name exists, and granwave did not write it; no file was moved.
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
    """Give a scratch directory whose files are moved to ``output`` at the end, or none on an error.

    Parameters
    ----------
    output
        Output directory; created if necessary, and removed again on failure if created here.
    outdated
        As in `Staging.place`.

    Raises
    ------
    InputError
        The directory cannot be written to, or a file exists that granwave did not write.
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
