"""Other tables in common formats: a load, a measured contact, plain rows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from granwave.analysis.contact_law.curves import read_curve
from granwave.lammps_inputs.case.loads.shapes import read_points
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.tables.layout import read_rows

POINTS = ((0.0, 0.0), (2e-5, 150.0), (4e-5, 0.0))


@pytest.mark.parametrize("text", [
    "0 0\n2e-5 150\n4e-5 0\n",
    "0, 0\n2e-5, 150\n4e-5, 0\n",
    "time_s;force_N\n0;0\n0,00002;150\n0,00004;0\n",
    "time (us)\tforce (kN)\n0\t0\n20\t0.15\n40\t0\n",
    "time_us,force_N\n0,0\n20,150\n40,0\n",
    "# a pulse\n0 0\n2e-5 150 # peak\n4e-5 0\n",
    " 0.0D+00 0.0D+00\n 2.0D-05 1.5D+02\n 4.0D-05 0.0D+00\n",
    "time,force\nus,N\n0,0\n20,150\n40,0\n",
    "sep=;\ntime (\u00b5s);force (N)\n0;0\n20;150\n40;0\n;\n",
])  # fmt: skip
def test_a_load_from_a_file(text: str, tmp_path: Path) -> None:
    (tmp_path / "pulse").write_text(text)
    assert read_points(tmp_path / "pulse") == POINTS


@pytest.mark.parametrize(("text", "message"), [
    ("time (min) force (N)\n0 0\n1 1\n", "expected two columns of numbers"),
    ("time (h);force\n0;0\n", 'line 1: found the unit "h", expected one of s, ms'),
    ("0 0\n1\n", 'found "1" in line 2'),
    ("0 0\n1 inf\n2 0\n", 'found inf in line 2'),
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


CURVE = ((0.0, 1e-6, 2e-6, 3e-6, 4e-6), (0.0, 10.0, 30.0, 50.0, 80.0))


@pytest.mark.parametrize("text", [
    "overlap_um,force_N\n0,0\n1,10\n2,30\n3,50\n4,80\n",
    "Displacement (mm);Load (kN)\n0,000;0,00\n0,001;0,01\n0,002;0,03\n0,003;0,05\n0,004;0,08\n",
    "Time\tExtension\tLoad\n(s)\t(mm)\t(N)\n0\t0\t0\n1\t0.001\t10\n2\t0.002\t30\n"
    "3\t0.003\t50\n4\t.004\t80\n",
    '"Specimen 1",,\n\n"Extension","Load"\n"[mm]","[N]"\n"0.000","0.0"\n".001","10"\n".002","30"\n'
    '".003","50"\n".004","80"\n',
    "Versuch 3\noverlap (\u00b5m);force (N)\n0;0\n1;10\n2;30\n3;50\n4;8.0D+01\n",
    "made by us\noverlap_um force_N\n0 0\n1 10\n2 30\n3 50\n4 80\n",
])  # fmt: skip
@pytest.mark.parametrize("encoding", ["utf-8", "cp1252", "utf-16"])
def test_measured_curves_of_machines(text: str, encoding: str, tmp_path: Path) -> None:
    (tmp_path / "curve.csv").write_bytes(text.encode(encoding))
    curve = read_curve(tmp_path / "curve.csv")
    assert curve.overlap == pytest.approx(CURVE[0])
    assert curve.force == pytest.approx(CURVE[1])


@pytest.mark.parametrize(("text", "message"), [
    ("Displacement,Load\n0,0\n1,1\n", "found Displacement, Load, expected one column overlap_m"),
    ("Displacement (mm),Extension (mm),Load (N)\n0,0,0\n1,1,1\n", "found Displacement (mm), Ext"),
    ("Displacement (in),Load (N)\n0,0\n1,1\n", "found displacement_in, force_N, expected one"),
])  # fmt: skip
def test_faults_of_measured_curves(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "curve.csv").write_text(text)
    with pytest.raises(InputError) as caught:
        read_curve(tmp_path / "curve.csv")
    assert message in str(caught.value)


def test_rows_have_decimal_points_and_their_lines(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("# head\na;b\n1,5;x, y\n")
    assert read_rows(tmp_path / "t.csv") == [(2, ["a", "b"]), (3, ["1.5", "x, y"])]
