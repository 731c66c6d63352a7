"""Outline of a report: its sections, from the inputs."""

from __future__ import annotations

from collections.abc import Sequence

from granwave.analysis.document.cells import named, show, tidied
from granwave.analysis.document.model import Block, Cell, Column, Figure, Group, Note, Report, Section, Table
from granwave.analysis.reports.inputs import Inputs, Run, Scan
from granwave.analysis.reports.sections.answer import answer_blocks, main_figures
from granwave.analysis.reports.sections.balance import SLUG as BALANCE
from granwave.analysis.reports.sections.balance import balance_notes, balance_section
from granwave.analysis.reports.sections.comparison import comparison_section
from granwave.analysis.reports.sections.figures import figures_section
from granwave.analysis.reports.sections.results import SLUG as RESULTS
from granwave.analysis.reports.sections.results import failures_section, results_section, status_cell
from granwave.analysis.reports.sections.setting import first_line, setting_of, symbols_note
from granwave.analysis.reports.sections.settings import settings_blocks
from granwave.analysis.reports.sections.studies import leads, main_picture, studies_of, studies_section, verdicts
from granwave.analysis.reports.sections.zone import zone_notes
from granwave.analysis.studies.study import Study
from granwave.lammps_inputs.run_directory import RESULT_FILE

_KIND = {"run": "granular run", "continuum": "continuum run", "spectra": "small waves"}
_IN_TITLE = 3  # names in the title


def build_report(inputs: Inputs, named: Sequence[str] = ()) -> Report:
    """Build the report of runs and scans.

    Parameters
    ----------
    named
        Names of studies of all runs, in addition to those that the scans name.
    """
    labels = [inputs.suite] if inputs.suite else [item.label for item in inputs.items]
    names = ", ".join(labels[:_IN_TITLE]) + (f" and {len(labels) - _IN_TITLE} more" if len(labels) > _IN_TITLE else "")
    failures, studies = failures_section(inputs), studies_of(inputs, named)
    above = {picture.name for study in studies for picture in study.pictures}
    picture = main_picture(studies, inputs)
    sections = (
        _answer(inputs, failures.slug, studies, picture),
        Section("Verdict", "verdict", verdicts(studies)),
        studies_section(inputs, studies),
        comparison_section(inputs),
        figures_section(inputs, above, main_figures(inputs, picture)),
        failures,
        results_section(inputs),
        balance_section(inputs),
        _what_was_run(inputs),
    )
    return tidied(Report(f"Report: {names}", _lead(inputs), tuple(section for section in sections if section.blocks)))


def _lead(inputs: Inputs) -> str:
    n_runs, n_scans = len(inputs.runs), len(inputs.scans)
    parts = []
    if n_runs:
        parts.append(f"{n_runs} run{'s' * (n_runs > 1)}")
    if n_scans:
        points = [point for scan in inputs.scans for point in scan.points]
        done = sum(point.run is not None for point in points)
        parts.append(f"{n_scans} scan{'s' * (n_scans > 1)} with {done} of {len(points)} points done")
    what = first_line(inputs)
    return " and ".join(parts) + (f": {what}." if what else ".")


def _answer(inputs: Inputs, failures: str, studies: Sequence[Study], picture: Figure | None) -> Section:
    """Make the first section: what must not be overlooked, what came out, and notes on it."""
    notes = _notes(inputs, failures)
    bad, others = ([note for note in notes if (note.tone == "bad") is wanted] for wanted in (True, False))
    answer = answer_blocks(inputs, picture, judged=any(study.verdict for study in studies))
    return Section("In short", "short", (*bad, *leads(studies), *answer, *symbols_note(inputs), *others))


