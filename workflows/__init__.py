"""Drives LAMMPS: one run from case to figures (`run_case`), the built-in studies, the command line."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from granwave.workflows.driver import Outcome, run_case

__all__ = ["Outcome", "run_case"]


def __getattr__(name: str) -> Any:
    # the command line starts here too, and most of its words need neither MPI nor matplotlib
    if name in __all__:
        from granwave.workflows import driver

        return getattr(driver, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
