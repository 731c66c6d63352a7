"""All figures of a comparison, as far as the runs allow them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from granwave.analysis.figures.style import Drawing, FigureFolder, style
from granwave.analysis.studies.granular_continuum import both, continuum, forces, granular, zone
from granwave.analysis.studies.granular_continuum.impacts import Impacts

_LOWEST = 0.1  # of the largest velocity: from where on peak forces are compared


def drawings(impacts: Impacts) -> Iterator[tuple[str, str, Drawing]]:
    """Names for files, captions, and figures."""
    for name, caption, drawing in (
        (
            "dissipated_fraction",
            "Dissipated fraction, granular and continuum",
            both.dissipated_fraction(impacts),
        ),
        ("plastic_volume", "Volume involved, granular and continuum", both.plastic_volume(impacts)),
        ("plastic_zone", "Size of the plastic zone: what holds 50, 90 and 99 %", zone.zone_sizes(impacts)),
        ("granular_scaling", "Granular: diameter, density, modulus and yield strength", granular.scaling(impacts)),
        ("granular_velocity", "Granular: dissipation against velocity", granular.dissipation_against_velocity(impacts)),
        ("loading_area", "Granular: number of struck spheres", granular.loading_area(impacts)),
        ("peak_force_impulse", "Granular: peak force against impulse", _linearity(impacts)),
        ("front", "Granular: the front by layer", _front(impacts)),
        ("continuum_scaling", "Continuum: modulus and yield strength", continuum.scaling(impacts)),
        ("continuum_mass", "Continuum: mass of the punch", continuum.by_mass(impacts)),
    ):
        if drawing is not None:
            yield name, caption, drawing


def draw_comparison(impacts: Impacts, directory: Path) -> list[Path]:
    """Save all figures with their data into ``directory/figures``; returns the PNG files."""
    folder = FigureFolder(directory)
    with style():
        for name, _, drawing in drawings(impacts):
            folder.save(drawing, name)
    return folder.written


def lowest_velocity(impacts: Impacts) -> float:
    """From which normalised velocity on peak forces are compared."""
    return _LOWEST * impacts.reference[-1].velocity_normalised if impacts.reference else 0.0


def _linearity(impacts: Impacts) -> Drawing | None:
    found = forces.linearity(impacts, lowest=lowest_velocity(impacts))
    return forces.peak_force_against_impulse(found) if found else None


def _front(impacts: Impacts) -> Drawing | None:
    found = forces.fronts(impacts)
    return forces.front_by_depth(found) if found else None