def _notes(inputs: Inputs, failures: str) -> list[Note]:
    notes: list[Note] = []
    for scan in inputs.scans:
        failed, missing = scan.count("failed"), sum(point.run is None for point in scan.points) - scan.count("failed")
        if failed:
            notes.append(Note(f"Scan {scan.label}: {failed} of {len(scan.points)} points failed.", "bad", failures))
        if missing:
            text = f"Scan {scan.label}: {missing} of {len(scan.points)} points are missing."
            notes.append(Note(text, "note", failures))
    results = [run for run in inputs.results() if run.has_balance]
    refused = [run.label for run in results if run.status == "refused"]
    if refused:
        notes.append(Note(f"Refused, as the energy balance did not close: {named(refused)}.", "bad", BALANCE))
    notes += balance_notes(results, BALANCE)
    notes += zone_notes(results, RESULTS)
    without = [run.label for run in results if not run.case]
    if without:
        notes.append(Note(f"No readable case.toml, so settings are not known: {named(without)}.", "note"))
    notes += [_damaged(run, inputs) for run in results if run.damaged]
    if not notes and results:
        text = "Every run finished, its energy balance closed, and no contact left the range of its law."
        notes.append(Note(text, "good"))
    return notes


def _damaged(run: Run, inputs: Inputs) -> Note:
    text = f"The {RESULT_FILE} of {run.label} is damaged, so studies and comparisons leave it out: make it anew with"
    return Note(f"{text} granwave analyse {inputs.path(run.directory)}", "bad")


def _what_was_run(inputs: Inputs) -> Section:
    columns = (
        Column("Name", key=True),
        Column("What"),
        Column("Case"),
        Column("Setting"),
        Column("Status"),
        Column("Directory"),
    )
    rows = tuple(_input_row(item, inputs) for item in inputs.items)
    blocks: list[Block] = [Table("What this report is about", columns, rows), *settings_blocks(inputs)]
    return Section("Settings and versions", "inputs", (*blocks, *_versions(list(inputs.results()))))


def _input_row(item: Run | Scan, inputs: Inputs) -> tuple[Cell, ...]:
    place = inputs.link(item.directory)
    if place.text == ".":
        place = inputs.link(item.directory, "that of this report")
    where = Cell(place.text, place.text, link=place)
    if isinstance(item, Run):
        name = item.summary.get("name")
        case = show(name) if name is not None else ""
        return (
            Cell(item.label, item.label), Cell(_kind(item)), Cell(case), Cell(setting_of(item.case)),
            status_cell(item.status), where,
        )  # fmt: skip
    done, failed = sum(point.run is not None for point in item.points), item.count("failed")
    status = f"{done} of {len(item.points)} points done"
    complete = done == len(item.points)
    return (
        Cell(item.label, item.label),
        Cell("scan"),
        Cell(str(item.source.case_name)),
        Cell("varied: " + ", ".join(item.source.varied) if item.source.varied else "one point"),
        Cell(status, done, "good" if complete else "bad" if failed else "note"),
        where,
    )


def _kind(run: Run) -> str:
    return {"inference": "inferred forces"}.get(str(run.summary.get("kind")), _KIND[run.kind])


def _versions(runs: Sequence[Run]) -> tuple[Block, ...]:
    """Return tables of versions: those that all runs share, then those that differ, by kind of run."""
    users: dict[str, dict[str, list[str]]] = {}
    kinds: dict[str, set[str]] = {}
    for run in runs:
        for name, version in run.versions.items():
            users.setdefault(name, {}).setdefault(version, []).append(run.label)
            kinds.setdefault(name, set()).add(run.kind)
    common = {
        name: version
        for name, found in users.items()
        for version, labels in found.items()
        if len(labels) == sum(run.kind in kinds[name] for run in runs)
    }
    blocks: list[Block] = []
    if common:
        columns = (Column("Program", key=True), Column("Version"))
        rows = tuple((Cell(name), Cell(version)) for name, version in common.items())
        title = "Versions, the same in all" if len(runs) > 1 else "Versions"
        blocks.append(Group(title, (Table(title, columns, rows, captioned=False),), folded=True))
    others = tuple(
        (Cell(name), Cell(version), Cell(named(labels)))
        for name, found in users.items()
        if name not in common
        for version, labels in found.items()
    )
    if others:
        heads = (Column("Program", key=True), Column("Version"), Column("Runs"))
        blocks.append(Note("Not all runs were made with the same versions.", "note"))
        blocks.append(Table("Versions that differ", heads, others))
    unknown = [run.label for run in runs if not run.versions]
    if unknown:
        blocks.append(Note(f"No versions are recorded: {named(unknown)}.", "note"))
    return tuple(blocks)
