"""Values of ``summary.json`` for the terminal: label, unit and meaning, looked up by name."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase

from granwave.analysis.quantities import Quantity, entries, quantity
from granwave.analysis.summary_table import explanation
from granwave.lammps_inputs.case.schema import did_you_mean, show
from granwave.lammps_inputs.errors import InputError


def is_quantity(name: str) -> bool:
    """Return True for the name of a value, or of a family of values such as ``line_*_speed``."""
    return any(fnmatchcase(name, entry.name) for entry in entries())


def quantity_text(name: str) -> str:
    """Return label, unit and meaning of a value; of a word, a list of the values with this word in
    their name or label.

    Raises
    ------
    InputError
        There is no such value; the message names the nearest.
    """
    if is_quantity(name):
        return explanation(name)
    listed = [quantity(entry.name) for entry in entries()]
    word = name.casefold()
    found = [one for one in listed if word and word in f"{one.name} {one.label}".casefold()]
    if not found:
        names = [one.name for one in listed]
        hint = did_you_mean(name, names, cutoff=0.5) or "; granwave quantities lists all"
        raise InputError(f"{show(name)[1:-1] or '(empty)'}: not a value of summary.json{hint}")
    return _table(found)


def all_quantities() -> str:
    """Return a list of all values: name, unit and label."""
    return _table([quantity(entry.name) for entry in entries()])


def _table(listed: Sequence[Quantity]) -> str:
    """List values: name, unit and label."""
    width = max(len(entry.name) for entry in listed)
    units = max(len(entry.unit) for entry in listed)
    return "\n".join(f"{one.name:{width}}  {one.unit:{units}}  {one.label}" for one in listed)
