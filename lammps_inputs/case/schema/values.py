"""Types of the values of keys: accepted values, in words and as JSON Schema, and readers.

A type is declared with its key, and is the only source on the values of the key, for the reader of
a file, the reference of the keys, the schema for editors and the completion of words.
"""

from __future__ import annotations

import abc
import dataclasses
import math
import sys
from collections.abc import Callable
from typing import Any, ClassVar

from granwave.lammps_inputs.case.schema.faults import ValidationError, refuse_if
from granwave.lammps_inputs.message_words import did_you_mean, show

_LEAST = 2.3e-308  # magnitude, in messages
LARGEST_COUNT = 2**31 - 1  # ids and counts are 32-bit integers in the default build of LAMMPS
NO_LIMIT = 2**63 - 1  # for counts that the schedule limits to the number of steps
LABEL_FORM = (
    "a name that is not empty and contains no tabs, line breaks or other control characters, nor "
    "spaces at its ends"
)
NAME_FORM = (
    'a plain name that can be the name of a directory: without "/", not starting with '
    '".", "-" or "~"'
)
_LONGEST_NAME = 200  # bytes; file systems allow 255, including suffixes

Finish = Callable[[Any], Any]
Json = dict[str, Any]


class ValueType(abc.ABC):
    """Type of the values of a key.

    Attributes
    ----------
    expected
        Accepted values, in words, as messages have them.
    kind
        Type of the values in JSON Schema; empty if there are several.
    """

    expected: str
    kind: ClassVar[str] = ""

    @abc.abstractmethod
    def read(self, value: Any) -> Any:
        """Convert a TOML value; raise `ValidationError` if it is not valid."""

    @property
    @abc.abstractmethod
    def json(self) -> Json:
        """JSON Schema of the TOML values."""

    @property
    def accepts(self) -> str:
        """Accepted values, in words, for a table of keys that has a column of units."""
        return self.expected

    @property
    def words(self) -> tuple[Any, ...]:
        """List of the allowed words, numbers or truth values."""
        return ()

    @property
    def tables(self) -> dict[str, type]:
        """Sections of the tables that a value may be or hold, by their names below the key: empty,
        ``[]`` for the entries of a list, or a dotted path.
        """
        return {}

    def is_meant(self, value: Any) -> bool:
        """Return True if a value is of this type among several, whether or not it is valid."""
        return kind_of_value(value) == self.kind


def kind_of_value(value: Any) -> str:
    """Return the name that JSON Schema has for the type of a TOML value."""
    kinds = ((bool, "boolean"), (int | float, "number"), (str, "string"), (list | tuple, "array"))
    return next((name for kind, name in kinds if isinstance(value, kind)), "object")


def finite(value: Any, expected: str) -> float:
    """Convert ``value`` to a finite float; raise `ValidationError` for booleans, strings, NaN and
    infinity.
    """
    refuse_if(isinstance(value, bool) or not isinstance(value, int | float), expected)
    try:
        result = float(value)
    except OverflowError:
        raise ValidationError(expected) from None
    refuse_if(not math.isfinite(result), expected)
    if 0 < abs(result) < sys.float_info.min:  # LAMMPS cannot read longer names
        raise ValidationError(f"{expected}: 0, or a magnitude from {_LEAST:.3g} up")
    return result


def whole(value: Any, expected: str, *, at_least: int = 1, at_most: int = LARGEST_COUNT) -> int:
    """Return ``value`` as an integer within bounds; raise `ValidationError` for booleans and
    floats.
    """
    refuse_if(isinstance(value, bool) or not isinstance(value, int) or value < at_least, expected)
    refuse_if(value > at_most, f"at most {at_most}")
    return value


@dataclasses.dataclass(frozen=True, kw_only=True)
class NumberType(ValueType):
    """A finite number within bounds.

    Attributes
    ----------
    unit
        Unit in messages; empty if there is none.
    form
        Accepted values in words; default: derived from the bounds.
    finish
        As in `TextType`.
    """

    kind: ClassVar[str] = "number"
    above: float = -math.inf
    at_least: float = -math.inf
    below: float = math.inf
    at_most: float = math.inf
    unit: str = ""
    form: str = ""
    finish: Finish | None = None

    @property
    def accepts(self) -> str:
        """Bounds in words."""
        if self.form:
            return self.form
        if math.isfinite(self.at_least):
            return f"a number from {self.at_least:g} {self._last}"
        limits = {"above": self.above, "below": self.below, "at most": self.at_most}
        bounds = [f"{name} {limit:g}" for name, limit in limits.items() if math.isfinite(limit)]
        return f"a number {' and '.join(bounds)}".rstrip()

    @property
    def _last(self) -> str:
        """Upper bound in words, after a lower bound."""
        if math.isfinite(self.at_most):
            return f"to {self.at_most:g}"
        return f"to below {self.below:g}" if math.isfinite(self.below) else "up"

    @property
    def expected(self) -> str:  # type: ignore[override]
        """Bounds and unit in words."""
        return f"{self.accepts} ({self.unit})" if self.unit else self.accepts

    def read(self, value: Any) -> Any:
        """Return the number as a float, or the result of `finish`."""
        number = finite(value, self.expected)
        is_within = self.above < number < self.below and self.at_least <= number <= self.at_most
        refuse_if(not is_within, self.expected)
        return number if self.finish is None else self.finish(number)

    @property
    def json(self) -> Json:
        """A number, with its bounds."""
        bounds = {
            "exclusiveMinimum": self.above,
            "minimum": self.at_least,
            "exclusiveMaximum": self.below,
            "maximum": self.at_most,
        }
        limits = {name: limit for name, limit in bounds.items() if math.isfinite(limit)}
        return {"type": "number", **limits}


