"""Statistics of the inner part of a bed, away from walls and surface."""

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
    LEAST_UNDER_GRAVITY,
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
_LEAST_INNER = 1.0  # mean diameters; a smaller inner part has no meaningful statistics
_SMALL_INSIDE = (
    "the part one diameter away from walls and surface is less than one diameter deep or wide"
)
_NOBODY_INSIDE = "no grain is one diameter away from walls and surface"
_PRESSED = 1e-10  # overlap with a wall / radius, above which it is not rounding
_CARRIES = 1e-3  # force of a contact / mean, above which the contact carries load


def inner_part(recipe: Recipe, bed: Bed) -> tuple[Floats, Floats]:
    """Return the corners of the inner part of a bed: (3,) each, m.

    In a tube it is the largest box with a square base; along periodic axes it spans the bed.
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
    """Return the mean depth of the surface, m, above which a tenth of the grains lies."""
    return float(np.quantile(bed.grains.position[:, 2], 0.1))


def statistics_of(recipe: Recipe, bed: Bed) -> PackingStatistics:
    """Return the statistics of a bed.

    Raises
    ------
    InputError
        No grains touch each other.
    """
    if not len(bed.contacts):
        raise InputError("the grains of the bed do not touch each other; use more grains")
    position = bed.grains.position
    low, high = inner_part(recipe, bed)
    n = len(bed.grains)
    is_inside = ((position > low) & (position < high)).all(axis=1)
    carrying = bed.normal_force > _CARRIES * bed.normal_force.mean()
    pairs = bed.contacts[carrying]
    carries = without_rattlers(n, pairs, _least_contacts(recipe), contacts_with_walls(bed))
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


def _least_contacts(recipe: Recipe) -> int:
    """Return the least number of contacts of a grain that carries load."""
    if recipe.friction:
        return LEAST_CONTACTS
    return LEAST_UNDER_GRAVITY if recipe.rests_under_gravity else LEAST_WITHOUT_FRICTION


def contacts_with_walls(bed: Bed) -> NDArray[np.int64]:
    """Return the number of walls that each grain was pressed against, the upper plane of a
    compression included: (n,).
    """
    container = bed.container
    position = bed.grains.position
    radius = bed.grains.diameter / 2
    gaps = []
    if container.height is None:
        gaps.append(bed.bottom - position[:, 2] - radius)
        ceiling = bed.record.get("ceiling")
        if ceiling is not None:
            gaps.append(position[:, 2] - radius - ceiling)
    if container.tube is not None:
        gaps.append(container.tube - np.hypot(position[:, 0], position[:, 1]) - radius)
    elif not container.periodic:
        for axis, width in enumerate(container.box):
            gaps += [position[:, axis] - radius, width - position[:, axis] - radius]
    pressed = [gap < -_PRESSED * radius for gap in gaps]
    return np.sum(pressed, axis=0, dtype=np.int64) if pressed else np.zeros(len(radius), np.int64)


def _solid_fraction(bed: Bed, low: Floats, high: Floats) -> float:
    """Return the solid fraction of a part of a bed; for a periodic bed, of the complete bed without
    a grid.
    """
    container = bed.container
    if container.height is not None:
        return volume(bed.grains.diameter) / (container.area * container.height)
    return solid_fraction(bed.grains.position, bed.grains.diameter, low, high, container.period)


def _mean(values: NDArray[Any]) -> float:
    return float(values.mean()) if values.size else math.nan


def statistics_rows(found: PackingStatistics, *, friction: bool) -> list[tuple[str, str]]:
    """Return the statistics and the published values, as pairs of a name and a value in words."""
    pressure = []
    if not math.isnan(found.pressure):
        pressure = [("pressure of preparation", f"{found.pressure:.4g} Pa")]
    return [
        ("grains", _words_of_grains(found)),
        ("contacts", f"{found.n_contacts} between grains"),
        ("solid fraction", _words_of_solid_fraction(found)),
        ("coordination", _words_of_coordination(found, friction=friction)),
        ("anisotropy of fabric", f"{found.anisotropy:.3f}; isotropic 0"),
        (
            "contact force",
            f"{found.mean_force:.3g} N on average, at most {found.largest_force:.3g} N",
        ),
        ("tail of the forces", _words_of_tail(found)),
        *pressure,
    ]


def _words_of_grains(found: PackingStatistics) -> str:
    """Return the number of grains, and the fraction of them that carries no load."""
    if math.isnan(found.rattlers):
        return str(found.n_grains)
    return f"{found.n_grains}, {100 * found.rattlers:.1f} % inside carry no load"


def _words_of_solid_fraction(found: PackingStatistics) -> str:
    """Return the measured and the published solid fractions, or the reason why there is none."""
    if math.isnan(found.solid_fraction):
        return f"none: {_SMALL_INSIDE}; add grains, or use a deeper or wider container"
    low, high = RANDOM_LOOSE_PACKING
    return (
        f"{found.solid_fraction:.3f} inside; random close packing {RANDOM_CLOSE_PACKING:g}, "
        f"loose {low:g} to {high:g}"
    )


def _words_of_coordination(found: PackingStatistics, *, friction: bool) -> str:
    """Return the measured and the published coordination, or the reason why there is none."""
    if math.isnan(found.coordination):
        return f"none: {_NOBODY_INSIDE}"
    limit = COORDINATION_WITH_FRICTION if friction else COORDINATION_WITHOUT_FRICTION
    stable = f"{limit:g} to {COORDINATION_WITHOUT_FRICTION:g}" if friction else f"{limit:g}"
    skeleton = "none"
    if not math.isnan(found.coordination_without_rattlers):
        skeleton = f"{found.coordination_without_rattlers:.2f}"
    return f"{skeleton} without rattlers, {found.coordination:.2f} with; at zero pressure {stable}"


def _words_of_tail(found: PackingStatistics) -> str:
    """Return the measured and the published exponent of the tail of the forces, or the reason why
    there is none.
    """
    if not math.isfinite(found.force_tail):
        return "none: too few contacts above the mean force"
    return f"exp(-{found.force_tail:.2f} F/<F>), <F> at the same depth; published {FORCE_TAIL:g}"


def statistics_values(found: PackingStatistics) -> Mapping[str, Any]:
    """Return the statistics by name, for JSON; SI units."""
    return {
        "n_grains": found.n_grains,
        "n_contacts": found.n_contacts,
        "solid_fraction": _finite(found.solid_fraction),
        "coordination": _finite(found.coordination),
        "coordination_without_rattlers": _finite(found.coordination_without_rattlers),
        "rattler_fraction": _finite(found.rattlers),
        "fabric_anisotropy": found.anisotropy,
        "fabric": found.fabric.tolist(),
        "force_tail": _finite(found.force_tail),
        "mean_force_N": found.mean_force,
        "largest_force_N": found.largest_force,
        "pressure_Pa": _finite(found.pressure),
    }


def _finite(value: float) -> float | None:
    """Return a value; None if it is not a finite number."""
    return value if math.isfinite(value) else None
