"""Parts of ``granwave check`` in addition to the plan: rows, values and lines."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from granwave.lammps_inputs.planning.impact_input import ImpactInput

Rows = Iterable[tuple[str, str]]


@dataclasses.dataclass(frozen=True)
class CheckPart:
    """Additions to the output of ``granwave check``; each is optional.

    Attributes
    ----------
    rows
        Label and text of rows of the table, above memory, disk and time; a text that is empty is
        omitted.
    values
        Values by name that ``--json`` shows above memory, disk and time.
    lines
        Lines below the table.
    further_values
        Values by name that ``--json`` shows below memory, disk and time.
    """

    rows: Sequence[tuple[str, str]] = ()
    values: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    lines: Sequence[str] = ()
    further_values: Mapping[str, Any] = dataclasses.field(default_factory=dict)


def input_rows(inputs: ImpactInput | None, *, at_most: bool = False) -> Rows:
    """Return rows of the energy and the velocity of an impact, if they apply.

    Parameters
    ----------
    at_most
        True if the energy is an upper bound.
    """
    if inputs is None or not inputs.energy:
        return
    bound = "at most " if at_most else ""
    yield "energy in", f"{bound}{inputs.energy:.6g} J"
    label = "energy normalised"
    units = (
        (inputs.energy_normalised, "F_y alpha_y of a contact"),
        (inputs.energy_continuum, "sigma_y^2 D^3/E, as in the continuum"),
    )
    for value, unit in units:
        if value is not None:
            yield label, f"{bound}{value:.6g} {unit}"
            label = ""
    if inputs.velocity_normalised is not None:
        yield "velocity normalised", f"{inputs.velocity_normalised:.6g}"


def input_values(inputs: ImpactInput, *, at_most: bool = False) -> dict[str, Any]:
    """Return values of the energy and the velocity of an impact; parameters as of `input_rows`."""
    normalised = inputs.energy_normalised
    if normalised is None:
        normalised = inputs.energy_continuum
    return {
        "energy_input_J": inputs.energy,
        "energy_input_at_most": at_most,
        "energy_input_normalised": normalised,
        "energy_input_over_sigma2_D3_E": inputs.energy_continuum,
        "velocity_normalised": inputs.velocity_normalised,
    }
