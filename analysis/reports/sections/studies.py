"""The studies that the scans of a report name: the sources beside ours, tolerances, protected targets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from granwave.analysis.document.cells import BLANK, percent, value_cell
from granwave.analysis.document.model import Cell, Column, Figure, Gallery, Group, Note, Section, Table
from granwave.analysis.document.pictures import picture_of
from granwave.analysis.reports.inputs import Inputs
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Row, Study, make_studies
from granwave.lammps_inputs.run_directory import FIGURES_DIRECTORY

SLUG = "studies"
_COLUMNS = (
    Column("Quantity", key=True),
    Column("Source", numeric=True),
    Column("Ours", numeric=True),
    Column("Difference", numeric=True),
    Column("Theory", numeric=True),
    Column("Where"),
    Column("Remark"),
)


def studies_section(inputs: Inputs, found: Sequence[Study]) -> Section:
    """The section of the report; without blocks where there is no study."""
    texts = [study.text for study in found]
    first = [texts.index(text) == n for n, text in enumerate(texts)]
    return Section("Studies", SLUG, tuple(_group(study, inputs, new) for study, new in zip(found, first, strict=True)))


def verdicts(found: Sequence[Study]) -> tuple[Group, ...]:
    """Return the verdicts of studies, for the top of the report."""
    return tuple(Group(study.title, tuple(map(Note, study.verdict))) for study in found if study.verdict)


def studies_of(inputs: Inputs, named: Sequence[str] = ()) -> list[Study]:
    """Studies that the scans of a report name, of all runs of the scans that name them but those that are damaged.

    Parameters
    ----------
    named
        Further studies, of all runs of the report.
    """
    offered: dict[str, dict[Path, FinishedRun]] = {}
    undone: dict[str, list[Mapping[str, Any]]] = {}
    read: dict[Path, tuple[FinishedRun, ...]] = {}
    asked = [(run, tuple(named)) for run in inputs.runs]
    asked += [(point.run, (*scan.studies, *named)) for scan in inputs.scans for point in scan.points if point.run]
    for run, names in asked:
        if not names or run.kind != "run" or run.damaged:
            continue
        if run.directory not in read:
            read[run.directory] = FinishedRun.among([(run.label, run.directory, run.summary)])
        for name in names:
            offered.setdefault(name, {}).update((one.directory, one) for one in read[run.directory])
    for scan in inputs.scans:
        for name in (*scan.studies, *named):
            undone.setdefault(name, []).extend(point.result.labels for point in scan.points if point.run is None)
    return make_studies({name: list(runs.values()) for name, runs in offered.items()}, undone)


def _group(study: Study, inputs: Inputs, new: bool) -> Group:
    """A study; its text only where it is new."""
    blocks: list[Table | Gallery | Note] = [Note(study.text)] if new else []
    if study.rows:
        what = "source" if any(row.source is not None for row in study.rows) else "theory"
        rows = tuple(map(_cells, study.rows))
        blocks.append(Table(f"{study.title}: {what} against ours", _COLUMNS, rows, sortable=True, by_row=True))
    blocks += study.tables
    if study.pictures:
        blocks.append(Gallery(pictures_of(study, inputs, SLUG)))
    return Group(f"{study.title}: tables and figures" if study.verdict else study.title, tuple(blocks))


def pictures_of(study: Study, inputs: Inputs, section: str) -> tuple[Figure, ...]:
    """Pictures of a study, with links to their data where it was saved.

    Parameters
    ----------
    section
        Slug of the section, before the names of their files.
    """
    figures = []
    folders = [inputs.base] + [item.directory for item in inputs.items if len(inputs.items) == 1]
    for picture in study.pictures:
        name = f"{FIGURES_DIRECTORY}/{picture.name}.csv"
        data = next((folder / name for folder in folders if (folder / name).is_file()), None)
        link = inputs.link(data, name) if data else None
        slug = f"{section}-{picture.name.replace('_', '-')}"
        figures.append(picture_of(picture.drawing, slug, picture.caption, link))
    return tuple(figures)


def _cells(row: Row) -> tuple[Cell, ...]:
    against = row.expected if row.source is None else row.source
    deviation = row.ours / against - 1 if against else None
    name = f"{row.quantity} ({row.unit})" if row.unit else row.quantity
    return (
        Cell(name, name),
        value_cell(row.source) if row.source is not None else Cell(BLANK),
        value_cell(row.ours),
        Cell(percent(100 * deviation), deviation) if deviation is not None else Cell(BLANK),
        value_cell(row.expected) if row.expected is not None else Cell(BLANK),
        Cell(row.where, row.where),
        Cell(row.remark, row.remark),
    )
