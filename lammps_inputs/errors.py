"""Errors that granwave raises on purpose; every other exception is a bug."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

_MOST_ERRORS = 100  # most lines of one error
_MOST_OF_TABLE = 5  # most errors of one table of measurements
SHOWN_CHARACTERS = 60


class GranwaveError(Exception):
    """Base class of the errors that granwave raises on purpose."""


@dataclasses.dataclass(frozen=True)
class Mismatch:
    """Value that is not valid: the found value, the valid values, and the remedy.

    Attributes
    ----------
    found
        The value, as in a file, or a description of the actual content.
    expected
        Valid values; empty if the remedy says it all.
    remedy
        Remedy, if it does not follow from the expected values.
    """

    found: str
    expected: str = ""
    remedy: str = ""

    def __str__(self) -> str:
        expected = f", expected {self.expected}" if self.expected else ""
        remedy = f"; {self.remedy}" if self.remedy else ""
        return f"found {self.found}{expected}{remedy}"


@dataclasses.dataclass(frozen=True, kw_only=True)
class InputFault:
    """One fault of an input.

    Attributes
    ----------
    source
        File, as shown to the user; empty if none is concerned.
    line
        Line of the file, counted from 1, which the sentence names too; None if it is not known.
    key
        Dotted key; empty if none is concerned.
    found, expected, remedy
        As in `Mismatch`; empty where the fault is a sentence.
    sentence
        The fault in words, where it is no mismatch.
    changed
        True if the key is none of the file, but of the changes of a case that were given with it.
    """

    source: str = ""
    line: int | None = None
    key: str = ""
    found: str = ""
    expected: str = ""
    remedy: str = ""
    sentence: str = ""
    changed: bool = False

    @property
    def message(self) -> str:
        """The fault without its location."""
        return self.sentence or str(Mismatch(self.found, self.expected, self.remedy))

    @property
    def place(self) -> str:
        """File and key; empty if there is none."""
        return ": ".join(part for part in (self.source, cut(self.key)) if part)

    def __str__(self) -> str:
        return f"{self.place}: {self.message}" if self.place else self.message

    def inside(self, source: str) -> InputFault:
        """Return the fault as a fault of a file that names the present file, or that contains the
        key.
        """
        return dataclasses.replace(
            self, source=": ".join(part for part in (source, self.source) if part), changed=False
        )

    def outside(self, source: str) -> InputFault:
        """Return the fault without its source, if it is the given source."""
        return dataclasses.replace(self, source="") if self.source == source else self


def cut(text: str) -> str:
    """Cut ``text`` to a readable length."""
    return text if len(text) <= SHOWN_CHARACTERS else text[: SHOWN_CHARACTERS - 3] + "..."


def fault_of(
    what: str | Mismatch, *, source: str = "", key: str = "", changed: bool = False
) -> InputFault:
    """Return the fault of a key, from a sentence or a mismatch."""
    place = InputFault(source=source, key=key, changed=changed)
    if isinstance(what, Mismatch):
        return dataclasses.replace(
            place, found=what.found, expected=what.expected, remedy=what.remedy
        )
    return dataclasses.replace(place, sentence=what)


class InputError(GranwaveError, ValueError):
    """Error of invalid input; nothing was run or written.

    Parameters
    ----------
    faults
        The faults, or sentences. Of very many faults only the first are kept, with the number of
        the others.

    Attributes
    ----------
    items
        The faults: file, key, found value, expected values, remedy.
    """

    def __init__(self, faults: str | InputFault | Iterable[str | InputFault]) -> None:
        listed = [faults] if isinstance(faults, str | InputFault) else list(faults)
        items = [fault_of(one) if isinstance(one, str) else one for one in listed]
        more = len(items) - _MOST_ERRORS
        if more > 1:
            items[_MOST_ERRORS:] = [fault_of(f"and {more} more errors; correct these first")]
        self.items: list[InputFault] = items
        super().__init__("\n".join(self.errors))

    @property
    def errors(self) -> list[str]:
        """The faults as text, one line each."""
        return [str(item) for item in self.items]

    if not TYPE_CHECKING:  # type checkers reject the former name by themselves

        def __getattr__(self, name: str) -> NoReturn:
            """Reject ``faults``, the former name of ``errors``, with the present one."""
            if name == "faults":
                raise AttributeError("InputError.faults is now called errors; removed in 1.1")
            raise AttributeError(f"'{type(self).__name__}' object has no attribute '{name}'")

    def __reduce__(self) -> tuple[type[InputError], tuple[list[InputFault]]]:
        return type(self), (self.items,)


def raise_all(checks: Iterable[Callable[[], object]]) -> None:
    """Run all ``checks``; raise one InputError with the errors of all that failed."""
    faults: list[InputFault] = []
    for check in checks:
        try:
            check()
        except InputError as error:
            faults += error.items
    if faults:
        raise InputError(faults)


class RunError(GranwaveError, RuntimeError):
    """Error of a computation that failed, or whose result was rejected, although its input was
    valid.
    """


def first_errors(path: str | Path, errors: Sequence[str]) -> list[str]:
    """Return the first errors of a table, and the number of the others."""
    others = len(errors) - _MOST_OF_TABLE
    if others <= 0:
        return list(errors)
    return [*errors[:_MOST_OF_TABLE], f"{path}: {others} more errors"]
