"""Statistics of a bed in its container: those of its inner part, away from walls and surface."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.extensions.packings.bed import Bed
from granwave.extensions.packings.recipe import Recipe
from granwave.extensions.packings.sizes import volume
from granwave.extensions.packings.statistics import (
    COORDINATION_WITH_FRICTION,
    COORDINATION_WITHOUT_FRICTION,
    FORCE_TAIL,
    LEAST_CONTACTS,
    LEAST_WITHOUT_FRICTION,
    RANDOM_CLOSE_PACKING,
    RANDOM_LOOSE_PACKING,
    PackingStatistics,
    anisotropy,
    coordination,
    exponential_tail,
    fabric,
    force_over_mean_at_depth,
    solid_fraction,
    without_rattlers,
)
from granwave.lammps_inputs.errors import InputError

Floats = NDArray[np.float64]

_MARGIN = 1.0  # mean diameters from walls and surface to the inner part
_LEAST_INNER = 1.0  # mean diameters; a smaller inner part says nothing
_CARRIES = 1e-3  # force of a contact over the mean from which on it carries load


def inner_part(recipe: Recipe, bed: Bed) -> tuple[Floats, Floats]:
    """Return the corners of the inner part of a bed: (3,) each, m.

    In a tube it is the largest box with a square base; along periodic axes it is all of the bed.
    """
    container = bed.container
    margin = _MARGIN * recipe.diameter.mean
    if container.tube is not None:
        half = (container.tube - margin) / math.sqrt(2)
        low = np.array([-half, -half, 0.0])
        high = np.array([half, half, 0.0])
    else:
        beside = 0.0 if container.periodic else margin
        low = np.array([beside, beside, 0.0])
        high = np.array([*(width - beside for width in container.box), 0.0])
    if container.height is not None:
        high[2] = container.height
        return low, high
    low[2] = _surface(bed) + margin
    high[2] = bed.bottom - margin
    return low, high


def _surface(bed: Bed) -> float:
    """Return the mean depth of the surface, m: where the upper tenth of the grains begins."""
    return float(np.quantile(bed.grains.position[:, 2], 0.1))


def statistics_of(recipe: Recipe, bed: Bed) -> PackingStatistics:
    """Return the statistics of a bed.

    Raises
    ------
    InputError
        No grains touch each other.
    """
    if not len(bed.contacts):
        raise InputError("the grains of the bed do not touch each other; give it more grains")
    position = bed.grains.position
    low, high = inner_part(recipe, bed)
    n = len(bed.grains)
    is_inside = ((position > low) & (position < high)).all(axis=1)
    carrying = bed.normal_force > _CARRIES * bed.normal_force.mean()
    pairs = bed.contacts[carrying]
    least = LEAST_CONTACTS if recipe.friction else LEAST_WITHOUT_FRICTION
    carries = without_rattlers(n, pairs, least)
    of_all = coordination(n, pairs)
    of_skeleton = coordination(n, pairs[carries[pairs].all(axis=1)])
    large = bool((high - low >= _LEAST_INNER * recipe.diameter.mean).all())
    tensor = fabric(bed.directions[carrying])
    force = bed.normal_force[carrying]
    return PackingStatistics(
        n_grains=n,
        n_contacts=int(carrying.sum()),
        solid_fraction=_solid_fraction(bed, low, high) if large else math.nan,
        coordination=_mean(of_all[is_inside]),
        coordination_without_rattlers=_mean(of_skeleton[is_inside & carries]),
        rattlers=1.0 - _mean(carries[is_inside]),
        anisotropy=anisotropy(tensor),
        fabric=tensor,
        force_tail=exponential_tail(force_over_mean_at_depth(force, bed.depth[carrying])),
        mean_force=float(force.mean()),
        largest_force=float(force.max()),
        pressure=bed.record.get("pressure", math.nan),
    )


def _solid_fraction(bed: Bed, low: Floats, high: Floats) -> float:
    """Return the solid fraction of a part of a bed; of all of a periodic one, without a grid."""
    container = bed.container
    if container.height is not None:
        return volume(bed.grains.diameter) / (container.area * container.height)
    return solid_fraction(bed.grains.position, bed.grains.diameter, low, high, container.period)


def _mean(values: NDArray[Any]) -> float:
    return float(values.mean()) if values.size else math.nan


def statistics_rows(found: PackingStatistics, *, friction: bool) -> list[tuple[str, str]]:
    """Return the statistics and the published values as names and values in words."""
    pressure = (
        [] if math.isnan(found.pressure) else [("pressure when made", f"{found.pressure:.4g} Pa")]
    )
    low, high = RANDOM_LOOSE_PACKING
    limit = COORDINATION_WITH_FRICTION if friction else COORDINATION_WITHOUT_FRICTION
    stable = f"{limit:g} to {COORDINATION_WITHOUT_FRICTION:g}" if friction else f"{limit:g}"
    return [
        ("grains", f"{found.n_grains}, {100 * found.rattlers:.1f} % inside carry no load"),
        ("contacts", f"{found.n_contacts} between grains"),
        (
            "solid fraction",
            f"{found.solid_fraction:.3f} inside; random close packing "
            f"{RANDOM_CLOSE_PACKING:g}, loose {low:g} to {high:g}",
        ),
        (
            "coordination",
            f"{found.coordination_without_rattlers:.2f} without rattlers, "
            f"{found.coordination:.2f} with; at zero pressure {stable}",
        ),
        ("anisotropy of fabric", f"{found.anisotropy:.3f}; isotropic 0"),
        (
            "contact force",
            f"{found.mean_force:.3g} N on average, at most {found.largest_force:.3g} N",
        ),
        (
            "tail of the forces",
            f"exp(-{found.force_tail:.2f} F/<F>), <F> at the same depth; published {FORCE_TAIL:g}",
        ),
        *pressure,
    ]


def statistics_values(found: PackingStatistics) -> Mapping[str, Any]:
    """Return the statistics by name, for JSON; SI units."""
    return {
        "n_grains": found.n_grains,
        "n_contacts": found.n_contacts,
        "solid_fraction": found.solid_fraction,
        "coordination": found.coordination,
        "coordination_without_rattlers": found.coordination_without_rattlers,
        "rattler_fraction": found.rattlers,
        "fabric_anisotropy": found.anisotropy,
        "fabric": found.fabric.tolist(),
        "force_tail": found.force_tail,
        "mean_force_N": found.mean_force,
        "largest_force_N": found.largest_force,
        "pressure_Pa": None if math.isnan(found.pressure) else found.pressure,
    }
