"""Other tables in the forms that people have: of a load, of a measured contact, of rows alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from granwave.analysis.contact_law.curves import read_curve
from granwave.lammps_inputs.case.loads.shapes import read_points
from granwave.lammps_inputs.tables.layout import read_rows

POINTS = ((0.0, 0.0), (2e-5, 150.0), (4e-5, 0.0))


@pytest.mark.parametrize("text", [
    "0 0\n2e-5 150\n4e-5 0\n",
    "0, 0\n2e-5, 150\n4e-5, 0\n",
    "time_s;force_N\n0;0\n0,00002;150\n0,00004;0\n",
    "time (us)\tforce (kN)\n0\t0\n20\t0.15\n40\t0\n",
    "time_us,force_N\n0,0\n20,150\n40,0\n",
    "# a pulse\n0 0\n2e-5 150 # peak\n4e-5 0\n",
])  # fmt: skip
def test_a_load_from_a_file(text: str, tmp_path: Path) -> None:
    (tmp_path / "pulse").write_text(text)
    assert read_points(tmp_path / "pulse") == POINTS


@pytest.mark.parametrize(("text", "message"), [
    ("time (min) force (N)\n0 0\n1 1\n", "expected two columns of numbers"),
    ("time (h);force\n0;0\n", 'line 1: found the unit "h", expected one of s, ms'),
    ("0 0\n1\n", 'found "1" in line 2'),
])  # fmt: skip
def test_faults_of_a_load(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "pulse").write_text(text)
    with pytest.raises(ValueError) as caught:
        read_points(tmp_path / "pulse")
    assert message in str(caught.value)


def test_a_measured_curve_with_decimal_commas(tmp_path: Path) -> None:
    overlaps = np.linspace(1e-6, 1e-5, 6)
    plain = "".join(f"{a:.3e},{1e9 * a**1.5:.6g}\n" for a in overlaps)
    (tmp_path / "plain.csv").write_text(f"overlap_m,force_N\n{plain}")
    german = plain.replace(",", ";").replace(".", ",")
    (tmp_path / "german.csv").write_text(f"overlap_m;force_N\r\n{german}")
    curves = [read_curve(tmp_path / name) for name in ("plain.csv", "german.csv")]
    assert np.array_equal(curves[0].overlap, curves[1].overlap)
    assert np.array_equal(curves[0].force, curves[1].force)


def test_rows_have_decimal_points_and_their_lines(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("# head\na;b\n1,5;x, y\n")
    assert read_rows(tmp_path / "t.csv") == [(2, ["a", "b"]), (3, ["1.5", "x, y"])]
