"""A packing whose diameters are hardly scattered has the bands of like spheres."""

from __future__ import annotations

import math

import numpy as np
import pytest

from granwave.analysis.spectra.band_structure import band_structure
from granwave.analysis.studies.bands import scattered_line, without_scatter
from granwave.workflows import load_case


def test_the_line_of_a_hardly_scattered_packing_is_the_band():
    case = load_case("precompressed-fcc", {"packing.size": [3, 4, 12], "packing.diameter_scatter": 1e-12})
    k = 0.4 * math.pi / (math.sqrt(2 / 3) * 0.01)
    bands = band_structure(without_scatter(case), f"0,0,0; 0,0,{k!r}", points=3, allow_floppy=True).bands
    assert scattered_line(case, k) == pytest.approx(float(np.nanmax(bands.frequency[-1])), rel=1e-4)
