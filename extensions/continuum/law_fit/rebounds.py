"""Measured coefficients of restitution against impact velocity, read from CSV."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError, first_errors
from granwave.lammps_inputs.files import read_number
from granwave.lammps_inputs.tables.layout import read_rows

RESTITUTION = "restitution"
CONTACT = "contact"  # names of several contacts in a table of `granwave law --restitution`
_VELOCITIES = {"velocity_m_s": 1.0, "velocity_cm_s": 1e-2, "velocity_mm_s": 1e-3}
_MOST = 1.1  # coefficient that exceeds 1 by more than noise

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, eq=False)
class Rebounds:
    """Measured rebounds.

    Attributes
    ----------
    source
        Name of the source, for messages.
    velocity
        Impact velocities, in rising order: (n,), m/s.
    restitution
        Coefficients of restitution: (n,).
    """

    source: str
    velocity: Array
    restitution: Array


def rebounds_of(velocity: Array, restitution: Array, source: str = "rebounds") -> Rebounds:
    """Make rebounds from velocities (m/s) and coefficients of restitution in any order."""
    order = np.argsort(velocity, kind="stable")
    return Rebounds(source, np.asarray(velocity)[order], np.asarray(restitution)[order])


def holds_rebounds(path: Path) -> bool:
    """Return True if a CSV file has a column of coefficients of restitution."""
    rows = read_rows(path)
    return bool(rows) and RESTITUTION in _names(rows[0][1])


def read_rebounds(path: Path) -> Rebounds:
    """Read a CSV file with the columns velocity_m_s (or velocity_cm_s, velocity_mm_s) and
    restitution; others are ignored.

    Raises
    ------
    InputError
        The file cannot be read, lacks a column, is of several contacts, or holds a wrong number;
        the message gives the line of each fault.
    """
    (_, head), *rows = read_rows(path)
    names = _names(head)
    velocities = [name for name in _VELOCITIES if name in names]
    if len(velocities) != 1:
        listed = " and ".join(velocities) or ", ".join(names)
        expected = f"one column {' or '.join(_VELOCITIES)}"
        raise InputError(f"{path}: found {listed}, expected {expected}")
    tables = [dict(zip(names, cells, strict=False)) for _, cells in rows]
    _refuse_several(path, tables)
    lines = [number for number, _ in rows]
    errors: list[str] = []
    velocity = _column(path, lines, tables, velocities[0], _is_velocity, errors)
    ratio = _column(path, lines, tables, RESTITUTION, _is_ratio, errors)
    if errors:
        raise InputError(first_errors(path, errors))
    return rebounds_of(_VELOCITIES[velocities[0]] * velocity, ratio, str(path))


def _names(cells: list[str]) -> list[str]:
    return [cell.strip() for cell in cells]


def _refuse_several(path: Path, tables: list[dict[str, str]]) -> None:
    contacts = dict.fromkeys(table.get(CONTACT, "") for table in tables)
    if len(contacts) > 1:
        listed = ", ".join(contacts)
        raise InputError(
            f"{path}: contact: found {len(contacts)} contacts ({listed}), expected one: keep only "
            "the rows for the bodies of --material and --radius"
        )


def _column(
    path: Path,
    lines: list[int],
    tables: list[dict[str, str]],
    name: str,
    fault: Callable[[float], str],
    errors: list[str],
) -> Array:
    """Return the numbers of a column, (n,); faults are added to ``errors``."""
    values = []
    for line, table in zip(lines, tables, strict=True):
        text = (table.get(name) or "").strip()
        try:
            value = read_number(text)
        except ValueError:
            value = math.nan
        expected = "a number" if not math.isfinite(value) else fault(value)
        if expected:
            errors.append(f"{path}: line {line}: {name}: found {show(text)}, expected {expected}")
        values.append(value)
    return np.array(values, dtype=np.float64)


def _is_velocity(value: float) -> str:
    """Return the expected value for an invalid velocity; empty for a valid velocity."""
    return "" if value > 0 else "a velocity above 0"


def _is_ratio(value: float) -> str:
    """Return the expected value for an invalid coefficient; empty for a valid coefficient."""
    return "" if 0 <= value <= _MOST else "a ratio from 0 to 1, not per cent"
