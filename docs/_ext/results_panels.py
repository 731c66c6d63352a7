"""Panels of the figures of values: stored rows with the same quantity and unit, ours next to the
value of the source, of theory, or of a verification.

Rows whose conditions differ by one number with at least three values are curves against that
number. Other rows are lines of a list. A page has at most `MOST` panels, first those with most
values of sources.
"""

from __future__ import annotations

import dataclasses
import hashlib
import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from results_quantities import Condition, Quantity, abscissa, quantity_of
from results_rows import interval_of, is_lower_bound
from results_stored import row_of

from granwave.analysis.studies.study import Row

MOST = 8  # panels of a page
MOST_LINES = 16  # of a list
MOST_CURVES = 6  # of a panel
_OF_SOURCE = 12  # weight of a value of a source relative to theory
_LEAST = 2  # values with a reference in a panel
_GAP = 10.0  # between the references of two panels with the same unit
_LEAST_POINTS = 3  # of a curve


@dataclasses.dataclass(frozen=True)
class Value:
    """A row of a panel.

    Attributes
    ----------
    label
        Conditions that differ from the other rows of the panel.
    x
        Abscissa in a panel of curves; None in a list.
    ours, source, theory
        The values; None if the row has none.
    bound
        "most" or "least" if the source or theory gives only a bound; otherwise empty.
    interval
        Half-width of the interval of error of the source; 0 if it gives none.
    """

    label: str
    x: float | None
    ours: float | None
    source: float | None
    theory: float | None
    bound: str
    interval: float

    def compared(self) -> bool:
        """Return True for a row with a reference."""
        return self.source is not None or self.theory is not None

    def reference(self) -> float | None:
        """Return the value of the source; of theory without a source."""
        return self.theory if self.source is None else self.source


@dataclasses.dataclass(frozen=True)
class Panel:
    """A panel of curves or a list.

    Attributes
    ----------
    title
        Quantity, and the conditions that all rows have in common; the title of the study for
        several quantities.
    subtitle
        Title of the study, empty if the rows are from several studies; the conditions that all
        rows have in common for several quantities.
    unit
        Unit of the values.
    abscissa
        Label of the abscissa of curves; empty for a list.
    curves
        Rows by curve; a list has one entry.
    is_mixed
        True for several quantities.
    """

    title: str
    subtitle: str
    unit: str
    abscissa: str
    curves: tuple[tuple[str, tuple[Value, ...]], ...]
    is_mixed: bool

    def study(self) -> str:
        """Return the title of the study; empty if the rows are from several studies."""
        return self.title if self.is_mixed else self.subtitle

    def values(self) -> tuple[Value, ...]:
        """Return all rows."""
        return tuple(itertools.chain.from_iterable(values for _, values in self.curves))

    def number(self) -> int:
        """Return the number of rows with a reference."""
        return sum(value.compared() for value in self.values())

    def weight(self) -> int:
        """Return the number of values with a reference, with `_OF_SOURCE` for a source."""
        sources = sum(value.source is not None for value in self.values())
        return self.number() + (_OF_SOURCE - 1) * sources


@dataclasses.dataclass(frozen=True)
class _Line:
    """A stored row with the parts of its name, and its study."""

    row: Row
    quantity: Quantity
    study: str

    def compared(self) -> bool:
        return self.row.source is not None or self.row.theory is not None

    def conditions(self, *, with_base: bool) -> tuple[str, ...]:
        """Return the conditions, after the quantity if rows have several quantities."""
        texts = tuple(condition.text for condition in self.quantity.conditions)
        return (self.quantity.base, *texts) if with_base else texts


@dataclasses.dataclass(frozen=True)
class ValuesOfPage:
    """Panels of a page, and the number of its values with a reference."""

    panels: tuple[Panel, ...]
    total: int
    verification: bool

    def values(self) -> tuple[Value, ...]:
        """Return all rows of the panels."""
        return tuple(itertools.chain.from_iterable(panel.values() for panel in self.panels))

    def number(self) -> int:
        """Return the number of values with a reference that the panels show."""
        return sum(panel.number() for panel in self.panels)

    def digest(self) -> str:
        """Return a digest of everything that the figure shows."""
        return hashlib.sha256(repr(self.panels).encode()).hexdigest()[:16]


def values_of(suite: Mapping[str, Any]) -> ValuesOfPage:
    """Return the panels of the page of a suite.

    A page without values of sources and theory has the references of its verifications.
    """
    lines = list(_lines(suite))
    kinds = {line.row.kind for line in lines}
    verification = kinds.isdisjoint(("source", "theory"))
    if not verification:
        lines = [line for line in lines if line.row.kind != "verification"]
    panels = _chosen(list(_panels(_without_repeated(lines))))
    total = sum(line.compared() for line in lines)
    return ValuesOfPage(tuple(panels), total, verification and "verification" in kinds)


