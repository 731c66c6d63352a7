"""Outline of a report: its sections, from the inputs; the energy balances, contacts beyond the law, and cut zones."""

from __future__ import annotations

import math
from collections.abc import Sequence

from granwave.analysis.document.model import (
    Block,
    Cell,
    Column,
    Figure,
    Group,
    Note,
    Report,
    Section,
    Table,
    Tone,
    named,
    show,
    text_table,
    tidied,
    value_cell,
    value_column,
)
from granwave.analysis.formatting.numbers import plain
from granwave.analysis.measures.zone_size import NOTED_SHARE, Mark, bounds_in_words, mark_of
from granwave.analysis.reports.answer import answer_blocks, main_figures
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
from granwave.lammps_inputs.case.contact import ALL_LAWS, LINE
from granwave.lammps_inputs.run_directory import RESULT_FILE

_KIND = {"run": "granular run", "continuum": "continuum run", "spectra": "small waves"}
_IN_TITLE = 3  # names in the title
_BEYOND_SMALL = "overlaps of 0.2 R*, which are no longer small against the grains, as the law takes them"
_BALANCE = "balance"
_MOST_OPEN = 12  # runs whose table is not folded
#: Largest accepted error of the balance over the input, by kind of run.
LIMITS = {"run": 1e-5, "continuum": 2e-2}
_PARTS = ("kinetic", "elastic", "dissipated", "punch", "viscous", "hourglass")
#: Parts of these, shown if any run has them.
_SHARES = ("energy_rotational_J", "energy_dissipated_friction_J", "energy_dissipated_rolling_J",
           "energy_dissipated_twisting_J", "energy_dissipated_adhesion_J", "energy_dissipated_viscous_J",
           "energy_dissipated_holder_J", "energy_absorbed_J", "support_energy_J", "support_lost_J")  # fmt: skip


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
        notes.append(Note(f"Refused, as the energy balance did not close: {named(refused)}.", "bad", _BALANCE))
    notes += balance_notes(results)
    notes += zone_notes(results)
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


def verdict(run: Run) -> tuple[str, Tone]:
    """Assess the energy balance of a run."""
    error = run.number("energy_balance_error")
    largest = LIMITS[run.kind]
    if error is None:
        return "not known", "note"
    if math.isnan(error) or error > largest:
        return f"poor: above {plain(f'{largest:.0e}')}", "bad"
    return "good", "good"


def balance_section(inputs: Inputs) -> Section:
    """Make the section of the report."""
    runs = [run for run in inputs.results() if run.has_balance]
    if not runs:
        nothing = () if any(inputs.results()) else (Note("There is no finished run."),)
        return Section("Energy balance", _BALANCE, nothing)
    text = "Error: the largest |kinetic + elastic + dissipated - input| of the ledger, over the input."
    limits = {
        "run": "Kinetic includes rotation; elastic what is stored tangentially and in the support; dissipated "
        "friction, viscous losses, the support's damper and absorbing spheres. A granular run above 1e-5 is refused "
        "(the published variant of the law, which cannot close, excepted).",
        "continuum": "A continuum run above 2 % is stopped.",
    }
    text = " ".join([text, *(limits[kind] for kind in LIMITS if any(run.kind == kind for run in runs))])
    table = _table(runs)
    shown = Group("Energies of all runs", (table,), folded=True) if len(runs) > _MOST_OPEN else table
    return Section("Energy balance", _BALANCE, (Note(text), shown))


def balance_notes(runs: Sequence[Run]) -> list[Note]:
    """Return warnings about poor balances and contacts beyond the law, for the top of the report."""
    notes = []
    for kind, largest in LIMITS.items():
        poor = [run for run in runs if run.kind == kind and verdict(run)[1] == "bad"]
        if poor:
            labels = named([run.label for run in poor])
            text = f"Poor energy balance, do not trust ({_errors(poor)}, more than {_share(largest)}): {labels}."
            notes.append(Note(text, "bad", _BALANCE))
    unknown = [run for run in runs if verdict(run)[0] == "not known"]
    still = [run for run in unknown if run.number("energy_input_J") == 0]
    for found, text in (
        (still, "No energy came in before the end"),
        ([run for run in unknown if run not in still], "No energy balance is recorded"),
    ):
        if found:
            notes.append(Note(f"{text}: {named([run.label for run in found])}.", "note", _BALANCE))
    beyond = [run for run in runs if (run.number("contacts_beyond_law") or 0) > 0]
    for fitted, text in ((True, "the law, which was fitted up to an overlap of 0.2 R*"), (False, _BEYOND_SMALL)):
        counts = [f"{run.label} ({run.number('contacts_beyond_law'):.0f})" for run in beyond if _fitted(run) == fitted]
        if counts:
            notes.append(Note(f"Contacts beyond {text}: {named(counts)}.", "note", _BALANCE))
    return notes


