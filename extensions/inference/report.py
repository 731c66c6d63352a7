"""Texts, tables and figures of inferred contact forces in a report."""

from __future__ import annotations

from granwave.analysis.document.model import show
from granwave.analysis.reports.kinds import ReportKind, ReportRun
from granwave.analysis.reports.sentences import printed, sentences
from granwave.extensions.inference.files import INFERENCE
from granwave.extensions.inference.forces.tables import ENTRIES, QUANTITIES

_KEYS = (
    "n_grains",
    "n_contacts",
    "n_significant_contacts",
    "n_loaded_contacts",
    "n_sliding_contacts",
    "largest_force_N",
    "mean_normal_force_N",
    "noise",
    "true_force_error",
    "standard_error_fraction",
    "acceleration_error",
    "residual_fraction",
    "chi2_per_equation",
    "youngs_modulus_Pa",
    "youngs_modulus_error_Pa",
    "n_equations",
    "n_unknowns",
)
_IN_PER_CENT = (
    "noise",
    "true_force_error",
    "standard_error_fraction",
    "acceleration_error",
    "residual_fraction",
)
_SENTENCES = (  # sentences that are shown if all their values are present
    "{n_loaded_contacts} of {n_contacts} contacts carry a force, at most {largest_force_N}.",
    "{n_significant_contacts} of them carry a force above two standard errors.",
    "The error is {true_force_error} of the true forces, for noise of {noise}.",
    "Their standard error is {standard_error_fraction} of the forces.",
    "The unexplained fraction of the data is {residual_fraction}.",
)
_CAPTIONS = {
    "force_network": "Inferred contact forces",
    "residuals": "Residual of the forces on each grain",
    "force_errors": "Standard errors of the forces against the forces",
    "modulus": "Misfit against Young's modulus",
    "noise": "Error of the forces against the noise of the measurement",
}
_LOOKS = {
    "force_network": "The width of a line is proportional to the force.",
    "residuals": "An outlier is a grain with a measurement error or a missing contact.",
    "force_errors": "Forces below twice their error may be zero.",
    "modulus": "A narrow minimum means that strains and accelerations determine the modulus well.",
    "noise": "A larger slope requires more accurate strains and accelerations.",
}
_TABLES = {INFERENCE: ENTRIES}


class InferenceKind(ReportKind):
    """Inferred forces, which have no energy balance and no case."""

    result_kind = INFERENCE
    noun = "inferred forces"
    has_balance = False
    main_figures = ("force_network",)
    captions = _CAPTIONS
    looks = _LOOKS
    table_keys = _KEYS
    in_per_cent = _IN_PER_CENT
    tables = _TABLES

    def setting(self, run: ReportRun) -> str:
        """Return the number of grains, the measurement and the assumptions."""
        grains = run.summary.get("n_grains")
        source = run.summary.get("measurement")
        count = grains[0] if isinstance(grains, list) and grains else grains
        friction = run.number("friction")
        parts = [f"forces of {count} grains of {source}", str(run.summary.get("state", ""))]
        if friction is not None:
            parts.append(f"friction {show(friction)}" if friction else "no friction")
        return ", ".join(part for part in parts if part)

    def title(self, run: ReportRun) -> str:
        """Return the title of a table."""
        return "Inferred forces"

    def in_words(self, run: ReportRun) -> str:
        """Return the results."""
        return sentences(_SENTENCES, printed(run.summary, _IN_PER_CENT))

    def label(self, run: ReportRun, key: str) -> str:
        """Return the label of a value of the summary."""
        return QUANTITIES[key].label if key in QUANTITIES else ""


REPORT_KINDS = (InferenceKind(),)
