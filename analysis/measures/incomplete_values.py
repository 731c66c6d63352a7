"""Values of a run that its end limits: dissipated fractions and numbers of yielded contacts that
still grow in the last tenth of the run, and forces on the bottom of which a larger one may follow.

A fraction f of the input energy still grows if f(T) - f(0.9 T) exceeds 0.001, or 0.5 % of f and
0.0001, where T is the end of the run. A number still grows if more than 0.5 % of it was added.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.target_record import Reached, reached

if TYPE_CHECKING:
    from granwave.analysis.result.reader import Result

INCOMPLETE = "incomplete_values"  # key of the summary
DISSIPATED_FRACTION = "dissipated_fraction"
#: Numbers of yielded contacts and of their spheres, and the volume of these spheres.
COUNTS = (
    "n_plastic_contacts", "n_plastic_spheres", "n_dissipating_contacts", "n_dissipating_spheres",
    "plastic_zone_volume_m3",
)  # fmt: skip
#: Values of the largest force on the bottom.
BOTTOM_PEAKS = (
    "wall_peak_force_N", "wall_dynamic_peak_force_N", "target_peak_force_N",
    "ground_peak_force_N", "peak_reduction", "peak_reduction_per_kg", "peak_reduction_per_m",
    "ground_peak_reduction",
)  # fmt: skip
BOTTOM_IMPULSES = ("wall_impulse_Ns", "wall_dynamic_impulse_Ns")
_ZONE_GROWING = "zone_growing"
_FRACTION = "_fraction"  # end of the names of fractions
_ABSORBED = "absorbed"
_AT_WALLS = "energy_dissipated_wall_J"  # part of the dissipated energy, which has no course
_VOLUMES = ("plastic_zone_volume_", "zone_volume_")
#: Columns of the energy record with a fraction of the input energy, other than the plastic one.
_COLUMNS = (
    "dissipated", "friction", "viscous", "holder", "rolling", "twisting", "adhesion", "absorbed",
)  # fmt: skip
_PLASTIC = "plastic"
_YIELDED = "energy/contacts_yielded"
_LAST_PART = 0.1  # fraction of the run: values that still change in it are not final
_GROWTH_OF_INPUT = 1e-3  # growth of a fraction of the input above which it is not final
_RELATIVE_GROWTH = 5e-3  # growth, relative to the value itself, above which it is not final
_LEAST_GROWTH = 1e-4  # growth of a fraction of the input that is always disregarded


def incomplete_values(result: Result) -> list[str]:
    """Return the names of the values of a run that its end limits, in the order of the summary.

    A wave that stays in its layer never loads the bottom, whose values are complete.
    """
    from granwave.analysis.measures.waves import stays_in_layer  # loads h5py

    names = [f"{name}{_FRACTION}" for name in _growing_energies(result)]
    if DISSIPATED_FRACTION in names:
        names.append(energy_of(DISSIPATED_FRACTION))
    if _YIELDED in result and _has_growing_count(result["energy/time"], result[_YIELDED]):
        names += COUNTS
    record = reached(result)
    if record is None or (not record.is_reached and stays_in_layer(result)):
        return names
    return [*names, *_of_bottom(record)]


def incomplete_in(summary: Mapping[str, Any]) -> Collection[str]:
    """Return the names of incomplete values in a summary, with the energies of incomplete fractions
    and the sizes of a plastic zone that still grows; empty if they are unknown.
    """
    names: list[str] = [*(summary.get(INCOMPLETE) or ())]
    energies = [energy_of(name) for name in names if name.endswith(_FRACTION)]
    if DISSIPATED_FRACTION in names:
        energies.append(_AT_WALLS)
    names += [name for name in energies if name in summary and name not in names]
    for direction in summary.get(_ZONE_GROWING) or ():
        sizes = (f"plastic_zone_{direction}_", f"zone_{direction}_", *_VOLUMES)
        names += [name for name in summary if name.startswith(sizes) and name not in names]
    return names


def energy_of(fraction: str) -> str:
    """Return the name of the energy, J, of a fraction of the input energy."""
    if fraction == DISSIPATED_FRACTION:
        return "energy_dissipated_J"
    part = fraction.removesuffix(_FRACTION)
    return f"energy_{part}_J" if part == _ABSORBED else f"energy_dissipated_{part}_J"


def growing_values(summary: Mapping[str, Any]) -> list[str]:
    """Return the names of the values in a summary that still grow at the end of the run, without
    the sizes of the plastic zone by direction, and without the forces on the bottom, of which a
    larger one may follow.
    """
    names = [name for name in summary.get(INCOMPLETE) or () if name not in BOTTOM_PEAKS]
    return [name for name in names if summary.get(name) is not None]


def _growing_energies(result: Result) -> list[str]:
    """Return the parts of the input energy that still grow at the end, as names of fractions."""
    time = result["energy/time"]
    given = result["energy/input"]
    courses = {name: result[f"energy/{name}"] for name in _COLUMNS if f"energy/{name}" in result}
    courses[_PLASTIC] = result.yield_ledger
    return [name for name, energy in courses.items() if _is_growing(time, energy, given)]


def _is_growing(time: Array, energy: Array, given: Array) -> bool:
    """Return True if a fraction of the input energy still grows at the end of a run."""
    if given[-1] <= 0:
        return False
    start = (1 - _LAST_PART) * time[-1]
    given_before = float(np.interp(start, time, given))
    before = float(np.interp(start, time, energy)) / given_before if given_before > 0 else 0.0
    last = float(energy[-1] / given[-1])
    limit = min(_GROWTH_OF_INPUT, max(_RELATIVE_GROWTH * abs(last), _LEAST_GROWTH))
    return last - before > limit


def _has_growing_count(time: Array, count: Array) -> bool:
    """Return True if a number still grows at the end of a run."""
    before = float(np.interp((1 - _LAST_PART) * time[-1], time, count))
    return before < (1 - _RELATIVE_GROWTH) * float(count[-1])


def _of_bottom(record: Reached) -> list[str]:
    """Return the values of the force on the bottom that may become larger after the end."""
    if not record.has_known_peak:
        return [*BOTTOM_PEAKS, *BOTTOM_IMPULSES]
    return [*BOTTOM_IMPULSES] if record.has_growing_impulse else []
