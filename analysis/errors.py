"""Errors of the analysis; messages state the found value, the expected value and the remedy."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

from granwave.lammps_inputs.errors import GranwaveError


class MissingOutputError(GranwaveError, FileNotFoundError):
    """Error of a missing output file of a run."""


class OutputFormatError(GranwaveError, ValueError):
    """Error of an output file of a run with wrong content."""


class MissingDataError(OutputFormatError, KeyError):
    """Error of a data set that a result lacks."""

    __str__ = Exception.__str__  # KeyError would quote its message


def did_you_mean(word: str, known: Iterable[str], cutoff: float = 0.6) -> str:
    """Return "did you mean NAME?" with the nearest of the known names; empty if none is near."""
    near = difflib.get_close_matches(word, list(known), n=1, cutoff=cutoff)
    return f"did you mean {near[0]}?" if near else ""