@dataclasses.dataclass(frozen=True, kw_only=True)
class CountType(ValueType):
    """A whole number within bounds; ``form`` and ``finish`` as in `TextType`."""

    kind: ClassVar[str] = "number"
    at_least: int = 1
    at_most: int = LARGEST_COUNT
    form: str = ""
    finish: Finish | None = None

    @property
    def expected(self) -> str:  # type: ignore[override]
        """Bounds in words."""
        last = "up" if self.at_most in (LARGEST_COUNT, NO_LIMIT) else f"to {self.at_most}"
        return self.form or f"a whole number from {self.at_least} {last}"

    def read(self, value: Any) -> Any:
        """Return the number."""
        number = whole(value, self.expected, at_least=self.at_least, at_most=self.at_most)
        return number if self.finish is None else self.finish(number)

    @property
    def json(self) -> Json:
        """A whole number, with its bounds."""
        return {"type": "integer", "minimum": self.at_least, "maximum": self.at_most}


@dataclasses.dataclass(frozen=True)
class ChoiceType(ValueType):
    """One of several words, whole numbers or booleans; ``finish`` as in `TextType`.

    Attributes
    ----------
    options
        The options, or a function that returns them, of options that extensions add to.
    """

    options: tuple[Any, ...] | Callable[[], tuple[Any, ...]]
    finish: Finish | None = dataclasses.field(default=None, kw_only=True)

    @property
    def expected(self) -> str:  # type: ignore[override]
        """All options."""
        return "one of " + ", ".join(show(option) for option in self.words)

    def read(self, value: Any) -> Any:
        """Return the option."""
        if value not in self.words or type(value) is not type(self.words[0]):
            raise ValidationError(self.expected + did_you_mean(value, map(str, self.words)))
        return value if self.finish is None else self.finish(value)

    @property
    def json(self) -> Json:
        """All options."""
        return {"enum": list(self.words)}

    @property
    def words(self) -> tuple[Any, ...]:
        """All options."""
        return self.options() if callable(self.options) else self.options

    def is_meant(self, value: Any) -> bool:
        """Return True for an option; a value of another type has another meaning."""
        return value in self.words and type(value) is type(self.words[0])


@dataclasses.dataclass(frozen=True, kw_only=True)
class TextType(ValueType):
    """A string.

    Attributes
    ----------
    expected
        Accepted values, in words.
    may_be_empty
        True if blank text is valid.
    finish
        Function that converts the string, or raises `ValidationError`.
    """

    kind: ClassVar[str] = "string"
    expected: str = "a string that is not empty"
    may_be_empty: bool = False
    finish: Finish | None = None

    def read(self, value: Any) -> Any:
        """Return the string, or the result of `finish`."""
        is_empty = isinstance(value, str) and not value.strip()
        refuse_if(not isinstance(value, str) or (is_empty and not self.may_be_empty), self.expected)
        return value if self.finish is None else self.finish(value)

    @property
    def json(self) -> Json:
        """A string."""
        return {"type": "string"} if self.may_be_empty else {"type": "string", "pattern": r"\S"}


@dataclasses.dataclass(frozen=True)
class WordType(ValueType):
    """One word, as an alternative to a value of another type; ``finish`` as in `TextType`."""

    word: str
    finish: Finish | None = None

    @property
    def expected(self) -> str:  # type: ignore[override]
        """The word in quotation marks."""
        return f'"{self.word}"'

    def read(self, value: Any) -> Any:
        """Return the word, or the result of `finish`."""
        refuse_if(value != self.word, self.expected)
        return self.word if self.finish is None else self.finish(self.word)

    @property
    def json(self) -> Json:
        """The word."""
        return {"const": self.word}

    @property
    def words(self) -> tuple[Any, ...]:
        """The word."""
        return (self.word,)

    def is_meant(self, value: Any) -> bool:
        """Return True for the word."""
        return bool(value == self.word)


@dataclasses.dataclass(frozen=True, kw_only=True)
class OtherType(ValueType):
    """Values with a separate reader, such as tables with user-defined names.

    Attributes
    ----------
    expected
        Accepted values, in words.
    kinds
        Types of the values in JSON Schema; none: any.
    finish
        Function that reads a value.
    """

    expected: str
    kinds: tuple[str, ...] = ()
    finish: Finish | None = None

    def read(self, value: Any) -> Any:
        """Return the result of `finish` for the value."""
        return value if self.finish is None else self.finish(value)

    @property
    def json(self) -> Json:
        """The types, if they are known."""
        return {"type": list(self.kinds)} if self.kinds else {}

    def is_meant(self, value: Any) -> bool:
        """Return True for a value of one of the types."""
        return kind_of_value(value) in self.kinds


def parse_label(value: Any) -> str:
    """Return ``value`` if it is a name that fits in one line of a table; raise `ValidationError`
    otherwise.
    """
    is_text = isinstance(value, str) and value != ""
    refuse_if(not is_text or value != value.strip() or not value.isprintable(), LABEL_FORM)
    return str(value)


def plain_name(value: Any) -> str:
    """Return ``value`` if it is a name that can safely be used for a directory; raise
    `ValidationError` otherwise.
    """
    fits = isinstance(value, str) and value.strip() == value != "" and value.isprintable()
    refuse_if(not fits or "/" in value or value[0] in ".-~", NAME_FORM)
    refuse_if(len(value.encode()) > _LONGEST_NAME, f"a plain name of at most {_LONGEST_NAME} bytes")
    return str(value)


LABEL = TextType(expected=LABEL_FORM, finish=parse_label)
PLAIN_NAME = TextType(expected=NAME_FORM, finish=plain_name)
