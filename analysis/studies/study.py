"""Comparison of a source with our results: rows of one table, figures, and further tables."""

from __future__ import annotations

import dataclasses
import importlib
import io
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from granwave.analysis.document.model import (
    BLANK,
    Cell,
    DocumentTable,
    Note,
    TableColumn,
    value_cell,
)
from granwave.analysis.errors import MissingDataError
from granwave.analysis.formatting.numbers import with_interval
from granwave.analysis.statistics import Estimate
from granwave.analysis.studies.registry import (
    COMPARISON,
    STUDIES,
    is_loaded,
    is_study_file,
    load_study,
)
from granwave.lammps_inputs.files import replace_text, write_csv_rows
from granwave.lammps_inputs.own_files import AnyPath
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import STUDY_ROWS

if TYPE_CHECKING:
    from granwave.analysis.figures.style import NotDrawn
    from granwave.analysis.studies.runs import AnyRun

Kind = Literal["source", "theory", "verification", "alone"]
Labels = Sequence[Mapping[str, Any]]  # values of the varied keys, for points of scans
Runs: TypeAlias = "Sequence[AnyRun[Any]]"


@dataclasses.dataclass(frozen=True)
class Row:
    """One quantity: the value of a source or theory, and our value.

    Attributes
    ----------
    quantity
        Name, with position and method of measurement.
    unit
        Of all three; empty for a number.
    source
        The source's value, as it is printed there; None where it gives none.
    ours
        Measured in the runs, so that it changes with them; None where only source and theory speak.
    where
        Source and position in it: ``Nesterenko (1.21)``.
    remark
        Why they differ, where they do by more than a few per cent.
    theory
        From theory. Of a verification: a value that the code must reproduce.
    verification
        The row tests the code, not the source: a second solver, a check value, a formula, or a
        value that similarity forces on any correct code.
    digits
        Meaningful digits of our value, where it depends on a choice such as the range of a fit.
    bound
        The value of the source (without a source, of theory) is a bound, such as the end of an
        axis: no difference from it is given.
    """

    quantity: str
    unit: str = ""
    source: float | None = None
    ours: float | None = None
    where: str = ""
    remark: str = ""
    theory: float | None = None
    verification: bool = False
    digits: int = 5
    bound: bool = False

    def __post_init__(self) -> None:
        """Convert numbers of numpy to Python, and reject a row without a comparison.

        Raises
        ------
        ValueError
            It has no value; or it is a verification without one of its two values, or with a value
            of a source.
        """
        for name in ("source", "ours", "theory"):
            if hasattr(value := getattr(self, name), "item"):
                object.__setattr__(self, name, value.item())
        if self.verification and (
            self.source is not None or self.ours is None or self.theory is None
        ):
            raise ValueError(
                f"{self.quantity}: expected ours and theory, and no source, of a verification"
            )
        if self.source is None and self.ours is None:
            raise ValueError(
                f"{self.quantity}: found no value, expected a value of the source or ours"
            )

    @property
    def kind(self) -> Kind:
        """Kind of the value that ours is compared with."""
        if self.verification:
            return "verification"
        if self.source is not None:
            return "source"
        return "alone" if self.theory is None else "theory"

    @property
    def deviation(self) -> float | None:
        """Our value divided by the source's value (without a source, the theory's value), minus 1;
        None for a bound.
        """
        against = self.theory if self.source is None else self.source
        return (
            self.ours / against - 1
            if against and self.ours is not None and not self.bound
            else None
        )


@dataclasses.dataclass(frozen=True)
class Picture:
    """A figure of a study.

    Attributes
    ----------
    name
        Of its files. An empty name, or one that begins with an underscore, is appended to the
        study's name: ``_pulses`` of ``square-in-plane`` becomes ``square_in_plane_pulses``.
    drawing
        The figure; a matplotlib figure is given its data. A function that draws it, for a figure
        whose failure shall not cost the next.
    data
        Of a figure of matplotlib: arrays by name, with the unit at the end of the name, saved as
        CSV next to it.
    """

    name: str
    caption: str
    drawing: Any
    data: dataclasses.InitVar[Mapping[str, Any] | None] = None

    def __post_init__(self, data: Mapping[str, Any] | None) -> None:
        """Combine a matplotlib figure and its data."""
        from granwave.analysis.figures.style import (
            Drawing,
        )  # imported on demand: matplotlib takes a second to load

        if not isinstance(self.drawing, Drawing) and not callable(self.drawing):
            object.__setattr__(self, "drawing", Drawing(self.drawing, dict(data or {})))


