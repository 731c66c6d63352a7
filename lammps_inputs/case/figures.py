"""``[figures]``: the figures of a run, and how they are drawn."""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import Any

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.material import AXES
from granwave.lammps_inputs.case.run import FRAMES_OF_A_FILM
from granwave.lammps_inputs.case.schema import ErrorList, ValidationError, read_table, show
from granwave.lammps_inputs.extensions import extensions, joined
from granwave.lammps_inputs.run_directory import FILM_FILE, VIEW_FILE

#: Names of the core's figures of a run, in the order of reports, before and after those of
#: extensions; `granwave.analysis.figures.run_figures` draws them.
FIGURES_BEFORE_ADDED = (
    "peak_force_principal", "peak_force_orthogonal", "peak_force_section", "peak_force_depth",
    "dissipation_principal", "dissipation_orthogonal", "dissipation_section",
    "dissipation_parts_principal", "dissipation_parts_orthogonal", "dissipation_parts_section",
    "dents_principal", "dents_orthogonal", "dents_section",
    "dissipation_ranked", "dissipation_cumulated", "plastic_zone_growth", "plastic_zone_size",
    "energies", "timestep", "bottom_force", "target", "impactor_velocity",
)  # fmt: skip
FIGURES_AFTER_ADDED = (
    "probes", "wave_front",
    "force_map", "force_histories", "along_chain", "bead_velocities", "transmission", "amplitude_sweep", "bars",
    "sensors", "line_speeds", "line_decay", "accelerations", "directions",
    "contact_network", "force_distribution", "line_diagram", "force_at_depths", "energy_by_region",
)  # fmt: skip
#: Figures of the core that are drawn by default: main results, and the records and planes requested
#: in the case.
FIGURES_BY_DEFAULT = (
    "peak_force_principal", "peak_force_section", "peak_force_depth", "dissipation_section",
    "plastic_zone_size", "energies", "bottom_force", "target", "probes",
    "force_map", "along_chain", "transmission", "amplitude_sweep", "bars",
    "sensors", "line_speeds", "line_decay", "accelerations",
)  # fmt: skip
FORMATS = ("pdf", "svg")  # formats of figures, in addition to PNG
FILM_FORMATS = ("mp4", "gif", "webp")
COLUMN = 0.08636  # m, 3.4 inches: a column of a journal
_LIMITS = schema.vector_type(
    2,
    "two increasing numbers above 0: the lower and the upper limit",
    lambda low, high: 0 < low < high,
)


NO_NORMAL = "a normal that is not [0, 0, 0]"
_PLANE_FORM = (
    '"x", "y" or "z" (the normal; through the impacted sphere), or {normal = [x, y, z], through = [x, y, z]} '
    "with a point in m"
)


@dataclasses.dataclass(frozen=True)
class CutPlane:
    """A plane through a packing."""

    normal: tuple[float, float, float] = schema.typed(
        "normal of the plane, of any nonzero length",
        schema.vector_type(3, "[x, y, z]", lambda *normal: any(normal), NO_NORMAL),
    )
    through: tuple[float, float, float] | None = schema.typed(
        "point of the plane; default: the centre of the impacted sphere",
        schema.vector_type(3, "[x, y, z] in m"),
        unit="m",
        default=None,
    )


def _across(letter: str) -> CutPlane:
    return CutPlane(AXES[letter])


_PLANE = schema.EitherType(
    types=(
        schema.ChoiceType(tuple(AXES), finish=_across),
        schema.TableType(section=CutPlane, expected=_PLANE_FORM),
    ),
    form=_PLANE_FORM,
)
_ONLY_FORM = 'a list of names of figures, such as ["energies", "packing_3d"]'
_DEPTHS_FORM = "a list of depths above 0 in m, such as [0.02, 0.05]"
_COLOUR_MAP_FORM = 'the name of a matplotlib colour map, such as "viridis"'
_FORMATS_FORM = f"a list of some of {', '.join(FORMATS)}, or [] for PNG only"


@cache
def figure_names() -> tuple[str, ...]:
    """Return the names of the figures of a run, in the order of reports."""
    own = dict.fromkeys((*FIGURES_BEFORE_ADDED, *FIGURES_AFTER_ADDED))
    added = joined("figure", own, {one.name: one.figures for one in extensions()})
    names_added = [name for name in added if name not in own]
    return (*FIGURES_BEFORE_ADDED, *names_added, *FIGURES_AFTER_ADDED)


@cache
def usual_figure_names() -> tuple[str, ...]:
    """Return the names of the figures that are drawn by default."""
    usual = set(FIGURES_BY_DEFAULT)
    for extension in extensions():
        usual |= extension.figures.keys() - set(extension.figures_on_request)
    return tuple(name for name in figure_names() if name in usual)


def _figure_name(name: str) -> str:
    if name not in figure_names():
        near = schema.did_you_mean(name, figure_names(), cutoff=0.5)
        hint = near or f", but {', '.join(figure_names())}"
        raise ValidationError(f"names of figures: there is no {show(name)}{hint}")
    return name


