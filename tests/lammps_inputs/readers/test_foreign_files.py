"""Files in the formats of other programs and of spreadsheets, all with the same two grains."""

from __future__ import annotations

import base64
import bz2
import gzip
import io
import lzma
import tarfile
import zipfile
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from granwave.lammps_inputs.case.packing.grains import Grains, read_grains
from granwave.lammps_inputs.readers.source import FileOptions, GrainSource
from tests.lammps_inputs.readers import writers

PLACES = [[0.01, 0.02, 0.005], [0.01, 0.02, 0.015]]
_LISTED = {"columns": ["x", "y", "z", "radius"]}


def read(path: Path, content: str | bytes, **options: Any) -> Grains:
    return read_grains(GrainSource(writers.write(path, content), FileOptions(**options)))


def fault(path: Path, content: str | bytes, **options: Any) -> str:
    with pytest.raises(ValueError) as caught:
        read(path, content, **options)
    return str(caught.value)


def dump(
    heads: str, rows: str, flags: str = "pp pp ff", box: str = "0 0.04\n0 0.04\n0 0.1\n"
) -> str:
    n_rows = rows.count("\n")
    start = f"ITEM: TIMESTEP\n100\nITEM: NUMBER OF ATOMS\n{n_rows}\nITEM: BOX BOUNDS {flags}\n"
    return f"{start}{box}ITEM: ATOMS {heads}\n{rows}"


def data(rows: str, atoms: str = "Atoms", head: str = "LAMMPS data file") -> str:
    box = "0 0.04 xlo xhi\n0 0.04 ylo yhi\n0 0.1 zlo zhi\n"
    return f"{head}\n\n2 atoms\n1 atom types\n\n{box}\n{atoms}\n\n{rows}"


DUMP = dump("id type x y z radius", "1 1 .01 .02 .005 .005\n2 1 .01 .02 .015 .005\n")
SCALED = "1 .175 .5 .05 .005\n2 .15 .5 .15 .005\n"  # of a box with the tilts xy and xz
TILTED = dump("id xs ys zs radius", SCALED, "xy xz yz pp pp ff",
              "0 0.055 0.005\n0 0.04 0.01\n0 0.1 0\n")  # fmt: skip
GENERAL = dump("id xs ys zs radius", SCALED, "abc origin pp pp ff",
               "0.04 0 0 0\n0.005 0.04 0 0\n0.01 0 0.1 0\n")  # fmt: skip
SPHERES = "1 1 0.01 2500 .01 .02 .005 0 0 0\n2 1 0.01 2500 .01 .02 .015 0 0 0\n"
GENERAL_DATA = data(SPHERES).replace(
    "0 0.04 xlo xhi\n0 0.04 ylo yhi\n0 0.1 zlo zhi\n",
    "0.04 0 0 avec\n0 0.04 0 bvec\n0 0 0.1 cvec\n0 0 0 abc origin\n",
)
ROWS = "0.01,0.02,0.005,0.005\n0.01,0.02,0.015,0.005\n"
MILLIMETRES = "10;20;5;10\n10;20;15;10\n"
BETWEEN_BLANKS = MILLIMETRES.replace(";", " ")
OLD_MERCURY = "0 0 0 0.005 0 0 0 0 0 0 1 10 3"
ARCHIVE = io.BytesIO()
with zipfile.ZipFile(ARCHIVE, "w") as archive:
    archive.writestr("bed.dump", DUMP)
TAR = io.BytesIO()
with tarfile.open(fileobj=TAR, mode="w") as packages:
    packages.addfile(tarfile.TarInfo("bed.dump"))
ARRAYS = io.BytesIO()
np.savez(ARRAYS, x=np.zeros(2), r=np.ones(2))
SPREADSHEET = io.BytesIO()
with zipfile.ZipFile(SPREADSHEET, "w") as archive:
    archive.writestr("xl/workbook.xml", "<workbook/>")
    archive.writestr("xl/worksheets/sheet1.xml", "<worksheet/>")


