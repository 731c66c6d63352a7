"""Fields of sections: one function for each type of key."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from granwave.lammps_inputs.case.hints import Usual
from granwave.lammps_inputs.case.schema.compound import (
    ChoiceOrTables,
    TablesType,
    or_word,
    vector_type,
)
from granwave.lammps_inputs.case.schema.faults import ErrorList, unit_name
from granwave.lammps_inputs.case.schema.reading import REQUIRED, KeyInfo, key_field
from granwave.lammps_inputs.case.schema.values import (
    LARGEST_COUNT,
    ChoiceType,
    CountType,
    NumberType,
    TextType,
    ValueType,
)


def typed(
    description: str,
    value_type: ValueType,
    *,
    unit: str | Usual | None = None,
    default: Any = REQUIRED,
) -> Any:
    """Field of a value of a type; unusual numbers in it give a warning."""
    usual = unit if isinstance(unit, Usual) else None
    info = KeyInfo(description=description, type=value_type, unit=unit_name(unit), usual=usual)
    return key_field(info, default)


def number(
    description: str,
    unit: str | Usual | None = None,
    *,
    default: Any = REQUIRED,
    above: float = -math.inf,
    below: float = math.inf,
    at_least: float = -math.inf,
    at_most: float = math.inf,
    word: str | None = None,
    units: str | None = None,
    form: str = "",
) -> Any:
    """Field of a finite number within bounds, or of ``word`` in its place; unusual values give a
    warning.

    Parameters
    ----------
    units
        Unit in messages, for a key with another unit in some tables.
    form
        Accepted values in words; default: derived from the bounds.
    """
    of_messages = "" if units or form else unit_name(unit)
    value_type: ValueType = NumberType(
        above=above, below=below, at_least=at_least, at_most=at_most, unit=of_messages, form=form
    )
    if units:
        form = f"{value_type.accepts} ({units})"
        value_type = NumberType(
            above=above, below=below, at_least=at_least, at_most=at_most, form=form
        )
    info = KeyInfo(
        description=description,
        type=value_type if word is None else or_word(word, value_type),
        unit=unit_name(unit),
        usual=unit if isinstance(unit, Usual) else None,
        varies=units is not None,
    )
    return key_field(info, default)


def positive_or_auto(description: str, unit: Usual, *, default: float | str = "auto") -> Any:
    """A positive number, or "auto"."""
    return number(description, unit, above=0, word="auto", default=default)


def choice(
    description: str,
    options: tuple[Any, ...] | Callable[[], tuple[Any, ...]],
    *,
    default: Any = REQUIRED,
    otherwise: TablesType | None = None,
) -> Any:
    """Field of one of the listed words, whole numbers or booleans.

    Parameters
    ----------
    options
        The options, or a function that returns them when they are needed.
    otherwise
        Tables that are valid too, which the reader of the section reads first.
    """
    value_type = ChoiceType(options)
    if otherwise is not None:
        value_type = ChoiceOrTables(options, otherwise)
    return typed(description, value_type, default=default)


def text(description: str, *, default: Any = REQUIRED) -> Any:
    """Field of a string that is not empty."""
    return typed(description, TextType(), default=default)


def path(description: str, *, default: Any = REQUIRED) -> Any:
    """Field of the path of a file."""
    return typed(description, TextType(expected="a path"), default=default)


def count(
    description: str, *, default: Any = REQUIRED, at_least: int = 1, at_most: int = LARGEST_COUNT
) -> Any:
    """Field of a whole number within bounds."""
    return typed(description, CountType(at_least=at_least, at_most=at_most), default=default)


def vector(description: str, unit: Usual) -> Any:
    """Field of three numbers, zero by default; unusual magnitudes give a warning."""
    three = vector_type(3, f"[x, y, z] in {unit.unit}")
    return typed(description, three, unit=unit, default=(0.0, 0.0, 0.0))


def nested(
    description: str, value_type: ValueType, read: Callable[[Any, ErrorList, str], Any]
) -> Any:
    """Field of a table with a separate reader, which adds its faults, and then returns None; None
    by default.
    """
    return key_field(KeyInfo(description=description, type=value_type, reader=read), None)
