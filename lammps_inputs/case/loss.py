"""``contact.loss``: energy that contacts lose by the rate of their overlap, beside yielding and friction."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from granwave.lammps_inputs.case.schema import ValidationError, finite, show
from granwave.lammps_inputs.case.si_values import POSSIBLE, VELOCITY

LOSS_FORM = (
    "{time = ...} in s, {restitution = ..., velocity = ...} with the velocity in m/s, "
    "{dashpot = ...} or {dashpot = {restitution = ...}}"
)
_KINDS = ("time", "restitution", "dashpot")
_LONGEST_TIME = 1.0  # s
_GAIN = "below 0 a contact would gain energy, and restitution exceed 1"


@dataclasses.dataclass(frozen=True, kw_only=True)
class DashpotRestitution:
    """Restitution that a dashpot gives a Hertzian contact, at any speed."""

    restitution: float


@dataclasses.dataclass(frozen=True, kw_only=True)
class Loss:
    """Viscous loss of contacts: one of the three kinds.

    Attributes
    ----------
    time
        Loss time A, s.
    restitution, velocity
        Restitution of a head-on collision, and its speed of approach, m/s; the loss time follows from both.
    dashpot
        Factor of Tsuji's dashpot, or the restitution that it gives a Hertzian contact.
    """

    time: float | None = None
    restitution: float | None = None
    velocity: float | None = None
    dashpot: float | DashpotRestitution | None = None


def parse_loss(value: Any) -> Loss:
    """Read a loss; raise `ValidationError` for anything but one of the three kinds."""
    if not isinstance(value, Mapping) or not value:
        raise ValidationError(LOSS_FORM)
    kinds = [name for name in _KINDS if name in value]
    if unknown := [name for name in value if name not in (*_KINDS, "velocity")]:
        raise ValidationError(f"{LOSS_FORM}; {unknown[0]} is unknown")
    if len(kinds) > 1:
        raise ValidationError(f"one of {LOSS_FORM}; {kinds[0]} and {kinds[1]} exclude each other")
    if kinds == ["restitution"] and "velocity" not in value:
        raise ValidationError(
            f"{LOSS_FORM}; the velocity at which the restitution holds is missing, "
            f"and {{dashpot = {{restitution = {show(value['restitution'])}}}}} holds at any"
        )
    if kinds != ["restitution"] and "velocity" in value:
        raise ValidationError(f"{LOSS_FORM}; a velocity belongs to a restitution")
    if "time" in value:
        time = finite(value["time"], LOSS_FORM)
        if time < 0:
            raise ValidationError(f"a loss time from 0 to {_LONGEST_TIME:g} s; {_GAIN}")
        if time > _LONGEST_TIME:
            raise ValidationError(f"a loss time from 0 to {_LONGEST_TIME:g} s; {time:g} us is {time:g}e-6")
        return Loss(time=time)
    if "dashpot" in value:
        return Loss(dashpot=_parse_dashpot(value["dashpot"]))
    velocity = finite(value["velocity"], LOSS_FORM)
    if not POSSIBLE["m/s"][0] <= velocity <= VELOCITY.high * 1e3:
        raise ValidationError("a velocity above 0 (m/s), at which the restitution holds")
    return Loss(restitution=_parse_restitution(value["restitution"]), velocity=velocity)


def _parse_dashpot(value: Any) -> float | DashpotRestitution:
    if isinstance(value, Mapping):
        if set(value) != {"restitution"}:
            raise ValidationError(LOSS_FORM)
        return DashpotRestitution(restitution=_parse_restitution(value["restitution"]))
    factor = finite(value, LOSS_FORM)
    if factor < 0:
        raise ValidationError(f"a factor of the dashpot from 0 up; {_GAIN}")
    return factor


def _parse_restitution(value: Any) -> float:
    restitution = finite(value, LOSS_FORM)
    if not 0 < restitution <= 1:
        raise ValidationError("a restitution above 0 and at most 1")
    return restitution
