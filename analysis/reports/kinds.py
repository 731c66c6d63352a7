"""Runs of a report and their kinds: the texts of a report on each kind of results.

A `ReportKind` reads the directories of a kind of results, and defines the differences from a run of
spheres, the kind of the core. Extensions add further kinds, see `Extension`.
"""

from __future__ import annotations

import dataclasses
import json
import sys
from collections.abc import Mapping, Sequence
from functools import cache, cached_property
from pathlib import Path
from typing import Any, ClassVar

from granwave.analysis.document.model import Report, is_number, named
from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.quantities import Quantity, quantity, report_columns
from granwave.analysis.result.not_a_run import (
    OF_A_RUN,
    UNFINISHED,
    no_results,
    state_in_words,
    way_on,
    where_stopped,
)
from granwave.analysis.result.reader import Result
from granwave.analysis.result.writer import BALANCE_REFUSED
from granwave.analysis.studies.runs import AnyRun, read_run
from granwave.lammps_inputs.case.run import BALANCE_TOLERANCE
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.extensions import added
from granwave.lammps_inputs.files import read_json, read_tables, regular
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.rounding import without_rounding
from granwave.lammps_inputs.run_directory import (
    CASE_FILE,
    RECORD_FILE,
    RUN,
    SCAN_INDEX,
    SUMMARY_FILE,
)

WARNING_OF = "Warning of"  # beginning of a note on the warning of a run
_END_KEY = "run.end_time"
_ACCEPTED = "energy_balance_accepted"
_LONGEST = 60  # most characters of an invalid value in a message
# end_reason of runs whose balance did not close, of this and of earlier versions
_REFUSED = (BALANCE_REFUSED, "refused")

#: A symbol with its values in runs, unit, and meaning.
Symbol = tuple[str, Sequence[float], str, str]


class UnfinishedRunError(InputError):
    """Error of an unfinished run without a summary."""


@dataclasses.dataclass(frozen=True)
class ReportRun:
    """A run with a summary, given directly or as a point of a scan.

    Attributes
    ----------
    label
        Label in the report; it contains a note if the run was rejected.
    kind
        Kind of the run, on which the keys of its summary depend.
    status
        ``done``, or ``refused`` if the energy balance did not close.
    case
        Resolved case by dotted key, such as ``load.velocity``, without ``name`` and derived values;
        a value may be a table, such as ``boundary.bottom``. Empty if unknown.
    record
        Content of run.json; empty if there is none.
    """

    label: str
    kind: ReportKind
    results: ResultDirectory
    status: str
    summary: Mapping[str, Any]
    case: Mapping[str, Any]
    record: Mapping[str, Any]

    @property
    def directory(self) -> Path:
        """Path of its directory."""
        return self.results.path

    @property
    def is_unfinished(self) -> bool:
        """True if the run ended before its end: interrupted, failed or still running."""
        return self.record.get("state") in UNFINISHED

    @property
    def stopped(self) -> str:
        """State of an unfinished run, with the time that it reached: ``interrupted at 50 µs of
        1 ms``, ``killed at 50 µs``; empty for a finished run.
        """
        if not self.is_unfinished:
            return ""
        state = state_in_words(self.directory, str(self.record["state"])).removeprefix("state ")
        end = self.number("end_time_s")
        if end is None:
            return state
        text = f"{state} at {quantity_in(end, 's')}"
        requested = self.case.get(_END_KEY)
        if requested is None or not is_number(requested):
            return text
        return f"{text} of {quantity_in(requested, 's')}"

    @property
    def warnings(self) -> list[str]:
        """Warnings about the case and the run that its record keeps, and that follow from its
        summary.
        """
        texts = self.record.get("warnings")
        kept = [str(text) for text in texts] if isinstance(texts, list) else []
        return [*kept, *self.kind.doubts(self.summary)]

    @property
    def has_balance(self) -> bool:
        """True for results of a time integration, which have energies."""
        return self.kind.has_balance

    @property
    def accepted_error(self) -> float:
        """Largest error of the energy balance, relative to the input, with which the run was
        accepted.

        Results of versions that did not record it were judged by the limits of those versions.
        """
        for source in (self.summary, self.record):
            value: Any = source.get(_ACCEPTED)
            if is_number(value):
                return float(value)
        if self.kind.accepted_error is not None:
            return self.kind.accepted_error
        aimed: Any = self.case.get("run.energy_tolerance")
        return max(BALANCE_TOLERANCE, aimed) if is_number(aimed) else BALANCE_TOLERANCE

    def number(self, key: str) -> float | None:
        """Return a value of the summary if it is a number, else None."""
        value = self.summary.get(key)
        return value if is_number(value) else None

    @cached_property
    def damaged(self) -> bool:
        """True if the result.h5 of a granular run is damaged; it may have been removed to keep only
        the summary.
        """
        if not self.kind.of_spheres:
            return False
        try:
            Result(self.results).close()
        except MissingOutputError:
            return False
        except OutputFormatError:
            return True
        return False

    @property
    def versions(self) -> dict[str, str]:
        """Versions of the programs that produced the run, by name."""
        versions = self.summary.get("versions")
        if not isinstance(versions, dict):
            return {}
        return {str(name): str(value) for name, value in versions.items()}


