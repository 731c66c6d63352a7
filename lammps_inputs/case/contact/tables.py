"""Tables in ``[contact]`` and ``[[pair]]``: losses, resistances, cohesion and initial dents."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, Final

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.contact.law_parameters import OF_LOSS, with_parameters
from granwave.lammps_inputs.case.hints import POSSIBLE, VELOCITY
from granwave.lammps_inputs.case.schema import (
    NumberType,
    TableType,
    ValidationError,
    refuse_if,
    show,
)

_GAIN = "below 0 a contact would gain energy, and restitution exceed 1"


def _restitution_field(description: str, default: Any) -> Any:
    form = "a restitution above 0 and at most 1"
    return schema.number(description, above=0, at_most=1, form=form, default=default)


@dataclasses.dataclass(frozen=True, kw_only=True)
class DashpotRestitution:
    """Restitution of a Hertzian contact with a dashpot, which does not depend on speed."""

    restitution: float = _restitution_field(
        "coefficient of restitution of a head-on collision of two spheres, at any speed",
        schema.REQUIRED,
    )


LOSS_FORM = (
    "{time = ...} in s, {restitution = ..., velocity = ...} with the velocity in m/s, "
    "{dashpot = ...}, {dashpot = {restitution = ...}} or "
    '{kind = "prony", weights = [...], times = [...]} with the times in s'
)
_LONGEST_TIME = 1.0  # s
_LONGEST_RELAXATION = 1e6  # s
_TIME_FORM = f"a relaxation time from 0 to {_LONGEST_TIME:g} s"


def _loss_time(time: float) -> float:
    refuse_if(time < 0, f"{_TIME_FORM}; {_GAIN}")
    refuse_if(time > _LONGEST_TIME, f"{_TIME_FORM}; {time:g} µs is {time:g}e-6")
    return time


def _dashpot(factor: float) -> float:
    refuse_if(factor < 0, f"a factor of the dashpot from 0 up; {_GAIN}")
    return factor


_DASHPOT = schema.EitherType(
    types=(
        TableType(section=DashpotRestitution, expected=LOSS_FORM),
        NumberType(form="a factor of the dashpot from 0 up", finish=_dashpot),
    ),
    form="a factor of the dashpot from 0 up, or {restitution = ...}",
)


_LOSS_KINDS = ("time", "restitution", "dashpot", "kind")
PRONY: Final = "prony"
MOST_BRANCHES = 4  # most branches of a Prony series, as in the plugin
_WEIGHTS_FORM = f"1 to {MOST_BRANCHES} weights, each above 0, with a sum below 1"
_TIMES_FORM = f"1 to {MOST_BRANCHES} times above 0 and at most {_LONGEST_RELAXATION:g} s"


def _weights(weights: tuple[float, ...]) -> tuple[float, ...]:
    refuse_if(sum(weights) >= 1, f"{_WEIGHTS_FORM}; at a sum of 1 the modulus relaxes to zero")
    return weights


_WEIGHTS = schema.ListType(
    item=NumberType(above=0, below=1, form=_WEIGHTS_FORM),
    expected=_WEIGHTS_FORM,
    at_most=MOST_BRANCHES,
    finish=_weights,
)
_TIMES = schema.ListType(
    item=NumberType(above=0, at_most=_LONGEST_RELAXATION, form=_TIMES_FORM),
    expected=_TIMES_FORM,
    at_most=MOST_BRANCHES,
)


@dataclasses.dataclass(frozen=True, kw_only=True)
@with_parameters(
    OF_LOSS, first=("time", "restitution", "velocity", "dashpot", "kind", "weights", "times")
)
class Loss:
    """Viscous damping of contacts: a time, restitution at a velocity, a dashpot, or a Prony series.

    The parameters of the loss along the surface are fields as well, with the names of the plugin.
    """

    time: float | None = schema.typed(
        "relaxation time: the elastic stress is evaluated at the strain plus this time multiplied "
        "by the strain rate",
        NumberType(form=_TIME_FORM, finish=_loss_time),
        unit="s",
        default=None,
    )
    restitution: float | None = _restitution_field(
        "coefficient of restitution of a head-on collision, which determines the relaxation time",
        None,
    )
    velocity: float | None = schema.number(
        "approach velocity at which the restitution applies",
        "m/s",
        at_least=POSSIBLE["m/s"][0],
        at_most=VELOCITY.high * 1e3,
        form="a velocity above 0 (m/s), at which the restitution applies",
        default=None,
    )
    dashpot: float | DashpotRestitution | None = schema.typed(
        "factor of Tsuji's dashpot, which multiplies sqrt(mass × stiffness); or the restitution "
        "of a Hertzian contact with this dashpot",
        _DASHPOT,
        default=None,
    )
    kind: str | None = schema.choice(
        '"prony": viscoelastic grains, whose modulus relaxes by a Prony series; '
        "`youngs_modulus` is the instantaneous modulus; for laws that do not yield",
        (PRONY,),
        default=None,
    )
    weights: tuple[float, ...] | None = schema.typed(
        "fractions of the modulus that relax, with a sum below 1", _WEIGHTS, default=None
    )
    times: tuple[float, ...] | None = schema.typed(
        "relaxation times of these fractions", _TIMES, unit="s", default=None
    )

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...

    @property
    def damps_surface(self) -> bool:
        """True if the contact is damped along its surface, where it has friction."""
        return bool(self.tangential)

    @property
    def branches(self) -> tuple[tuple[float, float], ...]:
        """Weight and time (s) of each branch of a Prony series; empty for other losses."""
        return tuple(zip(self.weights or (), self.times or (), strict=True))

    def checked(self) -> Loss:
        """Return the loss; raise `ValidationError` unless it is of one of the four kinds."""
        kinds = [name for name in _LOSS_KINDS if getattr(self, name) is not None]
        alone = self.damps_surface and not kinds
        refuse_if(
            alone,
            f"{LOSS_FORM}; tangential is a factor of the normal damping that one of these sets",
        )
        self._check_series()
        both = " and ".join(kinds[:2])
        refuse_if(len(kinds) > 1, f"one of {LOSS_FORM}; {both} exclude each other")
        if kinds != ["restitution"]:
            is_alone = self.velocity is not None
            refuse_if(is_alone, f"{LOSS_FORM}; velocity is only used with a restitution")
        elif self.velocity is None:
            at_any = (
                f"{{dashpot = {{restitution = {show(self.restitution)}}}}} applies at any velocity"
            )
            missing = "the velocity at which the restitution applies is missing"
            raise ValidationError(f"{LOSS_FORM}; {missing}, and {at_any}")
        return self

    def _check_series(self) -> None:
        """Raise `ValidationError` for a series without its kind, its weights or its times."""
        if self.kind is None:
            alone = self.weights is not None or self.times is not None
            refuse_if(alone, f'{LOSS_FORM}; weights and times require kind = "{PRONY}"')
            return
        whole = self.weights is not None and self.times is not None
        refuse_if(not whole, f'{LOSS_FORM}; kind = "{PRONY}" requires weights and times')
        numbers = len(self.weights or ()), len(self.times or ())
        refuse_if(numbers[0] != numbers[1], f"{LOSS_FORM}; as many times as weights")
        refuse_if(
            self.damps_surface,
            f"{LOSS_FORM}; a Prony series has no damping to which tangential is a ratio",
        )


LOSS = TableType(section=Loss, expected=LOSS_FORM, finish=Loss.checked)

MARSHALL = "marshall"  # resistance to twisting by friction of the contact circle
ROLLING_FORM = "a coefficient, or {coefficient = ..., stiffness = (N/m), damping = (N s/m)}"
TWISTING_FORM = (
    'a coefficient in m, {coefficient = (m), stiffness = (N m), damping = (N m s)}, or "marshall"'
)
_MOST_COEFFICIENT = 10.0
_MOST_STIFFNESS = 1e15
_MOST_DAMPING = 1e9
_COEFFICIENT_FORM = f"a coefficient from 0 to {_MOST_COEFFICIENT:g}"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Resistance:
    """Spring, dashpot and slider that resist the rolling or the twisting of a contact.

    A coefficient of 0 means no resistance, also in a pair that overrides [contact].
    """

    coefficient: float = schema.number(
        "largest torque divided by effective radius and normal force for rolling, by normal force "
        "(m) for twisting",
        at_least=0,
        at_most=_MOST_COEFFICIENT,
        form=_COEFFICIENT_FORM,
    )
    stiffness: float | None = schema.number(
        "stiffness, N/m for rolling, N m for twisting; default: determined from the contact circle",
        above=0,
        at_most=_MOST_STIFFNESS,
        form=(
            f"a stiffness above 0, to {_MOST_STIFFNESS:g}; omit it to determine it from the "
            "contact circle"
        ),
        default=None,
    )
    damping: float = schema.number(
        "constant of the dashpot, N s/m for rolling, N m s for twisting",
        at_least=0,
        at_most=_MOST_DAMPING,
        form=f"a damping from 0 to {_MOST_DAMPING:g}",
        default=0.0,
    )


def _resistance(form: str, *others: schema.ValueType) -> schema.EitherType:
    def of_coefficient(coefficient: float) -> Resistance:
        bounds = f"{form}; coefficient from 0 to {_MOST_COEFFICIENT:g}"
        refuse_if(not 0 <= coefficient <= _MOST_COEFFICIENT, bounds)
        return Resistance(coefficient=coefficient)

    coefficient = NumberType(finish=of_coefficient)
    table = TableType(section=Resistance, expected=form)
    return schema.EitherType(types=(*others, table, coefficient), form=form)


ROLLING = _resistance(ROLLING_FORM)
TWISTING = _resistance(TWISTING_FORM, schema.WordType(MARSHALL))

COHESION_FORM = '{kind = "jkr" or "dmt", energy = (work of adhesion, J/m^2)}'
_MOST_ADHESION = 1e4  # J/m^2


@dataclasses.dataclass(frozen=True, kw_only=True)
class Cohesion:
    """Cohesion of contacts.

    An energy of 0 means no cohesion, for instance in a pair that overrides [contact].
    """

    kind: str = schema.choice(
        "model of cohesion: jkr (Johnson, Kendall and Roberts) or dmt (Derjaguin, Muller and "
        "Toporov)",
        ("jkr", "dmt"),
    )
    energy: float = schema.number(
        "work of adhesion of the two surfaces",
        "J/m^2",
        at_least=0,
        at_most=_MOST_ADHESION,
        form=f"an energy from 0 to {_MOST_ADHESION:g}",
    )


COHESION = TableType(section=Cohesion, expected=COHESION_FORM)

DENT_FORM = (
    "a number in m, the path of a result.h5, or tables {overlap = ...} or {force = ...} with low "
    "and high = [x, y, z]"
)


def _size_field(description: str, unit: str) -> Any:
    form = "a number, not negative"
    return schema.number(description, unit, at_least=0, form=form, default=None)


def _corner_field(description: str) -> Any:
    return schema.typed(
        description, schema.vector_type(3, "[x, y, z] in m"), unit="m", default=None
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Dents:
    """Initial dents of the contacts in a box, given by the largest earlier overlap or force."""

    overlap: float | None = _size_field("largest earlier overlap", "m")
    force: float | None = _size_field("largest earlier force", "N")
    low: tuple[float, float, float] | None = _corner_field("corner of the box; default: no limit")
    high: tuple[float, float, float] | None = _corner_field("opposite corner of the box")

    def checked(self) -> Dents:
        """Return the dents; raise `ValidationError` for two sizes, or an empty box."""
        refuse_if((self.overlap is None) == (self.force is None), DENT_FORM)
        if self.low is not None and self.high is not None:
            is_empty = any(a > b for a, b in zip(self.low, self.high, strict=True))
            refuse_if(is_empty, "low below high along each axis of the box")
        return self


def _size(size: float) -> float:
    refuse_if(size < 0, f"{DENT_FORM}, not negative")
    return size


_DENT = TableType(section=Dents, expected=DENT_FORM, finish=Dents.checked)
DENTS = schema.EitherType(
    types=(
        schema.TextType(expected=DENT_FORM),
        schema.ListType(item=_DENT, expected=DENT_FORM, alone=True),
        NumberType(finish=_size),
    ),
    form=DENT_FORM,
)
