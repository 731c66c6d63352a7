"""Zero of the overlap in `granwave fit`: curves with a nonzero reading at first contact."""

from __future__ import annotations

import logging
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from granwave.analysis.contact_law.curves import curve_of, read_curve
from granwave.analysis.figures.style import write_csv
from granwave.extensions.continuum.law_fit.fit import fit_law
from granwave.extensions.continuum.law_fit.zero import ZERO, estimated_zero, shifted
from granwave.extensions.continuum.terminal import fit
from granwave.lammps_inputs.case.contact.contact import LAW_CONSTANTS
from granwave.lammps_inputs.contact.law import contact_of
from granwave.lammps_inputs.errors import InputError
from tests.extensions.continuum.test_fit import BRASS, R, options, sampled
from tests.helpers.twins.twin import OTHER

PUBLISHED = contact_of([BRASS], [R])
FEW = ["pressure_limit", "pressure_rate", "area_slope"]  # without the joint of the areas: quick
SOME = [*FEW, "unloading_exponent"]
NAMED = re.compile(r"with a zero of (\S+) \+- (\S+) µm")


def named_zero(text: str) -> tuple[float, float]:
    """Return the zero that a message names and its uncertainty, um."""
    found = NAMED.search(text)
    assert found is not None, text
    return float(found[1]), float(found[2])


def test_a_curve_that_is_shifted_by_3_um_names_the_shift(caplog):
    curve = shifted(sampled(0.01, 1, turns=(1.0,), law=PUBLISHED), -3e-6)
    with caplog.at_level(logging.WARNING, "granwave"):
        plain = fit_law(curve, [BRASS], [R], SOME)
    assert plain.misfit.rms_percent.max() > 50  # near the touch
    said = [one.getMessage() for one in caplog.records if "zero" in one.getMessage()]
    assert len(said) == 1
    zero, spread = named_zero(said[0])
    assert abs(zero - 3) < 4 * spread < 0.4
    assert "--fit-zero" in said[0]


def test_zero_and_some_constants_of_an_exact_curve():
    changed = LAW_CONSTANTS | {name: OTHER[name] for name in SOME}
    curve = sampled(turns=(0.5, 1.0), law=contact_of([BRASS], [R], constants=changed))
    found = fit_law(shifted(curve, -3e-6), [BRASS], [R], SOME, fit_zero=True)
    assert found.zero == pytest.approx(3e-6, rel=1e-6)
    assert found.constants == pytest.approx(changed, rel=1e-5)


@pytest.mark.validation
def test_zero_and_constants_of_an_exact_curve():
    found = fit_law(shifted(sampled(turns=(0.5, 0.75, 1.0)), -3e-6), [BRASS], [R], fit_zero=True)
    assert found.zero == pytest.approx(3e-6, rel=1e-6)
    assert found.constants == pytest.approx(OTHER, rel=1e-5)
    assert not found.undetermined(ZERO)
    assert found.curve.overlap[0] == pytest.approx(0.0, abs=1e-11)


def test_error_bars_of_the_zero():
    """Noise of 1 % in the force: the scatter over many curves is the stated uncertainty."""
    pulls = []
    for seed in range(12):
        curve = shifted(sampled(0.01, seed, turns=(), law=PUBLISHED), -3e-6)
        found = fit_law(curve, [BRASS], [R], FEW, fit_zero=True)
        pulls.append((found.zero - 3e-6) / found.uncertainty[ZERO])
    assert abs(np.mean(pulls)) < 1.0
    assert 0.5 < np.std(pulls) < 1.7


def test_a_good_curve_keeps_its_zero(caplog):
    """Without a shift the zero is 0 within its uncertainty, and no message mentions it."""
    curve = sampled(0.01, 2, turns=(), law=PUBLISHED)
    with caplog.at_level(logging.WARNING, "granwave"):
        fit_law(curve, [BRASS], [R], FEW)
    assert "zero" not in caplog.text
    found = fit_law(curve, [BRASS], [R], FEW, fit_zero=True)
    assert abs(found.zero) < 4 * found.uncertainty[ZERO]


def test_a_curve_that_is_bad_for_another_reason_names_no_zero(caplog):
    curve = sampled(0.003, 2, turns=())
    wavy = curve.force * (1 + 0.2 * np.sin(np.arange(curve.force.size) / 8))
    with caplog.at_level(logging.WARNING, "granwave"):
        fit_law(curve_of(curve.overlap, wavy, curve.branch), [BRASS], [R], FEW)
    assert "zero" not in caplog.text


def test_a_curve_that_cannot_be_fitted_names_the_shift():
    curve = shifted(sampled(0.005, 1, turns=(), law=PUBLISHED), -50e-6)
    with pytest.raises(InputError, match="no passive law") as refused:
        fit_law(curve, [BRASS], [R], FEW)
    assert named_zero(str(refused.value))[0] == pytest.approx(50, abs=0.2)


@pytest.mark.parametrize("zero", [-40e-6, 0.0, 3e-6, 80e-6])
def test_start_of_the_search(zero):
    """The initial estimate only has to be near, relative to the complete curve of 480 um."""
    curve = shifted(sampled(0.01, 4, turns=()), -zero)
    assert estimated_zero(curve, PUBLISHED) == pytest.approx(zero, abs=5e-6)


def test_readings_below_zero(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """They are readings of a gauge that was set to zero too late: without branches, in um."""
    curve = shifted(sampled(0.003, 5, turns=(1.0,)), 5e-6)
    table = {"overlap_um": 1e6 * curve.overlap, "force_N": curve.force}
    path = tmp_path / "gauge.csv"
    write_csv(table, path)
    with pytest.raises(
        InputError, match=r"overlap_um: found -5, expected no negative value .*zero"
    ):
        fit(options(path, tmp_path / "out"))
    read = read_curve(path, any_zero=True)
    assert read.turns == pytest.approx([curve.overlap.max()])
    assert fit(options(path, tmp_path / "out", free=FEW, fit_zero=True)) == 0
    shown = capsys.readouterr().out
    assert re.search(r"^zero +-\d\.\d+e-06 +\d", shown, re.MULTILINE)
    text = (tmp_path / "out" / "fit.toml").read_text()
    assert "# Readings of the overlap less -" in text
    assert "zero" not in tomllib.loads(text)["contact"]
    rows = (tmp_path / "out" / "fit.csv").read_text().splitlines()
    assert len(rows) == 1 + len(LAW_CONSTANTS) + 1
    assert rows[-1].startswith("zero,-")
