"""Result of a search for a design, for scripts and notebooks."""

from __future__ import annotations

import dataclasses
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granwave.analysis.errors import MissingOutputError
from granwave.extensions.design.files import DESIGN_OUTCOME, DESIGN_TABLE, has_outcome
from granwave.lammps_inputs.files import read_json

if TYPE_CHECKING:
    import pandas


@dataclasses.dataclass(frozen=True)
class Designs:
    """Result of a search for a design.

    Attributes
    ----------
    directory
        Directory of the results.
    """

    directory: Path

    @cached_property
    def table(self) -> pandas.DataFrame:
        """Table of all designs, from designs.csv; units are part of the names."""
        import pandas

        return pandas.read_csv(self.directory / DESIGN_TABLE)

    @cached_property
    def outcome(self) -> dict[str, Any]:
        """Content of design.json."""
        return read_json(self.directory / DESIGN_OUTCOME) or {}

    @property
    def best(self) -> dict[str, Any] | None:
        """The best design: its variables, objective, mass, height and checks; None if none meets
        the limits.
        """
        found: dict[str, Any] | None = self.outcome.get("best")
        return found

    def _repr_html_(self) -> str:
        return self.table.to_html()


def load_designs(directory: Path) -> Designs:
    """Return the result of a search that ``granwave design`` left in a directory.

    Raises
    ------
    MissingOutputError
        The search is not finished.
    """
    if not has_outcome(directory):
        raise MissingOutputError(
            f"{directory / DESIGN_OUTCOME}: is missing, since the search is not finished; resume "
            f"with  granwave design FILE -o {directory} --resume"
        )
    return Designs(directory)
