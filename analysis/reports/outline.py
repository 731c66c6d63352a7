"""Outline of a report: its sections, from the inputs."""

from __future__ import annotations

from collections.abc import Sequence

from granwave.analysis.document.cells import named, show, text_table, tidied
from granwave.analysis.document.model import Block, Cell, Figure, Group, Note, Report, Section, Tone
from granwave.analysis.reports.answer import answer_blocks, main_figures
from granwave.analysis.reports.balance import SLUG as BALANCE
from granwave.analysis.reports.balance import balance_notes, balance_section, zone_notes
from granwave.analysis.reports.figures import figures_section
from granwave.analysis.reports.inputs import Inputs, Run, Scan
from granwave.analysis.reports.results import SLUG as RESULTS
from granwave.analysis.reports.results import failures_section, results_section, status_cell
from granwave.analysis.reports.setting import first_line, setting_of, settings_blocks, symbols_note
from granwave.analysis.reports.studies import (
    comparison_section,
    leads,
    main_picture,
    studies_of,
    studies_section,
    verdicts,
)
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
    heads = ("Name", "What", "Case", "Setting", "Status", "Directory")
    what = text_table("What this report is about", heads, [_input_row(item, inputs) for item in inputs.items])
    sections = (
        _answer(inputs, failures.slug, studies, picture),
        Section("Verdict", "verdict", verdicts(studies)),
        studies_section(inputs, studies),
        comparison_section(inputs),
        figures_section(inputs, above, main_figures(inputs, picture)),
        failures,
        results_section(inputs),
        balance_section(inputs),
        Section("Settings and versions", "inputs", (what, *settings_blocks(inputs), *_versions(inputs))),
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
    for run in (run for run in results if run.damaged):
        text = (
            f"The {RESULT_FILE} of {run.label} is damaged, so studies and comparisons leave it out: make it anew with"
        )
        notes.append(Note(f"{text} granwave analyse {inputs.path(run.directory)}", "bad"))
    if not notes and results:
        text = "Every run finished, its energy balance closed, and no contact left the range of its law."
        notes.append(Note(text, "good"))
    return notes


def _input_row(item: Run | Scan, inputs: Inputs) -> tuple[str | Cell, ...]:
    place = inputs.link(item.directory)
    if place.text == ".":
        place = inputs.link(item.directory, "that of this report")
    name, where = Cell(item.label, item.label), Cell(place.text, place.text, link=place)
    if isinstance(item, Run):
        kind = "inferred forces" if item.is_inference else _KIND[item.kind]
        case = show(item.summary["name"]) if item.summary.get("name") is not None else ""
        return name, kind, case, setting_of(item.case), status_cell(item.status), where
    done, failed = sum(point.run is not None for point in item.points), item.count("failed")
    tone: Tone = "good" if done == len(item.points) else "bad" if failed else "note"
    status = Cell(f"{done} of {len(item.points)} points done", done, tone)
    setting = "varied: " + ", ".join(item.source.varied) if item.source.varied else "one point"
    return name, "scan", str(item.source.case_name), setting, status, where


def _versions(inputs: Inputs) -> list[Block]:
    """Return tables of versions: those that all runs share, then those that differ, by kind of run."""
    runs = list(inputs.results())
    users: dict[str, dict[str, list[Run]]] = {}
    for run in runs:
        for name, version in run.versions.items():
            users.setdefault(name, {}).setdefault(version, []).append(run)
    same, others = [], []
    for name, found in users.items():
        of_name = [run for alike in found.values() for run in alike]
        kinds = {run.kind for run in of_name}
        if len(found) == 1 and len(of_name) == sum(run.kind in kinds for run in runs):
            same.append((name, *found))
        else:
            others += [(name, version, named([run.label for run in alike])) for version, alike in found.items()]
    blocks: list[Block] = []
    if same:
        title = "Versions, the same in all" if len(runs) > 1 else "Versions"
        table = text_table(title, ("Program", "Version"), same, captioned=False)
        blocks.append(Group(title, (table,), folded=True))
    if others:
        blocks.append(Note("Not all runs were made with the same versions.", "note"))
        blocks.append(text_table("Versions that differ", ("Program", "Version", "Runs"), others))
    unknown = [run.label for run in runs if not run.versions]
    if unknown:
        blocks.append(Note(f"No versions are recorded: {named(unknown)}.", "note"))
    return blocks