def vtk_51() -> str:
    """Return a legacy file in ParaView's present format, with metadata and words."""
    return (
        "# vtk DataFile Version 5.1\nvtk output\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n"
        "0.01 0.02 0.005 0.01 0.02 0.015 \n\nMETADATA\nINFORMATION 0\n\nVERTICES 3 2\n"
        "OFFSETS vtktypeint64\n0 1 2 \nCONNECTIVITY vtktypeint64\n0 1 \n\nPOINT_DATA 2\n"
        "TENSORS stress double\n1 0 0\n0 1 0\n0 0 1\n\n1 0 0\n0 1 0\n0 0 1\n\n"
        "FIELD FieldData 3\nname 1 2 string\na\nb\nradius 1 2 float\n0.005 0.005 \n"
        "METADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 0 1\n\n"
        "id 1 2 int\n1 2\n"
    )


def vtu(appended: bool = False) -> str:
    """Return a file of points in two pieces, and an empty one, as parallel programs write it."""
    blob = ""
    pieces = '<Piece NumberOfPoints="0" NumberOfCells="0"><Points/><PointData/></Piece>'
    for place in PLACES:
        arrays = []
        for name, values, n in (("Points", place, 3), ("Diameter", [0.01], 1), ("Type", [2.0], 1)):
            head = f'<DataArray type="Float32" Name="{name}" NumberOfComponents="{n}"'
            if appended:
                raw = np.array(values, "<f4").tobytes()
                arrays.append(f'{head} format="appended" offset="{len(blob)}"/>')
                blob += base64.b64encode(np.array([len(raw)], "<u4").tobytes() + raw).decode()
            else:
                arrays.append(f'{head} format="ascii">{" ".join(map(str, values))}</DataArray>')
        points, *others = arrays
        pieces += (
            f'<Piece NumberOfPoints="1"><Points>{points}</Points>'
            f"<PointData>{''.join(others)}</PointData></Piece>"
        )
    tail = f'<AppendedData encoding="base64">\n _{blob}\n</AppendedData>' if appended else ""
    start = '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" byte_order="LittleEndian">'
    return f"{start}<UnstructuredGrid>{pieces}</UnstructuredGrid>{tail}</VTKFile>\n"


