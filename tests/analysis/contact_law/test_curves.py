"""Tables and figures of force against overlap."""

from __future__ import annotations

import csv
import math

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw
from granwave.analysis import law_table, write_law


def contact(law="elastoplastic", strength=550e6):
    return ContactLaw(
        law,
        youngs_modulus=(115e9,) * 2,
        poisson_ratio=(0.3,) * 2,
        yield_strength=(strength,) * 2,
        radius=(5e-3,) * 2,
    )


@pytest.mark.parametrize(("peak", "force"), [(2, 2.4711), (10, 24.3497), (50, 197.692), (200, 962.643), (400, 2064.69)])
def test_loading_ends_at_the_check_values(peak, force):
    """Check values of the elastoplastic law, default variant."""
    table = law_table(contact(), peak)
    loading = table["branch"] == "loading"
    assert table["overlap_normalised"][loading][-1] == pytest.approx(peak, rel=1e-12)
    assert table["force_normalised"][loading][-1] == pytest.approx(force, rel=2e-5)


@pytest.mark.parametrize(("peak", "lost"), [(10, 51.993), (50, 3051.69), (200, 75500.0)])
def test_area_between_loading_and_unloading_is_what_is_lost(peak, lost):
    table = law_table(contact(), peak)
    area = {
        name: abs(
            np.trapezoid(*(table[key][table["branch"] == name] for key in ("force_normalised", "overlap_normalised")))
        )
        for name in ("loading", "unloading_4", "reloading_4")
    }
    assert area["loading"] - area["unloading_4"] == pytest.approx(lost, rel=1e-3)
    assert area["unloading_4"] == pytest.approx(area["reloading_4"], rel=1e-12)


@pytest.mark.parametrize("law", ["elastoplastic", "hertz", "bilinear", "thornton"])
def test_branches_meet_where_unloading_starts(law):
    table = law_table(contact(law), 40)
    top = table["force_N"][table["branch"] == "loading"].max()
    for name in ("unloading_4", "reloading_4"):
        assert table["force_N"][table["branch"] == name].max() == pytest.approx(top, rel=1e-12)
    assert set(table) == {"branch", "overlap_m", "force_N", "overlap_normalised", "force_normalised"}


def test_material_without_a_yield_strength():
    table = law_table(contact("hertz", math.inf), 100)
    assert table["overlap_m"].max() == pytest.approx(0.01 * 2.5e-3)
    assert np.isnan(table["force_normalised"]).all()


def test_files(tmp_path):
    write_law(contact(), tmp_path / "law.csv")
    with open(tmp_path / "law.csv") as file:
        assert next(csv.reader(file)) == [
            "branch",
            "overlap_m",
            "force_N",
            "overlap_normalised",
            "force_normalised",
        ]
    write_law(contact(), tmp_path / "plot.png", title="brass")
    assert all((tmp_path / f"plot.{suffix}").stat().st_size > 1000 for suffix in ("png", "pdf", "csv"))
    with pytest.raises(ValueError, match=r"expected \.png, \.pdf or \.csv"):
        write_law(contact(), tmp_path / "law.txt")
    with pytest.raises(ValueError, match="expected a positive number"):
        law_table(contact(), -1.0)
