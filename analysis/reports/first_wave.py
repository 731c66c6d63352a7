"""Course of the peak force of the first wave along a chain, in words."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.measures.bead_wave import beads_after_reflection
from granwave.analysis.measures.beads import bead_contact_depths, bead_peaks
from granwave.analysis.measures.leading_wave import REACHED, FirstWave, first_wave
from granwave.analysis.reports.kinds import ReportRun
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.errors import GranwaveError

_SAME_FORCE = 1e-3  # relative difference of forces that are constant along a chain
_FEWEST_LEVEL = 4  # fewest contacts at the end of a course with a constant force
_FEWEST_CONTACTS = 2  # fewest contacts of a course
_FRACTIONS = {"half": 0.5, "a tenth": 0.1}  # of the largest force, with their names


def course_of_peaks(run: ReportRun) -> str:
    """Return the course of the dynamic peak force of the first wave along the contacts of a chain,
    with the depths at which it has decayed to a half and to a tenth; empty if there is none.
    """
    try:
        with Result(run.results) as result:
            if "chain" not in result:
                return ""
            depth = np.abs(result["chain/contact_position"] - result.origin[2])
            return course_in_words(first_wave(result), depth)
    except (GranwaveError, KeyError, ValueError, IndexError):
        return ""


def course_of_beads(result: Result) -> str:
    """Return the course along the beads of a chain with added grains, as `course_of_peaks`."""
    peak = bead_peaks(result)
    is_late = beads_after_reflection(result)
    is_known = np.isfinite(peak) & ~is_late
    is_passing = ~np.isfinite(peak) & ~is_late
    wave = FirstWave(np.nan_to_num(peak), is_known, is_passing, None)
    course = course_in_words(wave, bead_contact_depths(result))
    if not course or not np.any(is_late):
        return course
    last = int(np.flatnonzero(is_late)[0])
    return f"{course}; beyond contact {last}, the largest force came after the reflection"


def course_in_words(wave: FirstWave, depth: NDArray[np.float64]) -> str:
    """Return the course of the peak force of a wave, as `course_of_peaks`.

    Parameters
    ----------
    depth
        Depths of the contacts below the impacted bead: (n_contacts,), m.
    """
    peak = np.where(wave.is_known, wave.peak, 0.0)
    known = np.flatnonzero(peak > REACHED * peak.max(initial=0.0))
    if len(known) < _FEWEST_CONTACTS:
        return _why_unknown(wave)
    course = _course(peak[known], known + 1)
    return course + _distances(peak[known], depth[known]) + _unknown_beyond(wave, int(known[-1]))


def _why_unknown(wave: FirstWave) -> str:
    """Return the reason why a wave has no course; empty where it has hardly started."""
    if not np.any(wave.is_passing):
        return ""
    end = "the end of the run" if wave.reflection is None else "the reflection"
    return f"is not known: the largest pulse has passed fewer than two contacts before {end}"


def _distances(peak: NDArray[np.float64], depth: NDArray[np.float64]) -> str:
    """Return a clause on the depths at which the peak force first is a half and a tenth of its
    largest value, beyond the contact with this value; empty if it does not decay to a half.

    Parameters
    ----------
    peak, depth
        Of the known contacts, in their order: (n_contacts,), N, and below the impacted bead, m.
    """
    first = int(peak.argmax())
    parts = [
        f"{name} at {quantity_in(distance, 'm')}"
        for name, fraction in _FRACTIONS.items()
        if (distance := _distance(peak[first:], depth[first:], fraction)) is not None
    ]
    return f" ({', '.join(parts)} below the impacted bead)" if parts else ""


def _distance(
    peak: NDArray[np.float64], depth: NDArray[np.float64], fraction: float
) -> float | None:
    """Return the depth at which forces first are a fraction of the first force, m; between contacts
    by an exponential. None if they never are.
    """
    level = np.log(peak / (fraction * peak[0]))
    below = np.flatnonzero(level <= 0)
    if not len(below):
        return None
    before = int(below[0]) - 1
    part = level[before] / (level[before] - level[before + 1])
    return float(depth[before] + part * (depth[before + 1] - depth[before]))


def _unknown_beyond(wave: FirstWave, last: int) -> str:
    """Return a clause on the contacts beyond the last with a known peak, by its index; empty if the
    wave has not reached them.
    """
    if wave.reflection is not None and last + 1 < len(wave.peak):
        end = "the reflection arrives"
    elif np.any(wave.is_passing[last:]):
        end = "the run ends"
    else:
        return ""
    return f"; beyond contact {last + 1}, {end} before the largest pulse has passed"


def _course(force: NDArray[np.float64], contact: NDArray[np.intp]) -> str:
    """Return the course of forces along contacts, by their numbers: (n,) each."""
    level = np.abs(force / force[-1] - 1) <= _SAME_FORCE
    n_level = int(np.argmin(level[::-1])) if not level.all() else len(level)
    first = f"{quantity_in(float(force[0]), 'N')} in contact {contact[0]}"
    if n_level == len(force):
        return f"is constant within 0.1 %: {first} to {contact[-1]}"
    steps = np.diff(force) / force[:-1]
    verb = ""
    if np.all(steps <= _SAME_FORCE):
        verb = "decreases"
    elif np.all(steps >= -_SAME_FORCE):
        verb = "increases"
    if not verb:
        ends = [
            f"{quantity_in(float(force[k]), 'N')} in contact {contact[k]}"
            for k in (int(force.argmin()), int(force.argmax()))
        ]
        return f"is between {ends[0]} and {ends[1]}"
    at = len(force) - n_level if n_level >= _FEWEST_LEVEL else len(force) - 1
    text = f"{verb} from {first} to {quantity_in(float(force[at]), 'N')} in contact {contact[at]}"
    if at == len(force) - 1:
        return text
    return f"{text} and is constant within 0.1 % from there to contact {contact[-1]}"
