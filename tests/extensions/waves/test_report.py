"""Report and datasets of small waves."""

from __future__ import annotations

import json
import math

import pytest
import xarray

import granwave as gw
from granwave.analysis.document.model import Note
from granwave.analysis.errors import OutputFormatError
from tests.helpers.made_up.synthetic_report import build

MASS = 8500 * math.pi * 0.00952**3 / 6  # kg, a bead of the row


def names_in(group):
    """Names of the figures of a group."""
    names = []
    for part in group.blocks:
        names += [figure.name for figure in part.figures]
    return names


@pytest.fixture(scope="module")
def small_waves(tmp_path_factory):
    """Bands and modes of a row under 20 N, in one directory."""
    place = tmp_path_factory.mktemp("waves") / "row"
    gw.bands("precompressed-chain", packing__size=6, directory=place)
    gw.modes("precompressed-chain", packing__size=6, directory=place)
    return place


def test_bands_have_a_report(small_waves):
    """Speed and band edge agree with the dispersion relation; the diagram is at the top."""
    report = build([small_waves], small_waves.parent)
    summary = json.loads((small_waves / "bands.json").read_text())
    edge = math.sqrt(4 * summary["contact_stiffness_N_per_m"] / MASS) / (2 * math.pi)
    said = [
        block.text
        for block in report.sections[0].blocks
        if isinstance(block, Note) and block.tone == "lead"
    ]
    assert f"No wave passes above {1e-3 * edge:.4g} kHz. The speed of long waves is" in said[0]
    assert said[1].startswith("row (modes): 6 modes from ")
    assert "row (bands) (chain of 6, brass, 9.52 mm, under 20 N, elastic, ideal)" in report.lead
    figures = next(section for section in report.sections if section.slug == "figures")
    of_bands, of_modes = map(names_in, figures.blocks)
    assert "bands" in " ".join(of_bands) and "density" not in " ".join(of_bands)
    assert len(of_modes) == 2
    assert not any(section.slug == "balance" for section in report.sections)


def test_small_waves(tmp_path):
    row = {"packing__size": 6}
    place = tmp_path / "waves"
    bands = gw.bands("precompressed-chain", directory=place, **row)
    xarray.testing.assert_identical(gw.load(place), bands)
    modes = gw.modes("precompressed-chain", directory=place, **row)
    through = gw.transmission(
        "precompressed-chain",
        directory=place,
        drive=1,
        sensors=[3, 5],
        frequencies=[1e3, 2e3],
        **row,
    )
    found = gw.load(place)
    assert list(found) == ["bands", "modes", "transmission"]
    for name, made in (("bands", bands), ("modes", modes), ("transmission", through)):
        xarray.testing.assert_identical(found[name], made)
    (place / "modes.json").write_text("{")
    with pytest.raises(OutputFormatError, match=r"modes\.json .* damaged .*granwave modes CASE"):
        gw.load(place)
