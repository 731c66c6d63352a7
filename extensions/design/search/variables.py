"""Variables of a design: choices and ranges, and the space that they span."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from granwave.lammps_inputs.case.schema import ErrorList, ValidationError, finite, whole

Values = dict[str, Any]  # values of a design by key
_EXPECTED = (
    "a list of choices, or a range {low = 0.004, high = 0.012}, with log = true, integer = true or "
    "step = ..."
)
_RANGE_KEYS = ("low", "high", "log", "integer", "step")
_DIGITS = 6  # significant digits of values in a range
_MOST_STEPS = 10_000  # largest number of values of a range with steps
_STEPS = (0.15, 0.03, 0.006)  # sizes of random changes over the range
_ROUNDING = 1e-9  # fraction of a step by which the last value may exceed the range
_TO_NEIGHBOUR = 0.05  # distance of neighbours in a continuous range over the range
_LOW_END = 0.01  # positions below which a value is at the low end of its range ...
_HIGH_END = 0.99  # ... and above which at the high end
_CHANGED = 1.5  # mean number of changed variables, in addition to a variable that always changes


@dataclasses.dataclass(frozen=True)
class Variable:
    """A variable of a design: a choice, or a number in a range.

    Attributes
    ----------
    key
        Key of the case, as in the design file.
    choices
        Values that it can take; empty for a continuous range.
    low, high, log
        Range, and whether it is searched logarithmically; the smallest and the largest of ordered
        choices.
    ordered
        True if the values are numbers.
    """

    key: str
    choices: tuple[Any, ...] = ()
    low: float = 0.0
    high: float = 1.0
    log: bool = False
    ordered: bool = True

    def value(self, share: float) -> Any:
        """Return the value at a fraction from 0 to 1 of the range, or of the choices."""
        if self.choices:
            return self.choices[min(int(share * len(self.choices)), len(self.choices) - 1)]
        if self.log:
            return _rounded(math.exp(math.log(self.low) + share * math.log(self.high / self.low)))
        return _rounded(self.low + share * (self.high - self.low))

    def share(self, value: float) -> float:
        """Return the position of a number in the range, from 0 to 1."""
        if self.high == self.low:
            return 0.5
        if self.log:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def features(self, value: Any) -> list[float]:
        """Return the coordinates of a value: its position in the range, from 0 to 1, or for words a
        vector such that any two words have the distance 1.
        """
        if self.ordered:
            return [self.share(value)]
        if len(self.choices) == 2:
            return [float(value == self.choices[1])]
        return [math.sqrt(0.5) * (choice == value) for choice in self.choices]

    def changed(self, value: Any, rng: Generator) -> Any:
        """Return a random other value: a near value in a range, any other word."""
        if not self.ordered:
            others = [choice for choice in self.choices if choice != value]
            return others[rng.integers(len(others))] if others else value
        size = _STEPS[rng.integers(len(_STEPS))]
        if self.choices:
            reach = max(1, round(size * len(self.choices)))
            step = int(rng.integers(1, reach + 1))
            if rng.random() >= 0.5:
                step = -step
            place = self.choices.index(value) + step
            return self.choices[min(max(place, 0), len(self.choices) - 1)]
        share = self.share(value) + size * rng.standard_normal()
        return self.value(min(max(share, 0.0), 1.0))

    def neighbours(self, value: Any) -> list[Any]:
        """Return the next value on either side, or all other words."""
        if not self.ordered:
            return [choice for choice in self.choices if choice != value]
        if self.choices:
            place = self.choices.index(value)
            return [self.choices[n] for n in (place - 1, place + 1) if 0 <= n < len(self.choices)]
        shares = [self.share(value) + step for step in (-_TO_NEIGHBOUR, _TO_NEIGHBOUR)]
        return [self.value(share) for share in shares if 0 <= share <= 1]

    def edge(self, value: Any) -> str:
        """Return the end of the range, ``low`` or ``high``, at which a value is; empty between the
        ends, and for words.
        """
        if not self.ordered or self.high == self.low:
            return ""
        share = self.share(value)
        if share < _LOW_END:
            return "low"
        return "high" if share > _HIGH_END else ""


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


def read_variable(key: str, value: Any) -> Variable:
    """Read a variable from its value in a design file.

    Raises
    ------
    ValidationError
        The value is no list of choices, and no range.
    """
    if isinstance(value, list):
        return _read_choices(key, value)
    if isinstance(value, Mapping) and {"low", "high"} <= set(value) <= set(_RANGE_KEYS):
        return _read_range(key, value)
    raise ValidationError(_EXPECTED)


def _read_choices(key: str, values: list[Any]) -> Variable:
    choices = tuple(choice for n, choice in enumerate(values) if choice not in values[:n])
    if not choices:
        raise ValidationError("at least one choice")
    if any(isinstance(choice, bool) or not isinstance(choice, int | float) for choice in choices):
        return Variable(key, choices, ordered=False)
    numbers = tuple(sorted(choices, key=lambda choice: finite(choice, "numbers that are finite")))
    return Variable(key, numbers, float(numbers[0]), float(numbers[-1]))


def _read_range(key: str, table: Mapping[str, Any]) -> Variable:
    log = table.get("log", False)
    integer = table.get("integer", False)
    if not isinstance(log, bool) or not isinstance(integer, bool):
        raise ValidationError(_EXPECTED)
    low = _read_end(table["low"], integer=integer)
    high = _read_end(table["high"], integer=integer)
    if high <= low:
        raise ValidationError(f"a range whose high ({high:g}) is above its low ({low:g})")
    if log and low <= 0:
        raise ValidationError("a range of positive numbers, as log = true")
    if "step" not in table and not integer:
        return Variable(key, (), low, high, log)
    step = finite(table["step"], _EXPECTED) if "step" in table else 1.0
    n_steps = (high - low) / step if step > 0 else math.inf
    if not 1 <= n_steps + _ROUNDING <= _MOST_STEPS or (integer and step != round(step)):
        raise ValidationError(
            f"a range of 1 to {_MOST_STEPS} steps above 0, whole ones of integers"
        )
    numbers = [low + n * step for n in range(int(n_steps + _ROUNDING) + 1)]
    choices = tuple(round(number) if integer else _rounded(number) for number in numbers)
    return Variable(key, choices, float(choices[0]), float(choices[-1]), log)


def _read_end(value: Any, *, integer: bool) -> float:
    """Return an end of a range as a number."""
    if integer:
        return float(whole(value, _EXPECTED, at_least=-(10**9)))
    return finite(value, _EXPECTED)


def read_variables(tables: Mapping[str, Any], name: str, errors: ErrorList) -> list[Variable]:
    """Read variables by key; faults are added to ``errors``."""
    variables = []
    for key, value in tables.items():
        try:
            variables.append(read_variable(key, value))
        except ValidationError as error:
            errors.add_wrong(f"{name}.{key}", value, error)
    return variables


@dataclasses.dataclass(frozen=True)
class Space:
    """Space of all designs with the given variables."""

    variables: tuple[Variable, ...]

    @property
    def size(self) -> float:
        """Number of designs; infinite with a continuous range."""
        return math.prod(
            len(variable.choices) if variable.choices else math.inf for variable in self.variables
        )

    def all(self) -> Iterator[Values]:
        """Yield all designs of a finite space."""
        keys = [variable.key for variable in self.variables]
        for values in itertools.product(*(variable.choices for variable in self.variables)):
            yield dict(zip(keys, values, strict=True))

    def at(self, shares: Sequence[float]) -> Values:
        """Return the design at a fraction of each variable's range."""
        return {
            variable.key: variable.value(share)
            for variable, share in zip(self.variables, shares, strict=True)
        }

    def features(self, designs: Sequence[Values]) -> NDArray[np.float64]:
        """Return the coordinates of designs: (n, number of coordinates)."""
        return np.array([self._features_of(design) for design in designs])

    def _features_of(self, design: Values) -> list[float]:
        """Return the coordinates of a design, variable by variable."""
        coordinates: list[float] = []
        for variable in self.variables:
            coordinates += variable.features(design[variable.key])
        return coordinates

    def changed(self, design: Values, rng: Generator) -> Values:
        """Return a design with one or a few variables changed."""
        is_changed = rng.random(len(self.variables)) < _CHANGED / len(self.variables)
        is_changed[rng.integers(len(self.variables))] = True
        values = {}
        for variable, changes in zip(self.variables, is_changed, strict=True):
            value = design[variable.key]
            values[variable.key] = variable.changed(value, rng) if changes else value
        return values

    def neighbours(self, design: Values) -> Iterator[tuple[str, Values]]:
        """Yield the designs with one variable at its next value, with the key of the variable."""
        for variable in self.variables:
            for value in variable.neighbours(design[variable.key]):
                yield variable.key, {**design, variable.key: value}