FORMS: dict[str, tuple[str | bytes, dict[str, Any]]] = {
    "dump in a time": (f"ITEM: UNITS\nsi\nITEM: TIME\n0.5\n{DUMP}ITEM: TIME\n1\n{DUMP}", {}),
    "dump with a tilted box": (TILTED, {}),
    "dump with a general box": (GENERAL, {}),
    "dump.xz": (lzma.compress(DUMP.encode()), {}),
    "dump.bz2": (bz2.compress(DUMP.encode()), {}),
    "dump.zip": (ARCHIVE.getvalue(), {}),
    "data of LIGGGHTS": (data(SPHERES, "Atoms # granular"), {}),
    "data with line ends of Windows": (data(SPHERES).replace("\n", "\r\n"), {}),
    "data with blanks before": (data(SPHERES, "  Atoms"), {}),
    "data in a general box": (GENERAL_DATA, {}),
    "data without sizes": (data("1 1 .01 .02 .005\n2 1 .01 .02 .015\n"), {"diameter": 0.01}),
    "data of Fortran": (data(SPHERES.replace(".005 0", ".5D-02 0")), {}),
    "header in Latin-1": ("x (µm);y (µm);z (µm);d (µm)\n1e4;2e4;5e3;1e4\n1e4;2e4;15e3;1e4\n"
                          .encode("cp1252"), {}),
    "UTF-16 of Excel": ("\ufeffx\ty\tz\tr\n".encode("utf-16-le")
                        + ROWS.replace(",", "\t").encode("utf-16-le"), {}),
    "row of units": ("x;y;z;d;n\nmm;mm;mm;mm;-\n10;20;5;10;1\n10;20;15;10;2\n", {}),
    "row of units in brackets": (f"x;y;z;d\n[mm];[mm];[mm];[mm]\n{MILLIMETRES}", {}),
    "units between blanks": (f"x (mm) y (mm) z (mm) d (mm)\n{BETWEEN_BLANKS}", {}),
    "units in a comment": (f"#\n# x [mm] y [mm] z [mm] d [mm]\n#\n{BETWEEN_BLANKS}", {}),
    "VTK without LOOKUP_TABLE": (
        "# vtk DataFile Version 3.0\n\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n"
        ".01 .02 .005 .01 .02 .015\nPOINT_DATA 2\nSCALARS radius float\n.005\n.005\n", {}),
    "names in capitals": (f"X [MM];Y [MM];Z [MM];D [MM]\n{MILLIMETRES}", {}),
    "title": (f"Centres of sample 3\n\nx,y,z,r\n{ROWS}", {}),
    "title with commas": (f"Centres,,,\nof 2026,,,\nx,y,z,r\n{ROWS},,,\n", {}),
    "separator of Excel": (f"sep=;\nx;y;z;r\n{ROWS.replace(',', ';')}", {}),
    "rows that end with a comma": ("x,y,z,r\n" + ROWS.replace("\n", ",\n"), {}),
    "number of rows above": ("2\n" + ROWS, _LISTED),
    "exponents of Fortran": (" 1.0D-02 2.0D-02 5.0D-03 5.0D-03\n 1.D-02 .2d-01 1.5D-02 5.0D-03\n",
                             _LISTED),
    "decimal commas in quotes": ('"x";"y";"z";"r"\n'
                                 '"0,01";"0,02";"0,005";"0,005"\n'
                                 '"0,01";"0,02";"0,015";"0,005"\n', {}),
    "columns of OVITO": ('# "Particle Identifier" "Position.X" "Position.Y" "Position.Z" "Radius"\n'
                         "1 .01 .02 .005 .005\n2 .01 .02 .015 .005\n", {}),
    "R": (f"x..mm.,y..mm.,z..mm.,d..mm.\n{MILLIMETRES.replace(';', ',')}", {}),
    "units behind commas": (f"x, mm;y, mm;z, mm;d, mm\n{MILLIMETRES}", {}),
    "German names": (f"Schwerpunkt X [mm];Schwerpunkt Y [mm];Schwerpunkt Z [mm];Durchmesser [mm]\n"
                     f"{MILLIMETRES}", {}),
    "Voxels": ("x;y;z;d (mm)\n20;40;10;10\n20;40;30;10\n", {"units": "0.5 mm"}),
    "Voxels in the names": ("x (voxel);y [px];z (pixels);d [px]\n20;40;10;20\n20;40;30;20\n",
                            {"units": "500 um"}),
    "units in words": ("x (millimeters);y (millimetres);z (micrometers);d (centimeter)\n"
                       "10;20;5000;1\n10;20;15000;1\n", {}),
    "end of DOS": (f"x,y,z,r\n{ROWS}\x1a", {}),
    "line ends of old Macintosh": (f"x,y,z,r\n{ROWS}".replace("\n", "\r"), {}),
    "ImageJ without a scale": ("CX (unit);CY (unit);CZ (unit);d\n"
                               ".01;.02;.005;.01\n.01;.02;.015;.01\n",
                               {}),
    "Avizo": ("Volume3d (um^3),BaryCenterX (um),BaryCenterY (um),BaryCenterZ (um),EqDiameter (um)\n"
              "5e11,10000,20000,5000,10000\n5e11,10000,20000,15000,10000\n", {}),
    "spam": ("Label\tZpos\tYpos\tXpos\n1.0\t5\t20\t10\n2.0\t15\t20\t10\n",
             {"units": "mm", "diameter": 0.01}),
    "scikit-image": (",label,centroid-0,centroid-1,centroid-2,equivalent_diameter_area\n"
                     "0,1,10,20,5,10\n1,2,10,20,15,10\n", {"units": "mm"}),
    "MATLAB": ("Centroid_1,Centroid_2,Centroid_3,EquivDiameter\n10,20,5,10\n10,20,15,10\n",
               {"units": "mm"}),
    "EDEM": ("EXTRACTED DATA\nTIME: 0.5 s\nQ01 : Particle Position X (m),"
             "Q02 : Particle Position Y (m),Q03 : Particle Position Z (m),"
             f"Q04 : Particle Radius (m)\n{ROWS}", {}),
    "id_x_y_z_r of YADE": ("#format id_x_y_z_r_matId\n0\t.01\t.02\t.005\t.005\t1\n"
                           "1\t.01\t.02\t.015\t.005\t1\n", {}),
    "old restart of MercuryDPM with springs": (
        "restart_version 3\nxmin 0 xmax 1 ymin 0 ymax 1 zmin 0 zmax 1\nParticles 2\n"
        f"TSP BP 0.01 0.02 0.005 {OLD_MERCURY} 0\n"
        f"TSP BP 0.01 0.02 0.015 {OLD_MERCURY} 1 0 0.5 0 0\n", {}),
    "old restart of MercuryDPM": (
        "restart_version 3\nxmin 0 xmax 1 ymin 0 ymax 1 zmin 0 zmax 1\nParticles 2\n"
        f"BP 0.01 0.02 0.005 {OLD_MERCURY}\n0.01 0.02 0.015 {OLD_MERCURY}\n", {}),
    "VTK 5.1": (vtk_51(), {}),
    "VTU in pieces": (vtu(), {}),
    "VTU in pieces, appended": (vtu(appended=True), {}),
    "XYZ without types": ("2\nProperties=pos:R:3:radius:R:1:color:R:3\n"
                          ".01 .02 .005 .005 0 0 1\n.01 .02 .015 .005 0 0 1\n", {}),
    "XYZ with names": ("2\ntype x y z r\n0 .01 .02 .005 .005\n0 .01 .02 .015 .005\n", {}),
    "XYZ in frames": ("1\n\nA 0 0 0\n2\n\nA 10 20 5\nB 10 20 15\n",
                      {"units": "mm", "diameter": 0.01}),
    "plain XYZ with a radius": ("2\nt = 1\n1 .01 .02 .005 .005\n1 .01 .02 .015 .005\n",
                                {"columns": ["type", "x", "y", "z", "radius"]}),
}  # fmt: skip


