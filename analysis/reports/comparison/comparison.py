"""Comparison of some runs: a sentence, tables and figures."""

from __future__ import annotations

import html
from collections.abc import Collection, Mapping, Sequence
from functools import cached_property
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from granwave.analysis.document.model import DocumentTable
from granwave.analysis.errors import MissingDataError
from granwave.analysis.figures.style import Drawing, NotDrawn, attempt
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.reports.comparison.cases import Difference, case_differences
from granwave.analysis.reports.comparison.compared_value import DIFFERENT_MEANING, ComparedValue
from granwave.analysis.reports.comparison.curves import SampledCurve
from granwave.analysis.reports.comparison.definitions import (
    WITH_WALLS,
    definition_notes,
    has_walls_in_some,
    limit_notes,
)
from granwave.analysis.reports.comparison.deviations import (
    Deviation,
    deviation,
    is_unit_doubtful,
    unranked_reasons,
)
from granwave.analysis.reports.comparison.ends import (
    differ_in_end_only,
    ends_in_words,
    have_unlike_ends,
    same_case_sentence,
)
from granwave.analysis.reports.comparison.energy_inputs import kinds_sentence
from granwave.analysis.reports.comparison.figures.figure import FigureData, read_figure
from granwave.analysis.reports.comparison.figures.registry import FIGURES
from granwave.analysis.reports.comparison.measured_curve import MeasuredCurve
from granwave.analysis.reports.comparison.measured_words import (
    closest_sentence,
    coverage_notes,
    range_notes,
    unit_notes,
)
from granwave.analysis.reports.comparison.models import caveat_on_model, model_dependence
from granwave.analysis.reports.comparison.protection import Ranking, protection_rankings
from granwave.analysis.reports.comparison.scatter import scatter_sentence
from granwave.analysis.reports.comparison.subjects import (
    ComparedRun,
    by_reason,
    names_in_words,
    names_with_cases,
)
from granwave.analysis.reports.comparison.value_words import (
    beyond_law_note,
    equal_in_figures,
    named_values,
    partial_note,
    sentence,
    truncation_note,
)
from granwave.analysis.reports.comparison.values import (
    compared_values,
    differing_values,
    results_and_details,
    unlike_names,
)
from granwave.analysis.reports.kinds import warning_notes

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

_UNITS = "units"  # key of ``attrs`` of a table
_RATIO = "ratio"
DEFINITIONS = "Definitions and settings that differ"  # titles of notes
LIMITS = "Limits of the compared values"
LEAST_RUNS = 2  # of a comparison without a measured curve
_LEAST_KINDS = 2


