"""``[run]``: end time, timestep and snapshots."""

from __future__ import annotations

import dataclasses
import re
from itertools import pairwise
from typing import Any, Literal

from granwave.lammps_inputs.case.schema import (
    NO_LIMIT,
    ValidationError,
    custom,
    finite,
    number,
    positive_or_auto,
    whole,
)
from granwave.lammps_inputs.case.si_values import INTERVAL, TIME

AUTO_END_TIME = 5e-3  # s, upper limit of `end_time = "auto"`
ENERGY_TOLERANCE = 3e-6  # default of `run.energy_tolerance`
LEAST_ENERGY_TOLERANCE = 1e-10  # rounding errors are some 1e-12 of the input
DEFAULT_FRAMES = 20  # default of `run.frames`; a run of fewer steps has fewer

_SHARE = re.compile(r"(\d+(?:\.\d+)?) ?%")


def _parse_frames(value: Any) -> int | tuple[float, ...] | tuple[str, ...]:
    expected = (
        'how many snapshots (from 1 up), or a list of rising times, all in s or all shares of run.end_time ("25 %")'
    )
    if not isinstance(value, list | tuple):
        return whole(value, expected, at_most=NO_LIMIT)
    words = [one for one in value if isinstance(one, str)]
    if words and len(words) != len(value):
        raise ValidationError(expected)
    times = tuple(parse_share(word, expected) for word in words) or tuple(finite(time, expected) for time in value)
    if not times or times[0] < 0 or any(later <= earlier for earlier, later in pairwise(times)):
        raise ValidationError(expected)
    return tuple(words) or times


def parse_share(text: str, expected: str) -> float:
    """Convert a share such as ``"25 %"`` to 0.25; raise `ValidationError` if it is none from 0 to 100 %."""
    if not (found := _SHARE.fullmatch(text)) or float(found[1]) > 100:
        raise ValidationError(expected)
    return float(found[1]) / 100


@dataclasses.dataclass(frozen=True, kw_only=True)
class Run:
    """``[run]``: end time, timestep and snapshots."""

    end_time: float | Literal["auto"] = positive_or_auto(
        "when the run ends; auto: when 50 us add less than 1e-4 of the input to dissipation, at most 5 ms",
        unit="s",
        usual=TIME,
        default=1e-3,
    )
    timestep: float | Literal["auto"] = positive_or_auto(
        "auto: follows the error of the energy balance; a number: all steps are that long",
        unit="s",
        usual=INTERVAL,
    )
    energy_tolerance: float = number(
        "largest error of the energy balance, over the input, that an automatic timestep aims at",
        at_least=LEAST_ENERGY_TOLERANCE,
        at_most=1e-3,
        default=ENERGY_TOLERANCE,
    )
    smallest_timestep: float | Literal["auto"] = positive_or_auto(
        "lower bound of an automatic timestep; auto: a quarter of that for the stiffest contact expected",
        unit="s",
        usual=INTERVAL,
    )
    largest_timestep: float | Literal["auto"] = positive_or_auto(
        "upper bound of an automatic timestep; auto: eight times that for the stiffest contact expected",
        unit="s",
        usual=INTERVAL,
    )
    frames: int | tuple[float, ...] | tuple[str, ...] = custom(
        "snapshots, the start and the end among them: how many, or the times", _parse_frames, default=DEFAULT_FRAMES
    )

    @property
    def frame_times(self) -> tuple[float, ...] | None:
        """Times of the snapshots, s, shares of the end time among them; None if only their number is given."""
        if isinstance(self.frames, int):
            return None
        return tuple(
            parse_share(time, "a share") * self.longest if isinstance(time, str) else time for time in self.frames
        )

    @property
    def adaptive(self) -> bool:
        """The timestep follows the error of the energy balance."""
        return isinstance(self.timestep, str)

    @property
    def longest(self) -> float:
        """Latest time that the run can reach, s."""
        return AUTO_END_TIME if isinstance(self.end_time, str) else self.end_time