@pytest.mark.parametrize("name", FORMS)
def test_grains_are_those_of_the_file(name: str, tmp_path: Path) -> None:
    content, options = FORMS[name]
    grains = read(tmp_path / "grains.txt", content, **options)
    single = {"rtol": 1e-6} if name.startswith("V") else {"rtol": 1e-15}
    assert np.allclose(grains.position, PLACES, atol=0, **single)
    assert grains.diameter == pytest.approx([0.01, 0.01], rel=single["rtol"])


def test_clumps_and_densities_of_vtk(tmp_path: Path) -> None:
    text = (
        "# vtk DataFile Version 3.0\n\nASCII\nDATASET POLYDATA\nPOINTS 3 double\n"
        "0 0 0 .009 0 0 .05 0 0\nPOINT_DATA 3\nSCALARS radii double 1\nLOOKUP_TABLE default\n"
        ".005 .005 .005\nSCALARS clumpId int 1\nLOOKUP_TABLE default\n0 0 -1\n"
        "SCALARS density double 1\nLOOKUP_TABLE default\n2500 2500 2600\n"
    )
    grains = read(tmp_path / "clumps.vtk", text)
    assert list(grains.clumps.values()) == [(1, 2)]
    assert grains.reading is not None
    assert grains.reading.density == (2500.0, 2600.0)


def test_densities_follow_from_masses(tmp_path: Path) -> None:
    mass = 2500 * np.pi / 6 * 0.01**3
    rows = f"1 {mass!r} 0 0 0 .005\n2 {2 * mass!r} 0 0 .01 .005\n"
    reading = read(tmp_path / "g", dump("id mass x y z radius", rows)).reading
    assert reading is not None
    assert reading.density == pytest.approx((2500.0, 5000.0))


def test_molecules_of_a_template_are_clumps(tmp_path: Path) -> None:
    text = writers.molecule() + "\nMolecules\n\n1 1\n2 1\n3 2\n"
    grains = read(tmp_path / "clump.mol", text, columns={"clump": "mol"})
    assert list(grains.clumps.values()) == [(1, 2)]


@pytest.mark.parametrize(("text", "message"), [
    (writers.molecule().partition("Diameters")[0], "found no section Diameters, expected one, or"),
    (writers.molecule()[:-8], "found 2 of 3 atoms in the section Diameters: the file is truncated"),
    (writers.molecule().replace("1 0.01\n", "1\n"),
     "found 0 values in the section Diameters, expected 1: diameter"),
])  # fmt: skip
def test_faults_of_templates(text: str, message: str, tmp_path: Path) -> None:
    assert message in fault(tmp_path / "clump.mol", text)