class ReportKind:
    """Texts, tables and figures of one kind of results in a report; by default of runs with an
    energy balance.

    Attributes
    ----------
    result_kind
        Name of the `granwave.lammps_inputs.result_kinds.ResultKind` that it reads.
    noun
        Description of a run in a table: ``granular run``.
    of_spheres
        True for runs of spheres, which LAMMPS made.
    has_balance
        True for results integrated in time, which have energies: it is shown by the tables and
        sentences of runs. Else those of the kind are shown.
    accepted_error
        Largest error of the energy balance / input, of runs that record none; None:
        ``run.energy_tolerance`` of the case.
    energies
        Values of the summary that are parts of the energy at the end, besides those of all runs.
    ledger
        Data sets of ``/energy`` of result.h5 that make up each form of energy of a comparison; the
        dissipated energy is that of the dissipated fraction.
    numerical
        Other data sets of ``/energy``, of the numerical method, with their names in words.
    limits
        Sentences on energies and their balance.
    main_figures
        Names of figures for the first section, the best first.
    captions
        Captions of figures, in their order.
    looks
        Features to look for in figures: the rest of their captions.
    table_keys
        Main values of a summary, in the order of their table; of kinds without a balance.
    in_per_cent
        Values that are fractions.
    tables
        Values of the summaries that only this kind has, by the name of a table of the reference.
    """

    result_kind: ClassVar[str]
    noun: ClassVar[str]
    of_spheres: ClassVar[bool] = False
    has_balance: ClassVar[bool] = True
    accepted_error: ClassVar[float | None] = None
    energies: ClassVar[Sequence[str]] = ()
    ledger: ClassVar[Mapping[str, Sequence[str]]] = {
        "kinetic": ("kinetic",),
        "elastic": ("elastic",),
        "dissipated": ("dissipated",),
    }
    numerical: ClassVar[Mapping[str, str]] = {}
    limits: ClassVar[str] = ""
    main_figures: ClassVar[Sequence[str]] = ()
    captions: ClassVar[Mapping[str, str]] = {}
    looks: ClassVar[Mapping[str, str]] = {}
    table_keys: ClassVar[Sequence[str]] = ()
    in_per_cent: ClassVar[Sequence[str]] = ()
    tables: ClassVar[Mapping[str, Sequence[Quantity]]] = {}

    # ------------------------------------------------------------------ reading

    def read(self, results: ResultDirectory, label: str) -> list[ReportRun]:
        """Read a directory, which may hold several runs.

        Raises
        ------
        InputError
            The results are not finished, damaged or changed, or cannot be in a report.
        """
        path = results.path
        names = sorted(entry.name for entry in path.iterdir())
        if not any(name in names for name in OF_A_RUN):
            expected = f"expected {SUMMARY_FILE} or {SCAN_INDEX} in it"
            raise InputError(no_results(path, names, "neither a run nor a scan", expected))
        if SUMMARY_FILE not in names:
            if stop := where_stopped(path):
                raise UnfinishedRunError(
                    f"{path}: {stop}, so there is no {SUMMARY_FILE}; {way_on(path)}"
                )
            raise InputError(
                f"{path}: a run without {SUMMARY_FILE}; make it with  granwave analyse {path}"
            )
        return [self.run_of(results, label, _summary(results))]

    def run_of(self, results: ResultDirectory, label: str, summary: Mapping[str, Any]) -> ReportRun:
        """Return the run of a directory whose summary was read."""
        results.check_case()
        if changed := results.changed_result():
            raise InputError(changed)
        case = by_key(read_tables(results / CASE_FILE) or results.tables_as_run() or {})
        record = read_json(results / RECORD_FILE) or {}
        status = "done"
        if record.get("state") == "refused" or summary.get("end_reason") in _REFUSED:
            label = f"{label} (refused)"
            status = "refused"
        return ReportRun(label, self, results, status, summary, case, record)

    def whole_report(self, directory: Path) -> Report | None:
        """Return the separate report of a single directory; None: the usual one."""
        return None

    def study_run(self, run: ReportRun) -> AnyRun[Any] | None:
        """Return a run as studies take it; None if its case cannot be read, or none takes it."""
        return None

    # ------------------------------------------------------------------ words

    def name_values(self, run: ReportRun, values: dict[str, str]) -> None:
        """Rename the values of a summary, as texts, for the sentences on runs."""

    def body(self, case: Mapping[str, Any]) -> str:
        """Return a description of a case of this kind, by dotted keys; empty for other cases."""
        return ""

    def load_keys(self, case: Mapping[str, Any]) -> dict[str, Any]:
        """Return the keys of the load of a case, by dotted keys, with the names of a packing."""
        return {}

    def energy_unit(self, run: ReportRun) -> float:
        """Return sigma_y^2 D^3/E, in which inputs of runs of all kinds are compared, J; 0 for a run
        without a yield strength.
        """
        return 0.0

    def setting(self, run: ReportRun) -> str:
        """Return a description of the run in a line; empty: its case describes it."""
        return ""

    def doubts(self, summary: Mapping[str, Any]) -> list[str]:
        """Return warnings that follow from a summary, sentences without full stops."""
        return []

    def symbols(self, runs: Sequence[ReportRun]) -> list[Symbol]:
        """Return symbols of figures and tables of runs of this kind, in addition to the symbols of
        packings.
        """
        return []

    # ------------------------------------------------------------------ without energies

    def part(self, run: ReportRun) -> str:
        """Return which part of the kind a run is; tables show runs of a part side by side."""
        return ""

    def title(self, run: ReportRun) -> str:
        """Return the title of a table of runs of one part."""
        return self.noun

    def in_words(self, run: ReportRun) -> str:
        """Return the results in sentences."""
        return ""

    def label(self, run: ReportRun, key: str) -> str:
        """Return the label of a value of a summary; empty: the usual one."""
        return ""

    def figures_of_others(self, run: ReportRun) -> set[str]:
        """Return the names of figures in its directory that belong to other results."""
        return set()


