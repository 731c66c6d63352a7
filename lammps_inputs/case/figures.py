"""The table ``[figures]`` of a case file: figures, film and page of a run, which change none of its results."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Mapping
from typing import Any, Literal

from granwave.lammps_inputs.case.schema import (
    ErrorList,
    ValidationError,
    choice,
    custom,
    finite,
    number,
    parse_point,
    read_table,
    show,
)

#: Names of the figures of a run, in the order of reports; `granwave.analysis.figures.run_figures` draws them.
FIGURE_NAMES = (
    "peak_force_principal", "peak_force_orthogonal", "peak_force_section", "peak_force_depth",
    "dissipation_principal", "dissipation_orthogonal", "dissipation_section",
    "dissipation_parts_principal", "dissipation_parts_orthogonal", "dissipation_parts_section",
    "dents_principal", "dents_orthogonal", "dents_section",
    "dissipation_ranked", "dissipation_cumulated", "plastic_zone_growth", "plastic_zone_size",
    "energies", "timestep", "bottom_force", "target", "impactor_velocity",
    "packing_3d", "packing_3d_dissipation", "probes", "wave_front",
    "force_map", "force_histories", "along_chain", "bead_velocities", "transmission", "amplitude_sweep", "bars",
    "sensors", "line_speeds", "line_decay", "accelerations", "directions",
)  # fmt: skip
FORMATS = ("pdf", "svg")  # of figures, besides PNG
FILM_FORMATS = ("mp4", "gif", "webp")
COLUMN = 0.08636  # m, 3.4 inches: a column of a journal
FRAMES_OF_A_FILM = 60  # default of `run.frames` where a film is asked for: ten seconds at six pictures a second
_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclasses.dataclass(frozen=True)
class CutPlane:
    """A plane through a packing.

    Attributes
    ----------
    normal
        Its normal, of any length but 0.
    through
        A point of it, m; None: the centre of the struck sphere.
    """

    normal: tuple[float, float, float]
    through: tuple[float, float, float] | None = None


def _parse_only(value: Any) -> tuple[str, ...]:
    expected = 'a list of names of figures, as ["energies", "packing_3d"]'
    if not isinstance(value, list | tuple) or not all(isinstance(name, str) for name in value):
        raise ValidationError(expected)
    for name in value:
        if name not in FIGURE_NAMES:
            near = difflib.get_close_matches(name.lower(), FIGURE_NAMES, n=1, cutoff=0.5)
            raise ValidationError(
                f"names of figures: there is no {show(name)}"
                + (f"; did you mean {near[0]}?" if near else f", but {', '.join(FIGURE_NAMES)}")
            )
    return tuple(dict.fromkeys(value))


def _parse_plane(value: Any) -> CutPlane:
    expected = (
        '"x", "y" or "z" (the normal; through the struck sphere), or {normal = [x, y, z], through = [x, y, z]} '
        "with a point in m"
    )
    if isinstance(value, str) and value in _AXES:
        return CutPlane(_AXES[value])
    if not isinstance(value, Mapping) or "normal" not in value or not set(value) <= {"normal", "through"}:
        raise ValidationError(expected)
    normal = parse_point(value["normal"], expected)
    if not any(normal):
        raise ValidationError("a normal that is not [0, 0, 0]")
    return CutPlane(normal, parse_point(value["through"], expected) if "through" in value else None)


def _parse_colour_map(value: Any) -> str:
    expected = 'the name of a colour map of matplotlib, as "viridis"'
    if not isinstance(value, str):
        raise ValidationError(expected)
    from matplotlib import colormaps  # takes longer to load than most commands need

    if value not in colormaps:
        near = difflib.get_close_matches(value.lower(), list(colormaps), n=1, cutoff=0.5)
        raise ValidationError(expected + (f"; did you mean {near[0]}?" if near else ""))
    return value


def _parse_limits(value: Any) -> tuple[float, float]:
    expected = "two rising numbers above 0: the lower and the upper end"
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValidationError(expected)
    low, high = (finite(end, expected) for end in value)
    if not 0 < low < high:
        raise ValidationError(expected)
    return low, high


def _parse_formats(value: Any) -> tuple[str, ...]:
    expected = f"a list of some of {', '.join(FORMATS)}, or [] for PNG alone"
    names = value if isinstance(value, list | tuple) else [value]
    if not all(isinstance(name, str) for name in names):
        raise ValidationError(expected)
    if unknown := [name for name in names if name not in (*FORMATS, "png")]:
        near = difflib.get_close_matches(unknown[0].lower(), FORMATS, n=1)
        raise ValidationError(expected + (f"; did you mean {near[0]}?" if near else ""))
    return tuple(name for name in FORMATS if name in names)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Figures:
    """``[figures]``: what is drawn of a run, and how; none of it changes a result."""

    only: tuple[str, ...] = custom("names of the figures to draw; all that apply by default", _parse_only, default=())
    plane: CutPlane | None = custom(  # noqa: RUF009
        "plane of a section of your own, besides the principal and the orthogonal one; its figures end in _section",
        _parse_plane,
        default=None,
    )
    colour_map: str | None = custom(
        "colour map of sections, cut packings, maps, films and pages; by default viridis for forces and velocities, "
        "inferno for dissipation, cividis for dents",
        _parse_colour_map,
        default=None,
    )
    force_limits: tuple[float, float] | None = custom(
        "ends of the colour scale of forces, over the force at first yield, or over the largest force where nothing "
        "yields; by default they fit the values",
        _parse_limits,
        default=None,
    )
    dissipation_limits: tuple[float, float] | None = custom(
        "ends of the colour scale of dissipation, over the energy input; 1e-6 and 0.1 by default",
        _parse_limits,
        default=None,
    )
    width: float = number(
        "width of a figure of one column; wider ones grow in proportion, texts stay as they are",
        unit="m",
        at_least=0.05,
        at_most=0.5,
        default=COLUMN,
    )
    formats: tuple[str, ...] = custom(
        "files of each figure besides the PNG and the CSV of its data; each form adds to the time of drawing",
        _parse_formats,
        default=("pdf",),
    )
    film: Literal["none", "mp4", "gif", "webp"] = choice(
        f"form of a film that is made with the figures, film.mp4 for one; run.frames is {FRAMES_OF_A_FILM} then, "
        "where it is not given",
        ("none", *FILM_FORMATS),
        default="none",
    )
    view: bool = choice(
        "a page to turn and cut the packing in a browser, view.html, made with the figures", (True, False),
        default=False,
    )  # fmt: skip


def read_figures(table: Any, source: str) -> Figures:
    """Read a table ``[figures]`` alone.

    Parameters
    ----------
    source
        Name of its file in messages.

    Raises
    ------
    InputError
        A key is wrong; the message lists all faults.
    """
    errors = ErrorList(source)
    found = read_table(Figures, table, "figures", errors)
    errors.report(source)
    assert found is not None  # it is None only with errors
    return found
