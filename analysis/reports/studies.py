"""Studies that the scans of a report name, and runs against each other: tables, figures, verdicts."""

from __future__ import annotations

import dataclasses
import importlib
import logging
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from operator import itemgetter
from pathlib import Path
from typing import Any

from granwave.analysis.document.model import (
    BLANK,
    Block,
    Cell,
    DocumentSection,
    DocumentTable,
    Figure,
    Gallery,
    Group,
    Note,
    TableColumn,
    column_table,
    percent,
    significant,
    value_cell,
)
from granwave.analysis.figures.style import NotDrawn, attempt, style
from granwave.analysis.formatting.numbers import plain, superscript
from granwave.analysis.formatting.values import ratio_in_words, readable_unit
from granwave.analysis.notebook import run as notebook
from granwave.analysis.reports.figures import picture_of
from granwave.analysis.reports.inputs import ReportInputs
from granwave.analysis.reports.kinds import ReportRun
from granwave.analysis.result.writer import BALANCE_REFUSED
from granwave.analysis.studies.registry import COMPARISON, STUDIES, is_study_file
from granwave.analysis.studies.runs import AnyRun, FinishedRun
from granwave.analysis.studies.study import Kind, Row, Study, make_studies, requirement
from granwave.lammps_inputs.run_directory import FIGURES_DIRECTORY, RESULT_FILE

_LOG = logging.getLogger(__name__)

SLUG = "studies"


@dataclasses.dataclass(frozen=True)
class ReportStudies:
    """Studies of a report.

    Attributes
    ----------
    of_scans
        Studies that the scans or the caller name.
    compared
        Comparisons of the runs with each other.
    """

    of_scans: Sequence[Study]
    compared: Sequence[Study]


def report_studies(inputs: ReportInputs, named: Sequence[str] = ()) -> ReportStudies:
    """Make the studies of a report.

    Parameters
    ----------
    named
        Names of studies of all runs, in addition to those that the scans name.
    """
    return ReportStudies(studies_of(inputs, named), comparison_of(inputs))


_CLOSE = (0.02, 0.1)  # largest difference from the source that is counted
_MOST_VERDICTS = 3  # most verdicts whose first sentences begin a report
#: End of the caption of the rows of each kind, and the heading of the theory's column.
_KINDS: dict[Kind, tuple[str, str]] = {
    "source": ("source against ours", "Theory"),
    "theory": ("theory against ours", "Theory"),
    "verification": ("verification of the code", "Must be"),
    "alone": ("granwave only (no reference)", "Theory"),
}
_VERIFIES = (
    "A verification tests the code, not a source: it compares with a second solver, a check "
    "value or a formula, or follows from similarity."
)


def studies_section(inputs: ReportInputs, found: Sequence[Study]) -> DocumentSection:
    """The section of the report; without blocks if there is no study, and without the figure at the
    top of the report.
    """
    above = _with_main_picture(found, inputs)
    groups = []
    for n, study in enumerate(found):
        pictures = study.pictures[1:] if study is above else study.pictures
        blocks: list[DocumentTable | Gallery | Note] = [*row_tables(study), *study.tables]
        blocks += pictures_of(dataclasses.replace(study, pictures=pictures), inputs, SLUG)
        if not blocks or study.text not in [one.text for one in found[:n]]:
            blocks.insert(0, Note(study.text))
        title = f"{study.title}: tables and figures" if study.verdict else study.title
        groups.append(Group(title, tuple(blocks)))
    return DocumentSection("Studies", SLUG, tuple(groups))


def main_picture(found: Sequence[Study], inputs: ReportInputs) -> Figure | None:
    """Return the first figure of the studies of a scan, for the top of the report; None if there
    are other inputs.
    """
    study = _with_main_picture(found, inputs)
    if study is None:
        return None
    first = pictures_of(
        dataclasses.replace(study, pictures=study.pictures[:1], failed=()), inputs, SLUG
    )[0]
    return first.figures[0] if isinstance(first, Gallery) else None


def _with_main_picture(found: Sequence[Study], inputs: ReportInputs) -> Study | None:
    alone = len(inputs.scans) == len(inputs.items) == 1
    return next((study for study in found if study.pictures), None) if alone else None


def leads(found: Sequence[Study]) -> tuple[Note, ...]:
    """Return the results of studies in sentences for the top of the report: agreement with
    sources, and verdicts.
    """
    rows = []
    for study in found:
        for row in study.rows:
            if row.kind == "source" and row.deviation is not None:
                rows.append(row)
    texts = []
    if rows:
        off = [abs(row.deviation or 0.0) for row in rows]
        within = " and ".join(
            f"within {100 * most:g} % for {sum(one <= most for one in off)}" for most in _CLOSE
        )
        worst = max(zip(off, rows, strict=True), key=itemgetter(0))
        name = ratio_in_words(worst[1].quantity)
        texts.append(
            f"Of {len(rows)} values of the sources, granwave agrees {within}; the largest "
            f"difference is {plain(f'{100 * worst[0]:.2g}')} % "
            f"({name[:1].lower()}{name[1:]})."
        )
    return tuple(Note(text, "lead") for text in [*texts, *_firsts(found).values()])