class Comparison:
    """Comparison of runs.

    Attributes
    ----------
    runs
        The runs, with their labels in figures.
    measured
        Measured curve by the name of the figure that it lies over; empty if there is none.
    quantities
        Requested names: of values and of figures; empty for all.
    left_out
        Messages about unfinished runs without a summary, which are not compared.
    """

    def __init__(
        self,
        runs: Sequence[ComparedRun],
        quantities: Sequence[str] = (),
        measured: Mapping[str, MeasuredCurve] | None = None,
        left_out: Sequence[str] = (),
    ) -> None:
        self.runs = tuple(runs)
        self.quantities = tuple(quantities)
        self.measured = dict(measured or {})
        self.left_out = tuple(left_out)
        self._drawn: dict[str, Drawing | NotDrawn | None] = {}
        self._data: dict[str, FigureData] = {}

    # ------------------------------------------------------------------ values and cases

    @cached_property
    def values(self) -> list[ComparedValue]:
        """Values of the summaries: the requested values, or all results, the most different
        first.
        """
        names = [name for name in self.quantities if name not in FIGURES]
        if self.quantities and not names:
            return []
        return compared_values(self.runs, names)

    @cached_property
    def without_ratio(self) -> dict[str, str]:
        """Words in place of the ratios of all results and details that ends of runs truncate, that
        a boundary limits, or that runs define differently, by name.
        """
        values = self._results_and_details
        words = {value.name: value.without_ratio for value in values if value.without_ratio}
        unlike = unlike_names(self.runs)
        if has_walls_in_some(self.runs):
            unlike.add(WITH_WALLS)
        return words | dict.fromkeys(unlike, DIFFERENT_MEANING)

    @cached_property
    def truncated(self) -> dict[str, tuple[ComparedRun, ...]]:
        """Runs whose end truncates a value, by its name; ratios are of the other runs."""
        truncated: dict[str, tuple[ComparedRun, ...]] = {}
        for value in self._results_and_details:
            if value.incomplete:
                places = sorted(value.incomplete)
                truncated[value.name] = tuple(self.runs[place] for place in places)
        return truncated

    @cached_property
    def _results_and_details(self) -> list[ComparedValue]:
        """All results, and details that ends or boundaries limit."""
        return results_and_details(self.runs)

    @cached_property
    def _finished(self) -> tuple[ComparedRun, ...]:
        """The finished runs."""
        return tuple(run for run in self.runs if not run.run.is_unfinished)

    @cached_property
    def _finished_values(self) -> list[ComparedValue]:
        """Values of the summaries of the finished runs: all results, the most different first."""
        if len(self._finished) == len(self.runs) and not self.quantities:
            return self.values
        return compared_values(self._finished)

    @property
    def _names_compared(self) -> list[str]:
        """Names of the requested values, and of values that describe the requested figures; empty
        for all.
        """
        if not self.quantities:
            return []
        names = dict.fromkeys(name for name in self.quantities if name not in FIGURES)
        for name in self.wanted_figures:
            names |= dict.fromkeys(FIGURES[name].values)
        return list(names)

    @property
    def _values_of_figures(self) -> list[ComparedValue]:
        """Values of the summaries that describe the requested figures."""
        names = self._names_compared
        values = compared_values(self.runs, names) if names else []
        return [value for value in values if value.numbers and not value.is_zero]

    @cached_property
    def case_rows(self) -> list[Difference]:
        """Differences of the cases: keys, and grains."""
        return case_differences(self.runs)

    @property
    def differs(self) -> bool:
        """True if any value or any case differs."""
        values = self.values if self.values and not self.quantities else compared_values(self.runs)
        return bool(differing_values(values) or self.case_rows)

    @cached_property
    def sentence(self) -> str:
        """The run closest to a measured curve, and the values that differ most, in sentences."""
        return " ".join(filter(None, [*self.measured_sentences, self.difference_sentence]))

    @property
    def paragraphs(self) -> list[str]:
        """Sentences in their order on a page: on a measured curve, the protection, and the other
        values that differ most.
        """
        differences = self._differences_in_words(self._ranked_names)
        sentences = self.protection
        scatter = scatter_sentence(self._finished) if differences or sentences else ""
        inputs = self._inputs_of_kinds if differences or sentences else ""
        paragraphs = [*self.measured_sentences, inputs, *sentences, differences, scatter]
        return [text for text in paragraphs if text]

    @property
    def headline(self) -> str:
        """First sentence of the page: the first of `paragraphs`; empty if there is none."""
        return next(iter(self.paragraphs), "")

    @property
    def _ranked_names(self) -> tuple[str, ...]:
        """Names of the values that the sentences on the protection state."""
        return tuple(chain.from_iterable(ranking.names for ranking in self._rankings))

    @property
    def stated_names(self) -> frozenset[str]:
        """Names of the values that sentences state, which tables have first."""
        names = self._ranked_names
        return frozenset([*names, *named_values(self._finished_values, names)])

    @property
    def _inputs_of_kinds(self) -> str:
        """The inputs of packings and blocks, in a sentence; empty if values were requested."""
        return "" if self.quantities else kinds_sentence(self._finished)

    @cached_property
    def measured_sentences(self) -> list[str]:
        """The run closest to each measured curve, for a single run its misfit; after the sentences
        on a doubtful unit of the curve.
        """
        is_alone = len(self.runs) < LEAST_RUNS
        sentences: list[str] = []
        for name, curve in self.measured.items():
            units = _units_of(name)
            sentences += unit_notes(curve, self._curves(name), units)
            deviations = self._named_deviations(name)
            sentences.append(closest_sentence(curve, deviations, units, alone=is_alone))
        return sentences

    @cached_property
    def difference_sentence(self) -> str:
        """The values that differ most, in a sentence; empty for a single run, and if only figures
        without such values were requested.
        """
        return self._differences_in_words()

    def _differences_in_words(self, stated: Collection[str] = ()) -> str:
        """Return the sentence on the values that differ most, without values that other sentences
        state.
        """
        if len(self.runs) < LEAST_RUNS:
            return ""
        if differ_in_end_only(self.runs):
            return f"{same_case_sentence(self.runs)} {self._largest_differences(stated)}".rstrip()
        if not self.differs:
            listed = names_in_words([run.name for run in self.runs])
            return f"Nothing differs: cases and results of {listed} are equal."
        return self._largest_differences(stated)

    def _largest_differences(self, stated: Collection[str]) -> str:
        """Return the values that differ most, in a sentence; of finished runs, if there are two."""
        if self.quantities and self.values:
            return sentence(self.values, self.runs, asked=True)
        if self.quantities:
            values = self._values_of_figures
            if not values:
                return ""
            return equal_in_figures(values, self.runs) or sentence(values, self.runs, asked=True)
        runs = self._finished
        if len(runs) < LEAST_RUNS:
            return sentence(compared_values(self.runs), self.runs, stated=stated)
        return sentence(self._finished_values, runs, stated=stated)

    @property
    def protection(self) -> list[str]:
        """Sentences that compare the protection by the runs: force on the bottom, and depth of the
        plastic zone; empty if values were requested, or if nothing differs. Of runs that differ in
        their model only, they state that the values depend on it.
        """
        sentences = [ranking.sentence for ranking in self._rankings]
        caveat = caveat_on_model(self._finished) if sentences else ""
        if caveat:
            sentences[0] = f"{sentences[0]} {caveat}"
        return sentences

    @cached_property
    def _rankings(self) -> list[Ranking]:
        """Orders of the runs by their protection."""
        if self.quantities or len(self.runs) < LEAST_RUNS or not self.differs:
            return []
        if differ_in_end_only(self.runs):
            return []
        names = names_with_cases(self.runs)
        finished = [place for place, run in enumerate(self.runs) if run in self._finished]
        return protection_rankings(
            [self.runs[place] for place in finished],
            [names[place] for place in finished],
            model_dependence(self._finished),
        )

    @property
    def table(self) -> pandas.DataFrame:
        """Values by name, the most different first: a column for each run, and the ratio.

        Units are in ``attrs["units"]``, by name. The ratio is that of the second to the first of
        two runs, of the largest to the smallest value of more runs; NaN where a value is zero or
        missing, where a boundary limits it, or where too few runs are complete; runs whose end
        truncates the value are left out.
        """
        import pandas

        columns: dict[str, list[float | None]] = {}
        for n, run in enumerate(self.runs):
            columns[run.name] = [value.values[n] for value in self.values]
        columns[_RATIO] = [value.ratio for value in self.values]
        names = pandas.Index([value.name for value in self.values], name="quantity")
        table = pandas.DataFrame(columns, index=names, dtype=float)
        table.attrs[_UNITS] = {value.name: value.unit or "1" for value in self.values}
        return table

    @property
    def differences(self) -> pandas.DataFrame:
        """Keys of the cases, and grains, that differ: values in words, a column for each run."""
        import pandas

        columns: dict[str, list[str]] = {}
        for n, run in enumerate(self.runs):
            columns[run.name] = [row.values[n] for row in self.case_rows]
        keys = pandas.Index([row.what for row in self.case_rows], name="key")
        return pandas.DataFrame(columns, index=keys, dtype=object)

    # ------------------------------------------------------------------ figures

    @property
    def wanted_figures(self) -> list[str]:
        """Names of the figures that are drawn if runs have their data: the requested figures, or
        all figures without those of one run of another kind.
        """
        asked = [name for name in FIGURES if name in self.quantities]
        asked += [name for name in self.measured if name not in asked]
        if self.quantities:
            return asked
        return [name for name in FIGURES if name not in self._figures_of_one_run]

    @cached_property
    def _figures_of_one_run(self) -> dict[str, ComparedRun]:
        """Run by the name of a figure that would show only this run, in a comparison of runs of
        several kinds; such figures are drawn only if they are requested.
        """
        if self.quantities or len({run.run.kind for run in self.runs}) < _LEAST_KINDS:
            return {}
        present = {name: list(self.data(name).present) for name in FIGURES}
        return {
            name: runs[0]
            for name, runs in present.items()
            if len(runs) == 1 and name not in self.measured
        }

    def data(self, name: str) -> FigureData:
        """Return the data of the runs for a figure, and the reasons for missing runs."""
        if name not in self._data:
            self._data[name] = read_figure(FIGURES[name], self.runs)
        return self._data[name]

    def drawing(self, name: str) -> Drawing | NotDrawn | None:
        """Return a figure; None if no run has its data, and the reason if it failed."""
        if name not in self._drawn:
            self._drawn[name] = attempt(f"figure {name}", lambda: self._draw(name))
        return self._drawn[name]

    def _draw(self, name: str) -> Drawing | None:
        present = self.data(name).present
        curves = [self.measured[name]] if name in self.measured else []
        return FIGURES[name].draw(present, curves) if present else None

    def caption(self, name: str) -> str:
        """Return the caption of a figure, with the runs that are not in it and the reasons."""
        figure = FIGURES[name]
        data = self.data(name)
        parts = [f"{figure.caption}."]
        if figure.look:
            parts.append(figure.look)
        if figure.is_cumulative and have_unlike_ends(list(data.present)):
            parts.append(f"Up to the end of each run: {ends_in_words(list(data.present))}.")
        if figure.notes is not None:
            parts.append(figure.notes(data.present))
        if name in self.measured:
            parts.append(self._measured_words(name))
        if data.lacking:
            parts.append(f"Not drawn: {by_reason(data.lacking)}.")
        return " ".join(filter(None, parts))

    def tables_of(self, name: str) -> list[DocumentTable]:
        """Return the tables of the data of a figure: one or none."""
        make = FIGURES[name].table
        table = None if make is None else make(self.data(name).present)
        return [] if table is None else [table]

    def _measured_words(self, name: str) -> str:
        curve = self.measured[name]
        units = FIGURES[name].units
        words = f"Black, dotted: {curve.columns[1]} of {curve.source}"
        changes: list[str] = []
        if curve.shift and units is not None:
            changes.append(f"shifted by {quantity_in(curve.shift, units[0])}")
        if curve.scale != 1:
            changes.append(f"multiplied by {curve.scale:g}")
        return f"{words}, {' and '.join(changes) or 'as measured'}."

    @cached_property
    def figures(self) -> tuple[str, ...]:
        """Names of the figures that these runs have."""
        from granwave.analysis.figures.style import style

        with style():
            return tuple(
                name for name in self.wanted_figures if isinstance(self.drawing(name), Drawing)
            )

    def figure(self, name: str, ax: Axes | Sequence[Axes] | None = None) -> Axes | list[Axes]:
        """Draw a figure for further editing; it is not saved.

        Parameters
        ----------
        name
            Name of the figure.
        ax
            Axes to draw into; of a figure of several panels a list of axes. By default a new
            figure.

        Returns
        -------
        Axes or list of Axes
            Axes of the figure, which pyplot shows; a list if there are several.

        Raises
        ------
        MissingDataError
            There is no figure of this name, or no run has its data.
        InputError
            The axes do not suit the panels.
        """
        from granwave.analysis.figures.series import draw_axes, no_figure

        if name not in FIGURES:
            raise no_figure("comparison", name, FIGURES)
        into: list[Axes] = []
        if ax is not None:
            into = list(np.ravel(np.array(ax, dtype=object)))
        axes = draw_axes(lambda: self._draw(name), into=into)
        if axes is None:
            lacking = self.data(name).lacking
            reasons = [f"{run.name}: {why}" for run, why in lacking.items()]
            why = "; ".join(reasons) or (
                "the runs do not differ in this quantity, or have no common grains"
            )
            raise MissingDataError(f"comparison: figure {name} does not apply ({why})")
        return axes

    # ------------------------------------------------------------------ measured

    def deviations(self, name: str) -> dict[ComparedRun, Deviation | None]:
        """Return the difference of each run from the measured curve over a figure."""
        curve_of = FIGURES[name].curve
        measured = self.measured[name]
        assert curve_of is not None  # a measured curve cannot be drawn over it
        is_doubtful = is_unit_doubtful(measured, self._curves(name))
        return {
            run: deviation(measured, curve_of(data), has_doubtful_unit=is_doubtful)
            for run, data in self.data(name).present.items()
        }

    def _named_deviations(self, name: str) -> dict[str, Deviation]:
        """Return the differences from a measured curve by the names of the runs that cover it."""
        return {
            run.name: difference
            for run, difference in self.deviations(name).items()
            if difference is not None
        }

    def _curves(self, name: str) -> dict[str, SampledCurve]:
        """Return the curves of a figure that are compared with a measured curve, by run."""
        curve_of = FIGURES[name].curve
        assert curve_of is not None  # a measured curve cannot be drawn over it
        return {run.name: curve_of(data) for run, data in self.data(name).present.items()}

    @property
    def misfits(self) -> pandas.DataFrame:
        """Difference of each run from the measured curve: rms, rms divided by the measured peak,
        relative difference of the peaks, number of points, and peak of the run in the measured
        range with its position; ``not_ranked`` is the reason for which a run is not ranked, or
        empty. Empty without a measured curve.
        """
        import pandas

        rows: list[dict[str, Any]] = []
        for name in self.measured:
            reasons = unranked_reasons(self._named_deviations(name))
            for run, difference in self.deviations(name).items():
                values = vars(difference) if difference is not None else {}
                reason = reasons.get(run.name, "")
                rows.append({"figure": name, "run": run.name, **values, "not_ranked": reason})
        return pandas.DataFrame(rows)

    # ------------------------------------------------------------------ in words

    @property
    def notes(self) -> list[str]:
        """Sentences on runs that are omitted, ended early, or that no figure shows, and on values
        that runs define differently or that a boundary limits.
        """
        return list(chain.from_iterable(self._note_groups))

    @property
    def grouped_notes(self) -> list[str]:
        """The notes, with a paragraph for all differences between definitions, and a paragraph for
        all limits by the end of a run or a boundary.
        """
        first, definitions, limits, last = self._note_groups
        joined = [" ".join(notes) for notes in (definitions, limits) if notes]
        return [*first, *joined, *last]

    @property
    def notes_by_subject(self) -> dict[str, list[str]]:
        """The notes by title: first and last notes without one, differences between definitions,
        and limits by the end of a run or a boundary.
        """
        first, definitions, limits, last = self._note_groups
        return {"": [*first, *last], DEFINITIONS: definitions, LIMITS: limits}

    @cached_property
    def _note_groups(self) -> tuple[list[str], list[str], list[str], list[str]]:
        """Notes on missing runs, on definitions, on limits, and on other subjects."""
        early = [f"{run.name} ({run.unfinished})" for run in self.runs if run.unfinished]
        first = [f"Left out: {message}." for message in self.left_out]
        if early:
            listed = ", ".join(early)
            first.append(f"Unfinished, compared up to the last output: {listed}.")
        definitions: list[str] = []
        limits = self._unlike_ends()
        if partial := partial_note(self.values, [run.name for run in self.runs]):
            limits.append(partial)
        if beyond := beyond_law_note(self.runs):
            limits.append(beyond)
        if len(self.runs) >= LEAST_RUNS:
            definitions = definition_notes(self.runs, self._names_compared)
            limits += limit_notes(self.runs, self._names_compared)
        last = warning_notes([run.run for run in self.runs])
        for name, curve in self.measured.items():
            last += coverage_notes(curve, self._named_deviations(name))
            last += range_notes(curve, self._named_deviations(name), _units_of(name))
        return first, definitions, limits, [*last, *self._undrawn(), *self._not_compared()]

    def _undrawn(self) -> list[str]:
        """Return a sentence on the runs that are in no figure; nothing if there is none."""
        undrawn: dict[ComparedRun, str] = {}
        drawn = [name for name in self.wanted_figures if self.data(name).present]
        for run in self.runs:
            reasons = [self.data(name).lacking.get(run) for name in drawn or self.wanted_figures]
            if reasons and reasons[0] and all(reasons):
                undrawn[run] = reasons[0]
        return [f"In no figure: {by_reason(undrawn)}."] if undrawn else []

    def _not_compared(self) -> list[str]:
        """Return a sentence on the figures that are left out since only one run has them; nothing
        if there are none.
        """
        names: dict[ComparedRun, list[str]] = {}
        for figure, run in self._figures_of_one_run.items():
            if FIGURES[figure].least == 1:
                names.setdefault(run, []).append(figure)
        parts = [f"{', '.join(figures)} ({run.name})" for run, figures in names.items()]
        if not parts:
            return []
        return [f"Figures that only one run has are drawn only on request: {'; '.join(parts)}."]

    def _unlike_ends(self) -> list[str]:
        """Return sentences on runs that end at different times; nothing if they do not."""
        if not have_unlike_ends(self.runs):
            return []
        notes: list[str] = []
        if not differ_in_end_only(self.runs):  # the sentence states the times
            notes.append(f"Runs end at different times: {ends_in_words(self.runs)}.")
        if truncated := truncation_note(self.values):
            notes.append(truncated)
        return notes

    def __repr__(self) -> str:
        lines = [*self.paragraphs, *self.notes, "", self.table.to_string(na_rep="")]
        return "\n".join([*lines, "", self.differences.to_string()])

    def _repr_html_(self) -> str:
        notes = "".join(f"<p>{html.escape(note)}</p>" for note in (*self.paragraphs, *self.notes))
        return f"{notes}\n{self.table.to_html(na_rep='')}\n{self.differences.to_html()}"


def _units_of(name: str) -> tuple[str, str]:
    """Return the SI units of a figure over which a measured curve can lie."""
    units = FIGURES[name].units
    assert units is not None  # `granwave.analysis.reports.comparison.compare` refuses others
    return units