@dataclasses.dataclass(frozen=True)
class Study:
    """Result of a study.

    Attributes
    ----------
    name
        Short, for links and files.
    title
        Of its part of the report.
    text
        Description of the runs, in a few sentences.
    rows
        Rows of the tables, one table for each kind.
    pictures
        Figures, in the order of the report.
    tables
        Tables of the study, with notes.
    verdict
        Results, in sentences for the top of the report.
    failed
        Parts that could not be drawn or computed.
    named
        Name or path by which a scan or the user named the study.
    """

    name: str
    title: str
    text: str
    rows: tuple[Row, ...] = ()
    pictures: tuple[Picture, ...] = ()
    tables: tuple[DocumentTable | Note, ...] = ()
    verdict: tuple[str, ...] = ()
    failed: tuple[NotDrawn, ...] = ()
    named: str = ""


def make_studies(
    runs: Mapping[str, Runs], undone: Mapping[str, Labels] | None = None
) -> list[Study]:
    """Make studies of finished runs, in the order of the registry.

    Parameters
    ----------
    runs
        Runs offered to each study, by its name; see `granwave.analysis.studies.registry`.
    undone
        Points that failed or were not run of the scans that name a study, as values of the keys
        that vary.
    """
    from granwave.analysis.figures.style import style  # loads matplotlib: imported on demand

    if not runs:
        return []
    with style():
        modules: dict[str, Any] = {
            name: importlib.import_module(path)
            for name, path in (STUDIES | COMPARISON).items()
            if name in runs
        }
        modules |= {name: load_study(name) for name in runs if is_study_file(name)}
        studies = list[Study]()
        for name, module in modules.items():
            made = _make(Path(name).stem, module, runs[name], (undone or {}).get(name, ()))
            studies += [dataclasses.replace(study, named=name) for study in made]
        return studies


def requirement(name: str) -> str:
    """State the runs that a study needs: ``packings of at least 3 heights``."""
    if is_study_file(name):
        return "at least one finished run that its function select(runs) accepts"
    return getattr(importlib.import_module(STUDIES[name]), "NEEDS", "other runs")


def _make(name: str, module: Any, runs: Runs, undone: Labels) -> Iterator[Study]:
    """Make the study of each group of runs."""
    groups = list(module.select(runs))
    # the module distinguishes the groups
    numbered = len(groups) > 1 and not hasattr(module, "name")
    for number, group in enumerate(groups, start=1):
        parts = _Parts(module, _word(name, module, group, number))
        # in the order in which they are made, which is the order of failures
        rows = tuple(parts.of("rows", group))
        pictures = tuple(_pictures(parts, group, f"_{number}" if numbered else ""))
        title = module.title(group) if hasattr(module, "title") else module.TITLE
        if numbered and not hasattr(module, "title"):
            title = f"{title} ({number})"
        yield Study(
            f"{name}-{number}" if numbered else parts.study,
            title,
            module.text(group) if hasattr(module, "text") else module.TEXT,
            rows,
            pictures,
            tuple(map(as_block, parts.of("tables", group))),
            (*parts.of("verdict", group), *parts.of("missing", group, undone)),
            tuple(parts.failed),
        )


def _word(name: str, module: Any, group: Any, number: int) -> str:
    """Return the name of the study of a group in the names of its figures."""
    if hasattr(module, "name"):
        return module.name(group)
    return f"{name}-{number}" if number > 1 else name


@dataclasses.dataclass
class _Parts:
    """Parts of a study, as functions of its module make them.

    Attributes
    ----------
    study
        Name of the study in messages.
    failed
        Parts that failed so far.
    """

    module: Any
    study: str
    failed: list[NotDrawn] = dataclasses.field(default_factory=list)

    def of(self, which: str, *arguments: Any) -> Iterator[Any]:
        """Iterate over a part, such as the rows, up to where it fails."""
        from granwave.analysis.figures.style import not_made

        if not hasattr(self.module, which):
            return
        done = 0
        try:
            for one in getattr(self.module, which)(*arguments):
                yield one
                done += 1
        except Exception as error:
            # a user's code may ask for the name of no run
            if isinstance(error, MissingDataError) and is_loaded(self.module):
                error = KeyError(str(error)).with_traceback(error.__traceback__)
            place = f"{which} of the study {self.study}, from number {done + 1} on,"
            file = getattr(self.module, "__file__", None) if is_loaded(self.module) else None
            self.failed.append(not_made(place, error, file=file))


