"""Forces of all contacts of a run: at rest, at an instant, and at the largest force of each
contact; and the tail of their distribution.

The instant has the largest elastic energy among the snapshots with ``output.contact_forces``, or in
the record of a chain. Contacts that carry less than 1e-4 of the largest force do not count: grains
that touch overlap by the rounding of their coordinates. The loaded contacts of a run, of which the
largest forces are a part, are those that the summary counts (`is_loaded`).

Beyond a threshold x0 an exponential tail is exp(-b (x - x0)). Of n independent values beyond it
the decay is b = (n - 1) / sum(x - x0), without bias, with the standard error b / sqrt(n - 2).
Whether the values are exponential is tested by the distance D of Kolmogorov and Smirnov, with the
limit for a fitted decay at a level of 1 % (Stephens, J. Am. Stat. Assoc. 69 (1974) 730):
(D - 0.2/n) (sqrt(n) + 0.26 + 0.5/sqrt(n)) < 1.308.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.formatting.numbers import instant
from granwave.analysis.lammps_output.dumps import read_frame_forces
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.contacts import is_loaded
from granwave.analysis.result.reader import Result
from granwave.analysis.result.trajectory import GROUP
from granwave.lammps_inputs.run_directory import DUMPS, FRAME_FORCES_FILE

STATIC = "static"
INSTANT = "instant"
PEAK = "peak"

_LEAST = 1e-4  # fraction of the largest force: contacts that carry less do not count
_FEWEST_IN_TAIL = 10  # fewest values of a fitted tail
_LARGEST_DEVIATION = 1.308  # Stephens's limit at a level of 1 %

Ids = NDArray[np.int64]
Blocks = Iterable[tuple[NDArray, ...]]  # ids i and j, and forces, N


@dataclasses.dataclass(frozen=True, eq=False)
class ContactForces:
    """Forces of the loaded contacts between grains.

    Attributes
    ----------
    name
        `STATIC`, `INSTANT` or `PEAK`.
    time
        Time, s; None for the largest force of each contact over the run.
    i, j
        Ids of the grains: (n_contacts,).
    force
        Forces: (n_contacts,), N.
    n_left_out
        Number of loaded contacts with a smaller force than 1e-4 of the largest, which do not count.
    """

    name: str
    time: float | None
    i: Ids
    j: Ids
    force: Array
    n_left_out: int = 0

    @property
    def title(self) -> str:
        """The state in words."""
        if self.name == STATIC:
            return "static state"
        if self.time is None:
            return "largest of each contact"
        return f"at {instant(self.time)}"


def contact_forces(result: Result, kept: NDArray[np.bool_] | None = None) -> list[ContactForces]:
    """Return the forces at rest, at the instant of the largest elastic energy, and the largest of
    each contact, if the run has them.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    kept
        True for spheres whose contacts with each other count: (n_spheres,); None: all.
    """
    states = []
    if "contacts/initial_force" in result:
        states.append(_joined(result, STATIC, 0.0, _of_table(result, "initial_force"), kept))
    at_instant = _at_instant(result)
    if at_instant is not None:
        time, pairs = at_instant
        states.append(_joined(result, INSTANT, time, [pairs], kept))
    states.append(_joined(result, PEAK, None, _largest_forces(result), kept))
    return [state for state in states if len(state.force)]


def _of_table(result: Result, column: str) -> Blocks:
    """Return the contacts of the run in blocks."""
    return result.blocks("contacts/i", "contacts/j", f"contacts/{column}")


def _largest_forces(result: Result) -> Blocks:
    """Yield the loaded contacts of the run with their largest forces, in blocks."""
    names = ("i", "j", "peak_force", "peak_overlap", "yield_overlap")
    for i, j, force, overlap, yield_overlap in result.blocks(
        *(f"contacts/{name}" for name in names)
    ):
        loaded = is_loaded(overlap, yield_overlap, force)
        yield i[loaded], j[loaded], force[loaded]


def _joined(
    result: Result,
    name: str,
    time: float | None,
    blocks: Blocks,
    kept: NDArray[np.bool_] | None,
) -> ContactForces:
    """Return the contacts of blocks that carry a force."""
    parts = []
    largest = 0.0
    for i, j, force in blocks:
        largest = max(largest, float(force.max(initial=0.0)))
        chosen = force > 0
        if kept is not None:
            chosen[chosen] = kept[result.rows(i[chosen])] & kept[result.rows(j[chosen])]
        parts.append((i[chosen], j[chosen], force[chosen]))
    i, j, force = (np.concatenate(column) for column in zip(*parts, strict=True))
    carries = force >= _LEAST * largest
    n_left_out = int(np.count_nonzero(~carries))
    return ContactForces(name, time, i[carries], j[carries], force[carries], n_left_out)


def _at_instant(result: Result) -> tuple[float, tuple[NDArray, ...]] | None:
    """Return the recorded instant with the largest elastic energy, s, and its contacts; None if
    none was recorded.
    """
    if (result.path.parent / DUMPS / FRAME_FORCES_FILE).exists():
        return _of_snapshot(result)
    if "chain" in result and result["chain/contact_force"].size:
        return _of_chain(result)
    return None


def _of_snapshot(result: Result) -> tuple[float, tuple[NDArray, ...]] | None:
    number = _most_energetic(result, result.frame_times)
    step = int(result[f"{GROUP}/position/step"][number])
    for frame in read_frame_forces(result.path.parent):
        if frame.step == step:
            i = frame["i"].astype(np.int64)
            j = frame["j"].astype(np.int64)
            return float(result.frame_times[number]), (i, j, frame["force"])
    return None


def _of_chain(result: Result) -> tuple[float, tuple[NDArray, ...]]:
    time = result["chain/time"]
    number = _most_energetic(result, time)
    i = result["chain/contact_i"]
    j = result["chain/contact_j"]
    between = np.maximum(i, j) <= result.assembly.n_spheres  # not with the face of a bar
    force = result["chain/contact_force"][number][between]
    return float(time[number]), (i[between], j[between], force)


def _most_energetic(result: Result, times: Array) -> int:
    """Return the number of the time with the largest elastic energy."""
    elastic = np.interp(times, result["energy/time"], result["energy/elastic"])
    return int(np.argmax(elastic))


@dataclasses.dataclass(frozen=True)
class ExponentialTail:
    """Exponential fitted to the values beyond a threshold.

    Attributes
    ----------
    start
        The threshold, in the unit of the values.
    decay
        Rate of the decay, 1 over that unit.
    error
        Standard error of the decay, of independent values.
    count
        Number of values beyond the threshold.
    is_exponential
        True unless the values beyond it differ from the exponential at a level of 1 %.
    """

    start: float
    decay: float
    error: float
    count: int
    is_exponential: bool


def exponential_tail(values: Array, start: float) -> ExponentialTail | None:
    """Fit an exponential to the values beyond a threshold; None for fewer than ten of them.

    Parameters
    ----------
    values
        Values: (n_values,).
    start
        The threshold.
    """
    beyond = np.sort(values[values > start]) - start
    count = len(beyond)
    if count < _FEWEST_IN_TAIL:
        return None
    decay = (count - 1) / float(beyond.sum())
    is_exponential = _deviation(beyond) < _LARGEST_DEVIATION
    return ExponentialTail(start, decay, decay / math.sqrt(count - 2), count, is_exponential)


def _deviation(values: Array) -> float:
    """Return Stephens's modified distance of rising values from the exponential of their mean."""
    count = len(values)
    expected = -np.expm1(-values / values.mean())
    steps = np.arange(count + 1) / count
    distance = float(max((steps[1:] - expected).max(), (expected - steps[:-1]).max()))
    root = math.sqrt(count)
    return (distance - 0.2 / count) * (root + 0.26 + 0.5 / root)
