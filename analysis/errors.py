"""Errors of the analysis; messages say what was found, what was expected and how to correct it."""

from __future__ import annotations

from granwave.lammps_inputs.errors import GranwaveError


class MissingOutputError(GranwaveError, FileNotFoundError):
    """Error of a missing output file of a run."""


class OutputFormatError(GranwaveError, ValueError):
    """Error of an output file of a run with wrong content."""


class MissingDataError(OutputFormatError, KeyError):
    """Error of a data set that a result lacks."""

    __str__ = Exception.__str__  # KeyError would quote its message
