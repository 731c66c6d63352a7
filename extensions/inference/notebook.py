"""Inferred forces for scripts and notebooks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.notebook.run import Run, Values
from granwave.extensions.inference.files import INFERRED_FORCES, INFERRED_GRAINS, MADE_MEASUREMENT
from granwave.extensions.inference.forces.tables import in_words

if TYPE_CHECKING:
    from pandas import DataFrame


class InferredForces(Values):
    """Inferred contact forces: a mapping of the values of their ``summary.json``, with tables.

    Parameters
    ----------
    summary
        Content of summary.json.
    forces, grains, measurement
        Columns of the tables.

    Attributes
    ----------
    forces
        Rows of forces.csv, one for each candidate contact.
    grains
        Rows of grains.csv, the residuals of each grain.
    measurement
        The synthetic measurement of a run; None for a table.
    """

    def __init__(
        self, summary: Mapping[str, Any], forces: Any, grains: Any, measurement: Any = None
    ) -> None:
        import pandas

        super().__init__(summary)
        self.forces: DataFrame = pandas.DataFrame(dict(forces))
        self.grains: DataFrame = pandas.DataFrame(dict(grains))
        self.measurement: DataFrame | None = (
            None if measurement is None else pandas.DataFrame(dict(measurement))
        )

    def __repr__(self) -> str:
        return in_words(self)


def load_inferred(directory: Path) -> InferredForces:
    """Return the forces that ``granwave infer`` wrote to a directory.

    Raises
    ------
    MissingOutputError
        There is no summary.
    OutputFormatError
        A table is missing or damaged.
    """
    import pandas

    summary = Run(directory).summary
    made = directory / MADE_MEASUREMENT
    try:
        forces, grains = (
            pandas.read_csv(directory / name) for name in (INFERRED_FORCES, INFERRED_GRAINS)
        )
        return InferredForces(
            summary, forces, grains, pandas.read_csv(made) if made.is_file() else None
        )
    except (OSError, ValueError) as error:
        raise OutputFormatError(
            f"{directory}: {INFERRED_FORCES} or {INFERRED_GRAINS} cannot be read: {error}"
        ) from None
