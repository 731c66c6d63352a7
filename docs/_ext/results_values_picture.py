"""Figure of the values of a page of results: panels of curves and lists, ours next to the source
and to theory.

The panels are in two columns. The figure contains the digest of its panels, so that a test detects
an outdated figure.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from results_axes import scale_abscissae, scale_values
from results_panels import Panel, Value, ValuesOfPage, values_of
from results_picture import digest_of, save
from results_quantities import lines_of, typeset
from results_rows import escaped

from granwave.analysis.figures.style import BLUE, GREY, ORANGE, style

# lengths in inches
_WIDTH = 7.6
_COLUMN = 3.7
_LABELS = 1.66  # of a list, left of its axis
_ORDINATE = 0.62  # left of the axis of curves
_EDGE = 0.1  # right of an axis
_TITLE = 0.135  # line of a title
_BASE = 0.11  # from the top of a line to its base
_LINE = 0.115  # line of a label
_CURVES = 1.35  # height of curves
_BELOW = 0.4  # ticks and label of an abscissa
_BETWEEN = 0.14  # panels of a column
_LEGEND = 0.3
_CHARACTERS = 18.1  # an inch of labels
_TITLE_CHARACTERS = 15.2  # an inch of a title
_SUBTITLE_CHARACTERS = 17.5
_NAME_CHARACTERS = 17.0  # of the name of a curve

#: Rule of the choice of panels and rows, in `results_panels`.
_CHOICE = (
    ": at most eight groups of values with the same quantity or unit, first the groups with most "
    "values of sources, from as many studies as possible"
)
_NARROW = 3  # curves in a panel of one column
_UNITS = {"": "dimensionless", "1e-3": "10⁻³", "us": "µs"}
_BLACK = "#222222"
_OURS = {"marker": "o", "ms": 4.2, "color": BLUE, "mec": BLUE}
_SOURCE = {"marker": "D", "ms": 6.2, "mfc": "none", "mec": ORANGE, "mew": 1.2, "ls": "none"}
_THEORY = {"marker": "x", "ms": 6.0, "mec": _BLACK, "mew": 1.0, "color": _BLACK}
_SMALL = 7  # points, of labels


@dataclasses.dataclass(frozen=True)
class _Place:
    """Position of a panel in inches: left edge, distance of its top from the top, and width."""

    left: float
    top: float
    width: float


def picture_of(name: str) -> str:
    """Return the file name of the figure of values of a suite."""
    return f"{name}-values.webp"


def write_stale(stored: Mapping[str, Any], folder: Path) -> None:
    """Draw the figures that are missing or outdated, and delete those without panels."""
    for name, suite in stored["suites"].items():
        page = values_of(suite)
        path = folder / picture_of(name)
        if not page.panels:
            path.unlink(missing_ok=True)
        elif is_stale(path, page):
            draw(page, path)


def is_stale(path: Path, page: ValuesOfPage) -> bool:
    """Return True for a figure that is missing or shows other values."""
    return not path.is_file() or digest_of(path) != page.digest()


def text_of(name: str, suite: Mapping[str, Any]) -> str:
    """Return the figure with its caption for a page; empty without panels."""
    page = values_of(suite)
    if not page.panels:
        return ""
    titles = [panel.title for panel in page.panels]
    text = f"Values of granwave next to those of the references: {'; '.join(dict.fromkeys(titles))}"
    kinds = [sentence for kind, sentence in _symbols(page) if _has(page, kind)]
    return (
        f"\n![{escaped(text)}]({picture_of(name)})\n\n"
        f"*The figure shows {page.number()} of the {page.total} values that have a reference in "
        f"the tables below{_CHOICE if page.number() < page.total else ''}. {'; '.join(kinds)}.*\n"
    )


def _symbols(page: ValuesOfPage) -> list[tuple[str, str]]:
    """Return the kinds of values with their symbols in words."""
    other = "the reference of the verification" if page.verification else "theory"
    return [
        ("ours", "Filled circles: granwave"),
        ("source", "open diamonds: the source"),
        ("theory", f"crosses and dashed lines: {other}"),
        ("interval", "vertical or horizontal bars: the error that the source states"),
        ("bound", "arrows: from a bound to the values that it permits"),
    ]


def _has(page: ValuesOfPage, kind: str) -> bool:
    """Return True if a value of the figure has a kind: the name of its attribute."""
    absent = (None, "") if kind in ("ours", "source", "theory") else (None, "", 0.0)
    return any(getattr(value, kind) not in absent for value in page.values())


def draw(page: ValuesOfPage, path: Path) -> None:
    """Draw the figure of a page, and save it."""
    with style():
        save(figure_of(page), path, page.digest())


def figure_of(page: ValuesOfPage) -> Figure:
    """Return the figure of a page."""
    places, height = _places(page.panels)
    figure = plt.figure(figsize=(_WIDTH, height))
    _legend(figure, page)
    for panel, place in zip(page.panels, places, strict=True):
        _draw_panel(figure, panel, place)
    return figure


def _places(panels: Sequence[Panel]) -> tuple[list[_Place], float]:
    """Return the places of the panels, each in the shorter column, and the height of the figure."""
    ends = [_LEGEND, _LEGEND]
    places = []
    for panel in panels:
        if len(panels) == 1 or len(panel.curves) > _NARROW:
            place = _Place(0.0, max(ends), _WIDTH)
            ends = 2 * [place.top + _height(panel, place.width)]
        else:
            column = int(ends[1] < ends[0])
            place = _Place(column * (_WIDTH - _COLUMN), ends[column], _COLUMN)
            ends[column] += _height(panel, place.width)
        places.append(place)
    return places, max(ends)


def _height(panel: Panel, width: float) -> float:
    """Return the height of a panel in inches."""
    inside = _CURVES if panel.abscissa else sum(_rows(panel, width))
    return _head(panel, width) + inside + _BELOW + _BETWEEN


def _head(panel: Panel, width: float) -> float:
    """Return the height of the titles of a panel."""
    names = max((len(_name(panel, name, width).split("\n")) for name, _ in panel.curves), default=0)
    named = any(name for name, _ in panel.curves)
    return _TITLE * len(_titles(panel, width)) + 0.06 + (_LINE * names + 0.03 if named else 0.0)


def _titles(panel: Panel, width: float) -> list[str]:
    """Return the lines of the title and the subtitle."""
    if not panel.subtitle:
        return _title(panel, width)
    below = lines_of(panel.subtitle, int(width * _SUBTITLE_CHARACTERS))
    return [*_title(panel, width), *below]


def _title(panel: Panel, width: float) -> list[str]:
    return lines_of(panel.title, int(width * _TITLE_CHARACTERS))


def _name(panel: Panel, name: str, width: float) -> str:
    """Return the name of a curve, in lines that fit above its axis."""
    own = (width - _ORDINATE - _EDGE) / len(panel.curves)
    return "\n".join(lines_of(name, int(own * _NAME_CHARACTERS)))


def _label(value: Value, width: float) -> str:
    """Return the label of a row of a list in lines."""
    return "\n".join(lines_of(value.label, int(_labels_width(width) * _CHARACTERS)))


def _labels_width(width: float) -> float:
    return _LABELS * width / _COLUMN


def _rows(panel: Panel, width: float) -> list[float]:
    """Return the heights of the rows of a list."""
    labels = [_label(value, width) for value in panel.values()]
    return [max(0.17, _LINE * len(label.split("\n")) + 0.06) for label in labels]


def _draw_panel(figure: Figure, panel: Panel, place: _Place) -> None:
    top = place.top
    main = len(_title(panel, place.width))
    for number, line in enumerate(_titles(panel, place.width)):
        weight = "bold" if number < main else "normal"
        colour = _BLACK if number < main else GREY
        _write(figure, place.left + 0.02, top, line, weight=weight, color=colour)
        top += _TITLE
    inside = dataclasses.replace(place, top=place.top + _head(panel, place.width))
    if panel.abscissa:
        _draw_curves(figure, panel, inside)
    else:
        _draw_list(figure, panel, inside)


def _write(figure: Figure, left: float, top: float, text: str, **properties: Any) -> None:
    """Write a line at a place in inches."""
    height = figure.get_figheight()
    properties = {"va": "baseline", "fontsize": _SMALL + 0.5} | properties
    figure.text(left / _WIDTH, 1 - (top + _BASE) / height, text, **properties)


def _axes(figure: Figure, left: float, top: float, width: float, height: float) -> Axes:
    """Return axes at a place in inches."""
    total = figure.get_figheight()
    axes = figure.add_axes(
        (left / _WIDTH, 1 - (top + height) / total, width / _WIDTH, height / total)
    )
    axes.tick_params(labelsize=_SMALL)
    return axes


def _draw_list(figure: Figure, panel: Panel, place: _Place) -> None:
    """Draw a row for each value, with a line between ours and its references."""
    heights = np.array(_rows(panel, place.width))
    labels = _labels_width(place.width)
    axes = _axes(
        figure,
        place.left + labels,
        place.top,
        place.width - labels - _EDGE,
        float(heights.sum()),
    )
    middles = np.cumsum(heights) - heights / 2
    for value, middle in zip(panel.values(), middles, strict=True):
        numbers = _numbers(value)
        axes.plot([min(numbers), max(numbers)], [middle, middle], color=GREY, lw=0.8, zorder=1)
        _markers(axes, value, middle)
    for edge in np.cumsum(heights)[:-1]:
        axes.axhline(edge, color=GREY, lw=0.3, alpha=0.35, zorder=0)
    axes.set_ylim(float(heights.sum()), 0.0)
    names = [_label(value, place.width) for value in panel.values()]
    axes.set_yticks(middles, names, linespacing=1.0)
    axes.tick_params(axis="y", length=0)
    factor = scale_values(axes, "x", _all_numbers(panel), 6)
    axes.set_xlabel(_unit(panel.unit, factor), fontsize=_SMALL, labelpad=2)


def _markers(axes: Axes, value: Value, middle: float) -> None:
    """Draw the values of a row of a list."""
    if value.ours is not None:
        axes.plot(value.ours, middle, zorder=3, **_OURS)
    if value.theory is not None:
        axes.plot(value.theory, middle, zorder=4, **_THEORY)
    reference = value.reference()
    if value.bound and reference is not None:
        _arrow(axes, (reference, middle), (-_towards(value), 0.0), _arrow_colour(value))
    if value.source is None:
        return
    axes.plot(value.source, middle, zorder=5, **_SOURCE)
    if value.interval:
        axes.errorbar(value.source, middle, xerr=value.interval, ecolor=ORANGE, capsize=2, lw=1)


def _towards(value: Value) -> float:
    """Return 1 if a bound permits smaller values, -1 if it permits larger values."""
    return 1.0 if (value.bound == "most") == ((value.reference() or 0) >= 0) else -1.0


def _arrow_colour(value: Value) -> str:
    """Return the colour of the reference of a row."""
    return _BLACK if value.source is None else ORANGE


def _arrow(
    axes: Axes, point: tuple[float, float], direction: tuple[float, float], colour: str
) -> None:
    """Draw an arrow of fixed length from a bound to the values that it permits."""
    axes.annotate(
        "",
        point,
        (15 * direction[0], 15 * direction[1]),
        textcoords="offset points",
        arrowprops={"arrowstyle": "<-", "color": colour, "lw": 1.0, "shrinkA": 0, "shrinkB": 3},
        annotation_clip=False,
    )


def _draw_curves(figure: Figure, panel: Panel, place: _Place) -> None:
    """Draw each curve in axes of its own, with the same scales."""
    number = len(panel.curves)
    step = (place.width - _ORDINATE - _EDGE) / number
    gap = 0.08 if number > 1 else 0.0
    for position, (name, values) in enumerate(panel.curves):
        left = place.left + _ORDINATE + position * step
        axes = _axes(figure, left, place.top, step - gap, _CURVES)
        _curve(axes, values)
        factor = scale_values(axes, "y", _all_numbers(panel), 5)
        abscissae = [value.x for value in panel.values() if value.x is not None]
        power = scale_abscissae(axes, abscissae, 3 if number >= _NARROW else 4)
        axes.set_title(_name(panel, name, place.width), fontsize=_SMALL, pad=2, linespacing=1.0)
        if position:
            axes.tick_params(labelleft=False)
        else:
            axes.set_ylabel(_unit(panel.unit, factor), fontsize=_SMALL, labelpad=2)
    middle = place.left + _ORDINATE + (number * step - gap) / 2
    below = place.top + _CURVES + 0.2
    label = f"{panel.abscissa} ({power})" if power else panel.abscissa
    _write(figure, middle, below, typeset(label), ha="center", fontsize=_SMALL)


def _curve(axes: Axes, values: Sequence[Value]) -> None:
    """Draw ours and theory as lines, and the source as points."""
    axes.plot(*_points(values, "ours"), ls="-", zorder=3, **_OURS)
    axes.plot(*_points(values, "theory"), ls="--", zorder=4, **_THEORY | {"ms": 4.5, "lw": 0.9})
    axes.plot(*_points(values, "source"), zorder=5, **_SOURCE)
    for value in values:
        reference = value.reference()
        if value.x is None or reference is None:
            continue
        if value.interval:
            axes.errorbar(value.x, reference, yerr=value.interval, ecolor=ORANGE, capsize=2, lw=1)
        if value.bound:
            _arrow(axes, (value.x, reference), (0.0, -_towards(value)), _arrow_colour(value))


def _points(values: Iterable[Value], kind: str) -> tuple[list[float], list[float]]:
    """Return the points of a kind."""
    found = [(value.x, getattr(value, kind)) for value in values]
    points = [(x, y) for x, y in found if x is not None and y is not None]
    return [x for x, _ in points], [y for _, y in points]


def _numbers(value: Value) -> list[float]:
    """Return all numbers of a row, with the ends of its interval."""
    found = [one for one in (value.ours, value.source, value.theory) if one is not None]
    if value.source is not None and value.interval:
        found += [value.source - value.interval, value.source + value.interval]
    return found


def _all_numbers(panel: Panel) -> list[float]:
    numbers: list[float] = []
    for value in panel.values():
        numbers += _numbers(value)
    return numbers


def _unit(unit: str, factor: str) -> str:
    """Return the label of an axis: the unit, with the power of ten of its labels."""
    if factor and not unit:
        return factor
    return f"{factor} {typeset(_UNITS.get(unit, unit))}".strip()


def _legend(figure: Figure, page: ValuesOfPage) -> None:
    """Draw the kinds of values that the figure has above the panels."""
    theory = "reference of the verification" if page.verification else "theory"
    entries = {
        "ours": Line2D([], [], label="granwave", **_OURS),
        "source": Line2D([], [], label="source", **_SOURCE),
        "theory": Line2D([], [], label=theory, ls="--", lw=0.9, **_THEORY),
    }
    shown = [entry for kind, entry in entries.items() if _has(page, kind)]
    figure.legend(
        handles=shown,
        loc="upper center",
        ncols=len(shown),
        bbox_to_anchor=(0.5, 1.0),
        borderaxespad=0.2,
        fontsize=8,
    )
