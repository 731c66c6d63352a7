"""``[run]``: times of a run, its snapshots, and the division between ranks."""

from __future__ import annotations

import dataclasses
import re
from itertools import pairwise
from typing import Any, ClassVar, Literal

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.hints import INTERVAL, TIME
from granwave.lammps_inputs.case.schema import ValidationError

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
        "µs, or in the multiple of 50 µs that contains a slow collision; at most 5 ms",
        TIME,
        default=1e-3,
    )
    timestep: float | str = schema.positive_or_auto(
        "length of the timesteps; auto: controlled by the error of the energy balance; a "
        "number: the same for all steps",
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
        f"{AUTO_FRAMES}, or {FRAMES_OF_A_FILM} with an animation, two thirds of them before the "
        "expected arrival of the wave at the bottom, if this time is known",
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
