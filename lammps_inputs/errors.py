"""The errors that granwave raises on purpose; every other exception is a bug."""

from __future__ import annotations

from collections.abc import Callable, Iterable


class GranwaveError(Exception):
    """Base of every error that granwave raises on purpose."""


class InputError(GranwaveError, ValueError):
    """The input is wrong; nothing was run and nothing was written.

    Parameters
    ----------
    errors
        One line each: the file, the key, what was found, what was expected, how to mend it.
    """

    def __init__(self, errors: str | Iterable[str]) -> None:
        self.errors: list[str] = [errors] if isinstance(errors, str) else list(errors)
        super().__init__("\n".join(self.errors))

    @property
    def faults(self) -> list[str]:
        """Former name of ``errors``, deprecated."""
        return self.errors

    def __reduce__(self) -> tuple[type[InputError], tuple[list[str]]]:
        return type(self), (self.errors,)


def raise_all(checks: Iterable[Callable[[], object]]) -> None:
    """Do all ``checks``; raise one InputError with the errors of all that failed."""
    errors: list[str] = []
    for check in checks:
        try:
            check()
        except InputError as error:
            errors += error.errors
    if errors:
        raise InputError(errors)


class RunError(GranwaveError, RuntimeError):
    """The input was right, but the computation failed or its result was refused."""
