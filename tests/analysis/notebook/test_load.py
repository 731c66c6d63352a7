"""Loading of bands, modes, transmission and inferred forces, as the functions that made them return them."""

from __future__ import annotations

import numpy as np
import pytest
import xarray

import granwave as gw
from granwave.analysis.errors import OutputFormatError
from granwave.lammps_inputs.files import plain

DISC = "id,x_m,y_m,radius_m,sxx,syy,sxy\n1,0,0.005,0.005,0,-1e5,0\n"
CASE = "[material]\ndensity = 1130\n[infer]\nfriction = 0.3\nthickness = 0.02\nwalls = {floor = 0.0, top = 0.01}\n"


def test_small_waves(tmp_path):
    row, place = {"packing__size": 6}, tmp_path / "waves"
    bands = gw.bands("precompressed-chain", directory=place, **row)
    xarray.testing.assert_identical(gw.load(place), bands)
    modes = gw.modes("precompressed-chain", directory=place, **row)
    through = gw.transmission(
        "precompressed-chain", directory=place, drive=1, sensors=[3, 5], frequencies=[1e3, 2e3], **row
    )
    found = gw.load(place)
    assert list(found) == ["bands", "modes", "transmission"]
    for name, made in (("bands", bands), ("modes", modes), ("transmission", through)):
        xarray.testing.assert_identical(found[name], made)
    (place / "modes.json").write_text("{")
    with pytest.raises(OutputFormatError, match=r"modes\.json .* damaged .*granwave modes CASE"):
        gw.load(place)


def test_inferred_forces(tmp_path):
    (tmp_path / "disc.csv").write_text(DISC)
    (tmp_path / "disc.toml").write_text(CASE)
    made = gw.infer(tmp_path / "disc.csv", tmp_path / "disc.toml", directory=tmp_path / "found")
    found = gw.load(tmp_path / "found")
    assert isinstance(found, gw.InferredForces) and dict(found) == plain(dict(made))
    assert np.array_equal(found.forces["normal_force_N"], made.forces["normal_force_N"]) and found.measurement is None
    assert "2 of them bear a force" in repr(found)
    (tmp_path / "found" / "forces.csv").unlink()
    with pytest.raises(OutputFormatError, match=r"forces\.csv or grains\.csv cannot be read"):
        gw.load(tmp_path / "found")