def verdicts(found: Sequence[Study]) -> tuple[Group, ...]:
    """Return the verdicts of studies that are not in `leads`."""
    said = _firsts(found)
    rest = [(study, study.verdict[study.name in said :]) for study in found]
    return tuple(
        Group(study.title, tuple(map(Note, verdict))) for study, verdict in rest if verdict
    )


def _firsts(found: Sequence[Study]) -> dict[str, str]:
    """Return the first sentences of the verdicts, unless there are many; several have their titles
    before them.
    """
    judged = [study for study in found if study.verdict]
    if len(judged) > _MOST_VERDICTS:
        return {}
    if len(judged) == 1:
        return {judged[0].name: judged[0].verdict[0]}
    return {study.name: f"{study.title}: {study.verdict[0]}" for study in judged}


def studies_of(inputs: ReportInputs, named: Sequence[str] = ()) -> list[Study]:
    """Studies named by the scans of a report, of all undamaged runs of these scans.

    Parameters
    ----------
    named
        Further studies, of all runs of the report.
    """
    offered: dict[str, dict[Path, Any]] = {}
    undone: dict[str, list[Mapping[str, Any]]] = {}
    read: dict[Path, AnyRun[Any] | None] = {}
    for run, labels, names in _runs_of_studies(inputs, named):
        for name in names:
            if run is None:
                undone.setdefault(name, []).append(labels)
            elif run.damaged:
                continue
            elif is_study_file(name):
                if run.status == "done":
                    offered.setdefault(name, {}).setdefault(
                        run.directory, notebook.Run(run.directory, labels)
                    )
            else:
                if run.directory not in read:
                    read[run.directory] = _read(run)
                found = read[run.directory]
                if isinstance(found, _run_type(name)):
                    offered.setdefault(name, {})[run.directory] = found
                elif run.kind.of_spheres:
                    offered.setdefault(name, {})
    made = make_studies({name: list(runs.values()) for name, runs in offered.items()}, undone)
    _warn_of_missing(made, named)
    return made


def _warn_of_missing(made: Sequence[Study], named: Sequence[str]) -> None:
    """Warn of studies named by the user that do not suit the runs."""
    made_by_name = {study.named for study in made}
    for name in named:
        if name not in made_by_name:
            _LOG.warning(
                "the report does not contain the study %s, which needs %s", name, requirement(name)
            )


def _runs_of_studies(
    inputs: ReportInputs, named: Sequence[str]
) -> Iterator[tuple[ReportRun | None, Mapping[str, Any], Sequence[str]]]:
    """Return each run of a report with its labels in a scan, and the names of its studies."""
    for run in inputs.runs:
        yield run, {}, named
    for scan in inputs.scans:
        for point in scan.points:
            yield point.run, point.result.labels, (*scan.studies, *named)


def _run_type(study: str) -> type[AnyRun[Any]]:
    """Return the class of the runs of a study."""
    if study not in STUDIES:
        return FinishedRun
    kind: type[AnyRun[Any]] = getattr(
        importlib.import_module(STUDIES[study]), "RUN_TYPE", FinishedRun
    )
    return kind


def _read(run: ReportRun) -> AnyRun[Any] | None:
    """Read a run for studies; None if no study takes its kind, or if it was rejected or cannot be
    read.
    """
    whole = run.status == "done" and (run.directory / RESULT_FILE).is_file()
    if not run.kind.of_spheres and not whole:
        return None
    if run.summary.get("end_reason") == BALANCE_REFUSED:
        return None
    return run.kind.study_run(run)


def row_tables(study: Study) -> list[DocumentTable | Note]:
    """Tables of the rows of a study, one for each kind; a report omits columns without a value."""
    blocks: list[DocumentTable | Note] = []
    for kind, (caption, theory) in _KINDS.items():
        rows = [row for row in study.rows if row.kind == kind]
        if not rows:
            continue
        footnotes = _footnotes(rows)
        names = [_quantity_name(row, footnotes) for row in rows]
        columns = [
            (TableColumn("Quantity", key=True), [Cell(name, name) for name in names]),
            (
                TableColumn("Source", numeric=True),
                [_reference(row.source, bound=row.bound) for row in rows],
            ),
            (TableColumn("Ours", numeric=True), [_number(row.ours, row.digits) for row in rows]),
            (TableColumn("Difference", numeric=True), [_difference(row.deviation) for row in rows]),
            (TableColumn(theory, numeric=True), [_theory(row) for row in rows]),
            (TableColumn("Where"), [Cell(row.where, row.where) for row in rows]),
        ]
        blocks += [Note(_VERIFIES)] if kind == "verification" else []
        table = column_table(
            f"{study.title}: {caption}",
            columns,
            sortable=True,
            by_row=True,
            footnotes=tuple(f"{mark} {remark}" for remark, mark in footnotes.items()),
        )
        blocks.append(table)
    return blocks


