"""Errors of the analysis: each says what was found, what was expected and how to mend it."""

from __future__ import annotations

from granwave.lammps_inputs.errors import GranwaveError


class MissingOutputError(GranwaveError, FileNotFoundError):
    """A file that the run should have left is not there."""


class OutputFormatError(GranwaveError, ValueError):
    """A file of the run is there but does not hold what it should."""


class MissingDataError(OutputFormatError, KeyError):
    """A result has no such data set."""

    __str__ = Exception.__str__  # KeyError puts quotes around its message