def _chosen(panels: Sequence[Panel]) -> list[Panel]:
    """Return the panels with most values, such that no study takes all places."""
    left = list(panels)
    chosen: list[Panel] = []
    while left and len(chosen) < MOST:
        studies = [panel.study() for panel in chosen]
        best = max(left, key=lambda panel: panel.weight() / (1 + studies.count(panel.study())))
        left.remove(best)
        chosen.append(best)
    return [panel for panel in panels if panel in chosen]


def _without_repeated(lines: Sequence[_Line]) -> list[_Line]:
    """Return the rows without those of ours alone that a row with a reference repeats."""
    compared = {(line.study, line.row.quantity) for line in lines if line.compared()}
    return [
        line for line in lines if line.compared() or (line.study, line.row.quantity) not in compared
    ]


def _lines(suite: Mapping[str, Any]) -> Iterator[_Line]:
    for study in suite["studies"].values():
        for record in study["rows"]:
            row = row_of(record)
            yield _Line(row, quantity_of(row.quantity), study["title"])


def _panels(lines: Sequence[_Line]) -> Iterator[Panel]:
    """Iterate over the panels: rows of a study with the same quantity, remaining rows of a study
    with the same unit, and remaining rows of several studies with the same quantity.
    """
    remaining = list(lines)
    steps = (
        (_study_and_quantity, _LEAST_POINTS),
        (_study_and_unit, _LEAST_POINTS),
        (_quantity_and_unit, _LEAST),
        (_study_and_unit, _LEAST),
    )
    for key, least in steps:
        groups: dict[tuple[str, ...], list[_Line]] = {}
        for line in remaining:
            groups.setdefault(key(line), []).append(line)
        remaining = []
        for group in groups.values():
            curves = _panels_of_curves(group)
            yield from (panel for panel, _ in curves)
            within = list(itertools.chain.from_iterable(lines for _, lines in curves))
            others = [line for line in group if line.compared() and line not in within]
            for part in _of_similar_size(others) if key is _study_and_unit else [others]:
                panel = _list_of(part) if len(part) >= least else None
                if panel is None:
                    remaining += part
                else:
                    yield panel


def _of_similar_size(lines: Sequence[_Line]) -> list[list[_Line]]:
    """Return rows in groups whose references have similar sizes, which one axis can show."""
    parts: list[list[_Line]] = []
    before = 0.0
    for line in sorted(lines, key=_size):
        if not parts or (before and _size(line) > _GAP * before):
            parts.append([])
        parts[-1].append(line)
        before = _size(line)
    for part in parts:
        part.sort(key=lines.index)
    return parts


def _size(line: _Line) -> float:
    reference = line.row.theory if line.row.source is None else line.row.source
    return abs(reference or 0.0)


def _study_and_quantity(line: _Line) -> tuple[str, ...]:
    return line.study, line.quantity.base, line.row.unit


def _quantity_and_unit(line: _Line) -> tuple[str, ...]:
    return line.quantity.base, line.row.unit


def _study_and_unit(line: _Line) -> tuple[str, ...]:
    return line.study, line.row.unit


def _panels_of_curves(lines: Sequence[_Line]) -> list[tuple[Panel, list[_Line]]]:
    """Return the panel of curves of a group with its rows, if curves contain at least half of the
    references.
    """
    template, curves = _curves(lines)
    within = list(itertools.chain.from_iterable(curves.values()))
    number = sum(line.compared() for line in within)
    if number < _LEAST or 2 * number < sum(line.compared() for line in lines):
        return []
    return [(_panel_of_curves(template, curves), within)]


def _curves(lines: Sequence[_Line]) -> tuple[str, dict[tuple[str, ...], list[_Line]]]:
    """Return the condition whose number varies, and the rows by their other conditions."""
    best: tuple[str, dict[tuple[str, ...], list[_Line]]] = "", {}
    conditions = itertools.chain.from_iterable(line.quantity.conditions for line in lines)
    templates = dict.fromkeys(one.template for one in conditions if one.numbers)
    for others_of, template in itertools.product((_others, _other_templates), templates):
        curves = _curves_along(template, lines, others_of)
        if _number(curves) > _number(best[1]):
            best = template, curves
    return best


def _number(curves: Mapping[Any, Sequence[Any]]) -> int:
    return sum(map(len, curves.values()))


