"""Studies that the scans of a report name, and runs against each other: tables, figures, verdicts."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from granwave.analysis.document.model import (
    BLANK,
    Block,
    Cell,
    Column,
    Figure,
    Gallery,
    Group,
    Note,
    Section,
    Table,
    named,
    percent,
    significant,
    value_cell,
)
from granwave.analysis.figures.style import NotDrawn, attempt, style
from granwave.analysis.formatting.numbers import plain
from granwave.analysis.notebook import run as notebook
from granwave.analysis.reports.figures import picture_of
from granwave.analysis.reports.inputs import Inputs, Run
from granwave.analysis.studies.packing_and_block.impacts import collect, not_ideal
from granwave.analysis.studies.registry import COMPARISON, OF_SPHERE_CONTACTS, is_study_file
from granwave.analysis.studies.runs import ContinuumRun, FinishedRun, SphereContactRun, finished_runs, read_run
from granwave.analysis.studies.study import Kind, Row, Study, make_studies
from granwave.lammps_inputs.run_directory import FIGURES_DIRECTORY, RESULT_FILE

SLUG = "studies"
_CLOSE = (0.02, 0.1)  # differences from the sources up to which values are counted
_MOST_VERDICTS = 3  # whose first sentences begin a report
#: End of the caption of the rows of each kind, and the heading of the theory's column.
_KINDS: dict[Kind, tuple[str, str]] = {
    "source": ("source against ours", "Theory"),
    "theory": ("theory against ours", "Theory"),
    "verification": ("verification of the code", "Must be"),
    "alone": ("ours alone", "Theory"),
}
_VERIFIES = (
    "A verification tests the code, not a source: its value is that of a second solver, a check value or a formula, or "
    "follows for any correct code by similarity."
)


def studies_section(inputs: Inputs, found: Sequence[Study]) -> Section:
    """The section of the report; without blocks where there is no study, and without the picture at the top of all."""
    texts = [study.text for study in found]
    first = [texts.index(text) == n for n, text in enumerate(texts)]
    if (above := _with_main_picture(found, inputs)) is not None:
        shown = [dataclasses.replace(one, pictures=one.pictures[1:]) if one is above else one for one in found]
        found = shown
    return Section("Studies", SLUG, tuple(_group(study, inputs, new) for study, new in zip(found, first, strict=True)))


def leads(found: Sequence[Study]) -> tuple[Note, ...]:
    """Return what the studies come to, in sentences for the top of the report: agreement with sources, and verdicts."""
    return tuple(Note(text, "lead") for text in [_agreement(found), *(text for _, text in _firsts(found))] if text)


def main_picture(found: Sequence[Study], inputs: Inputs) -> Figure | None:
    """Return the first picture of the studies of a scan, for the top of the report; None beside other inputs."""
    study = _with_main_picture(found, inputs)
    if study is None:
        return None
    first = pictures_of(dataclasses.replace(study, pictures=study.pictures[:1], failed=()), inputs, SLUG)[0]
    return first.figures[0] if isinstance(first, Gallery) else None


def _with_main_picture(found: Sequence[Study], inputs: Inputs) -> Study | None:
    alone = len(inputs.scans) == len(inputs.items) == 1
    return next((study for study in found if study.pictures), None) if alone else None


def verdicts(found: Sequence[Study]) -> tuple[Group, ...]:
    """Return the verdicts of studies without what `leads` has said."""
    said = {study.name: 1 for study, _ in _firsts(found)}
    rest = [(study, study.verdict[said.get(study.name, 0) :]) for study in found]
    return tuple(Group(study.title, tuple(map(Note, verdict))) for study, verdict in rest if verdict)


def _firsts(found: Sequence[Study]) -> list[tuple[Study, str]]:
    """Return the first sentences of the verdicts, unless there are many; several have their titles before them."""
    judged = [study for study in found if study.verdict]
    if len(judged) > _MOST_VERDICTS:
        return []
    return [(study, f"{study.title}: {study.verdict[0]}" if len(judged) > 1 else study.verdict[0]) for study in judged]


def _agreement(found: Sequence[Study]) -> str:
    """Say how far our values are from those of the sources; empty if there are none of theirs."""
    compared = [row for study in found for row in study.rows if row.kind == "source"]
    rows = [(abs(row.deviation), row) for row in compared if row.deviation is not None]
    if not rows:
        return ""
    if len(rows) == 1:
        return f"The one value that a source gives, and ours, differ by {_percent(rows[0][0])}."
    close = [sum(deviation <= limit for deviation, _ in rows) for limit in _CLOSE]
    text = f"Of {len(rows)} values that the sources give, {close[0]} of ours lie within {_percent(_CLOSE[0])}"
    text += f" and {close[1]} within {_percent(_CLOSE[1])}"
    far = [row for deviation, row in rows if deviation > _CLOSE[1] and row.theory and row.ours is not None]
    as_theory = sum(abs(row.ours / row.theory - 1) <= _CLOSE[0] for row in far)  # type: ignore[operator]
    if as_theory:
        text += f"; {as_theory} more lie within {_percent(_CLOSE[0])} of theory"
    worst, row = max(rows, key=lambda pair: pair[0])
    if worst > 1:
        return f"{text}. Remarks tell why the rest differ."
    return f"{text}; the largest difference is {_percent(worst)} ({row.quantity[:1].lower()}{row.quantity[1:]})."


def _percent(share: float) -> str:
    """Return a share in per cent, with two digits."""
    return f"{plain(f'{100 * share:.2g}')} %"


def studies_of(inputs: Inputs, named: Sequence[str] = ()) -> list[Study]:
    """Studies that the scans of a report name, of all runs of the scans that name them but those that are damaged.

    Parameters
    ----------
    named
        Further studies, of all runs of the report.
    """
    offered: dict[str, dict[Path, Any]] = {}
    undone: dict[str, list[Mapping[str, Any]]] = {}
    read: dict[Path, tuple[FinishedRun | SphereContactRun, ...]] = {}
    nothing: Mapping[str, Any] = {}
    asked = [(run, nothing, tuple(named)) for run in inputs.runs]
    asked += [
        (point.run, point.result.labels, (*scan.studies, *named))
        for scan in inputs.scans
        for point in scan.points
        if point.run
    ]
    for run, labels, names in asked:
        if not names or run.damaged:
            continue
        for name in filter(is_study_file, names):
            if run.status == "done":
                offered.setdefault(name, {}).setdefault(run.directory, notebook.Run(run.directory, labels))
        names = tuple(name for name in names if not is_study_file(name))
        if run.directory not in read:
            read[run.directory] = _read(run)
        for name in names:
            wanted = SphereContactRun if name in OF_SPHERE_CONTACTS else FinishedRun
            found = {one.directory: one for one in read[run.directory] if isinstance(one, wanted)}
            if found or run.kind == "run":
                offered.setdefault(name, {}).update(found)
    for scan in inputs.scans:
        for name in (*scan.studies, *named):
            undone.setdefault(name, []).extend(point.result.labels for point in scan.points if point.run is None)
    return make_studies({name: list(runs.values()) for name, runs in offered.items()}, undone)


def _read(run: Run) -> tuple[FinishedRun | SphereContactRun, ...]:
    """Read a run for studies; nothing if there are none of its kind, or it was refused or cannot be read."""
    if run.kind == "run":
        return tuple(finished_runs([(run.label, run.directory, run.summary)]))
    found = read_run(run.label, run.directory, run.summary)
    whole = run.status == "done" and (run.directory / RESULT_FILE).is_file()
    return (found,) if isinstance(found, SphereContactRun) and whole else ()


def _group(study: Study, inputs: Inputs, new: bool) -> Group:
    """A study; its text where it is new, or where there is nothing else."""
    blocks: list[Table | Gallery | Note] = [Note(study.text)] if new else []
    blocks += row_tables(study)
    blocks += study.tables
    blocks += pictures_of(study, inputs, SLUG)
    title = f"{study.title}: tables and figures" if study.verdict else study.title
    return Group(title, tuple(blocks) or (Note(study.text),))


def row_tables(study: Study) -> list[Table | Note]:
    """Tables of the rows of a study, one for each kind."""
    blocks: list[Table | Note] = []
    for kind, (caption, theory) in _KINDS.items():
        rows = tuple(_cells(row) for row in study.rows if row.kind == kind)
        if rows and kind == "verification":
            blocks.append(Note(_VERIFIES))
        if rows:
            table = Table(f"{study.title}: {caption}", _columns(theory), rows, sortable=True, by_row=True)
            blocks.append(table)
    return blocks


def pictures_of(study: Study, inputs: Inputs, section: str) -> tuple[Gallery | Note, ...]:
    """Pictures of a study, with links to their data where it was saved, and what of it could not be made.

    Parameters
    ----------
    section
        Slug of the section, before the names of their files.
    """
    figures, failed = list[Figure](), list(study.failed)
    folders = [inputs.base] + [item.directory for item in inputs.items if len(inputs.items) == 1]
    for picture in study.pictures:
        name = f"{FIGURES_DIRECTORY}/{picture.name}.csv"
        data = next((folder / name for folder in folders if (folder / name).is_file()), None)
        link = inputs.link(data, name) if data else None
        slug = f"{section}-{picture.name.replace('_', '-')}"
        figure = attempt(f"figure {picture.name}", partial(picture_of, picture.drawing, slug, picture.caption, link))
        failed.append(figure) if isinstance(figure, NotDrawn) else figures.append(figure)
    gallery = (Gallery(tuple(figures)),) if figures else ()
    return (*gallery, *(Note(f"The {one}.", "bad") for one in failed))


def _columns(theory: str) -> tuple[Column, ...]:
    """Return the columns of a table of rows; those without a value are left out of a report."""
    numbers = ("Source", "Ours", "Difference", theory)
    return (
        Column("Quantity", key=True), *(Column(one, numeric=True) for one in numbers), Column("Where"), Column("Remark")
    )  # fmt: skip


def _cells(row: Row) -> tuple[Cell, ...]:
    deviation = row.deviation
    name = f"{row.quantity} ({row.unit})" if row.unit else row.quantity
    return (
        Cell(name, name),
        Cell(f"{significant(row.source, 5)} (bound)", row.source)
        if row.bound and row.source is not None
        else value_cell(row.source),
        value_cell(row.ours) if row.ours is None else Cell(significant(row.ours, row.digits), row.ours),
        Cell(percent(100 * deviation), deviation) if deviation is not None else Cell(BLANK),
        value_cell(row.theory),
        Cell(row.where, row.where),
        Cell(row.remark, row.remark),
    )


_COMPARISON = "comparison"


def comparison_section(inputs: Inputs) -> Section:
    """The section of the report; without blocks where there is nothing to compare.

    Runs that are left out are named with the reason.
    """
    blocks: list[Block] = []
    runs = _compared(inputs)
    for study in _studies(runs):
        if study.pictures or study.failed:
            with style():
                pictures = pictures_of(study, inputs, _COMPARISON)
            blocks += [Note(study.text), *pictures, *study.tables]
    if blocks and (refused := [run.label for run in inputs.whole() if run.status == "refused"]):
        blocks.append(Note(f"Left out here, as the energy balance did not close: {', '.join(refused)}.", "bad"))
    if blocks and (others := _left_out(runs)):
        listed = "; ".join(f"{named(labels)} ({reason})" for reason, labels in others.items())
        blocks.append(Note(f"Left out here: {listed}.", "note"))
    return Section("Comparison", _COMPARISON, tuple(blocks))


def comparison_of(inputs: Inputs) -> list[Study]:
    """Comparison of a report's runs; empty if none can be compared."""
    return _studies(_compared(inputs))


def _studies(runs: Sequence[FinishedRun | ContinuumRun]) -> list[Study]:
    impacts = collect(runs)
    if len(impacts.granular) + len(impacts.continuum) < 2:
        return []
    return make_studies(dict.fromkeys(COMPARISON, runs))


def _compared(inputs: Inputs) -> list[FinishedRun | ContinuumRun]:
    """Return the runs of grains and of blocks with a closed balance."""
    whole = [run for run in inputs.whole() if run.has_balance and run.status != "refused"]
    found = [read_run(run.label, run.directory, run.summary) for run in whole]
    return [run for run in found if isinstance(run, FinishedRun | ContinuumRun)]


def _left_out(runs: Sequence[FinishedRun | ContinuumRun]) -> dict[str, list[str]]:
    """Return the labels of the runs that the comparison does not show, by the reason."""
    found: dict[str, list[str]] = {}
    for run in runs:
        if isinstance(run, FinishedRun) and (reason := not_ideal(run)):
            found.setdefault(reason, []).append(run.label)
    others = collect(runs).other_packings
    return found | ({"another packing than the reference's": others["label"].tolist()} if len(others) else {})
