"""Text tables in common formats."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from granwave.lammps_inputs.readers.columns import quantity_of
from granwave.lammps_inputs.readers.source import FileOptions
from granwave.lammps_inputs.readers.table import read_table_text
from granwave.lammps_inputs.tables.digits import half_units
from granwave.lammps_inputs.tables.text_table import read_text_table
from granwave.lammps_inputs.tables.units import in_si, split_unit

PLACES = [[0.0, 0.5, 1.25], [2.0, -1.5, 3e-3]]
FORMS = {
    "commas": "x,y,z,d\n0,0.5,1.25,1\n2,-1.5,3e-3,2\n",
    "commas and blanks": "x, y,  z, d\n0, 0.5, 1.25, 1\n2, -1.5, 3e-3, 2\n",
    "semicolons": "x;y;z;d\n0;0.5;1.25;1\n2;-1.5;3e-3;2\n",
    "tabs": "x\ty\tz\td\n0\t0.5\t1.25\t1\n2\t-1.5\t3e-3\t2\n",
    "blanks": "x y z d\n0 0.5   1.25 1\n2 -1.5 3e-3 2\n",
    "blanks before and behind": "  x y z d \n  0 0.5   1.25 1  \n 2\t-1.5 3e-3 2 \n",
    "decimal commas and semicolons": "x;y;z;d\n0;0,5;1,25;1\n2;-1,5;3e-3;2,0\n",
    "decimal commas and blanks": "x y z d\n0 0,5 1,25 1\n2 -1,5 3e-3 2,0\n",
    "decimal commas and tabs": "x\ty\tz\td\n0\t0,5\t1,25\t1\n2\t-1,5\t3e-3\t2\n",
    "line ends of Windows": "x;y;z;d\r\n0;0,5;1,25;1\r\n2;-1,5;0,003;2\r\n",
    "comments": "# a\n% b\n// c\nx,y,z,d # names\n\n0,0.5,1.25,1\n# here\n2,-1.5,3e-3,2\n",
    "names in a comment": "# made by numpy\n# x y z d\n0 0.5 1.25 1\n2 -1.5 3e-3 2\n",
    "names in quotes": '"x","y","z","d"\n0,"0.5",1.25,1\n2,-1.5,3e-3,2\n',
    "units in the names": "x (mm),y [cm],z_um,d in m\n0,50,1250000,1\n2000,-150,3e3,2\n",
    "other names": "Radius;Points:0;Points:1;Points:2\n0.5;0;0.5;1.25\n1;2;-1.5;3e-3\n",
    "vectors by number": "pos_0 pos_1 pos_2 DIAMETER\n0 0.5 1.25 1\n2 -1.5 3e-3 2\n",
}  # fmt: skip


@pytest.mark.parametrize("form", FORMS)
def test_tables_of_any_form(form: str) -> None:
    table = read_table_text(FORMS[form], FileOptions())
    assert table.position.tolist() == PLACES
    assert table.radius is not None
    assert table.radius.tolist() == [0.5, 1.0]
    assert table.notes == []


def test_columns_that_are_named_by_the_user() -> None:
    text = "0;0.5;1.25;x;0.5\n2;-1.5;3e-3;y;1\n"
    table = read_table_text(text, FileOptions(columns=["x", "y", "z", "", "radius"]))
    assert table.position.tolist() == PLACES
    text = "x,y,z,depth,R2\n0,0.5,9,1.25,0.5\n2,-1.5,9,3e-3,1\n"
    table = read_table_text(text, FileOptions(columns={"z": "depth", "radius": 5}))
    assert table.position.tolist() == PLACES
    assert table.radius is not None and table.radius.tolist() == [0.5, 1.0]


def test_unknown_columns_are_left_out_and_named_once() -> None:
    table = read_table_text("x,y,z,d,colour,ke,fx\n0,0,0,1,red,2,3\n", FileOptions())
    assert table.notes == ["columns ignored: colour, ke"]


def test_decimal_digits_are_kept_in_other_units() -> None:
    values = np.array([6.35, 12.7, 0.1, 3.3])
    assert in_si(values, -3).tolist() == [6.35e-3, 12.7e-3, 0.1e-3, 3.3e-3]


@pytest.mark.parametrize(("head", "name", "unit"), [
    ("x (mm)", "x", "mm"), ("x[µm]", "x", "um"), ("x/mm", "x", "mm"), ("x_m", "x", "m"),
    ("vx_m_s", "vx", "m/s"), ("density (kg/m3)", "density", "kg/m^3"), ("x", "x", ""),
    ("mass in g", "mass", "g"), ("axis_x", "axis_x", ""),
])  # fmt: skip
def test_units_in_names(head: str, name: str, unit: str) -> None:
    assert split_unit(head) == (name, unit)


@pytest.mark.parametrize(("head", "quantity"), [
    ("X", "x"), ("pos_x", "x"), ("x_m", "x"), ("center y", "y"), ("zu", "z"), ("p_z", "z"),
    ("R", "radius"), ("radii", "radius"), ("D", "diameter"), ("Particle Diameter (mm)", "diameter"),
    ("velocity:2", "vz"), ("v_x", "vx"), ("wz", "omegaz"), ("matId", "type"), ("rho", "density"),
    ("axis_x", "axis_x"), ("fx", ""), ("colour", ""),
])  # fmt: skip
def test_usual_names(head: str, quantity: str) -> None:
    assert quantity_of(head)[0] == quantity


@pytest.mark.parametrize(("texts", "half"), [
    (["0.123", "0.100", "0.050"], [5e-4] * 3),  # %.3f
    (["0.123457", "0.05", "12.3457"], [5e-7, 5e-8, 5e-5]),  # %.6g
    (["1.23457e-02", "5.00000e+01", "0.00000e+00"], [5e-8, 5e-5, 5e-8]),  # %.5e
    (["1", "20", "-3"], [0.5] * 3),
])  # fmt: skip
def test_half_units(texts: list[str], half: list[float]) -> None:
    assert half_units(texts, np.array(list(map(float, texts)))) == pytest.approx(half)


def test_a_row_of_quotes_left_open_is_one_row() -> None:
    with pytest.raises(ValueError, match="line 2: found 1 value, expected 2"):
        read_text_table('a,b\n"0,0\n1,1\n')
    table = read_text_table('a,b\n0,"1 # 2\n1,x\n')
    assert table.words(1) == ["1 # 2", "x"]


SIZES = (0.001, 0.0025)  # m
DENSITIES = (2500.0, 7800.0)  # kg/m^3


def _with_columns(head: str, *columns: list[float]) -> str:
    """Return a table of two grains with further columns behind their positions in mm."""
    places = ((0.0, 0.0, 1.0), (0.0, 0.0, 3.0))
    rows = [
        [*place, *values] for place, values in zip(places, zip(*columns, strict=True), strict=True)
    ]
    lines = [",".join(map(repr, row)) for row in rows]
    return "\n".join([f"x (mm),y (mm),z (mm),{head}", *lines]) + "\n"


VOLUMES = [math.pi / 6 * size**3 for size in SIZES]
MASSES = [volume * density for volume, density in zip(VOLUMES, DENSITIES, strict=True)]


@pytest.mark.parametrize(("head", "unit", "options"), [
    ("Volume (m^3)", 1.0, {}),
    ("Volume [mm3]", 1e-9, {}),
    ("volume_mm3", 1e-9, {}),
    ("Vol (mm\u00b3)", 1e-9, {}),
    ("vol in \u00b5m^3", 1e-18, {}),
    ("Volume (cm^3)", 1e-6, {}),
    ("Volume", 1e-9, {"units": "mm"}),
    ("Vol (unit)", 1e-9, {"units": "mm"}),
    ("Vol (pix)", 0.02**3 * 1e-9, {"units": "0.02 mm"}),
    ("Size of grain", 1e-9, {"units": "mm", "columns": {"volume": "Size of grain"}}),
])  # fmt: skip
def test_diameters_of_volumes(head: str, unit: float, options: dict[str, Any]) -> None:
    text = _with_columns(head, [volume / unit for volume in VOLUMES])
    table = read_table_text(text, FileOptions(**options))
    assert table.radius == pytest.approx(np.array(SIZES) / 2, rel=1e-14)
    assert table.notes[-1] == (
        f"no column of diameters; computed for spheres from the column {head}: 0.001 to 0.0025 m"
    )


def test_diameters_of_masses_and_densities() -> None:
    text = _with_columns("mass (g),rho (g/cc)", [1e3 * m for m in MASSES], [2.5, 7.8])
    table = read_table_text(text, FileOptions())
    assert table.radius == pytest.approx(np.array(SIZES) / 2, rel=1e-14)
    assert table.density == pytest.approx(np.array(DENSITIES))
    assert table.notes == [
        "no column of diameters; computed for spheres from the columns mass (g) and rho (g/cc): "
        "0.001 to 0.0025 m"
    ]


@pytest.mark.parametrize("options", [{}, {"diameter": 0.002}])
def test_sizes_are_preferred_to_volumes(options: dict[str, Any]) -> None:
    columns = [[1.0, 1.0]] if options else [[1.0, 1.0], [0.5, 1.25]]
    text = _with_columns("volume" if options else "volume,radius (mm)", *columns)
    table = read_table_text(text, FileOptions(**options))
    if options:
        assert table.radius is None
    else:
        assert table.radius == pytest.approx(np.array(SIZES) / 2)
    assert table.notes == ["column ignored: volume"]


@pytest.mark.parametrize(("text", "message"), [
    (_with_columns("volume (mm3)", [1.0, 0.0]), "line 3: found 0 for volume, expected a number ab"),
    (_with_columns("mass,density", [1.0, 1.0], [-1.0, 1.0]), "line 2: found -1 for density"),
    (_with_columns("volume (in3)", [1.0, 1.0]), 'found the unit "in3" of the column "volume (in3'),
    (_with_columns("volume (vox)", [1.0, 1.0]), 'found the column "volume (vox)" in voxels'),
    (_with_columns("mass", [1.0, 1.0]), "found no column diameter, expected x, y, z, diameter (or"),
])  # fmt: skip
def test_faults_of_volumes(text: str, message: str) -> None:
    with pytest.raises(ValueError) as caught:
        read_table_text(text, FileOptions())
    assert message in str(caught.value)