def _curves_along(
    template: str, lines: Sequence[_Line], others_of: Callable[[_Line, str], tuple[str, ...]]
) -> dict[tuple[str, ...], list[_Line]]:
    """Return the rows along the number of a condition, by their other conditions.

    If a condition has several numbers, such as an impulse with its force and its duration, the
    first one varies.
    """
    found: dict[tuple[str, ...], list[_Line]] = {}
    for line in lines:
        if _condition_of(line, template) is not None:
            found.setdefault(others_of(line, template), []).append(line)
    return {others: curve for others, curve in found.items() if _is_curve(curve, template)}


def _is_curve(lines: Sequence[_Line], template: str) -> bool:
    """Return True for enough rows with distinct abscissae, of which at least one has a reference.

    Their other conditions are the same, or all vary together with the abscissa.
    """
    abscissae = {_abscissa_of(line, template) for line in lines}
    others = {_others(line, template) for line in lines}
    return (
        len(lines) == len(abscissae) >= _LEAST_POINTS
        and len(others) in (1, len(lines))
        and any(map(_Line.compared, lines))
    )


def _condition_of(line: _Line, template: str) -> Condition | None:
    for condition in line.quantity.conditions:
        if condition.template == template:
            return condition
    return None


def _abscissa_of(line: _Line, template: str) -> float:
    condition = _condition_of(line, template)
    assert condition is not None
    return condition.numbers[0]


def _others(line: _Line, template: str) -> tuple[str, ...]:
    """Return the conditions of a row except the one that varies."""
    return tuple(one.text for one in line.quantity.conditions if one.template != template)


def _other_templates(line: _Line, template: str) -> tuple[str, ...]:
    """Return the conditions except the one that varies, with {} for numbers that vary with it."""
    templates = [condition.template for condition in line.quantity.conditions]
    return tuple(one for one in templates if one != template)


def _panel_of_curves(template: str, curves: Mapping[tuple[str, ...], Sequence[_Line]]) -> Panel:
    """Return a panel with the curves that have most references."""
    ranked = sorted(curves, key=lambda others: -sum(map(_Line.compared, curves[others])))
    shown = [others for others in curves if others in ranked[:MOST_CURVES]]
    common = _common(shown)
    lines = list(itertools.chain.from_iterable(curves[others] for others in shown))
    named = []
    for others in shown:
        points = sorted(curves[others], key=lambda line: _abscissa_of(line, template))
        values = tuple(_value(line.row, "", _abscissa_of(line, template)) for line in points)
        named.append((_joined(others, common), values))
    return _panel(lines, common, abscissa(template), tuple(named))


def _list_of(lines: Sequence[_Line]) -> Panel | None:
    """Return a list of rows, first those with a source; None if their conditions are the same."""
    ordered = sorted(lines, key=lambda line: line.row.source is None)[:MOST_LINES]
    shown = [line for line in lines if line in ordered]
    mixed = len({line.quantity.base for line in shown}) > 1
    texts = [line.conditions(with_base=mixed) for line in shown]
    common = _common(texts)
    labels = [
        _joined(text, common) or line.quantity.base for line, text in zip(shown, texts, strict=True)
    ]
    if len(set(labels)) < len(labels):
        return None
    values = tuple(_value(line.row, label, None) for line, label in zip(shown, labels, strict=True))
    return _panel(shown, common, "", (("", values),))


def _panel(
    lines: Sequence[_Line], common: Sequence[str], label: str, curves: tuple[Any, ...]
) -> Panel:
    bases = {line.quantity.base for line in lines}
    studies = {line.study for line in lines}
    study = studies.pop() if len(studies) == 1 else ""
    if len(bases) > 1:
        conditions = ", ".join(text for text in common if text not in study)
        return Panel(study, conditions, lines[0].row.unit, label, curves, is_mixed=True)
    title = ", ".join([*bases, *common])
    return Panel(title, study, lines[0].row.unit, label, curves, is_mixed=False)


def _common(texts: Iterable[Sequence[str]]) -> list[str]:
    """Return the conditions that all rows have."""
    rows = list(texts)
    shared = set(rows[0]).intersection(*rows)
    return [text for text in rows[0] if text in shared and "{}" not in text]


def _joined(texts: Iterable[str], common: Sequence[str]) -> str:
    return ", ".join(text for text in texts if text not in common and "{}" not in text)


def _value(row: Row, label: str, x: float | None) -> Value:
    bound = ""
    if row.bound:
        bound = "least" if is_lower_bound(row) else "most"
    interval = float(interval_of(row) or 0.0)
    numbers = [_rounded(one) for one in (row.ours, row.source, row.theory)]
    return Value(label, x, *numbers, bound, interval)


def _rounded(number: float | None) -> float | None:
    """Return a number with the digits that a figure shows, for its digest."""
    return None if number is None else float(f"{number:.4g}")