def _each_once(values: tuple[Any, ...]) -> tuple[Any, ...]:
    return tuple(dict.fromkeys(values))


def _colour_map(name: str) -> str:
    from matplotlib import colormaps  # imported on demand: slow to load

    if name not in colormaps:
        hint = schema.did_you_mean(name, colormaps, cutoff=0.5)
        raise ValidationError(_COLOUR_MAP_FORM + hint)
    return name


def _formats(names: tuple[str, ...]) -> tuple[str, ...]:
    unknown = [name for name in names if name not in (*FORMATS, "png")]
    if unknown:
        raise ValidationError(_FORMATS_FORM + schema.did_you_mean(unknown[0], FORMATS))
    return tuple(name for name in FORMATS if name in names)


_ONLY = schema.ListType(
    item=schema.TextType(expected=_ONLY_FORM, may_be_empty=True, finish=_figure_name),
    expected=_ONLY_FORM,
    at_least=0,
    finish=_each_once,
)
_DEPTHS = schema.ListType(
    item=schema.NumberType(above=0.0, form=_DEPTHS_FORM),
    expected=_DEPTHS_FORM,
    finish=_each_once,
)
_COLOUR_MAP = schema.TextType(expected=_COLOUR_MAP_FORM, may_be_empty=True, finish=_colour_map)
_FORMATS = schema.ListType(
    item=schema.TextType(expected=_FORMATS_FORM, may_be_empty=True),
    expected=_FORMATS_FORM,
    at_least=0,
    alone=True,
    finish=_formats,
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Figures:
    """``[figures]``: selection and appearance of the figures of a run; they change no result."""

    only: tuple[str, ...] = schema.typed(
        "names of the figures to draw; default: cut packing, section, peak force against depth or "
        "along the chain, plastic zone, energies, force at the bottom, and the records requested "
        "by the case",
        _ONLY,
        default=(),
    )
    all: bool = schema.choice(
        "draw all applicable figures (ignored if only is set)", (True, False), default=False
    )
    plane: CutPlane | None = schema.typed(
        "plane of an additional section; the names of its figures end in _section",
        _PLANE,
        default=None,
    )
    depths: tuple[float, ...] | None = schema.typed(
        "depths of the figure force_at_depths, below the centre of the impacted sphere; "
        "default: up to five between layers, or along the chain",
        _DEPTHS,
        unit="m",
        default=None,
    )
    colour_map: str | None = schema.typed(
        "colour map of sections, cut packings, maps, animations and pages; default: viridis for "
        "forces and velocities, inferno up to orange for dissipation, cividis for plastic "
        "indentations and small waves",
        _COLOUR_MAP,
        default=None,
    )
    force_limits: tuple[float, float] | None = schema.typed(
        "limits of the colour scale of forces, relative to the force at first yield, or to the "
        "largest force if nothing yields; default: the range of the values",
        _LIMITS,
        default=None,
    )
    dissipation_limits: tuple[float, float] | None = schema.typed(
        "limits of the colour scale of dissipation, relative to the energy input; default: 1e-6 "
        "and 0.1",
        _LIMITS,
        default=None,
    )
    width: float = schema.number(
        "width of a single-column figure; wider figures scale in proportion, font sizes do not "
        "change",
        "m",
        at_least=0.05,
        at_most=0.5,
        default=COLUMN,
    )
    formats: tuple[str, ...] = schema.typed(
        "additional file formats of each figure, as well as PNG and the CSV file of its data; "
        "each format takes additional time",
        _FORMATS,
        default=("pdf",),
    )
    film: str = schema.choice(
        "format of an animation that is made with the figures, such as film.mp4; run.frames is "
        f"then {FRAMES_OF_A_FILM} by default",
        ("none", *FILM_FORMATS),
        default="none",
    )
    view: bool = schema.choice(
        "make view.html with the figures, a page to rotate and cut the packing in a "
        "browser", (True, False),
        default=False,
    )  # fmt: skip

    @property
    def chosen(self) -> tuple[str, ...]:
        """Names of the figures to draw, if they apply."""
        if self.only:
            return self.only
        return figure_names() if self.all else usual_figure_names()

    @property
    def products(self) -> dict[str, str]:
        """Names of the files that are made with the figures, by their key."""
        files = {}
        if self.film != "none":
            files["film"] = FILM_FILE.format(self.film)
        if self.view:
            files["view"] = VIEW_FILE
        return files


def read_figures(table: Any, source: str) -> Figures:
    """Read only a table ``[figures]``.

    Parameters
    ----------
    source
        Name of its file in messages.

    Raises
    ------
    InputError
        A key is invalid; the message lists all faults.
    """
    errors = ErrorList(source)
    found = read_table(Figures, table, "figures", errors)
    errors.report(source)
    assert found is not None  # it is None only with errors
    return found
