"""The studies that the scans of a report name: the sources beside ours, tolerances, protected targets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from granwave.analysis.document.cells import BLANK, percent, significant, value_cell
from granwave.analysis.document.model import Cell, Column, Figure, Gallery, Group, Note, Section, Table
from granwave.analysis.document.pictures import picture_of
from granwave.analysis.reports.inputs import Inputs, Run
from granwave.analysis.studies.registry import OF_SPHERE_CONTACTS
from granwave.analysis.studies.runs import FinishedRun, SphereContactRun, read_run
from granwave.analysis.studies.study import Kind, Row, Study, make_studies
from granwave.lammps_inputs.run_directory import FIGURES_DIRECTORY, RESULT_FILE

SLUG = "studies"
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
    offered: dict[str, dict[Path, FinishedRun | SphereContactRun]] = {}
    undone: dict[str, list[Mapping[str, Any]]] = {}
    read: dict[Path, tuple[FinishedRun | SphereContactRun, ...]] = {}
    asked = [(run, tuple(named)) for run in inputs.runs]
    asked += [(point.run, (*scan.studies, *named)) for scan in inputs.scans for point in scan.points if point.run]
    for run, names in asked:
        if not names or run.damaged:
            continue
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
        return FinishedRun.among([(run.label, run.directory, run.summary)], lambda _: True)
    found = read_run(run.label, run.directory, run.summary)
    whole = run.status == "done" and (run.directory / RESULT_FILE).is_file()
    return (found,) if isinstance(found, SphereContactRun) and whole else ()


def _group(study: Study, inputs: Inputs, new: bool) -> Group:
    """A study; its text only where it is new."""
    blocks: list[Table | Gallery | Note] = [Note(study.text)] if new else []
    blocks += row_tables(study)
    blocks += study.tables
    if study.pictures:
        blocks.append(Gallery(pictures_of(study, inputs, SLUG)))
    return Group(f"{study.title}: tables and figures" if study.verdict else study.title, tuple(blocks))


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
        value_cell(row.source),
        value_cell(row.ours) if row.ours is None else Cell(significant(row.ours, row.digits), row.ours),
        Cell(percent(100 * deviation), deviation) if deviation is not None else Cell(BLANK),
        value_cell(row.theory),
        Cell(row.where, row.where),
        Cell(row.remark, row.remark),
    )