def _fitted(run: Run) -> bool:
    """Return True if the law of a run was fitted to finite elements, or is not known."""
    law = run.case.get("contact.law", "elastoplastic")
    return law != LINE and (law not in ALL_LAWS or bool(ALL_LAWS[law].fitted))


def _errors(runs: Sequence[Run]) -> str:
    """Describe the errors of the balances of runs, with a note on those that are not a number."""
    errors = [run.number("energy_balance_error") or 0.0 for run in runs]
    finite = [error for error in errors if math.isfinite(error)]
    if not finite:
        return "the error is not a number"
    up_to = "up to " if len(finite) > 1 else ""
    return f"off by {up_to}{_share(max(finite))} of the input" + (", or not a number" * (len(finite) < len(errors)))


def _share(value: float) -> str:
    """Format a share with two digits, in per cent from 0.1 % on."""
    return f"{100 * value:.2g} %" if value >= 1e-3 else plain(f"{value:.2g}")


def _table(runs: Sequence[Run]) -> Table:
    parts = [f"energy_{part}_J" for part in _PARTS]
    shown = [key for key in ("energy_input_J", *parts) if any(run.summary.get(key) is not None for run in runs)]
    shown += [key for key in _SHARES if any(run.summary.get(key) for run in runs)]
    columns = [
        *(Column("Run", key=True), *map(value_column, shown)),
        *(Column("Error over input", numeric=True), Column("Balance"), Column("Timestep", "s", numeric=True)),
        *(Column("Timesteps dropped", numeric=True), Column("Contacts beyond the law", numeric=True)),
    ]
    rows = []
    for run in runs:
        (text, tone), dropped = verdict(run), run.record.get("attempts")
        noted: Tone = "note" if (run.number("contacts_beyond_law") or 0) > 0 else ""
        rows.append(
            (
                Cell(run.label, run.label),
                *(value_cell(run.summary.get(key)) for key in shown),
                value_cell(run.summary.get("energy_balance_error"), tone=tone if tone == "bad" else ""),
                Cell(text, text, tone),
                value_cell(run.summary.get("timestep_s")),
                value_cell(len(dropped) if isinstance(dropped, list) else None),
                value_cell(run.summary.get("contacts_beyond_law"), tone=noted),
            )
        )
    return Table("Energies at the end, and the error of the balance", tuple(columns), tuple(rows), sortable=True)


def zone_notes(runs: Sequence[Run]) -> list[Note]:
    """Return notes on runs whose zone reaches a boundary, and on runs in which a wave returned from one."""
    notes = []
    cut = _with_bounds([run for run in runs if mark_of(run.summary) is Mark.CUT])
    if cut:
        text = "The plastic zone reaches a bound, which cuts its outermost depth or radius, and may change what holds "
        notes.append(Note(f"{text}99 % of its energy: {cut}.", "note", RESULTS))
    returned = [run for run in runs if mark_of(run.summary) is Mark.WAVE]
    waves = [f"{run.label} ({100 * run.summary['wave_return_share']:.2g} %)" for run in returned]
    if waves:
        text = f"More than {100 * NOTED_SHARE:g} % of the energy of yielding was dissipated after a wave could be back "
        notes.append(Note(f"{text}from a bound: {named(waves)}.", "note", RESULTS))
    return notes


def _with_bounds(runs: Sequence[Run]) -> str:
    """Name runs with the bounds that their zones reach; those that all reach only once."""
    labels, bounds = [run.label for run in runs], [bounds_in_words(run.summary["zone_cut"]) for run in runs]
    if len(runs) > 1 and len(set(bounds)) == 1:
        return f"{named(labels)} (all: {bounds[0]})"
    return named([f"{label} ({one})" for label, one in zip(labels, bounds, strict=True)])
