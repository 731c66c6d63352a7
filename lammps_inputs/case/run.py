"""``[run]``, ``[output]`` and ``[figures]``: times of a run, records in addition to its snapshots,
and its figures.
"""

from __future__ import annotations

import dataclasses
import re
from functools import cache
from itertools import pairwise
from typing import Any, ClassVar, Literal

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.hints import INTERVAL, TIME
from granwave.lammps_inputs.case.material import AXES
from granwave.lammps_inputs.case.schema import ErrorList, ValidationError, read_table, show
from granwave.lammps_inputs.extensions import extensions, joined
from granwave.lammps_inputs.run_directory import FILM_FILE, VIEW_FILE

AUTO_END_TIME = 5e-3  # s, upper limit of `end_time = "auto"`
ENERGY_TOLERANCE = 3e-6  # default of `run.energy_tolerance`
#: Largest accepted error of the energy balance / input, for all runs.
BALANCE_TOLERANCE = 1e-5
LEAST_ENERGY_TOLERANCE = 1e-10  # rounding errors are about 1e-12 of the input
AUTO: Literal["auto"] = "auto"
AUTO_FRAMES = 20  # snapshots of `run.frames = "auto"`, limited by the number of steps
# number of snapshots for an animation: ten seconds at six frames per second
FRAMES_OF_A_FILM = 60

_SHARE = re.compile(r"(\d+(?:\.\d+)?) ?%")


_FRAMES_FORM = (
    'the number of snapshots (from 1 up), "auto", or a list of increasing times, all in s or all '
    'fractions of run.end_time ("25 %")'
)


@dataclasses.dataclass(frozen=True)
class TimesType(schema.ValueType):
    """Type of the times of snapshots: seconds, or fractions of the end time in words."""

    kind: ClassVar[str] = "array"
    expected: str = _FRAMES_FORM

    def read(self, value: Any) -> tuple[float, ...] | tuple[str, ...]:
        """Return the times, s, or the fractions unchanged."""
        schema.refuse_if(not isinstance(value, list | tuple) or not value, self.expected)
        in_words = all(isinstance(one, str) for one in value)
        read = parse_share if in_words else schema.finite
        times = [read(one, self.expected) for one in value]
        falls = any(later <= earlier for earlier, later in pairwise(times))
        schema.refuse_if(times[0] < 0 or falls, self.expected)
        return tuple(value) if in_words else tuple(times)

    @property
    def json(self) -> dict[str, Any]:
        """A list of numbers, or of words."""
        items = {"anyOf": [{"type": "number"}, {"type": "string"}]}
        return {"type": "array", "items": items, "minItems": 1}


_GRID_FORM = '"auto", or the numbers of bricks along x, y and z, such as [2, 1, 4]'
_GRID = schema.or_word(
    AUTO,
    schema.ListType(
        item=schema.CountType(form=_GRID_FORM), expected=_GRID_FORM, at_least=3, at_most=3
    ),
    form=_GRID_FORM,
)
_FRAMES = schema.EitherType(
    types=(
        schema.WordType(AUTO),
        TimesType(),
        schema.CountType(at_most=schema.NO_LIMIT, form=_FRAMES_FORM),
    ),
    form=_FRAMES_FORM,
)


def parse_share(text: str, expected: str) -> float:
    """Convert a fraction such as ``"25 %"`` to 0.25; raise `ValidationError` unless it is from 0 to
    100 %.
    """
    if not (found := _SHARE.fullmatch(text)) or float(found[1]) > 100:
        raise ValidationError(expected)
    return float(found[1]) / 100


#: Keys of ``[run]`` that divide the box between ranks and do not affect results.
DIVISION_KEYS = ("processors", "balance")


