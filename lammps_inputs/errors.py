"""Errors that granwave raises on purpose; every other exception is a bug."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable

_MOST_ERRORS = 100  # lines of one error


class GranwaveError(Exception):
    """Base class of the errors that granwave raises on purpose."""


class InputError(GranwaveError, ValueError):
    """Error of wrong input; nothing was run and nothing was written.

    Parameters
    ----------
    errors
        Messages, one line each: file, key, what was found, what was expected, how to correct it. Of
        very many the first are kept, and a line with the number of the others.
    """

    def __init__(self, errors: str | Iterable[str]) -> None:
        self.errors: list[str] = [errors] if isinstance(errors, str) else list(errors)
        if (more := len(self.errors) - _MOST_ERRORS) > 1:
            self.errors[_MOST_ERRORS:] = [f"and {more} more errors; correct these first"]
        super().__init__("\n".join(self.errors))

    @property
    def faults(self) -> list[str]:
        """Former name of ``errors``, deprecated since 0.3."""
        warnings.warn(
            "InputError.faults is now called errors; refused from 1.1",
            DeprecationWarning,
            stacklevel=2,
        )
        return self.errors

    def __reduce__(self) -> tuple[type[InputError], tuple[list[str]]]:
        return type(self), (self.errors,)


def raise_all(checks: Iterable[Callable[[], object]]) -> None:
    """Run all ``checks``; raise one InputError with the errors of all that failed."""
    errors: list[str] = []
    for check in checks:
        try:
            check()
        except InputError as error:
            errors += error.errors
    if errors:
        raise InputError(errors)


class RunError(GranwaveError, RuntimeError):
    """Error of a computation that failed, or whose result was refused, although its input was
    right.
    """
