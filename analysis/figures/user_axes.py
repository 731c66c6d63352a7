"""Figures in axes of the user, and curves of another run drawn over a figure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any
from weakref import WeakKeyDictionary, WeakSet

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.container import ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotParams
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.text import Text
from numpy.typing import NDArray

from granwave.analysis.figures.fitted_legends import fit_legend, narrow_above
from granwave.analysis.figures.legends import uncover_curves_of
from granwave.analysis.figures.titles import fit_titles
from granwave.lammps_inputs.errors import InputError

_OTHER_LINE = "--"  # line style of another run
_OTHER_MARKER = "x"  # marker of its points that no line joins
_OTHER_ALPHA = 0.7
SOLID = ", solid"  # end of the label of an axis with a second axis: style of its curve
_FONT = 8  # font size of legends, points
_SMALLEST = 6.0  # smallest font size of legends, points
_WIDEST = 0.97  # width of a legend above the axes / width of the figure
_PASSES = 2  # layouts for broken titles, which take room from each other
_SIDES = ("left", "right", "bottom", "top", "wspace", "hspace")  # of the places of subplots
_COLOUR_BAR = "<colorbar>"  # label that matplotlib gives to the axes of colour bars


class UserFigure:
    """Figure whose panels are axes of the user; other attributes are those of the figure of these
    axes.

    Parameters
    ----------
    panels
        Axes of the user, of one figure, in the order of the panels.
    """

    def __init__(self, panels: Sequence[Axes]) -> None:
        self._panels = list(panels)
        figure = self._panels[0].get_figure(root=True)
        if figure is None:
            raise InputError("ax: found axes that were removed, expected axes of a figure")
        self._figure = figure
        self._before = [axes for axes in self._figure.axes if axes not in self._panels]
        self._has_common_x = False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._figure, name)

    @property
    def axes(self) -> list[Axes]:
        """Axes of the panels, and axes added by the drawing, such as colour bars."""
        return [axes for axes in self._figure.axes if axes not in self._before]

    @property
    def all_axes(self) -> list[Axes]:
        """Axes of the figure of the user."""
        return list(self._figure.axes)

    def subplots(
        self, rows: int = 1, columns: int = 1, *, squeeze: bool = True, **options: Any
    ) -> Axes | NDArray[Any]:
        """Return the axes of the user as an array of panels; as ``Figure.subplots``.

        Raises
        ------
        InputError
            There are more or fewer panels, or panels of another projection.
        """
        number = rows * columns
        if number != len(self._panels):
            expected = "1, as it has one panel" if number == 1 else f"a list of {number}"
            raise InputError(f"ax: found {len(self._panels)} axes; the figure needs {expected}")
        self._has_common_x = bool(options.get("sharex"))
        if self._has_common_x:
            self._hide_inner_labels(has_common_y=bool(options.get("sharey")))
        projection = (options.get("subplot_kw") or {}).get("projection", self._panels[0].name)
        if any(axes.name != projection for axes in self._panels):
            raise InputError(f"ax: expected axes with projection={projection!r}")
        if squeeze and number == 1:
            return self._panels[0]
        grid = np.array(self._panels, dtype=object).reshape(rows, columns)
        return grid.squeeze() if squeeze else grid

    def _hide_inner_labels(self, *, has_common_y: bool) -> None:
        """Hide the numbers of common axes between panels that fill the grid of the user."""
        places = [axes.get_subplotspec() for axes in self._panels]
        grids = {id(place.get_gridspec()) for place in places if place is not None}
        if None in places or len(grids) != 1:
            return
        for axes, place in zip(self._panels, places, strict=True):
            assert place is not None
            rows, columns = place.get_gridspec().get_geometry()
            if rows * columns != len(self._panels):
                return
            axes.tick_params(labelbottom=place.is_last_row())
            if has_common_y:
                axes.tick_params(labelleft=place.is_first_col())

    def align(self) -> None:
        """Give panels with a common horizontal axis the limits of the last one, and its label
        where no panel is below them.
        """
        if not self._has_common_x:
            return
        last = self._panels[-1]
        for axes in self._panels[:-1]:
            axes.set_xlim(last.get_xlim())
            if not axes.get_xlabel() and not self._has_panel_below(axes):
                axes.set_xlabel(last.get_xlabel())

    def _has_panel_below(self, axes: Axes) -> bool:
        """Return True if a panel is below axes."""
        place = axes.get_position()
        for other in self._panels:
            box = other.get_position()
            if box.y1 <= place.y0 and box.x0 < place.x1 and place.x0 < box.x1:
                return True
        return False

    def legend(self, *artists: Any, loc: str = "", **options: Any) -> None:
        """Draw the legend of the figure in its first panel."""
        self._panels[0].legend(*artists, **options)

    def supxlabel(self, text: str, **options: Any) -> Text:
        """Label the horizontal axes of all panels, or of the last panel in a figure with other
        axes.
        """
        if self._before:
            return self._panels[-1].set_xlabel(text, **options)
        return self._figure.supxlabel(text, **options)

    def supylabel(self, text: str, **options: Any) -> Text:
        """Label the vertical axes of all panels, or of the first panel in a figure with other
        axes.
        """
        if self._before:
            return self._panels[0].set_ylabel(text, **options)
        return self._figure.supylabel(text, **options)

    def findobj(self, match: Any = None, include_self: bool = True) -> list[Any]:
        """Return the artists of the panels."""
        artists: list[Any] = []
        for axes in self.axes:
            artists += axes.findobj(match, include_self)
        return artists


_figure: ContextVar[UserFigure | None] = ContextVar("figure of the user", default=None)


def user_figure() -> UserFigure | None:
    """Return the figure that is drawn into; None: a new one."""
    return _figure.get()


@contextmanager
def drawing_into(panels: Sequence[Axes]) -> Iterator[UserFigure]:
    """Redirect drawing in the ``with`` block into axes of the user."""
    figure = UserFigure(panels)
    token = _figure.set(figure)
    try:
        yield figure
    finally:
        _figure.reset(token)


@contextmanager
def laid_out(panels: Sequence[Axes]) -> Iterator[None]:
    """Lay out the figure of axes of the user in the ``with`` block, so that labels and legends fit
    into it, if the figure has no layout engine and its axes are at the usual places of matplotlib.
    """
    figure = panels[0].get_figure(root=True) if panels else None
    if figure is None or figure.get_layout_engine() is not None or not _are_usual(panels):
        yield
        return
    subplots = [axes for axes in figure.axes if _is_usual(axes)]
    figure.set_layout_engine("constrained")
    try:
        yield
        figure.draw_without_rendering()
    finally:
        figure.set_layout_engine(None)
        for axes in subplots:
            _laid_out[axes] = axes.get_position(original=True).bounds


def _are_usual(panels: Sequence[Axes]) -> bool:
    """Return True for axes of subplots at the usual places of matplotlib, or at their places in an
    earlier layout of granwave: they were not adjusted or placed by hand.
    """
    has_places = all(axes.get_subplotspec() is not None for axes in panels)
    return has_places and all(axes in _drawn or _is_usual(axes) for axes in panels)


def _is_usual(axes: Axes) -> bool:
    """Return True for axes at the place of their subplot with matplotlib's settings, or where a
    layout of granwave left them.
    """
    place = axes.get_subplotspec()
    if place is None:
        return False
    bounds = axes.get_position(original=True).bounds
    if axes in _laid_out:
        return np.allclose(bounds, _laid_out[axes])
    figure = axes.get_figure(root=True)
    assert figure is not None
    set_sides = [getattr(figure.subplotpars, side) for side in _SIDES]
    usual = [getattr(SubplotParams(), side) for side in _SIDES]
    is_there = np.allclose(bounds, place.get_position(figure).bounds)
    return set_sides == usual and is_there


def plots_of(figure: Figure | UserFigure) -> list[Axes]:
    """Return the axes of a figure without its colour bars."""
    return [axes for axes in figure.axes if axes.get_label() != _COLOUR_BAR]


#: Places of the subplots of users in the last layout of granwave: left, bottom, width, height.
_laid_out: WeakKeyDictionary[Axes, tuple[float, ...]] = WeakKeyDictionary()
#: Label of titles of ours, which get the text sizes of the user in his axes.
SCALED_TEXT = "title of granwave"


def match_text(figure: Figure | UserFigure, panels: Sequence[Axes]) -> None:
    """Give second axes, colour bars and titles the text sizes of the first panel of the user, and
    all texts its font.

    Parameters
    ----------
    panels
        Axes of the user.
    """
    label = panels[0].xaxis.label.get_fontsize()
    ticks = panels[0].xaxis.get_ticklabels()
    for title in [*(axes.title for axes in panels), *figure.texts]:
        if title.get_label() == SCALED_TEXT:
            title.set_fontsize(label)
    for axes in figure.axes:
        if axes in panels:
            continue
        for axis in (axes.xaxis, axes.yaxis):
            axis.label.set_fontsize(label)
            if ticks:
                axis.set_tick_params(labelsize=ticks[0].get_fontsize())
    match_font(figure, panels)


def match_font(figure: Figure | UserFigure, panels: Sequence[Axes]) -> None:
    """Give all texts of a figure the font of the first panel of the user."""
    family = panels[0].xaxis.label.get_fontfamily()
    for axes in figure.axes:
        axes.tick_params(axis="both", which="both", labelfontfamily=family)
    common = [text for text in figure.texts if text.get_label() == SCALED_TEXT]
    for text in [*common, *figure.findobj(Text)]:
        text.set_fontfamily(family)


_drawn: WeakSet[Axes] = WeakSet()  # axes of users with figures of ours


def fit_to_axes(figure: UserFigure) -> None:
    """Break titles that are longer than their axes, and place legends where they fit and cover no
    curve. Earlier figures in the same figure of the user, whose axes became smaller, are fitted
    again.
    """
    _drawn.update(figure.axes)
    drawn = [axes for axes in figure.all_axes if axes in _drawn]
    leave_layout(figure)
    for _ in range(_PASSES):
        figure.draw_without_rendering()
        if not any([fit_titles(axes) for axes in drawn]):
            break
    figure.draw_without_rendering()
    moved = [fit_legend(axes) for axes in drawn]
    if any(moved):
        figure.draw_without_rendering()
    for axes in drawn:
        narrow_above(axes)
        fit_titles(axes)
    figure.draw_without_rendering()


def leave_layout(figure: Figure | UserFigure) -> None:
    """Exclude legends from the layout, in which a wide legend leaves no room for its axes."""
    for axes in figure.axes:
        legend = axes.get_legend()
        if legend is not None:
            legend.set_in_layout(False)


def add_curves(panels: Sequence[Axes], others: Sequence[Axes], name: str, own: str) -> bool:
    """Draw the curves of another run, dashed, over the panels of a run.

    Second axes, such as the axis of the impulse in a figure of the force, are removed. If one
    figure has more panels than the other, the first panels with equal quantities are used. The
    figure grows by the legends above its panels.

    Parameters
    ----------
    panels, others
        Panels of both figures, in one order.
    name, own
        Names of the other run and of the run in legends.

    Returns
    -------
    bool
        False if there are no curves, or other panels.
    """
    pairs = list(zip(panels, others, strict=False))
    if len(panels) != len(others):
        pairs = [pair for pair in pairs if pair[0].get_ylabel() == pair[1].get_ylabel()]
    number = 0
    second: list[Axes] = []
    for axes, other in pairs:
        if _is_second(axes, panels):
            second.append(axes)
            continue
        curves = _curves_of(other)
        has_labels = any(not label.startswith("_") for _, label in curves)
        for curve, label in curves:
            _add_curve(axes, curve, _label_of_other(label, name, has_labels=has_labels))
        if curves:
            axes.set_xlim(_widened(axes.get_xlim(), other.get_xlim()))
            axes.set_ylim(_widened(axes.get_ylim(), other.get_ylim()))
            if len(curves) == 1:
                _name_curve(axes.lines[0], own)
            legend = axes.get_legend()
            if legend is not None or len(curves) == 1:
                _draw_legend(axes, _own_first(axes, name), legend)
        number += len(curves)
    for axes in second:
        axes.remove()
    if second:
        _uncolour(panels[0])
    return number > 0


def _label_of_other(label: str, name: str, *, has_labels: bool) -> str:
    """Return the label of a curve of another run: the first line of its label with the name of the
    run. Curves without a label have the name alone, and none next to curves with labels.
    """
    if label.startswith("_"):
        return "_" if has_labels else name
    first, *_ = label.split("\n")
    return f"{first}, {name}"


def _draw_legend(axes: Axes, entries: tuple[list[Any], list[str]], before: Legend | None) -> None:
    """Draw a legend of the curves of both runs. A legend above the axes of a figure of ours has the
    width of the figure at most, and the figure grows by its height.

    Parameters
    ----------
    entries
        Handles and labels.
    before
        Legend of the curves of this run, which it replaces.
    """
    size = _size_of(before)
    figure = axes.get_figure(root=True)
    extent = None if before is None else before.get_window_extent()
    is_above = extent is not None and not axes.bbox.overlaps(extent.padded(-1))
    if extent is None or not is_above or figure is None or figure.get_layout_engine() is None:
        axes.legend(*entries, fontsize=size)
        uncover_curves_of(axes)
        return
    place: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0)}
    height = extent.height
    legend = axes.legend(*entries, fontsize=size, **place)
    width = legend.get_window_extent().width / figure.bbox.width
    if width > _WIDEST:
        legend = axes.legend(*entries, fontsize=max(size * _WIDEST / width, _SMALLEST), **place)
    grown = (legend.get_window_extent().height - height) / figure.dpi
    if grown > 0:
        figure.set_figheight(figure.get_figheight() + grown)


def _own_first(axes: Axes, name: str) -> tuple[list[Any], list[str]]:
    """Return handles and labels of a legend, with the curves of another run last."""
    handles, labels = axes.get_legend_handles_labels()
    of_other = [label == name or label.endswith(f", {name}") for label in labels]
    order = sorted(range(len(labels)), key=of_other.__getitem__)
    return [handles[place] for place in order], [labels[place] for place in order]


def _uncolour(axes: Axes) -> None:
    """Give an axis the usual colours, which are of its curve next to a second axis, and its label
    without the style of this curve.
    """
    axes.yaxis.label.set_color(rcParams["axes.labelcolor"])
    axes.set_ylabel(axes.get_ylabel().removesuffix(SOLID))
    axes.tick_params(axis="y", colors=rcParams["ytick.color"])


def _is_second(axes: Axes, panels: Sequence[Axes]) -> bool:
    """Return True for axes that lie over an earlier panel, with an axis in common."""
    earlier = panels[: list(panels).index(axes)]
    common = axes.get_shared_x_axes()
    place = axes.get_position().bounds
    return any(
        common.joined(axes, panel) and panel.get_position().bounds == place for panel in earlier
    )


def _curves_of(axes: Axes) -> list[tuple[Line2D, str]]:
    """Return the curves of axes with their labels; for error bars the points without the bars."""
    labels: dict[Line2D, str] = {}
    ends: list[Line2D] = []
    for container in axes.containers:
        if isinstance(container, ErrorbarContainer):
            points, caps, _ = container.lines
            ends += caps
            if points is not None:
                labels[points] = str(container.get_label())
    return [
        (line, labels.get(line, str(line.get_label())))
        for line in axes.lines
        if line.get_transform() == axes.transData and line not in ends
    ]


def _size_of(legend: Legend | None) -> float:
    """Return the size of the text of a legend, points."""
    return _FONT if legend is None else float(legend.get_texts()[0].get_fontsize())


def _name_curve(curve: Line2D, name: str) -> None:
    """Give a curve without a name its name in legends."""
    if str(curve.get_label()).startswith("_"):
        curve.set_label(name)


def _add_curve(axes: Axes, curve: Line2D, label: str) -> None:
    """Draw a curve of another run with a label; points that no line joins stay points."""
    is_joined = curve.get_linestyle() not in ("None", "none", "", " ")
    axes.plot(
        *curve.get_data(),
        linestyle=_OTHER_LINE if is_joined else "none",
        marker="" if is_joined else _OTHER_MARKER,
        markersize=curve.get_markersize(),
        drawstyle=curve.get_drawstyle(),
        color=curve.get_color(),
        alpha=_OTHER_ALPHA,
        label=label,
    )


def _widened(own: tuple[float, float], other: tuple[float, float]) -> tuple[float, float]:
    """Return limits that include two ranges, in the direction of the first range."""
    ends = (*own, *other)
    if own[0] > own[1]:
        return max(ends), min(ends)
    return min(ends), max(ends)
