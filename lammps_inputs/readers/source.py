"""A file of grains to be read: its bytes, its text, and the options of the user."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path

from granwave.lammps_inputs.files import read_regular
from granwave.lammps_inputs.readers.packed import unpacked
from granwave.lammps_inputs.tables.encoding import decoded_table, start_of
from granwave.lammps_inputs.tables.units import has_size, length_power

_NUL = "\0"
_END_OF_DOS = "\x1a"
_HEAD = 4096  # characters that show the format


@dataclasses.dataclass(frozen=True, kw_only=True)
class FileOptions:
    """Keys of a case for reading a file of grains.

    Attributes
    ----------
    format
        Name of the format; empty: that of the content.
    columns
        Names of the columns in their order, of a table without them; or the name of a column, or
        its number from 1, by quantity.
    units
        Unit of the lengths, or the size of a voxel, such as ``0.012 mm``; empty: that of the file,
        or metres.
    step
        Timestep of a file of several; None: the last.
    diameter
        Diameter of grains for which the file has none, m.
    """

    format: str = ""
    columns: Sequence[str] | Mapping[str, str | int] = ()
    units: str = ""
    step: int | None = None
    diameter: float | None = None

    @property
    def heads(self) -> Sequence[str]:
        """Names of the columns in their order; empty unless they were given as a list."""
        return () if isinstance(self.columns, Mapping) else self.columns

    @property
    def names(self) -> Mapping[str, str | int]:
        """Columns by quantity; empty unless they were given as a table."""
        return self.columns if isinstance(self.columns, Mapping) else {}

    @property
    def has_voxels(self) -> bool:
        """True if the user gave the size of a voxel."""
        return bool(self.units) and has_size(self.units)

    def power(self) -> float:
        """Return the power of ten of the unit of the lengths, in metres."""
        return length_power(self.units) if self.units else 0


@dataclasses.dataclass(frozen=True)
class GrainSource:
    """A file of grains that is read.

    Attributes
    ----------
    path
        The file.
    options
        The user's settings for it.
    """

    path: Path
    options: FileOptions = FileOptions()

    @cached_property
    def content(self) -> bytes:
        """Bytes of the file, unpacked if it is a .gz, .xz, .bz2 or .zip.

        Raises
        ------
        OSError
            The file cannot be read.
        ValueError
            It is packed and damaged, or of a kind that holds no text.
        """
        return unpacked(read_regular(self.path))

    @cached_property
    def text(self) -> str:
        """Text of the file, with the line ends of Unix.

        Raises
        ------
        ValueError
            It is no text, or has characters NUL, as a damaged file, or UTF-16 without its mark.
        """
        text = decoded_table(self.content).rstrip(_END_OF_DOS)
        if _NUL in text:
            line = text.count("\n", 0, text.index(_NUL)) + 1
            raise ValueError(
                f"line {line}: found a NUL character, expected text; the file is damaged, or "
                "UTF-16 without its mark: save it as UTF-8"
            )
        if "\r" not in text:
            return text
        return text.replace("\r\n", "\n").replace("\r", "\n")

    @cached_property
    def head(self) -> str:
        """First characters of the file, whatever their encoding."""
        return start_of(self.content, _HEAD)

    @property
    def whole_lines(self) -> str:
        """First complete lines of the file."""
        if len(self.content) <= _HEAD:
            return self.head
        return self.head.rpartition("\n")[0]

    @property
    def is_binary(self) -> bool:
        """True if the file is not text."""
        return _NUL in self.head
