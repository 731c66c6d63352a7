"""``[run]``, ``[output]`` and ``[figures]``: times of a run, records besides its snapshots, and
what is drawn of it.
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
#: Largest error of the energy balance, over the input, that is accepted of every run.
BALANCE_TOLERANCE = 1e-5
LEAST_ENERGY_TOLERANCE = 1e-10  # rounding errors are some 1e-12 of the input
AUTO: Literal["auto"] = "auto"
AUTO_FRAMES = 20  # snapshots of `run.frames = "auto"`; a run of fewer steps has fewer
# the same where a film is asked for: ten seconds at six pictures a second
FRAMES_OF_A_FILM = 60

_SHARE = re.compile(r"(\d+(?:\.\d+)?) ?%")


_FRAMES_FORM = (
    'how many snapshots (from 1 up), "auto", or a list of rising times, all in s or all shares '
    'of run.end_time ("25 %")'
)


@dataclasses.dataclass(frozen=True)
class TimesType(schema.ValueType):
    """Type of the times of snapshots: seconds, or shares of the end time in words."""

    kind: ClassVar[str] = "array"
    expected: str = _FRAMES_FORM

    def read(self, value: Any) -> tuple[float, ...] | tuple[str, ...]:
        """Return the times, s, or the shares as they are."""
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


_FRAMES = schema.EitherType(
    types=(
        schema.WordType(AUTO),
        TimesType(),
        schema.CountType(at_most=schema.NO_LIMIT, form=_FRAMES_FORM),
    ),
    form=_FRAMES_FORM,
)


def parse_share(text: str, expected: str) -> float:
    """Convert a share such as ``"25 %"`` to 0.25; raise `ValidationError` if it is none from 0 to
    100 %.
    """
    if not (found := _SHARE.fullmatch(text)) or float(found[1]) > 100:
        raise ValidationError(expected)
    return float(found[1]) / 100


@dataclasses.dataclass(frozen=True, kw_only=True)
class RunSettings:
    """``[run]``: end time, timestep and snapshots."""

    end_time: float | str = schema.positive_or_auto(
        "when the run ends; auto: when 50 us add less than 1e-4 of the input to dissipation, at most 5 ms",
        TIME,
        default=1e-3,
    )
    timestep: float | str = schema.positive_or_auto(
        "auto: follows the error of the energy balance; a number: all steps are that long", INTERVAL
    )
    energy_tolerance: float = schema.number(
        "largest error of the energy balance, over the input, that an automatic timestep aims at",
        at_least=LEAST_ENERGY_TOLERANCE,
        at_most=1e-3,
        default=ENERGY_TOLERANCE,
    )
    smallest_timestep: float | str = schema.positive_or_auto(
        "lower bound of an automatic timestep; auto: a quarter of that for the stiffest contact expected",
        INTERVAL,
    )
    largest_timestep: float | str = schema.positive_or_auto(
        "upper bound of an automatic timestep; auto: eight times that for the stiffest contact expected",
        INTERVAL,
    )
    frames: int | Literal["auto"] | tuple[float, ...] | tuple[str, ...] = schema.typed(
        "snapshots, the start and the end among them: how many, evenly spaced, or the times; "
        f"auto: {AUTO_FRAMES}, {FRAMES_OF_A_FILM} with a film, two thirds of them until the wave is "
        "expected at the bottom, if that is known",
        _FRAMES,
        default=AUTO,
    )

    @property
    def frame_times(self) -> tuple[float, ...] | None:
        """Times of the snapshots, s, shares of the end time among them; None if only their number
        is given.
        """
        if not isinstance(self.frames, tuple):
            return None
        return tuple(
            parse_share(time, "a share") * self.longest if isinstance(time, str) else time
            for time in self.frames
        )

    @property
    def accepted_balance_error(self) -> float:
        """Largest error of the energy balance, over the input, with which the run is accepted."""
        return max(BALANCE_TOLERANCE, self.energy_tolerance)

    @property
    def adaptive(self) -> bool:
        """The timestep follows the error of the energy balance."""
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
    """Probe of one sphere or of the contact of two, recorded at its own rate."""

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
    """``[output]``: form of the snapshots, and records besides snapshots and energies."""

    dump_format: str = schema.choice(
        "form of the dump of snapshots: binary is written and read ten times as fast, text is read by every program",
        ("binary", "text"),
        default="binary",
    )
    probes: tuple[Probe, ...] = schema.typed(
        "spheres and contacts recorded at their own rate", _PROBES, default=()
    )
    probe_interval: float | str = schema.positive_or_auto(
        "time between records of probes and walls; auto: five timesteps", INTERVAL
    )
    history: int | Literal["auto"] = schema.typed(
        "instants at which the velocity of every bead of a chain and the force of every contact are recorded; "
        "auto: 1000 (fewer with long bars) for chains of five beads and more; the same for each [[line]], auto: 2000",
        schema.or_word(
            AUTO,
            schema.CountType(at_least=0, at_most=schema.NO_LIMIT),
            form='a whole number from 0 up or "auto"',
        ),
        default="auto",
    )
    contact_forces: bool = schema.choice(
        "forces of all contacts at every snapshot, with forces and spins of the spheres; for granwave infer, and "
        "run.contact_forces in Python",
        (False, True),
        default=False,
    )
    parts: bool | Literal["auto"] = schema.typed(
        "files of snapshots, contacts and checkpoints, one from each rank instead of one from all; "
        "auto: from 10 million spheres on",
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
)  # fmt: skip
#: Names of further figures of the core, which are drawn only where they are asked for by name.
FIGURES_ON_REQUEST = ("contact_network", "force_distribution", "line_diagram")
FORMATS = ("pdf", "svg")  # of figures, besides PNG
FILM_FORMATS = ("mp4", "gif", "webp")
COLUMN = 0.08636  # m, 3.4 inches: a column of a journal
_LIMITS = schema.vector_type(
    2, "two rising numbers above 0: the lower and the upper end", lambda low, high: 0 < low < high
)


NO_NORMAL = "a normal that is not [0, 0, 0]"
_PLANE_FORM = (
    '"x", "y" or "z" (the normal; through the struck sphere), or {normal = [x, y, z], through = [x, y, z]} '
    "with a point in m"
)


@dataclasses.dataclass(frozen=True)
class CutPlane:
    """A plane through a packing."""

    normal: tuple[float, float, float] = schema.typed(
        "normal of the plane, of any length but 0",
        schema.vector_type(3, "[x, y, z]", lambda *normal: any(normal), NO_NORMAL),
    )
    through: tuple[float, float, float] | None = schema.typed(
        "point of the plane; the centre of the struck sphere by default",
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
_ONLY_FORM = 'a list of names of figures, as ["energies", "packing_3d"]'
_COLOUR_MAP_FORM = 'the name of a colour map of matplotlib, as "viridis"'
_FORMATS_FORM = f"a list of some of {', '.join(FORMATS)}, or [] for PNG alone"


@cache
def figure_names() -> tuple[str, ...]:
    """Return the names of the figures of a run, in the order of reports."""
    own = dict.fromkeys((*FIGURES_BEFORE_ADDED, *FIGURES_AFTER_ADDED, *FIGURES_ON_REQUEST))
    added = joined("figure", own, {one.name: one.figures for one in extensions()})
    names_added = [name for name in added if name not in own]
    return (*FIGURES_BEFORE_ADDED, *names_added, *FIGURES_AFTER_ADDED, *FIGURES_ON_REQUEST)


def usual_figure_names() -> tuple[str, ...]:
    """Return the names of the figures that are drawn unless others are asked for."""
    return tuple(name for name in figure_names() if name not in FIGURES_ON_REQUEST)


def _figure_name(name: str) -> str:
    if name not in figure_names():
        near = schema.did_you_mean(name, figure_names(), cutoff=0.5)
        hint = near or f", but {', '.join(figure_names())}"
        raise ValidationError(f"names of figures: there is no {show(name)}{hint}")
    return name


def _each_once(names: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(names))


def _colour_map(name: str) -> str:
    from matplotlib import colormaps  # takes longer to load than most commands need

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
    """``[figures]``: what is drawn of a run, and how; none of it changes a result."""

    only: tuple[str, ...] = schema.typed(
        "names of the figures to draw; by default all that apply, but contact_network, "
        "force_distribution and line_diagram",
        _ONLY,
        default=(),
    )
    plane: CutPlane | None = schema.typed(
        "plane of a section of your own, besides the principal and the orthogonal one; its figures end in _section",
        _PLANE,
        default=None,
    )
    colour_map: str | None = schema.typed(
        "colour map of sections, cut packings, maps, films and pages; by default viridis for forces and velocities, "
        "inferno for dissipation, cividis for dents",
        _COLOUR_MAP,
        default=None,
    )
    force_limits: tuple[float, float] | None = schema.typed(
        "ends of the colour scale of forces, over the force at first yield, or over the largest force where nothing "
        "yields; by default they fit the values",
        _LIMITS,
        default=None,
    )
    dissipation_limits: tuple[float, float] | None = schema.typed(
        "ends of the colour scale of dissipation, over the energy input; 1e-6 and 0.1 by default",
        _LIMITS,
        default=None,
    )
    width: float = schema.number(
        "width of a figure of one column; wider ones grow in proportion, texts stay as they are",
        "m",
        at_least=0.05,
        at_most=0.5,
        default=COLUMN,
    )
    formats: tuple[str, ...] = schema.typed(
        "files of each figure besides the PNG and the CSV of its data; each form adds to the time of drawing",
        _FORMATS,
        default=("pdf",),
    )
    film: str = schema.choice(
        f"form of a film that is made with the figures, film.mp4 for one; there are {FRAMES_OF_A_FILM} snapshots then, "
        "where run.frames is not given",
        ("none", *FILM_FORMATS),
        default="none",
    )
    view: bool = schema.choice(
        "a page to turn and cut the packing in a browser, view.html, made with the figures", (True, False),
        default=False,
    )  # fmt: skip

    @property
    def products(self) -> dict[str, str]:
        """Names of the files that are made with the figures, by the key that asks for them."""
        files = {}
        if self.film != "none":
            files["film"] = FILM_FILE.format(self.film)
        if self.view:
            files["view"] = VIEW_FILE
        return files


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
