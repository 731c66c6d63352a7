"""Types of lists, of tables, and of values of several types.

`TableType`, the type of a table with a separate section, is in
`granwave.lammps_inputs.case.schema.reading`, with the reader of tables.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from granwave.lammps_inputs.case.schema.faults import ValidationError, refuse_if
from granwave.lammps_inputs.case.schema.values import (
    ChoiceType,
    Finish,
    Json,
    NumberType,
    ValueType,
    WordType,
)
from granwave.lammps_inputs.message_words import did_you_mean


@dataclasses.dataclass(frozen=True, kw_only=True)
class ListType(ValueType):
    """A list of values of one type.

    Attributes
    ----------
    item
        Type of the values.
    expected
        Accepted lists, in words.
    at_least, at_most
        Numbers of values that are valid.
    alone
        True if a single value without a list is also valid.
    finish
        As in `TextType`, of the tuple of values.
    """

    kind: ClassVar[str] = "array"
    item: ValueType
    expected: str
    at_least: int = 1
    at_most: int | None = None
    alone: bool = False
    finish: Finish | None = None

    def read(self, value: Any) -> Any:
        """Return the values as a tuple."""
        if self.alone and not isinstance(value, list | tuple):
            value = (value,)
        refuse_if(not isinstance(value, list | tuple) or len(value) < self.at_least, self.expected)
        refuse_if(self.at_most is not None and len(value) > self.at_most, self.expected)
        values = tuple(self._read_item(n, entry) for n, entry in enumerate(value, start=1))
        return values if self.finish is None else self.finish(values)

    def _read_item(self, n: int, value: Any) -> Any:
        """Read the n-th value; the fault of a value inside a table names the table by number."""
        try:
            return self.item.read(value)
        except ValidationError as error:
            raise (error.below(str(n), value) if error.key else error) from None

    @property
    def json(self) -> Json:
        """A list or a single value."""
        several = {"type": "array", "items": self.item.json, "minItems": self.at_least}
        if self.at_most is not None:
            several["maxItems"] = self.at_most
        return {"anyOf": [self.item.json, several]} if self.alone else several

    @property
    def tables(self) -> dict[str, type]:
        """Sections of the entries that are tables."""
        return {f"[]{name}": section for name, section in self.item.tables.items()}

    def is_meant(self, value: Any) -> bool:
        """Return True for a list, or for a single value in place of a list."""
        if isinstance(value, list | tuple):
            return True
        return self.alone and self.item.is_meant(value)


def vector_type(
    n: int,
    expected: str,
    fits: Callable[..., bool] = lambda *_: True,
    otherwise: str = "",
) -> ListType:
    """Make the type of a list of ``n`` numbers that ``fits`` accepts.

    Parameters
    ----------
    otherwise
        Expected numbers, for the message; ``expected`` by default.
    """

    def fitting(numbers: tuple[float, ...]) -> tuple[float, ...]:
        refuse_if(not fits(*numbers), otherwise or expected)
        return numbers

    number = NumberType(form=expected)
    return ListType(item=number, expected=expected, at_least=n, at_most=n, finish=fitting)


@dataclasses.dataclass(frozen=True, kw_only=True)
class EitherType(ValueType):
    """A value whose type is one of several.

    A value is read by the first type that accepts it by `ValueType.is_meant`; without such a type
    the value is a fault.

    Attributes
    ----------
    types
        The types, special ones first.
    form
        Accepted values in words; by default the values of all types.
    """

    types: tuple[ValueType, ...]
    form: str = ""

    @property
    def expected(self) -> str:  # type: ignore[override]
        """Accepted values of all types, in words."""
        return self.form or " or ".join(one.expected for one in self._words_last())

    @property
    def accepts(self) -> str:
        """Accepted values of all types, in words."""
        return self.form or " or ".join(one.accepts for one in self._words_last())

    def _words_last(self) -> list[ValueType]:
        """Return the types in the order of a sentence."""
        return sorted(self.types, key=lambda one: isinstance(one, WordType))

    def read(self, value: Any) -> Any:
        """Read the value by its type."""
        for one in self.types:
            if one.is_meant(value):
                return self._read_by(one, value)
        raise ValidationError(self.expected)

    def _read_by(self, one: ValueType, value: Any) -> Any:
        """Read a value by one of the types; the message for an invalid value lists all types."""
        try:
            return one.read(value)
        except ValidationError as error:
            if error.expected == one.expected and not error.key:
                raise ValidationError(self.expected) from None
            raise

    @property
    def json(self) -> Json:
        """One of the types."""
        return {"anyOf": [one.json for one in self.types]}

    @property
    def words(self) -> tuple[Any, ...]:
        """Words of all types."""
        return tuple(itertools.chain.from_iterable(one.words for one in self.types))

    @property
    def tables(self) -> dict[str, type]:
        """Sections of all types."""
        found: dict[str, type] = {}
        for one in self.types:
            found |= one.tables
        return found

    def is_meant(self, value: Any) -> bool:
        """Return True if a value appears to be of one of the types."""
        return any(one.is_meant(value) for one in self.types)


def or_word(
    word: str, other: ValueType, form: str = "", finish: Finish | None = None
) -> EitherType:
    """Make the type of a word, or of a value of another type.

    Parameters
    ----------
    form
        Accepted values in words, as in `EitherType`.
    finish
        Function that converts the word.
    """
    return EitherType(types=(WordType(word, finish), other), form=form)


@dataclasses.dataclass(frozen=True, kw_only=True)
class TablesType(ValueType):
    """A table of values by name, with a separate reader.

    Attributes
    ----------
    expected
        Accepted tables, in words.
    inner
        Types of the values by name.
    """

    kind: ClassVar[str] = "object"
    expected: str
    inner: Mapping[str, ValueType]

    def read(self, value: Any) -> Any:
        """Return the table."""
        return value

    @property
    def json(self) -> Json:
        """A table of these names."""
        properties = {name: one.json for name, one in self.inner.items()}
        return {"type": "object", "additionalProperties": False, "properties": properties}

    @property
    def tables(self) -> dict[str, type]:
        """Sections of the values that are tables."""
        found: dict[str, type] = {}
        for name, one in self.inner.items():
            found |= {f"{name}.{path}".rstrip("."): section for path, section in one.tables.items()}
        return found


@dataclasses.dataclass(frozen=True)
class ChoiceOrTables(ChoiceType):
    """One of several words; or a table, which the reader of the section reads first."""

    otherwise: TablesType

    @property
    def accepts(self) -> str:
        """All options, and the tables in words."""
        return f"{self.expected}; or {self.otherwise.expected}"

    def read(self, value: Any) -> Any:
        """Return the option; a fault names the tables too."""
        try:
            return super().read(value)
        except ValidationError:
            raise ValidationError(
                self.accepts + did_you_mean(value, map(str, self.words))
            ) from None

    @property
    def json(self) -> Json:
        """All options, or a table."""
        return {"anyOf": [super().json, self.otherwise.json]}

    @property
    def tables(self) -> dict[str, type]:
        """Sections of the tables."""
        return self.otherwise.tables