CLUMPS_OF_OTHERS = {
    "yade": ("#format x_y_z_r_clumpId\n", "{x} 0 0 0.005 {clump}\n", (7, 7, -1)),
    "liggghts": ("", "{x} 0 0 0.005 {clump}\n", (0, 0, -1)),
    "csv": ("x,y,z,r,body\n", "{x},0,0,0.005,{clump}\n", (3, 3, 0)),
}


@pytest.mark.parametrize("name", CLUMPS_OF_OTHERS)
def test_clumps_of_other_programs(name: str, tmp_path: Path) -> None:
    """Clump numbers start anywhere, with -1 or 0 for single grains; two overlapping grains form one
    body.
    """
    head, form, numbers = CLUMPS_OF_OTHERS[name]
    rows = [
        form.format(x=x, clump=clump) for x, clump in zip((0.0, 0.009, 0.05), numbers, strict=True)
    ]
    text = head + "".join(rows)
    if name == "liggghts":
        text = dump("x y z radius id_multisphere", text)
    grains = read(tmp_path / "clumps.txt", text)
    assert list(grains.clumps.values()) == [(1, 2)]


@pytest.mark.parametrize("head", [
    "Particle ID,Particle X-Coordinate (m),Particle Y-Coordinate (m),Particle Z-Coordinate (m),"
    "Particle Size (m)",
    "ball.id,ball.pos.x,ball.pos.y,ball.pos.z,diameter",
    "id,location_x,location_y,location_z,d",
])  # fmt: skip
def test_names_of_other_programs(head: str, tmp_path: Path) -> None:
    grains = read(tmp_path / "grains.csv", f"{head}\n1,0.01,0.02,0.005,0.01\n2,.01,.02,.015,.01\n")
    assert grains.position == pytest.approx(np.array(PLACES), rel=1e-15)
    assert grains.diameter == pytest.approx([0.01, 0.01], rel=1e-15)


def test_decimal_commas_far_below_the_names(tmp_path: Path) -> None:
    rows = "".join(f"0;0;{10 * k};10\n" for k in range(30))
    grains = read(tmp_path / "g.csv", f"x;y;z;d\n{rows}0;0;299,5;10\n", units="mm")
    assert grains.position[-1, 2] == 0.2995


def test_units_of_a_dump_are_above_its_first_step(tmp_path: Path) -> None:
    """Dumps with ``dump_modify units yes``; in another unit the grains are 100 times as far
    apart.
    """
    grains = read(tmp_path / "g", f"ITEM: UNITS\ncgs\n{DUMP}{DUMP}")
    assert grains.position == pytest.approx(np.array(PLACES) / 100)
    assert "found the units lj" in fault(tmp_path / "lj", f"ITEM: UNITS\nlj\n{DUMP}")


@pytest.mark.parametrize(("style", "length", "velocity", "density"), [
    ("si", 1.0, 1.0, 1.0), ("cgs", 1e-2, 1e-2, 1e3), ("micro", 1e-6, 1.0, 1e3),
    ("nano", 1e-9, 1.0, 1e6),
])  # fmt: skip
def test_units_of_lammps(
    style: str, length: float, velocity: float, density: float, tmp_path: Path
) -> None:
    """Velocities in the units micro and nano are micrometres per microsecond and nanometres per
    nanosecond.
    """
    head = f"LAMMPS data file via write_data, timestep = 0, units = {style}"
    motion = "\nVelocities\n\n1 0 0 7 0 0 0\n2 0 0 0 0 0 0\n"
    grains = read(tmp_path / "g", data(SPHERES, "Atoms # sphere", head) + motion)
    assert grains.position == pytest.approx(length * np.array(PLACES))
    assert grains.velocity[0] == pytest.approx([0, 0, 7 * velocity])
    assert grains.reading is not None
    assert grains.reading.density == pytest.approx((2500 * density, 2500 * density))
    rows = "1 .01 .02 .005 0 0 7 .005\n2 .01 .02 .015 0 0 0 .005\n"
    text = f"ITEM: UNITS\n{style}\n" + dump("id x y z vx vy vz radius", rows)
    assert np.allclose(read(tmp_path / "d", text).velocity, grains.velocity, rtol=1e-15)