class GranularKind(ReportKind):
    """Runs of spheres."""

    result_kind = RUN
    noun = "granular run"
    of_spheres = True
    limits = (
        "Kinetic energy includes rotation; elastic energy includes tangential springs and the "
        "support; dissipated energy includes friction, viscous damping, the damper of the support "
        "and absorbing spheres. A granular run above the accepted error is rejected (except with "
        "the published variant of the law, whose balance cannot close)."
    )
    main_figures = (
        "amplitude_sweep",
        "transmission",
        "packing_3d",
        "force_map",
        "wave_front",
        "peak_force_principal",
        "along_chain",
        "peak_force_depth",
        "energies",
    )

    def study_run(self, run: ReportRun) -> AnyRun[Any] | None:
        """Return a run as studies take it."""
        return read_run(run.label, run.directory, run.summary)

    def energy_unit(self, run: ReportRun) -> float:
        """Return the unit with the diameter of the spheres, J."""
        return unit_of_energy(run, "packing.diameter")

    def name_values(self, run: ReportRun, values: dict[str, str]) -> None:
        """Distinguish the largest force between spheres from the largest force including walls."""
        pairs = values.pop("peak_force_N", "")
        if run.number("peak_force_N"):
            values["between_spheres"] = pairs
        every = run.number("peak_force_with_walls_N")
        if every and every != run.number("peak_force_N"):
            values["with_walls"] = values["peak_force_with_walls_N"]