def _footnotes(rows: Sequence[Row]) -> dict[str, str]:
    """Return the mark of each remark of the rows, in their order; equal remarks share one."""
    remarks = dict.fromkeys(row.remark for row in rows if row.remark)
    return {remark: superscript(place) for place, remark in enumerate(remarks, 1)}


def _quantity_name(row: Row, footnotes: Mapping[str, str]) -> str:
    """Return the quantity of a row with its unit and the mark of its remark."""
    quantity = ratio_in_words(row.quantity)
    name = f"{quantity} ({readable_unit(row.unit)})" if row.unit else quantity
    return f"{name} {footnotes[row.remark]}" if row.remark else name


def _theory(row: Row) -> Cell:
    """Return the value of theory, which is a bound only in a row without a source."""
    return _reference(row.theory, bound=row.bound and row.source is None)


def _reference(value: float | None, *, bound: bool) -> Cell:
    if bound and value is not None:
        return Cell(f"{significant(value, 5)} (bound)", value)
    return value_cell(value)


def _number(value: float | None, digits: int) -> Cell:
    return value_cell(None) if value is None else Cell(significant(value, digits), value)


def _difference(deviation: float | None) -> Cell:
    return Cell(BLANK) if deviation is None else Cell(percent(100 * deviation), deviation)


def pictures_of(study: Study, inputs: ReportInputs, section: str) -> tuple[Gallery | Note, ...]:
    """Figures of a study, with links to saved data, and messages on figures that
    failed.

    Parameters
    ----------
    section
        Slug of the section, before the names of their files.
    """
    figures = list[Figure]()
    failed = list(study.failed)
    folders = [inputs.base] + [item.directory for item in inputs.items if len(inputs.items) == 1]
    for picture in study.pictures:
        name = f"{FIGURES_DIRECTORY}/{picture.name}.csv"
        data = next((folder / name for folder in folders if (folder / name).is_file()), None)
        link = inputs.link(data, name) if data else None
        slug = f"{section}-{picture.name.replace('_', '-')}"
        figure = attempt(
            f"figure {picture.name}",
            partial(picture_of, picture.drawing, slug, picture.caption, link),
        )
        failed.append(figure) if isinstance(figure, NotDrawn) else figures.append(figure)
    gallery = (Gallery(tuple(figures)),) if figures else ()
    return (*gallery, *(Note(f"The {one}.", "bad") for one in failed))


_COMPARISON = "comparison"
_DISSIPATION = "Dissipation and plastic zones"  # title of the section


def comparison_section(inputs: ReportInputs, compared: Sequence[Study]) -> DocumentSection:
    """The section of the report; without blocks if there is nothing to compare.

    Omitted runs are named with the reason.

    Parameters
    ----------
    compared
        Comparisons of the runs, from `comparison_of`.
    """
    blocks: list[Block] = []
    for study in compared:
        if study.pictures or study.failed:
            with style():
                pictures = pictures_of(study, inputs, _COMPARISON)
            blocks += [Note(study.text), *pictures, *study.tables]
    if blocks and (refused := [run.label for run in inputs.whole() if run.status == "refused"]):
        blocks.append(
            Note(
                f"Omitted here, because the energy balance did not close: {', '.join(refused)}.",
                "bad",
            )
        )
    if blocks:
        runs = _whole_runs(inputs)
        for path in COMPARISON.values():
            blocks += importlib.import_module(path).remarks(runs)
    return DocumentSection(_DISSIPATION, _COMPARISON, tuple(blocks))


def comparison_of(inputs: ReportInputs) -> list[Study]:
    """Comparisons of a report's runs; empty if none can be compared."""
    runs = _whole_runs(inputs)
    compared = {
        name: runs
        for name, path in COMPARISON.items()
        if importlib.import_module(path).can_compare(runs)
    }
    return make_studies(compared)


def _whole_runs(inputs: ReportInputs) -> list[AnyRun[Any]]:
    """Return the runs with a closed balance for comparison; empty if there is no
    comparison.
    """
    if not COMPARISON:
        return []
    whole = [run for run in inputs.whole() if run.has_balance and run.status != "refused"]
    runs = [run.kind.study_run(run) for run in whole]
    return [run for run in runs if run is not None]
