"""Figures of a bed: distribution of contact forces, and solid fraction by depth."""

from __future__ import annotations

import numpy as np

from granwave.analysis.figures.series import panels
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, WIDTH, Drawing
from granwave.extensions.packings.bed import Bed
from granwave.extensions.packings.recipe import Recipe
from granwave.extensions.packings.statistics import (
    FORCE_TAIL,
    RANDOM_CLOSE_PACKING,
    RANDOM_LOOSE_PACKING,
    TAIL_FROM,
    depth_profile,
    force_distribution,
    force_over_mean_at_depth,
)

_MILLI = 1e3  # mm in a m
_SLICES_A_DIAMETER = 4


def bed_figure(recipe: Recipe, bed: Bed) -> Drawing:
    """Draw the distribution of the normal forces of contacts, and the solid fraction by depth."""
    figure, left, right = panels(3.0, 2, width=WIDTH * 1.9)
    middle, density = force_distribution(force_over_mean_at_depth(bed.normal_force, bed.depth))
    filled = density > 0
    left.semilogy(middle[filled], density[filled], "o", ms=3, color=BLUE, label="bed")
    tail = middle[middle >= TAIL_FROM]
    level = density[filled][middle[filled] >= TAIL_FROM][0]
    published = level * np.exp(-FORCE_TAIL * (tail - tail[0]))
    left.semilogy(tail, published, color=ORANGE, label=f"exp(-{FORCE_TAIL:g} F/<F>), published")
    left.set(xlabel="Force / mean at this depth", ylabel="Probability density")
    left.legend()
    step = recipe.diameter.mean / _SLICES_A_DIAMETER
    edges = np.arange(0.0, bed.bottom + step, step)
    edges = edges[edges <= bed.bottom]
    places = bed.grains.position
    diameter = bed.grains.diameter
    height = bed.container.height
    if height is not None:  # grains at the ends, on both sides
        period = np.array([0.0, 0.0, height])
        places = np.concatenate([places - period, places, places + period])
        diameter = np.tile(diameter, 3)
    profile = depth_profile(places, diameter, bed.container.area, edges)
    depth = (edges[:-1] + edges[1:]) / 2
    right.plot(_MILLI * depth, profile, color=BLUE)
    right.axhline(RANDOM_CLOSE_PACKING, color=GREY, lw=0.8, label="random close packing")
    right.axhspan(*RANDOM_LOOSE_PACKING, color="0.9", lw=0, label="random loose packing")
    right.set(xlabel="Depth (mm)", ylabel="Solid fraction", ylim=(0, None))
    right.legend()
    columns = {
        "force_over_mean": middle,
        "probability_density": density,
        "depth_m": depth,
        "solid_fraction": profile,
    }
    return Drawing(figure, columns)