def h5md(unit: Any, steps_of_velocity: list[int]) -> bytes:
    """Return a trajectory of two steps, with separate steps for the velocities."""
    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        group = file.create_group("particles/all")
        places = 1e3 * np.array(PLACES)
        group["position/value"] = np.stack([0 * places, places])
        group["position/value"].attrs["unit"] = unit
        group["position/step"] = [0, 100]
        group["velocity/value"] = np.ones((len(steps_of_velocity), 2, 3))
        group["velocity/step"] = steps_of_velocity
        group["radius"] = [5.0, 5.0]
    return content.getvalue()


def test_h5md_with_units_of_c_and_elements_of_other_steps(tmp_path: Path) -> None:
    grains = read(tmp_path / "a", h5md(np.bytes_("mm"), [0, 50, 100]))
    assert grains.position == pytest.approx(np.array(PLACES))
    assert grains.velocity.tolist() == [[1e-3] * 3] * 2
    assert not read(tmp_path / "b", h5md("mm", [0, 50])).velocity.any()
    message = fault(tmp_path / "c", h5md("Angstrom", [100]))
    assert 'found positions in the unit "Angstrom", expected m, dm' in message


def test_a_number_that_may_be_cut_is_noted(tmp_path: Path) -> None:
    grains = read(tmp_path / "g", DUMP[:-1])
    assert grains.reading is not None
    assert "the last line is incomplete; the dump may be truncated there" in grains.reading.notes


def test_text_above_a_table_is_noted(tmp_path: Path) -> None:
    grains = read(tmp_path / "g.csv", f"Centres\nof 2026\nx,y,z,r\n{ROWS}")
    assert grains.reading is not None
    assert grains.reading.notes == ["text down to line 2 above the names of the columns ignored"]


def test_lengths_without_a_unit_next_to_others_are_noted(tmp_path: Path) -> None:
    text = "x (mm),y,z,r\n10,0.02,0.005,0.005\n10,0.02,0.015,0.005\n"
    grains = read(tmp_path / "g.csv", text)
    assert grains.position == pytest.approx(np.array(PLACES))
    assert grains.reading is not None
    assert grains.reading.notes == [
        "columns without a unit (y, z, r), although other columns have one; read in metres, or in "
        "packing.units"
    ]
    text = "x (mm),y,z,r\n10,20,5,5\n10,20,15,5\n"
    grains = read(tmp_path / "g.csv", text, units="mm")
    assert grains.reading is not None
    assert not grains.reading.notes


def test_whole_types_of_vtk_have_no_decimals(tmp_path: Path) -> None:
    grains = read(tmp_path / "g", vtu())
    assert grains.reading is not None
    assert grains.reading.types == {"2": 2}