GRANULAR = GranularKind()


@cache
def report_kinds() -> tuple[ReportKind, ...]:
    """Return all kinds, the kind of the core first."""
    kinds: list[ReportKind] = [GRANULAR]
    for more in added("report"):
        kinds += more
    return tuple(kinds)


def report_kind_in(results: ResultDirectory) -> ReportKind:
    """Return the kind of the results in a directory.

    Raises
    ------
    InputError
        No extension here reads them, or shows them in a report.
    """
    kind = results.kind
    if not kind.installed:
        raise InputError(f"{results}: {kind.why_no_run}")
    for one in report_kinds():
        if one.result_kind == kind.name:
            return one
    if kind.why_no_run:
        raise InputError(f"{results}: contains {kind.content}, which reports do not support")
    return GRANULAR


def warning_notes(runs: Sequence[ReportRun]) -> list[str]:
    """Return the warnings of runs with the names of the runs, each warning once."""
    names: dict[str, list[str]] = {}
    for run in runs:
        for text in run.warnings:
            names.setdefault(text, []).append(run.label)
    return [f"{WARNING_OF} {named(labels)}: {text}." for text, labels in names.items()]


def unit_of_energy(run: ReportRun, diameter_key: str) -> float:
    """Return sigma_y^2 D^3/E of the material of a case, J; 0 if it lacks one of them."""
    keys = (diameter_key, "material.yield_strength", "material.youngs_modulus")
    diameter, strength, modulus = (run.case.get(key) for key in keys)
    if not (strength and diameter and modulus):
        return 0.0
    return float(strength**2 * diameter**3 / modulus)


def by_key(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of a case by dotted key."""
    values: dict[str, Any] = {}
    for name, value in tables.items():
        if isinstance(value, dict) and name != "resolved":
            values |= {f"{name}.{key}": part for key, part in value.items()}
        elif name not in ("name", "resolved"):
            values[name] = value
    return values


def _summary(results: ResultDirectory) -> dict[str, Any]:
    results.refuse_special()
    path = results.path
    try:
        summary = json.loads(regular(path / SUMMARY_FILE).read_text(encoding="utf-8"))
        if isinstance(summary, dict):
            wrong = "".join(no_numbers(summary)[:1])
        else:
            wrong = f"found a {type(summary).__name__}, expected a table of values"
    except (OSError, ValueError, RecursionError) as error:
        wrong = f"cannot be read ({error})"
    if wrong:
        raise InputError(
            f"{path / SUMMARY_FILE}: {wrong}; recreate it with  granwave analyse {path}"
        )
    return without_rounding(summary)


def no_numbers(summary: Mapping[str, Any]) -> list[str]:
    """Describe the quantities of a summary that are not numbers; null is allowed for quantities
    that do not apply.
    """
    faults = []
    for key, value in summary.items():
        if value is None or not (quantity(key).unit or key in report_columns()):
            continue
        if (
            isinstance(value, list)
            and not quantity(key).unit
            and all(isinstance(item, str) for item in value)
        ):
            continue  # a list of words, such as the boundaries that a zone reaches
        if not is_number(value) or abs(value) > sys.float_info.max:
            text = repr(value)
            more = "..." if len(text) > _LONGEST else ""
            faults.append(f"{key}: found {text[:_LONGEST]}{more}, expected a number")
    return faults
