"""Texts, tables and figures of runs of finite elements in a report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from granwave.analysis.document.model import show
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.reports.kinds import ReportKind, ReportRun, Symbol, unit_of_energy
from granwave.extensions.continuum.files import CONTINUUM
from granwave.extensions.continuum.punch.resolution import doubts
from granwave.extensions.continuum.runs import ContinuumRun, SphereContactRun, read_elements

_OF_PUNCH = (
    "the unit of energies of the punch, with its diameter D and the yield strength and modulus of "
    "the block"
)
_LEDGER = {
    "kinetic": ("kinetic", "punch"),
    "elastic": ("elastic",),
    "dissipated": ("plastic",),
}
_NUMERICAL = {
    "viscous": "artificial viscosity",
    "hourglass": "hourglass control",
    "contact": "contact",
    "damping": "damping",
}
_LOOKS = {
    "plastic_strain": "The coloured region is the plastic zone. Of a small zone only the edge of "
    "the punch is shown.",
    "plastic_zone": "From the first yield to the end of yielding. The outline is the largest zone; "
    "the material outside it remained elastic.",
    "plastic_zone_volume": "The wave has passed when the zone at one instant decreases after its "
    "peak.",
    "punch": "During the contact: when the velocity is constant, the punch has left the block.",
    "von_mises": "At the largest plastic zone, or at the largest stress if nothing yields. Colours "
    "at the yield strength show the zone that yields at this instant.",
}


class ElementKind(ReportKind):
    """Runs of finite elements: a punch on a block, or two spheres in contact."""

    result_kind = CONTINUUM
    noun = "continuum run"
    accepted_error = 2e-2  # accepted error of results that do not record it
    energies = ("energy_punch_J", "energy_viscous_J", "energy_hourglass_J")
    ledger = _LEDGER
    numerical = _NUMERICAL
    limits = "A continuum run above the accepted error is stopped."
    main_figures = ("plastic_strain", "von_mises", "energies")
    looks = _LOOKS

    def study_run(self, run: ReportRun) -> ContinuumRun | SphereContactRun | None:
        """Return a run in the form that studies use."""
        return read_elements(run.label, run.directory, run.summary)

    def name_values(self, run: ReportRun, values: dict[str, str]) -> None:
        """Give the largest force of two spheres the same name as in a run."""
        if run.number("max_force_N") is not None:
            values.setdefault("peak_force_N", values["max_force_N"])

    def body(self, case: Mapping[str, Any]) -> str:
        """Return a description of a case; empty for a packing."""
        if "punch.diameter" in case:
            mass = f" and {show(case['punch.mass'])} kg" if "punch.mass" in case else ""
            return f"punch of {quantity_in(case['punch.diameter'], 'm')}{mass} on a block"
        if "sphere.radius" in case:
            return f"two spheres in contact, R = {quantity_in(case['sphere.radius'], 'm')}"
        return ""

    def load_keys(self, case: Mapping[str, Any]) -> dict[str, Any]:
        """Return the velocity of the punch as the velocity of an impact."""
        return {"load.velocity": case["punch.velocity"]} if "punch.velocity" in case else {}

    def energy_unit(self, run: ReportRun) -> float:
        """Return the unit with the diameter of the punch, J."""
        return unit_of_energy(run, "punch.diameter")

    def doubts(self, summary: Mapping[str, Any]) -> list[str]:
        """Return warnings on large strains, an unresolved plastic zone and viscous losses."""
        return doubts(summary)

    def symbols(self, runs: Sequence[ReportRun]) -> list[Symbol]:
        """Return the unit of energies of a punch."""
        units = [unit for unit in map(self.energy_unit, runs) if unit]
        return [("sigma_y^2 D^3/E", units, "J", _OF_PUNCH)]


REPORT_KINDS = (ElementKind(),)
