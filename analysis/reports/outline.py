"""Outline of a report: its sections, from the inputs; the energy balances, contacts beyond the law,
and cut zones.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain

from granwave.analysis.document.model import (
    Badge,
    Block,
    Cell,
    DocumentSection,
    DocumentTable,
    Figure,
    Group,
    Link,
    Note,
    Report,
    TableColumn,
    Tone,
    cell_in_unit,
    column_table,
    named,
    show,
    significant,
    text_table,
    tidied,
    units_of_values,
    value_cell,
    value_column,
)
from granwave.analysis.formatting.numbers import counted, plain
from granwave.analysis.measures.zone_size import (
    NOTED_SHARE,
    PERIODIC_SIDES,
    Mark,
    bounds_in_words,
    is_collision,
    mark_of,
    zone_marks,
)
from granwave.analysis.reports.answer import answer_blocks, main_figures
from granwave.analysis.reports.comparison.blocks import comparison_blocks
from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.comparison.comparison import Comparison
from granwave.analysis.reports.comparison.definitions import OF_THE_END, end_notes
from granwave.analysis.reports.comparison.ends import GROWING
from granwave.analysis.reports.figures import figures_section, views
from granwave.analysis.reports.inputs import ReportInputs, ReportScan
from granwave.analysis.reports.kinds import (
    WARNING_OF,
    ReportRun,
    report_kinds,
    warning_notes,
)
from granwave.analysis.reports.results import SLUG as RESULTS
from granwave.analysis.reports.results import failures_section, results_section, status_cell
from granwave.analysis.reports.setting import first_line, setting_of, settings_blocks, symbols_note
from granwave.analysis.reports.studies import (
    ReportStudies,
    comparison_section,
    leads,
    main_picture,
    report_studies,
    studies_section,
    verdicts,
)
from granwave.analysis.reports.used_symbols import parts_of, parts_of_sections, uses_symbol
from granwave.analysis.studies.study import Study
from granwave.lammps_inputs.case.contact.contact import ALL_LAWS, LINE
from granwave.lammps_inputs.case.run import BALANCE_TOLERANCE
from granwave.lammps_inputs.run_directory import RESULT_FILE

_IN_TITLE = 3  # most names in the title
_TIGHT = 1e-3  # largest accepted error of a balance that badges do not state
#: Notes on runs, before their names.
_REFUSED = "Rejected: energy balance error too large"
_POOR = "Energy balance error too large, do not use (up to {off} of the input, more than {most})"
_IDLE = "No energy input before the end"
_UNKNOWN = "No energy balance is recorded"
_BEYOND_FIT = "Contacts beyond the range of the law, which was fitted up to an overlap of 0.2 R*"
_BEYOND_SMALL = (
    "Contacts beyond overlaps of 0.2 R*, which the law assumes to be small compared with the grains"
)
_LEFT_OUT = "Left out: "  # before the message of an unfinished run
_CUT = (
    "The plastic zone reaches a boundary, which limits its extent, and may change the depths and "
    "radii that contain 50, 90 and 99 % of its dissipation"
)
_UNFINISHED = "Unfinished, with values up to the last output"
_OF_ENDS = (_UNFINISHED, *OF_THE_END)  # notes on the ends of runs
#: Notes that a comparison has itself.
_OF_COMPARISON = (_CUT, _LEFT_OUT, WARNING_OF, *_OF_ENDS)
_WAVES = (
    f"More than {100 * NOTED_SHARE:g} % of the plastic dissipation occurred after a reflection "
    "from a boundary could return"
)
_NO_CASE = "No readable case.toml, so settings are unknown"
_DAMAGED = (
    f"The {RESULT_FILE} of {{}} is damaged, so studies and comparisons omit it: recreate it with"
)
_GOOD = (
    "Every run finished with an acceptable energy balance, and no contact left the range of "
    "its law."
)
_ERROR = (
    "Error: the largest |kinetic + elastic + dissipated - input| of the energy balance, relative "
    "to the input."
)
_BALANCE = "balance"
_MOST_OPEN = 12  # most runs whose table is not folded
_PARTS = ("energy_kinetic_J", "energy_elastic_J", "energy_dissipated_J")
#: Sections that are shown if any run has them.
_SHARES = ("energy_rotational_J", "energy_dissipated_friction_J", "energy_dissipated_rolling_J",
           "energy_dissipated_twisting_J", "energy_dissipated_adhesion_J", "energy_dissipated_viscous_J",
           "energy_dissipated_holder_J", "energy_absorbed_J", "support_energy_J", "support_lost_J")  # fmt: skip


def build_report(inputs: ReportInputs, named: Sequence[str] = ()) -> Report:
    """Make the studies of runs and scans, and build their report.

    Parameters
    ----------
    named
        Names of studies of all runs, in addition to those that the scans name.
    """
    return report_with_studies(inputs, report_studies(inputs, named))


def report_with_studies(inputs: ReportInputs, made: ReportStudies) -> Report:
    """Build the report of runs and scans whose studies are made already."""
    labels = [inputs.suite] if inputs.suite else [item.label for item in inputs.items]
    failures = failures_section(inputs)
    studies = made.of_scans
    above = {picture.name for picture in chain.from_iterable(one.pictures for one in studies)}
    picture = main_picture(studies, inputs)
    compared = [run for run in inputs.runs if run.has_balance]
    comparison = compare_runs(compared) if len(compared) > 1 else None
    heads = ("Name", "What", "Case", "Setting", "Status", "Directory")
    what = text_table(
        "Contents of this report", heads, [_input_row(item, inputs) for item in inputs.items]
    )
    others = (
        DocumentSection("Verdict", "verdict", verdicts(studies)),
        studies_section(inputs, studies),
        comparison_section(inputs, made.compared),
        figures_section(inputs, above, main_figures(inputs, picture)),
        failures,
        results_section(inputs, comparison),
        balance_section(inputs),
        DocumentSection(
            "Settings and versions", "inputs", (what, *settings_blocks(inputs), *_versions(inputs))
        ),
    )
    answer = _answer(inputs, failures.slug, studies, picture, comparison, others)
    sections = (answer, *others)
    return tidied(
        Report(
            f"Report: {_names_in_title(labels)}",
            _lead(inputs),
            tuple(section for section in sections if section.blocks),
            _badges(inputs) if any(inputs.results()) else (),
        )
    )


def build_comparison(inputs: ReportInputs, comparison: Comparison, data: Link) -> Report:
    """Build the page of a comparison: the comparison itself, all values, energies and settings.

    Parameters
    ----------
    data
        Link to the folder of its figures.
    """
    failures = failures_section(inputs)
    notes = [
        note
        for note in _notes(inputs, failures.slug)
        if note.tone != "good" and not note.text.startswith(_OF_COMPARISON)
    ]
    blocks = comparison_blocks(comparison, data)
    others = (
        failures,
        results_section(inputs, comparison),
        balance_section(inputs),
        DocumentSection(
            "Settings and versions", "inputs", (*settings_blocks(inputs), *_versions(inputs))
        ),
    )
    symbols = _symbols(inputs, blocks, others)
    first = DocumentSection("Comparison", "short", (*blocks, *symbols, *notes))
    sections = (first, *others)
    names = _names_in_title([run.name for run in comparison.runs])
    shown = tuple(section for section in sections if section.blocks)
    return tidied(Report(f"Comparison: {names}", _lead(inputs), shown, _badges(inputs)))


def _names_in_title(labels: Sequence[str]) -> str:
    """Return some names, and the number of the others."""
    names = ", ".join(labels[:_IN_TITLE])
    more = len(labels) - _IN_TITLE
    return f"{names} and {more} more" if more > 0 else names


def _lead(inputs: ReportInputs) -> str:
    n_runs = len(inputs.runs)
    n_scans = len(inputs.scans)
    parts = []
    if n_runs:
        parts.append(counted(n_runs, "run"))
    if n_scans:
        n_points = sum(len(scan.points) for scan in inputs.scans)
        done = 0
        for scan in inputs.scans:
            done += sum(point.run is not None for point in scan.points)
        scans = counted(n_scans, "scan")
        parts.append(f"{scans} with {done} of {n_points} points done")
    what = first_line(inputs)
    return " and ".join(parts) + (f": {what}." if what else ".")


def _answer(
    inputs: ReportInputs,
    failures: str,
    studies: Sequence[Study],
    picture: Figure | None,
    comparison: Comparison | None,
    later: Sequence[DocumentSection],
) -> DocumentSection:
    """Make the first section: warnings, results, and notes.

    Parameters
    ----------
    later
        Other sections, whose symbols it defines.
    """
    notes = _notes(inputs, failures)
    compared = [run for run in inputs.runs if run.has_balance]
    if not inputs.scans and len(inputs.runs) > 1:
        told = warning_notes(compared) if len(compared) > 1 else []
        of_comparison = (_CUT, _BEYOND_FIT, _BEYOND_SMALL, *_OF_ENDS)
        listed = of_comparison if len(compared) > 1 else _CUT
        notes = [
            note for note in notes if not note.text.startswith(listed) and note.text not in told
        ]
    if comparison is not None:
        notes = [note for note in notes if note.text not in comparison.notes]
    bad, others = (
        [note for note in notes if (note.tone == "bad") is wanted] for wanted in (True, False)
    )
    judged = any(study.verdict for study in studies)
    answer = answer_blocks(inputs, picture, comparison, judged=judged)
    blocks = [*leads(studies), *answer, *views(inputs)]
    symbols = _symbols(inputs, blocks, later)
    return DocumentSection("In short", "short", (*bad, *blocks, *symbols, *others))


def _symbols(
    inputs: ReportInputs, blocks: Sequence[Block], sections: Sequence[DocumentSection]
) -> list[Note]:
    """Return the definitions of the symbols that blocks and sections use."""
    parts = [*parts_of(blocks), *parts_of_sections(sections)]
    return symbols_note(inputs, lambda symbol: uses_symbol(symbol, parts))


def _badges(inputs: ReportInputs) -> tuple[Badge, ...]:
    """Return the states of the runs: finished, energy balance, plastic zone at a boundary, contacts
    beyond the law.
    """
    runs = list(inputs.results())
    undone = len(inputs.left_out)
    for scan in inputs.scans:
        undone += sum(point.run is None for point in scan.points)
    where = "failures" if inputs.scans else "short"
    unfinished = undone + sum(run.status != "done" or run.is_unfinished for run in runs)
    total = undone + len(runs)
    badges = [_badge(unfinished, total, "finished", "not finished", "bad", where)]
    balanced = [run for run in runs if run.has_balance]
    if balanced:
        tones = [verdict(run)[1] for run in balanced]
        closed = _closed(balanced)
        if "bad" in tones or "note" not in tones:
            poor = tones.count("bad")
            badges.append(
                _badge(poor, len(balanced), closed, "energy balance open", "bad", _BALANCE)
            )
        else:
            unknown = tones.count("note")
            badges.append(
                _badge(unknown, len(balanced), closed, "energy balance unknown", "note", _BALANCE)
            )
        beyond = sum(_beyond_law(run) for run in balanced)
        inside = "contacts within the law"
        badges.append(
            _badge(beyond, len(balanced), inside, "contacts beyond the law", "note", _BALANCE)
        )
    yielding = [run for run in balanced if _has_zone(run)]
    if yielding:
        cut = sum(mark_of(run.summary) is not Mark.NONE for run in yielding)
        is_growing = any(run.summary.get(GROWING) for run in yielding)
        so_far = " so far" if is_growing else ""
        clear = f"plastic zone clear of the boundaries{so_far}"
        badges.append(
            _badge(
                cut, len(yielding), clear, "boundaries influence the plastic zone", "note", RESULTS
            )
        )
    return tuple(badges)


def _closed(runs: Sequence[ReportRun]) -> str:
    """Return the text of an energy balance that is accepted, with the bound if it is large."""
    bound = max(run.accepted_error for run in runs)
    if bound <= _TIGHT:
        return "energy balance closed"
    return f"energy balance within {show(100 * bound)} %"


def _badge(count: int, total: int, good: str, bad: str, tone: Tone, section: str) -> Badge:
    """Return the badge of a state that ``count`` of ``total`` runs lack."""
    if not count:
        return Badge(good, "good")
    return Badge(f"{bad}: {count} of {total}" if total > 1 else bad, tone, section)


def _notes(inputs: ReportInputs, failures: str) -> list[Note]:
    """Return notes on incomplete or doubtful points and runs, or a note that there are
    none.
    """
    notes = [Note(f"{_LEFT_OUT}{message}.", "bad") for message in inputs.left_out]
    for scan in inputs.scans:
        failed = scan.count("failed")
        missing = sum(point.run is None for point in scan.points) - failed
        undone: list[tuple[int, str, Tone]] = [
            (failed, "failed", "bad"),
            (missing, "is missing" if missing == 1 else "are missing", "note"),
        ]
        notes += [
            Note(f"Scan {scan.label}: {count} of {len(scan.points)} points {what}.", tone, failures)
            for count, what, tone in undone
            if count
        ]
    runs = [run for run in inputs.results() if run.has_balance]
    poor = [run for run in runs if verdict(run)[1] == "bad"]
    idle = [
        run.label
        for run in runs
        if run.number("energy_balance_error") is None and run.number("energy_input_J") == 0
    ]
    unknown = [
        run.label
        for run in runs
        if run.number("energy_balance_error") is None and run.label not in idle
    ]
    beyond = [
        (run, f"{run.label} ({run.number('contacts_beyond_law'):.0f})")
        for run in runs
        if _beyond_law(run)
    ]
    cut = _by_bounds([run for run in runs if mark_of(run.summary) is Mark.CUT])
    waves = [
        f"{run.label} ({100 * run.summary['wave_return_share']:.2g} %)"
        for run in runs
        if Mark.WAVE in zone_marks(run.summary)
    ]
    stopped = [f"{run.label} ({run.stopped})" for run in inputs.results() if run.stopped]
    told: list[tuple[str, Sequence[str], Tone, str]] = [
        (_UNFINISHED, stopped, "bad", ""),
        (_REFUSED, [run.label for run in runs if run.status == "refused"], "bad", _BALANCE),
        *_poor_balances(poor),
        (_IDLE, idle, "note", _BALANCE),
        (_UNKNOWN, unknown, "note", _BALANCE),
        (_BEYOND_FIT, [text for run, text in beyond if _fitted(run)], "note", _BALANCE),
        (_BEYOND_SMALL, [text for run, text in beyond if not _fitted(run)], "note", _BALANCE),
        (_CUT, cut, "note", RESULTS),
        (_WAVES, waves, "note", RESULTS),
        (_NO_CASE, [run.label for run in runs if not run.case], "note", ""),
    ]  # fmt: skip
    notes += [
        Note(f"{text}: {named(labels)}.", tone, section)
        for text, labels, tone, section in told
        if labels
    ]
    notes += [Note(text, "note") for text in end_notes(runs)]
    notes += [Note(text, "note") for text in warning_notes(list(inputs.results()))]
    notes += [
        Note(f"{_DAMAGED.format(run.label)} granwave analyse {inputs.path(run.directory)}", "bad")
        for run in runs
        if run.damaged
    ]
    if runs and not notes:
        return [Note(_GOOD, "good")]
    return notes


def _has_zone(run: ReportRun) -> bool:
    """Return True for a run whose plastic zone could reach a boundary.

    A packing of one layer has no depth; if it also has no sides, its zone has no extent. A
    collision of two spheres has no zone that boundaries limit.
    """
    if run.summary.get("zone_cut") is None or is_collision(run.summary):
        return False
    sizes = [run.summary.get(name) for name in ("zone_depth_90_m", "zone_radius_90_m")]
    has_yielded = bool(run.number("energy_dissipated_plastic_J"))
    return not has_yielded or any(size is not None for size in sizes)


def _by_bounds(runs: Sequence[ReportRun]) -> list[str]:
    """List the boundaries that plastic zones reach, with the runs: ``bottom, sides (a, b)``."""
    labels: dict[str, list[str]] = {}
    for run in runs:
        labels.setdefault(_bounds_reached(run), []).append(run.label)
    return [f"{bounds} ({named(reached)})" for bounds, reached in labels.items()]


def _bounds_reached(run: ReportRun) -> str:
    """Return the boundaries that the plastic zone of a run reaches, in words."""
    return bounds_in_words(run.summary["zone_cut"], periodic=run.summary.get(PERIODIC_SIDES))


def _poor_balances(poor: Sequence[ReportRun]) -> list[tuple[str, Sequence[str], Tone, str]]:
    """Return the text and the labels of runs with a large energy balance error, by their accepted
    error.
    """
    found: list[tuple[str, Sequence[str], Tone, str]] = []
    for accepted in sorted({run.accepted_error for run in poor}):
        runs = [run for run in poor if run.accepted_error == accepted]
        off = significant(max(map(_error_of, runs)), 2)
        text = _POOR.format(off=off, most=significant(accepted, 2))
        found.append((text, [run.label for run in runs], "bad", _BALANCE))
    return found


def _beyond_law(run: ReportRun) -> bool:
    return (run.number("contacts_beyond_law") or 0) > 0


def _error_of(run: ReportRun) -> float:
    """Return the error of the balance; infinite if it is not a number."""
    error = run.number("energy_balance_error") or 0.0
    return math.inf if math.isnan(error) else error


def _input_row(item: ReportRun | ReportScan, inputs: ReportInputs) -> tuple[str | Cell, ...]:
    place = inputs.link(item.directory)
    if place.text == ".":
        place = inputs.link(item.directory, "that of this report")
    name = Cell(item.label, item.label)
    where = Cell(place.text, place.text, link=place)
    if isinstance(item, ReportRun):
        case = show(item.summary["name"]) if item.summary.get("name") is not None else ""
        setting = setting_of(item.case)
        return name, item.kind.noun, case, setting, status_cell(item.status), where
    done = sum(point.run is not None for point in item.points)
    failed = item.count("failed")
    tone: Tone = "bad" if failed else "note"
    if done == len(item.points):
        tone = "good"
    status = Cell(f"{done} of {len(item.points)} points done", done, tone)
    setting = "varied: " + ", ".join(item.source.varied) if item.source.varied else "one point"
    return name, "scan", str(item.source.case_name), setting, status, where


def _versions(inputs: ReportInputs) -> list[Block]:
    """Return tables of versions: first versions that all runs share, then versions that differ, by
    kind of run.
    """
    runs = list(inputs.results())
    same = []
    others = []
    for name in dict.fromkeys(chain.from_iterable(run.versions for run in runs)):
        users = [run for run in runs if name in run.versions]
        found = list(dict.fromkeys(run.versions[name] for run in users))
        if len(found) == 1 and len(users) == sum(
            run.kind in {user.kind for user in users} for run in runs
        ):
            same.append((name, *found))
        else:
            labels = [
                named([run.label for run in users if run.versions[name] == version])
                for version in found
            ]
            others += [(name, version, text) for version, text in zip(found, labels, strict=True)]
    blocks: list[Block] = []
    if same:
        title = "Versions, the same in all" if len(runs) > 1 else "Versions"
        table = text_table(title, ("Program", "Version"), same, captioned=False)
        blocks.append(Group(title, (table,), folded=True))
    if others:
        blocks.append(Note("Not all runs were made with the same versions.", "note"))
        blocks.append(text_table("Versions that differ", ("Program", "Version", "Runs"), others))
    if unknown := [run.label for run in runs if not run.versions]:
        blocks.append(Note(f"No versions are recorded: {named(unknown)}.", "note"))
    return blocks


def verdict(run: ReportRun) -> tuple[str, Tone]:
    """Assess the energy balance of a run."""
    if run.number("energy_balance_error") is None:
        return "not known", "note"
    error = _error_of(run)
    if error > run.accepted_error:
        return f"too large: above {_limit(run)}", "bad"
    if run.kind.accepted_error is None and error > BALANCE_TOLERANCE:
        return f"accepted: at most {_limit(run)}, run.energy_tolerance", "good"
    return "good", "good"


def _limit(run: ReportRun) -> str:
    return plain(f"{run.accepted_error:.1g}")


def balance_section(inputs: ReportInputs) -> DocumentSection:
    """Make the section of the report."""
    runs = [run for run in inputs.results() if run.has_balance]
    if not runs:
        nothing = () if any(inputs.results()) else (Note("There is no finished run."),)
        return DocumentSection("Energy balance", _BALANCE, nothing)
    there = {run.kind for run in runs}
    text = " ".join([_ERROR, *(kind.limits for kind in report_kinds() if kind in there)])
    table = _table(runs)
    shown = (
        Group("Energies of all runs", (table,), folded=True) if len(runs) > _MOST_OPEN else table
    )
    return DocumentSection("Energy balance", _BALANCE, (Note(text), shown))


def _fitted(run: ReportRun) -> bool:
    """Return True if the law of a run was fitted to finite-element results, or is unknown."""
    law = run.case.get("contact.law", "elastoplastic")
    return law != LINE and (law not in ALL_LAWS or bool(ALL_LAWS[law].fitted))


def _energy_columns(
    keys: Sequence[str], runs: Sequence[ReportRun]
) -> list[tuple[TableColumn, list[Cell]]]:
    """Return the columns of energies of runs, in one unit."""
    summaries = [run.summary for run in runs]
    columns: list[tuple[TableColumn, list[Cell]]] = []
    for key, (unit, size) in units_of_values(keys, summaries).items():
        cells = [cell_in_unit(summary.get(key), size) for summary in summaries]
        columns.append((value_column(key, unit=unit), cells))
    return columns


def _table(runs: Sequence[ReportRun]) -> DocumentTable:
    parts = list(_PARTS)
    for kind in dict.fromkeys(run.kind for run in runs):
        parts += kind.energies
    shown = [
        key
        for key in ("energy_input_J", *parts)
        if any(run.summary.get(key) is not None for run in runs)
    ]
    shown += [key for key in _SHARES if any(run.summary.get(key) for run in runs)]
    verdicts = [verdict(run) for run in runs]
    dropped = [run.record.get("attempts") for run in runs]
    errors = [
        value_cell(run.summary.get("energy_balance_error"), tone=tone if tone == "bad" else "")
        for run, (_, tone) in zip(runs, verdicts, strict=True)
    ]
    beyond = [
        value_cell(run.summary.get("contacts_beyond_law"), tone="note" if _beyond_law(run) else "")
        for run in runs
    ]
    columns = [
        (TableColumn("Run", key=True), [Cell(run.label, run.label) for run in runs]),
        *_energy_columns(shown, runs),
        (TableColumn("Error / input", numeric=True), errors),
        (TableColumn("Accepted error", numeric=True), [value_cell(run.accepted_error) for run in runs]),
        (TableColumn("Balance"), [Cell(text, text, tone) for text, tone in verdicts]),
        (TableColumn("Timestep", "s", numeric=True), [value_cell(run.summary.get("timestep_s")) for run in runs]),
        (TableColumn("Timesteps dropped", numeric=True),
         [value_cell(len(one) if isinstance(one, list) else None) for one in dropped]),
        (TableColumn("Contacts beyond the law", numeric=True), beyond),
    ]  # fmt: skip
    return column_table("Energies at the end, and the error of the balance", columns, sortable=True)
