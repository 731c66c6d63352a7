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

Values = dict[str, Any]  # of a design, by key
_EXPECTED = "a list of choices, or a range {low = 0.004, high = 0.012}, with log = true, integer = true or step = ..."
_RANGE_KEYS = ("low", "high", "log", "integer", "step")
_DIGITS = 6  # of values in a range
_MOST_STEPS = 10_000  # of a range that counts as a list of values
_STEPS = (0.15, 0.03, 0.006)  # of a change of a variable, over its range: one of them at random


@dataclasses.dataclass(frozen=True)
class Variable:
    """A variable of a design: one of some choices, or a number in a range.

    Attributes
    ----------
    key
        Key of the case, as in the design file.
    choices
        The values that it can take; empty for a continuous range.
    low, high, log
        Range, and whether it is searched in the logarithm; of ordered choices the smallest and the
        largest.
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
        """Return the value at a share from 0 to 1 of the range, or of the choices."""
        if self.choices:
            return self.choices[min(int(share * len(self.choices)), len(self.choices) - 1)]
        if self.log:
            return _rounded(math.exp(math.log(self.low) + share * math.log(self.high / self.low)))
        return _rounded(self.low + share * (self.high - self.low))

    def share(self, value: float) -> float:
        """Return the place of a number in the range, from 0 to 1."""
        if self.high == self.low:
            return 0.5
        if self.log:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def features(self, value: Any) -> list[float]:
        """Return the coordinates of a value: its share of the range, or a vector for words, a
        distance of 1 apart.
        """
        if self.ordered:
            return [self.share(value)]
        if len(self.choices) == 2:
            return [float(value == self.choices[1])]
        return [math.sqrt(0.5) * (choice == value) for choice in self.choices]

    def changed(self, value: Any, rng: Generator) -> Any:
        """Return another value at random: near by in a range, any in choices of words."""
        if not self.ordered:
            others = [choice for choice in self.choices if choice != value]
            return others[rng.integers(len(others))] if others else value
        size = _STEPS[rng.integers(len(_STEPS))]
        if self.choices:
            place = self.choices.index(value)
            reach = max(1, round(size * len(self.choices)))
            step = int(rng.integers(1, reach + 1)) * (1 if rng.random() < 0.5 else -1)
            return self.choices[min(max(place + step, 0), len(self.choices) - 1)]
        return self.value(min(max(self.share(value) + size * rng.standard_normal(), 0.0), 1.0))

    def neighbours(self, value: Any) -> list[Any]:
        """Return the next values to either side; of words all others."""
        if not self.ordered:
            return [choice for choice in self.choices if choice != value]
        if self.choices:
            place = self.choices.index(value)
            return [self.choices[n] for n in (place - 1, place + 1) if 0 <= n < len(self.choices)]
        shares = [self.share(value) + step for step in (-0.05, 0.05)]
        return [self.value(share) for share in shares if 0 <= share <= 1]

    def edge(self, value: Any) -> str:
        """Return the end of the range that a value stands at, ``low`` or ``high``; empty if at
        none, or for words.
        """
        if not self.ordered or self.high == self.low:
            return ""
        share = self.share(value)
        return "low" if share < 0.01 else "high" if share > 0.99 else ""


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


def read_variable(key: str, value: Any) -> Variable:
    """Read a variable from its value in a design file; raise `ValidationError` if it is none."""
    if isinstance(value, list):
        choices = tuple(one for n, one in enumerate(value) if one not in value[:n])
        if not choices:
            raise ValidationError("at least one choice")
        if any(isinstance(one, bool) or not isinstance(one, int | float) for one in choices):
            return Variable(key, choices, ordered=False)
        ordered = tuple(sorted(choices, key=lambda one: finite(one, "numbers that are finite")))
        return Variable(key, ordered, float(ordered[0]), float(ordered[-1]))
    if not isinstance(value, Mapping) or not {"low", "high"} <= set(value) <= set(_RANGE_KEYS):
        raise ValidationError(_EXPECTED)
    log = value.get("log", False)
    integer = value.get("integer", False)
    if not isinstance(log, bool) or not isinstance(integer, bool):
        raise ValidationError(_EXPECTED)
    low, high = (float(whole(value[end], _EXPECTED, at_least=-(10**9))) if integer else finite(value[end], _EXPECTED)
                 for end in ("low", "high"))  # fmt: skip
    if high <= low:
        raise ValidationError(f"a range whose high ({high:g}) is above its low ({low:g})")
    if log and low <= 0:
        raise ValidationError("a range of positive numbers, as log = true")
    step = finite(value["step"], _EXPECTED) if "step" in value else float(integer)
    if "step" not in value and not integer:
        return Variable(key, (), low, high, log)
    count = (high - low) / step if step > 0 else math.inf
    if not 1 <= count + 1e-9 <= _MOST_STEPS or (integer and step != round(step)):
        raise ValidationError(
            f"a range of 1 to {_MOST_STEPS} steps above 0, whole ones of integers"
        )
    numbers = [low + n * step for n in range(int(count + 1e-9) + 1)]
    choices = tuple(round(one) if integer else _rounded(one) for one in numbers)
    return Variable(key, choices, float(choices[0]), float(choices[-1]), log)


def read_variables(tables: Mapping[str, Any], name: str, errors: ErrorList) -> list[Variable]:
    """Read variables by key; faults go into ``errors``."""
    found = []
    for key, value in tables.items():
        try:
            found.append(read_variable(key, value))
        except ValidationError as error:
            errors.add_wrong(f"{name}.{key}", value, error)
    return found


@dataclasses.dataclass(frozen=True)
class Space:
    """All designs that some variables make."""

    variables: tuple[Variable, ...]

    @property
    def size(self) -> float:
        """Number of designs; infinite with a continuous range."""
        return math.prod(len(one.choices) if one.choices else math.inf for one in self.variables)

    def all(self) -> Iterator[Values]:
        """Give all designs of a finite space."""
        keys = [one.key for one in self.variables]
        for values in itertools.product(*(one.choices for one in self.variables)):
            yield dict(zip(keys, values, strict=True))

    def at(self, shares: Sequence[float]) -> Values:
        """Return the design at a share of each variable's range."""
        return {
            one.key: one.value(share) for one, share in zip(self.variables, shares, strict=True)
        }

    def features(self, designs: Sequence[Values]) -> NDArray[np.float64]:
        """Return the coordinates of designs: (n, number of coordinates)."""
        return np.array(
            [[x for one in self.variables for x in one.features(d[one.key])] for d in designs]
        )

    def changed(self, design: Values, rng: Generator) -> Values:
        """Return a design with one variable changed, or a few."""
        chosen = rng.random(len(self.variables)) < 1.5 / len(self.variables)
        chosen[rng.integers(len(self.variables))] = True
        return {
            one.key: one.changed(design[one.key], rng) if change else design[one.key]
            for one, change in zip(self.variables, chosen, strict=True)
        }

    def neighbours(self, design: Values) -> Iterator[tuple[str, Values]]:
        """Give the designs with one variable at its next value, with that variable's key."""
        for one in self.variables:
            for value in one.neighbours(design[one.key]):
                yield one.key, {**design, one.key: value}