FAULTS = [
    (SPREADSHEET.getvalue(),
     "found a spreadsheet (.xlsx), expected a file of grains; save it as CSV"),
    (b"\xd0\xcf\x11\xe0" + bytes(99), "found a spreadsheet (.xls)"),
    (b"\x28\xb5\x2f\xfd" + bytes(99), "found a .zst file, expected a file of grains; unpack it"),
    (lzma.compress(b"x" * 999)[:-40], "found a .xz file that cannot be unpacked"),
    (ARCHIVE.getvalue()[:-40], "found a .zip file that cannot be unpacked"),
    (gzip.compress(b"x" * 999)[:-9], "found a .gz file that cannot be unpacked"),
    ("version https://git-lfs.github.com/spec/v1\n", "found a Git LFS pointer"),
    ("<!doctype html><html></html>", "found a web page"),
    (b"CDF\x01" + bytes(99), "found a NetCDF file, expected a file of grains; write the grains"),
    (b"\xf6" + 7 * b"\xff" + b"DUMPCUSTOM" + bytes(99),
     "found a binary dump of LAMMPS, expected a file of grains; write it as text by dump custom"),
    ("---\ncreator: LAMMPS\ntimestep: 0\n",
     "line 1: found no natoms in the step that begins here; the dump is damaged or truncated"),
    (writers.yaml_step(0) + writers.yaml_step(100)[:-60],
     "': the dump is truncated"),
    (writers.yaml_step(0) + "".join(writers.yaml_step(100).splitlines(keepends=True)[:-2]),
     "found 2 of 3 atoms in the step 100: the dump is truncated; packing.step = 0 reads the "
     "previous step"),
    (DUMP + dump("id x y z radius", ""),
     "found no atom in the step 100, expected one or more; packing.step = 100 reads the "
     "previous step"),
    (f"x,y,z,r\n{ROWS}\0\0\0", "line 4: found a NUL character, expected text; the file is damaged"),
    ("x,y,z,r\n1,2,3,1\n".encode("utf-16-le"), "or UTF-16 without its mark: save it as UTF-8"),
    ("LAMMPS (22 Jul 2025)\nStep Temp\n", "found a log of LAMMPS"),
    ("solid bed\n  facet normal 0 0 1\n", "found a surface (STL)"),
    ('<?xml version="1.0"?>\n<!DOCTYPE boost_serialization>\n', "found a simulation of YADE"),
    (ARRAYS.getvalue(), "found arrays of NumPy (.npz: x.npy, r.npy)"),
    ("x (px),y (px),z (px),d (px)\n1,2,3,4\n",
     'found the column "x (px)" in voxels, expected their size, such as packing.units = "0.012 '),
    ("ply\nformat ascii 1.0\n", "found a PLY file"),
    ("ball create id 1 radius 0.005 position (0,0,0)\n", "found commands of PFC"),
    ("$bdyty\n RBDY3 1\n", "found bodies of LMGC90"),
    (b"PAR1" + bytes(99), "found a Parquet file"),
    (b"\xff\xfex\0y", "found UTF-16 that is damaged"),
    ("ITEM: TIMESTEP\n1\nITEM: NUMBER OF ENTRIES\n1\nITEM: ENTRIES c_1[1]\n1\n",
     "line 3: found a dump of contacts (ITEM: NUMBER OF ENTRIES), expected one of atoms"),
    (dump("id x ys zs radius", SCALED, "xy xz yz pp pp ff", "0 1 0.1\n0 1 0\n0 1 0\n"),
     "found both scaled and unscaled coordinates in a tilted box"),
    ("x;y;z;d\n0,5;0;0;1\n1.000;0;0;1\n",
     'line 3: found "1.000" for x, expected a finite number, without a thousands separator'),
    ("id,x,y,z,r\n99999999999999999999,0,0,0,1\n", "line 2: found 1e+20 for id, expected a whole"),
    (gzip.compress(TAR.getvalue()), "found an archive (.tar), expected a file of grains; unpack"),
    ('<VTKFile header_type="Foo"/>', 'found header_type "Foo", expected UInt32 or UInt64'),
    (vtu().replace("0.01 0.02 0.005", "0.01 0.02"),
     "found 2 numbers of Points, expected 3 for each point: the file is damaged"),
    (vtu().replace('Diameter" NumberOfComponents="1"', 'Diameter" NumberOfComponents="x"'),
     'found "x" components of Diameter, expected a number'),
    ("x,y,z,r,d\n0,0,0,1,2\n", 'choose one: packing.columns = {diameter = "d"}'),
    ("3\n\nA 0 0 0\nB 0 0 1\n", "line 1: found 2 of 3 grains: the file is truncated"),
    ("2\n\nA 0 0 0 1\nB 0 0 1 1\n", "type x y z and 1 without a name, expected a property radius"),
    ('<VTKFile type="Collection"><DataSet file="a.vtu"/></VTKFile>',
     "found a list of other files (a.vtu ...), expected points"),
    ("# vtk DataFile Version 3.0\n\nASCII\nPOINTS 2\n", 'found "POINTS 2" without its numbers'),
]  # fmt: skip


@pytest.mark.parametrize(("content", "message"), FAULTS, ids=[message for _, message in FAULTS])
def test_faults_say_what_to_do(content: str | bytes, message: str, tmp_path: Path) -> None:
    assert message in fault(tmp_path / "grains.txt", content)


