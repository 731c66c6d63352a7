"""A value of several runs that are compared: its ratio, or the reason why it has none."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain

from granwave.analysis.document.model import Cell
from granwave.analysis.formatting.numbers import interval_in_any_unit, number, quantity_in
from granwave.analysis.measures.law_range import BEYOND_LAW, BEYOND_LAW_MEANING
from granwave.analysis.measures.zone_resolution import percent_with_error
from granwave.analysis.reports.comparison.ends import AT_THE_END
from granwave.analysis.reports.sentences import share

ROUNDING = 1e-12  # value / largest value of the runs that counts as zero
_NO_FRACTION = 1e-3  # fraction that counts as zero next to zero
#: In place of the ratio of a value that the end of a run truncates, that still grows at this end,
#: or that a boundary limits.
TRUNCATED = "truncated"
STILL_GROWING = "still growing"
LIMITED = "limited"
#: The same for a value of a plastic zone that the mesh of a run does not resolve.
NOT_RESOLVED = "not resolved"
#: The same for a value that kinds of runs define differently.
DIFFERENT_MEANING = "defined differently"
MARK = "*"  # after a value that the end of its run truncates
PARTIAL = "Truncated by the end of the run"
_PAIR = 2
_FRACTION = "_fraction"  # end of the names of fractions


@dataclass(frozen=True)
class ComparedValue:
    """A value of the summary in each run.

    Attributes
    ----------
    name
        Its key in summary.json.
    values
        By run; None where a run does not have it: (n_runs,).
    label
        Name in words.
    unit
        SI unit; empty if there is none.
    is_truncated
        True if ends of runs truncate it so that too few runs are complete, or if it still grows; it
        then has no ratio.
    incomplete
        Positions of the runs whose end truncates it; the ratio is of the other runs.
    growing
        Positions of the runs at whose end it still grows.
    is_limited
        True for a size of plastic zones of which a boundary limits at least one, so that it has no
        ratio.
    is_growing
        True for a truncated value if it still grows at the end of a run.
    is_of_input
        True for an energy in J or a size of the plastic zone, of runs with different inputs, which
        depends on the input.
    differs_in_meaning
        True for a value that the kinds of these runs define differently, so that it has no ratio.
    is_unresolved
        True for a value of plastic zones of which the mesh of a run does not resolve at least one,
        so that it has no ratio.
    errors
        Large uncertainties, by run; None where there is none: (n_runs,), or empty.
    beyond_law
        Positions of the runs of which contacts beyond the range of the law determine the value.
    """

    name: str
    values: tuple[float | None, ...]
    label: str
    unit: str
    is_truncated: bool = False
    is_limited: bool = False
    is_growing: bool = False
    is_of_input: bool = False
    differs_in_meaning: bool = False
    incomplete: frozenset[int] = frozenset()
    growing: frozenset[int] = frozenset()
    is_unresolved: bool = False
    errors: tuple[float | None, ...] = ()
    beyond_law: frozenset[int] = frozenset()

    @property
    def places_left_out(self) -> frozenset[int]:
        """Positions of the runs that are not compared, because others are complete."""
        return frozenset() if self.is_truncated and not self.is_growing else self.incomplete

    @property
    def marked_places(self) -> frozenset[int]:
        """Positions of the runs whose end truncates it, or at whose end it still grows; for two
        runs the latter only, since a word in place of the ratio shows the former.
        """
        return self.growing | (self.incomplete if len(self.values) > _PAIR else frozenset())

    @property
    def compared(self) -> list[float | None]:
        """Values of the runs that are compared: of all, if the value is truncated."""
        return [value for n, value in enumerate(self.values) if n not in self.places_left_out]

    @property
    def is_cut(self) -> bool:
        """True if the end of any run truncates it."""
        return bool(self.incomplete) or (self.is_truncated and not self.is_growing)

    @property
    def compared_numbers(self) -> list[float]:
        """Values of the runs that are compared, of those that have it."""
        return [value for value in self.compared if value is not None]

    @property
    def numbers(self) -> list[float]:
        """Values of the runs that have it."""
        return [value for value in self.values if value is not None]

    @property
    def is_zero(self) -> bool:
        """True if it is zero in every run."""
        return not any(self.numbers)

    @property
    def ratio(self) -> float | None:
        """Ratio of the second to the first value of two runs; for more runs, of the largest to the
        smallest magnitude, without the runs whose end truncates the value.

        None for a single run, if a compared run has no value or the value zero, if the value is
        truncated, still grows or is limited, or if runs define it differently.
        """
        numbers = self.compared_numbers
        if self.without_ratio or None in self.compared or not all(numbers):
            return None
        if len(numbers) < 2:
            return None
        if len(self.values) == _PAIR:
            return numbers[1] / numbers[0]
        smallest, *_, largest = sorted(numbers, key=abs)
        return largest / smallest

    @property
    def without_ratio(self) -> str:
        """Words in place of the ratio of a value that is truncated, still grows, is limited or not
        resolved, or that runs define differently; empty otherwise.
        """
        if self.is_unresolved and not self.differs_in_meaning:
            return NOT_RESOLVED
        return self._without_ratio_if_resolved

    @property
    def _without_ratio_if_resolved(self) -> str:
        """The same words of a value whose uncertainty is disregarded."""
        if self.differs_in_meaning:
            return DIFFERENT_MEANING
        if self.is_limited:
            return LIMITED
        if self.is_truncated and not self.is_growing:
            return TRUNCATED
        return STILL_GROWING if self.is_growing else ""

    @property
    def is_complete(self) -> bool:
        """True for a value that every run has and defines in the same way, that neither the end of
        a run nor a boundary limits, and that is resolved or has a known uncertainty.
        """
        return self._is_known and not self.incomplete and None not in self.values

    @property
    def has_complete_runs(self) -> bool:
        """True for a value that the runs have whose end does not truncate it, that neither grows
        nor is limited, and that is resolved or has a known uncertainty.
        """
        return self._is_known and None not in self.compared

    @property
    def _is_known(self) -> bool:
        """True for a value that has a ratio, or has none only since it is uncertain."""
        if self.is_unresolved and not any(self.errors):
            return False
        return not self._without_ratio_if_resolved

    @property
    def is_main(self) -> bool:
        """True for a complete value that is no value at an arbitrary instant, and no energy or size
        of runs with different inputs.
        """
        return self.is_complete and not self.is_of_input and self.name not in AT_THE_END

    @property
    def is_negligible(self) -> bool:
        """True for fractions that are zero in a run and hardly more in the others."""
        sizes = [abs(number) for number in self.compared_numbers]
        is_fraction = self.name.endswith(_FRACTION)
        return is_fraction and min(sizes, default=0.0) == 0 and max(sizes) < _NO_FRACTION

    @property
    def is_within_errors(self) -> bool:
        """True if the values agree within their uncertainties."""
        if not any(self.errors):
            return False
        known = [
            (value, error or 0.0)
            for value, error in zip(self.values, self.errors, strict=True)
            if value is not None
        ]
        lowest = min(value + error for value, error in known)
        highest = max(value - error for value, error in known)
        return highest <= lowest

    @property
    def spread(self) -> float:
        """Logarithm of largest over smallest magnitude; infinite for zero next to a number."""
        numbers = self.compared_numbers
        sizes = [abs(number) for number in numbers]
        if len(sizes) < 2 or not any(sizes):
            return 0.0
        if min(sizes) <= ROUNDING * max(sizes) or min(numbers) < 0 < max(numbers):
            return math.inf
        return math.log(max(sizes) / min(sizes))

    def text(self, value: float) -> str:
        """Return a value in words: ``1.2 kN``, ``34 %``, with its uncertainty ``0.32 ± 0.23 %``."""
        error = self.error_at(self.values.index(value)) if value in self.values else None
        if error and self.name.endswith(_FRACTION):
            return percent_with_error(value, error)
        if error:
            return interval_in_any_unit(value, error, self.unit)
        if self.name.endswith(_FRACTION):
            return share(value)
        prefixed = self.unit.isalpha() and self.unit != "kg"
        return quantity_in(value, self.unit if prefixed else "") + (
            f" {self.unit}" if self.unit and not prefixed else ""
        )

    def error_at(self, place: int) -> float | None:
        """Return the uncertainty of the value of the run at a position; None if it is small or
        unknown.
        """
        return self.errors[place] if self.errors else None


def digits(number: float | None) -> str:
    """Return a number with as many digits as equal values have."""
    return "" if number is None else f"{number:.9e}"


def marked(cell: Cell, *, is_marked: bool) -> Cell:
    """Return the cell of a value, with the mark of a value that the end of its run truncates."""
    if not is_marked or cell.value is None:
        return cell
    meaning = f"{cell.meaning} {PARTIAL}.".lstrip()
    return replace(cell, text=f"{cell.text}{MARK}", meaning=meaning)


def footnotes_of_marks(rows: Iterable[Sequence[Cell]]) -> tuple[str, ...]:
    """Return the meaning of the mark of truncated values below a table, if any cell has it."""
    has_marks = any(cell.text.endswith(MARK) for cell in chain.from_iterable(rows))
    return (f"{MARK} {PARTIAL}.",) if has_marks else ()


def marked_beyond_law(cell: Cell, *, is_beyond: bool) -> Cell:
    """Return the cell of a value, with the mark of contacts beyond the range of the law."""
    if not is_beyond or cell.value is None:
        return cell
    return replace(cell, text=f"{cell.text} {BEYOND_LAW}", meaning=f"{BEYOND_LAW_MEANING}.")


def factor(ratio: float) -> str:
    """Return a ratio as text with three digits."""
    return number(ratio)
