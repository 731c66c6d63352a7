"""Content of the files of single programs in addition to positions and sizes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.lammps_inputs.case.packing.grains import Grains, read_grains
from granwave.lammps_inputs.readers.source import FileOptions, GrainSource
from tests.lammps_inputs.readers import writers

RESTART = """MercuryDPM 0.14 name grains revision 1 repository none
dataFile    fileType ONE_FILE saveCount 10
xMin 0 xMax 0.05 yMin 0 yMax 0.04 zMin 0 zMax 0.1
Species 2
LinearViscoelasticSpecies id 0 density 2500 stiffness 10000 dissipation 0
LinearViscoelasticSpecies id 1 density 7800 stiffness 10000 dissipation 0
LinearViscoelasticMixedSpecies idMin 0 stiffness 10000 dissipation 0
Walls 1
InfiniteWall id 0 indSpecies 0 position 0 0 0 normal 0 0 -1
Boundaries 1
PeriodicBoundary id 0 normal 1 0 0 scaleFactor 1 distanceLeft 0 distanceRight 0.04 shift 0.04 0 0
Particles 2
BaseParticle id 0 indSpecies 0 position 0.01 0.02 0.005 orientation 1 0 0 0 velocity 0 0 0 \
angularVelocity 0 0 0 force 0 0 0 torque 0 0 0 radius 0.005 invMass 0
BaseParticle id 1 indSpecies 1 position 0.01 0.02 0.015 orientation 1 0 0 0 velocity 0 0 -2 \
angularVelocity 1 2 3 force 0 0 0 torque 0 0 0 radius 0.005 invMass 9
""".replace("\\\n", "")


def read(path: Path, content: str | bytes, **options: Any) -> Grains:
    return read_grains(GrainSource(writers.write(path, content), FileOptions(**options)))


def fault(path: Path, content: str | bytes, **options: Any) -> str:
    with pytest.raises(ValueError) as caught:
        read(path, content, **options)
    return str(caught.value)


def notes(grains: Grains) -> str:
    assert grains.reading is not None
    return "; ".join(grains.reading.notes)


def test_a_restart_file_of_mercury(tmp_path: Path) -> None:
    """Densities of species, a period, spins, and particles of infinite mass as a group."""
    grains = read(tmp_path / "grains.restart", RESTART)
    assert grains.group == ("fixed", "")
    assert grains.spin.tolist() == [[0, 0, 0], [1, 2, 3]]
    assert grains.velocity[1].tolist() == [0, 0, -2]
    reading = grains.reading
    assert reading is not None
    assert reading.format == "MercuryDPM restart"
    assert reading.density == (2500.0, 7800.0)
    assert reading.periodic == (True, False, False)
    assert reading.bounds == pytest.approx(writers.BOX)
    assert '1 particles are fixed in the file (invMass 0): the group "fixed"' in notes(grains)


def test_particles_of_mercury_in_two_dimensions(tmp_path: Path) -> None:
    rows = "0.01 0.005 1 2 0.005 0 0.5 3\n0.01 0.015 0 0 0.005 0 0 3\n"
    grains = read(tmp_path / "grains.data", f"2 0.1 0 0 0.04 0.04\n{rows}")
    assert grains.position.tolist() == [[0.01, 0.005, 0], [0.01, 0.015, 0]]
    assert grains.velocity[0].tolist() == [1, 2, 0]
    assert grains.spin[0].tolist() == [0, 0, 0.5]
    assert "spheres with their centres at z = 0" in notes(grains)
    assert "line 2: found 7 values, expected 8" in fault(
        tmp_path / "damaged.data", f"2 0.1 0 0 1 1\n{rows.replace(' 3', '', 1)}", format="mercury"
    )


def test_a_geometry_of_esys(tmp_path: Path) -> None:
    grains = read(tmp_path / "grains.geo", writers.esys())
    reading = grains.reading
    assert reading is not None
    assert reading.types == {"7": 3}
    assert reading.periodic == (True, True, False)
    assert "1 bonds ignored" in notes(grains)


@pytest.mark.parametrize(("text", "message"), [
    (writers.esys().replace("Simple\n3", "Simple\n4"), "found 3 of 4 particles: the file is tr"),
    (writers.esys().replace("3D", "2D"), "found particles in two dimensions (Dimension 2D)"),
    (writers.esys().replace("Simple", "Rot"), 'found particles of the type "Rot", expected Simple'),
    (writers.esys().partition("Begin")[0], "found no section BeginParticles"),
    (writers.mfix()[:-60], "found 2 of 3 particles: the file is truncated"),
    (writers.mfix().replace("Particles:", "Particle"), "found no line Particles: N"),
    (writers.mfix().replace("Diameter:     T", "Diameter:     F"), "found no diameters, expected"),
])  # fmt: skip
def test_faults_of_heads(text: str, message: str, tmp_path: Path) -> None:
    assert message in fault(tmp_path / "grains", text)


def test_values_of_all_particles_of_mfix(tmp_path: Path) -> None:
    rule = 20 * "="
    text = (
        f"Version 2.0\n{rule}\nDimension: 2\nParticles: 2\n{rule}\nVariable\n{rule}\n"
        "Coordinates:  T\nPhase_ID: T\nDiameter: F 0.01\nDensity: F 2700.\n"
        f"Velocity: F 0.0 -1.0 0.0\nSpecies: T\n{rule}\n| x | y | phase |\n{rule}\n"
        ".01 .005 1\n.01 .015 2\n"
    )
    grains = read(tmp_path / "particle_input.dat", text)
    assert grains.position.tolist() == [[0.01, 0.005, 0], [0.01, 0.015, 0]]
    assert grains.diameter.tolist() == [0.01, 0.01]
    assert grains.velocity.tolist() == 2 * [[0, -1, 0]]
    reading = grains.reading
    assert reading is not None
    assert reading.density == (2700.0, 2700.0)
    assert reading.types == {"1": 1, "2": 1}


@pytest.mark.parametrize(("row", "place"), [
    ("1 2 3 .5 2.7 0 0 -4", [0.01, 0.02, 0.03]), ("1 2 .5 2.7 0 -4", [0.01, 0.02, 0]),
])  # fmt: skip
def test_old_particles_of_mfix(row: str, place: list[float], tmp_path: Path) -> None:
    grains = read(tmp_path / "particle_input.dat", f"{row}\n", format="mfix", units="cm")
    assert grains.position[0] == pytest.approx(place)
    assert grains.diameter == pytest.approx([0.01])
    assert grains.velocity[0].min() == pytest.approx(-0.04)


def test_box_and_sizes_of_packing_generation(tmp_path: Path) -> None:
    """The final solid fraction determines the diameters, whatever diameters the file has."""
    path = tmp_path / "packing.xyzd"
    without = read(path, writers.xyzd())
    assert "no file packing.nfo in the folder of the packing" in notes(without)
    volume = 0.04 * 0.04 * 0.1
    first = float(np.pi / 6 * (writers.DIAMETER**3).sum() / volume)
    info = (
        "N: 3\n Dimensions: 0.04 0.04 0.1\n Theoretical Porosity: "
        f"{1 - 2 * first!r}\nFinal Porosity: {1 - first / 8!r} (Tolerance: 1.000100)\n"
    )
    path.with_suffix(".nfo").write_text(info)
    grains = read(path, writers.xyzd())
    assert grains.diameter == pytest.approx(writers.DIAMETER / 2)
    assert grains.period == pytest.approx((0.04, 0.04))
    assert "diameters times 0.5, by the final porosity" in notes(grains)
    path.with_suffix(".nfo").write_text(info.replace("Final Porosity: ", "Final Porosity: 3"))
    assert "expected a number between 0 and 1" in fault(path, writers.xyzd())
    path.with_suffix(".nfo").write_text("N: 3\n")
    assert "found no Dimensions and no Final Porosity" in fault(path, writers.xyzd())


def test_spheres_of_packing_generation_in_single_precision(tmp_path: Path) -> None:
    values = np.column_stack([writers.POSITION, writers.DIAMETER]).astype("<f4")
    grains = read(tmp_path / "packing.xyzd", values.tobytes())
    assert grains.position == pytest.approx(writers.POSITION, rel=1e-7)
    assert "expected binary numbers x, y, z and a diameter" in fault(
        tmp_path / "damaged.xyzd", values.tobytes()[:-3], format="xyzd"
    )


def test_values_of_cells_of_vtk_are_passed_over(tmp_path: Path) -> None:
    """The number of cells may differ from the number of points."""
    cells = "CELL_DATA 1\nSCALARS pressure float\nLOOKUP_TABLE default\n3\n"
    text = writers.vtk_ascii().replace("POINT_DATA", f"{cells}POINT_DATA")
    grains = read(tmp_path / "grains.vtk", text)
    assert np.array_equal(grains.position, writers.POSITION)


def test_a_hybrid_of_liggghts(tmp_path: Path) -> None:
    text = writers.data_file("hybrid granular bond/gran")
    grains = read(tmp_path / "grains.data", text)
    assert np.array_equal(grains.diameter, writers.DIAMETER)


OF_VERSION_2 = """restart_version 2
name grains
xmin 0 xmax 1 ymin 0 ymax 1 zmin 0 zmax 1
Species 1
k 1 disp 1 kt 1 dispt 1 mu 0.5 rho 1200 dim_particle 3
WallsPeriodic 1
normal 0 1 0 pos_left 0 pos_right 0.5 shift 0 0.5 0
Particles 2
0.1 0.2 0.3 0 0 0 0.05 0 0 0 1 2 3 1 10 0
0.1 0.2 0.4 0 0 0 0.05 0 0 0 0 0 0 1 10 1 1e-5 2e-5 3e-5 2 -1 26
"""


def test_a_restart_file_of_mercury_of_version_2(tmp_path: Path) -> None:
    """Springs follow the values of a particle, which has no species."""
    grains = read(tmp_path / "grains.restart", OF_VERSION_2)
    assert grains.position[:, 2].tolist() == [0.3, 0.4]
    assert grains.spin[0].tolist() == [1, 2, 3]
    reading = grains.reading
    assert reading is not None
    assert reading.types == {"0": 2}
    assert reading.density == (1200.0, 1200.0)
    assert reading.periodic == (False, True, False)
    assert reading.bounds is not None
    assert reading.bounds[1].tolist() == [0, 0.5]


def test_steps_of_mercury_without_particles(tmp_path: Path) -> None:
    head = "0 0.1 0 0 0 1 1 1\n"
    step = writers.mercury_step(0.2)
    grains = read(tmp_path / "grains.data", head + head + step)
    assert np.array_equal(grains.position, writers.POSITION)
    assert "found no particle in the step 1, expected one or more; packing.step = 0 reads" in fault(
        tmp_path / "emptied.data", step + head
    )


def test_particles_of_mercury_without_angles(tmp_path: Path) -> None:
    rows = "0.01 0.02 0.005 0 0 1 0.005 0\n0.01 0.02 0.015 0 0 0 0.005 0\n"
    grains = read(tmp_path / "start.dat", f"2 0.0 0 0 0 0.04 0.04 0.1\n{rows}")
    assert grains.diameter.tolist() == [0.01, 0.01]
    assert grains.velocity[0].tolist() == [0, 0, 1]
    table = "1 1 0 0 0 0.005 0.01 0.02\n2 1 0 0 1 0.005 0.01 0.02\n3 1 0 0 2 0.005 0.01 0.02\n"
    assert "found 8 columns without names" in fault(tmp_path / "table.dat", table)


def test_velocities_u_v_w(tmp_path: Path) -> None:
    """Columns as in the tables of MFiX; `u` without `v` and `w` has no meaning."""
    text = "X,Y,Z,phase_id,diameter,density,U,V,W\n0,0,0,1,.01,1000,1,2,3\n"
    grains = read(tmp_path / "particle_input.csv", text)
    assert grains.velocity.tolist() == [[1, 2, 3]]
    with_unit = read(tmp_path / "g.csv", "x,y,z,r,u (mm/s),v (mm/s),w (mm/s)\n0,0,0,1,1,2,3\n")
    assert with_unit.velocity[0] == pytest.approx([1e-3, 2e-3, 3e-3])
    alone = read(tmp_path / "h.csv", "x,y,z,r,u\n0,0,0,1,1\n")
    assert "column ignored: u" in notes(alone)


@pytest.mark.parametrize(("text", "message"), [
    ("0 0 0\n0 0 1\n", 'packing.columns = ["x", "y", "z"] with packing.diameter for all grains'),
    ("0 0 0 1\n0 0 1 1\n", 'packing.columns = ["x", "y", "z", "radius"]'),
    ("0 0 0 1 7\n0 0 1 1 7\n", "packing.columns = {x = 1, y = 2, z = 3, radius = 4} (numbers of"),
    ("0 0 0 1 1 0 0 0\n0 0 1 1 1 0 0 0\n", 'or packing.format = "mfix" for particles of MFiX'),
    ("0 12 1 1 5 .5 .5 23 KF6843H84OPHH3017U3D 24 0\n", "found a scene of MUSEN"),
    (b"\x16\0\0\0\0\0\0\0serialization::archive\x12\0", "found a simulation of YADE (O.save)"),
])  # fmt: skip
def test_advice_fits_the_file(text: str | bytes, message: str, tmp_path: Path) -> None:
    """The column names of the advice can be used unchanged."""
    assert message in fault(tmp_path / "grains.txt", text)