def test_files_known_to_ase_by_their_ending_are_no_tables(tmp_path: Path) -> None:
    form = "ATOM  {:5d}  C   GRN A   1    {:8.3f}{:8.3f}{:8.3f}  1.00  0.00           C\n"
    rows = [form.format(k, *(1000 * np.array(place))) for k, place in enumerate(PLACES, start=1)]
    grains = read(tmp_path / "grains.pdb", "".join([*rows, "END\n"]), units="mm", diameter=0.01)
    assert np.allclose(grains.position, PLACES, rtol=1e-12, atol=0)
    table = "x y z r\n.01 .02 .005 .005\n.01 .02 .015 .005\n"
    assert np.array_equal(read(tmp_path / "grains.pdb", table).position, PLACES)


@pytest.mark.parametrize(("third", "ratio"), [("9", "900"), ("1e-5", "0.001")])
def test_a_grain_in_another_unit_is_noted(third: str, ratio: str, tmp_path: Path) -> None:
    text = f"x,y,z,d\n0,0,0,0.01\n0,0,0.01,0.01\n0,0,30,{third}\n"
    reading = read(tmp_path / "g.csv", text).reading
    assert reading is not None
    assert reading.notes == [
        f"line 4: a diameter of {float(third):g} m is {ratio} times the median; "
        "are there two units in the file?"
    ]


def test_particles_of_other_shapes_are_noted(tmp_path: Path) -> None:
    text = writers.mercury_restart().replace("SphericalParticle", "SuperQuadricParticle")
    reading = read(tmp_path / "g.restart", text).reading
    assert reading is not None
    assert reading.notes[0] == (
        "3 particles are not spheres (SuperQuadricParticle); read as spheres of their radius"
    )


def test_an_example_of_types_is_one_of_toml(tmp_path: Path) -> None:
    rows = "1 10 0 0 0 .005\n2 9 0 0 .01 .005\n"
    reading = read(tmp_path / "g", dump("id type x y z radius", rows)).reading
    assert reading is not None
    assert reading.notes == [
        '2 types of grains become one material; packing.types = {"9" = "steel", "10" = "steel"} '
        "assigns one to each"
    ]


def test_json_of_no_program_is_called_so(tmp_path: Path) -> None:
    text = '[{"x": 0.1, "radius": 0.1}]'
    assert "found JSON, expected a file of grains; write" in fault(tmp_path / "g.json", text)


def test_a_size_that_the_user_names_is_that_of_the_grains(tmp_path: Path) -> None:
    text = "x,y,z,r,d\n0,0,0,9,0.01\n0,0,0.01,9,0.01\n"
    grains = read(tmp_path / "g.csv", text, columns={"diameter": "d"})
    assert grains.diameter.tolist() == [0.01, 0.01]


_TENTH = 0.1**3 / 6 * np.pi


@pytest.mark.parametrize("content", [
    dump("id x y z volume", f"1 0 0 0 {_TENTH}\n2 0 0 .1 {_TENTH}\n"),
    dump("id x y z mass density", f"1 0 0 0 {_TENTH} 1\n2 0 0 .1 {2 * _TENTH} 2\n"),
    "2\nProperties=species:S:1:pos:R:3:volume:R:1\n"
    f"A 0 0 0 {_TENTH}\nA 0 0 .1 {_TENTH}\n",
    "# vtk DataFile Version 3.0\n-\nASCII\nDATASET POLYDATA\nPOINTS 2 double\n0 0 0\n0 0 .1\n"
    f"POINT_DATA 2\nSCALARS Volume double 1\nLOOKUP_TABLE default\n{_TENTH}\n{_TENTH}\n",
])  # fmt: skip
@pytest.mark.parametrize("units", [None, "mm"])
def test_volumes_of_grains_without_sizes(content: str, units: str | None, tmp_path: Path) -> None:
    in_metres = units is None or " mass " in content  # masses and densities have units of their own
    grains = read(tmp_path / "grains", content, **({"units": units} if units else {}))
    assert grains.diameter == pytest.approx(0.1 * (1.0 if in_metres else 1e-3), rel=1e-14)
    assert grains.reading is not None
    assert "computed for spheres from the column" in " ".join(grains.reading.notes)
