"""Peaks of made-up runs of a shaken bead; a packing whose diameters are hardly scattered."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from granwave.analysis.spectra.band_structure import band_structure
from granwave.analysis.studies.bands.resonance import peaks, rows
from granwave.analysis.studies.bands.scattered import scattered_line, without_scatter
from granwave.workflows import load_case

OWN, OVERLAP = 1e4, 1e-6


def shaken(force, frequency):
    """A run whose velocity is a parabola about the frequency of perturbation theory; force: amplitude over overlap."""
    top = OWN * (1 - force**2 / 24)
    velocity = 2 * math.pi * top * OVERLAP * force * (1 - ((frequency - top) / 300) ** 2)
    load = SimpleNamespace(amplitude=force, shape="harmonic", frequencies=(frequency, frequency))
    return SimpleNamespace(
        case=SimpleNamespace(load=load), velocity=velocity, own_frequency=OWN, overlap=OVERLAP, sweep=None
    )


def test_peaks_of_made_up_runs():
    runs = [shaken(force, frequency) for force in (0.1, 0.3) for frequency in np.linspace(9900, 10040, 8)]
    found = peaks(runs)
    assert [one[1] for one in found] == pytest.approx([1 - force**2 / 24 for force in (0.1, 0.3)], rel=1e-9)
    assert [one[2] for one in found] == pytest.approx([0.1, 0.3], rel=1e-6)
    slope = next(row for row in rows(runs) if "shift" in row.quantity)
    assert slope.ours == pytest.approx(-1 / 24, rel=1e-3) and slope.theory == -1 / 24
    assert not peaks(runs[-3:])  # the largest at an end of the frequencies


def test_the_line_of_a_hardly_scattered_packing_is_the_band():
    case = load_case("precompressed-fcc", {"packing.size": [3, 4, 12], "packing.diameter_scatter": 1e-12})
    k = 0.4 * math.pi / (math.sqrt(2 / 3) * 0.01)
    bands = band_structure(without_scatter(case), f"0,0,0; 0,0,{k!r}", points=3, allow_floppy=True).bands
    assert scattered_line(case, k) == pytest.approx(float(np.nanmax(bands.frequency[-1])), rel=1e-4)