@dataclasses.dataclass(frozen=True, kw_only=True)
class RunSettings:
    """``[run]``: end time, timestep and snapshots."""

    end_time: float | str = schema.positive_or_auto(
        "end of the run; auto: when dissipation grows by less than 1e-4 of the energy input in 50 "
        "us, at most 5 ms",
        TIME,
        default=1e-3,
    )
    timestep: float | str = schema.positive_or_auto(
        "auto: controlled by the error of the energy balance; a number: the length of all steps",
        INTERVAL,
    )
    energy_tolerance: float = schema.number(
        "target for the error of the energy balance, relative to the energy input, of an "
        "automatic timestep",
        at_least=LEAST_ENERGY_TOLERANCE,
        at_most=1e-3,
        default=ENERGY_TOLERANCE,
    )
    smallest_timestep: float | str = schema.positive_or_auto(
        "lower bound of an automatic timestep; auto: a quarter of the timestep for the stiffest "
        "contact expected",
        INTERVAL,
    )
    largest_timestep: float | str = schema.positive_or_auto(
        "upper bound of an automatic timestep; auto: eight times the timestep for the stiffest "
        "contact expected",
        INTERVAL,
    )
    frames: int | Literal["auto"] | tuple[float, ...] | tuple[str, ...] = schema.typed(
        "snapshots, including start and end: their number (evenly spaced), or their times; auto: "
        f"{AUTO_FRAMES}, {FRAMES_OF_A_FILM} with an animation, two thirds of them before the wave "
        "is expected at the bottom, if this time is known",
        _FRAMES,
        default=AUTO,
    )
    processors: tuple[int, int, int] | Literal["auto"] = schema.typed(
        "grid of bricks into which the box is divided, one for each rank; auto: the grid with the "
        "shortest steps, predicted from ghost spheres and the growing wave. Results do not "
        "depend on it",
        _GRID,
        default=AUTO,
    )
    balance: bool = schema.choice(
        "divide the box again during the run, so that all ranks have the same number of moving "
        "spheres; for local impacts on many ranks. Results do not depend on it",
        (False, True),
        default=False,
    )

    @property
    def frame_times(self) -> tuple[float, ...] | None:
        """Times of the snapshots, s, fractions of the end time among them; None if only their
        number is given.
        """
        if not isinstance(self.frames, tuple):
            return None
        return tuple(
            parse_share(time, "a share") * self.longest if isinstance(time, str) else time
            for time in self.frames
        )

    @property
    def accepted_balance_error(self) -> float:
        """Largest error of the energy balance, relative to the input, with which the run is
        accepted.
        """
        return max(BALANCE_TOLERANCE, self.energy_tolerance)

    @property
    def adaptive(self) -> bool:
        """True if the timestep follows the error of the energy balance."""
        return isinstance(self.timestep, str)

    @property
    def longest(self) -> float:
        """Latest time that the run can reach, s."""
        return AUTO_END_TIME if isinstance(self.end_time, str) else self.end_time


_PROBE_FORM = "a list such as [{sphere = 12}, {contact = [12, 34]}]"


_PARTS_FORM = 'true, false or "auto"'
_PARTS = schema.or_word(AUTO, schema.ChoiceType((True, False)), form=_PARTS_FORM)
_PROBE_ID = schema.CountType(form="an id from 1 up")


_TWO_IDS = "two ids from 1 up"


@dataclasses.dataclass(frozen=True)
class Probe:
    """Probe of a sphere, or of the contact of two spheres, recorded at its own rate."""

    sphere: int | None = schema.typed("id of the sphere", _PROBE_ID, default=None)
    contact: tuple[int, int] | None = schema.typed(
        "ids of two spheres, whose contact is recorded",
        schema.ListType(
            item=schema.CountType(form=_TWO_IDS), expected=_TWO_IDS, at_least=2, at_most=2
        ),
        default=None,
    )

    def checked(self) -> Probe:
        """Return the probe; raise `ValidationError` unless it is of a sphere or of a contact."""
        schema.refuse_if((self.sphere is None) == (self.contact is None), _PROBE_FORM)
        return self

    @property
    def spheres(self) -> tuple[int, ...]:
        """Ids of its sphere or spheres."""
        return self.contact if self.contact is not None else (self.sphere or 0,)


_PROBES = schema.ListType(
    item=schema.TableType(section=Probe, expected=_PROBE_FORM, finish=Probe.checked),
    expected=_PROBE_FORM,
    at_least=0,
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Output:
    """``[output]``: form of the snapshots, and further records."""

    dump_format: str = schema.choice(
        "format of the dump of snapshots: binary is written and read ten times faster, text can "
        "be read by every program",
        ("binary", "text"),
        default="binary",
    )
    probes: tuple[Probe, ...] = schema.typed(
        "spheres and contacts that are recorded every probe_interval", _PROBES, default=()
    )
    probe_interval: float | str = schema.positive_or_auto(
        "time between records of probes and walls; auto: five timesteps", INTERVAL
    )
    history: int | Literal["auto"] = schema.typed(
        "number of instants at which the velocity of every bead of a chain and the force of every "
        "contact are recorded; auto: 1000 (fewer with long bars) for chains of at least five "
        "beads; for each [[line]] likewise, auto: 2000",
        schema.or_word(
            AUTO,
            schema.CountType(at_least=0, at_most=schema.NO_LIMIT),
            form='a whole number from 0 up or "auto"',
        ),
        default="auto",
    )
    contact_forces: bool = schema.choice(
        "record the forces of all contacts, and the forces and angular velocities of the spheres, "
        "at every snapshot; for granwave infer, and run.contact_forces in Python",
        (False, True),
        default=False,
    )
    parts: bool | Literal["auto"] = schema.typed(
        "write snapshots, contacts and checkpoints to several files, snapshots and contacts to one "
        "file per node; auto: from 10 million spheres on",
        _PARTS,
        default="auto",
    )


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
        "forces and velocities, inferno for dissipation, cividis for plastic indentations",
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