def _pictures(parts: _Parts, group: Any, ending: str) -> Iterator[Picture]:
    """Iterate over the figures of a study that can be drawn.

    Parameters
    ----------
    ending
        End of the names of their files.
    """
    from granwave.analysis.figures.style import NotDrawn, attempt

    for one in parts.of("pictures", group):
        file = one.name + ending
        if not one.name or one.name.startswith("_"):
            file = parts.study.replace("-", "_") + one.name
        drawing = one.drawing
        if callable(drawing):
            drawing = attempt(f"figure {file}", drawing)
        if isinstance(drawing, NotDrawn):
            parts.failed.append(drawing)
        else:
            yield Picture(file, one.caption, drawing)


def draw_studies(found: Sequence[Study], directory: AnyPath) -> list[Path]:
    """Save all figures of studies with their data into ``directory/figures``; returns the PNG
    files.
    """
    from granwave.analysis.figures.style import (
        FigureFolder,
        style,
    )  # imported on demand: matplotlib takes a second to load

    folder = FigureFolder(directory)
    with style():
        for study in found:
            for picture in study.pictures:
                folder.save(picture.drawing, picture.name)
    return folder.written


def record_of(row: Row) -> dict[str, Any]:
    """Return a row by name of the column; None if a value is missing."""
    return {
        "kind": row.kind,
        "quantity": row.quantity,
        "unit": row.unit,
        "source": row.source,
        "granwave": row.ours,
        "difference": row.deviation,
        "theory": row.theory,
        "where": row.where,
        "remark": row.remark,
    }


def write_rows(found: Sequence[Study], directory: AnyPath) -> Path | None:
    """Write the rows of all studies into ``study_rows.csv``; None, and no file, if there are none.

    Raises
    ------
    InputError
        A file of this name exists, and granwave did not write it.
    """
    results = ResultDirectory.at(directory)
    records = []
    for study in found:
        for row in study.rows:
            records.append({"study": study.name} | record_of(row))
    if not records:
        results.clear([STUDY_ROWS])
        return None
    text = io.StringIO()
    write_csv_rows(text, [list(records[0]), *(record.values() for record in records)])
    results.claim([STUDY_ROWS])
    replace_text(results / STUDY_ROWS, text.getvalue())
    return results / STUDY_ROWS


def span(label: str, values: Mapping[str, Estimate], unit: str = "") -> str:
    """State the range of a quantity: ``Peak force: from 212 ± 50 N (10 layers) to 1560 N
    (2 layers).``

    Parameters
    ----------
    values
        By what they are of.
    """
    ends = [choose(values, key=lambda name: values[name].mean) for choose in (min, max)]
    low, high = (f"{with_interval(values[name], unit=unit)} ({name})" for name in ends)
    return f"{label}: from {low} to {high}."


def numeric(*heads: str | tuple[str, str], key: bool = False) -> tuple[TableColumn, ...]:
    """Columns of numbers, by heading, or by heading and unit."""
    pairs = [(head, "") if isinstance(head, str) else head for head in heads]
    return tuple(TableColumn(heading, unit, numeric=True, key=key) for heading, unit in pairs)


def table_of(
    caption: str, columns: Iterable[TableColumn], rows: Iterable[Iterable[Any]], **options: Any
) -> DocumentTable:
    """A table of values; existing cells are unchanged.

    Parameters
    ----------
    options
        Further fields of a table, such as ``sortable``.
    """
    cells = tuple(
        tuple(one if isinstance(one, Cell) else value_cell(one) for one in row) for row in rows
    )
    return DocumentTable(caption, tuple(columns), cells, **options)


def as_block(one: Any) -> Any:
    """Make a table of caption and columns, ``("Impacts", {"Velocity (m/s)": velocity})``, and a
    note of a sentence.

    Values are numbers, estimates or texts; the unit ends the heading in brackets. All other values
    are unchanged.
    """
    if isinstance(one, str):
        return Note(one)
    if not isinstance(one, tuple):
        return one
    caption, columns = one
    heads = []
    for place, (name, values) in enumerate(columns.items()):
        heading, _, unit = (
            name.removesuffix(")").partition(" (") if name.endswith(")") else (name, "", "")
        )
        text = any(isinstance(value, str) for value in values)
        heads.append(TableColumn(heading, unit, numeric=not text, key=text and not place))
    return DocumentTable(
        caption,
        tuple(heads),
        tuple(tuple(map(_cell, row)) for row in zip(*columns.values(), strict=True)),
    )


def _cell(value: Any) -> Cell:
    if isinstance(value, str):
        return Cell(value, value)
    if isinstance(value, Estimate):
        if value.half_width > 0:
            return Cell(with_interval(value), value.mean)
        value = value.mean
    number = value if isinstance(value, int) else float(value)
    return value_cell(number) if math.isfinite(number) else Cell(BLANK)
