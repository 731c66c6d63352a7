"""Inputs of the runs of a comparison: energy, and velocity and mass of an impactor."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from granwave.analysis.formatting.numbers import number, quantity_in
from granwave.analysis.reports.comparison.subjects import ComparedRun, joined_texts

_ENERGY = "energy_input_J"
_VELOCITY = "load.velocity"
_KIND = "load.kind"
_IMPACT = "impact"
_PLATE = "plate"
_STRIKER = "striker"
_STATIC_LOAD = "precompression.kind"
_LEAST_KINDS = 2
_GRAMS = 1e3
_SAME = 1e-6  # relative difference of inputs that are equal
_MOST_LISTED = 4  # runs that a sentence lists; of more the smallest and the largest input


def have_same_input(runs: Sequence[ComparedRun]) -> bool:
    """Return True for runs with equal input energies, and equal velocities of their impactors."""
    return _are_equal([input_energy(run) for run in runs]) and _are_equal(
        [velocity for velocity in map(_velocity, runs) if velocity is not None]
    )


def input_energy(run: ComparedRun) -> float:
    """Return the input energy of a run, J; 0 if it is unknown."""
    return run.run.number(_ENERGY) or 0.0


def inputs_in_words(runs: Sequence[ComparedRun]) -> str:
    """Return the inputs of runs: ``55.6 mJ (4.45 g at 5 m/s) in a, 222 mJ (4.45 g at 10 m/s) in
    b``; of many runs the smallest and the largest.
    """
    if len(runs) <= _MOST_LISTED:
        return joined_texts([(run.name, _input_text(run)) for run in runs], "in")
    ends = (min(runs, key=input_energy), max(runs, key=input_energy))
    least, most = [f"{_input_text(run)} in {run.name}" for run in ends]
    return f"from {least} to {most}"


def kinds_sentence(runs: Sequence[ComparedRun]) -> str:
    """Return a sentence on the inputs of runs of several kinds, in the unit that they have in
    common; empty for one kind, and if a run has no such unit.
    """
    if len({run.run.kind for run in runs}) < _LEAST_KINDS:
        return ""
    inputs = {run: relative_input(run) for run in runs}
    if not all(inputs.values()):
        return ""
    least, most = [extreme(inputs.values()) for extreme in (min, max)]
    if len(runs) > _MOST_LISTED:
        listed = f"from {number(least)} to {number(most)}"
    else:
        listed = joined_texts([(run.name, number(size)) for run, size in inputs.items()], "in")
    between = "the inputs are equal"
    if not _are_equal([least, most]):
        between = f"a ratio of {number(most / least)} between largest and smallest"
    return (
        "Inputs of packings and blocks are compared relative to sigma_y^2 D^3/E, with the yield "
        "strength and modulus of the material and the diameter D of the spheres or of the punch: "
        f"{listed}; {between}."
    )


def relative_input(run: ComparedRun) -> float:
    """Return the input energy relative to sigma_y^2 D^3/E; 0 if it is unknown."""
    unit = run.run.kind.energy_unit(run.run)
    return input_energy(run) / unit if unit else 0.0


def have_unlike_inputs(runs: Sequence[ComparedRun]) -> bool:
    """Return True for runs of several kinds whose inputs relative to sigma_y^2 D^3/E differ, or are
    not known.
    """
    if len({run.run.kind for run in runs}) < _LEAST_KINDS:
        return False
    inputs = [relative_input(run) for run in runs]
    return not all(inputs) or not _are_equal(inputs)


def _input_text(run: ComparedRun) -> str:
    energy = input_energy(run)
    velocity = _velocity(run)
    if not energy or not velocity:
        return quantity_in(energy, "J")
    mass = 2 * energy / velocity**2
    return f"{quantity_in(energy, 'J')} ({number(_GRAMS * mass)} g at {abs(velocity):g} m/s)"


def _velocity(run: ComparedRun) -> float | None:
    """Return the velocity of the impacted sphere, the strikers or the plate, or of the body that
    hits a block, m/s; None with another load, and for strikers of several velocities.
    """
    case = run.run.case
    case = {**case, **run.run.kind.load_keys(case)}
    if strikers := case.get(_STRIKER):
        return _velocity_of_strikers(strikers, case)
    velocity = case.get(_VELOCITY)
    is_impact = case.get(_KIND, _IMPACT) in (_IMPACT, _PLATE)
    if not is_impact or not isinstance(velocity, float | int) or isinstance(velocity, bool):
        return None
    return float(velocity)


def _velocity_of_strikers(strikers: Sequence[Any], case: Mapping[str, Any]) -> float | None:
    """Return the common velocity of strikers that are the only load, m/s; None otherwise."""
    if case.get(_KIND) != _STRIKER or case.get(_STATIC_LOAD):
        return None
    tables = [striker for striker in strikers if isinstance(striker, Mapping)]
    speeds = [math.hypot(*striker.get("velocity", ())) for striker in tables]
    return speeds[0] if speeds and _are_equal(speeds) else None


def _are_equal(values: Sequence[float]) -> bool:
    largest = max(map(abs, values), default=0.0)
    return max(values, default=0.0) - min(values, default=0.0) <= _SAME * largest
