"""Surfaces of triangles as walls: planes, convergence to a cylinder, edges, rejected input."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave._contact_laws import TriangleMesh, read_stl
from tests.conftest import BIN, PLAIN, script_of
from tests.helpers import meshes
from tests.helpers.bodies.thrown_sphere import state, thrown
from tests.helpers.bodies.two_spheres import BOX, value

HERTZ = "hertz 115e9 0.3"
FRICTION = "hertz 115e9 0.3 friction 0.3"
YIELDS = "elastoplastic 115e9 0.3 550e6 friction 0.3"
ANGLE = 30


def wall(path: Path, patch: int = 1, law: str = HERTZ, name: str = "wall") -> str:
    return f"fix {name} all wall/gran/hysteretic mesh {path} {ANGLE} {patch} {law}"


def written(path: Path, triangles: np.ndarray) -> Path:
    path.write_text(meshes.stl_text(triangles))
    return path


@pytest.mark.parametrize("law", [HERTZ, FRICTION, YIELDS])
@pytest.mark.parametrize("n", [1, 10])
def test_a_flat_plate_is_a_plane(lammps: Any, tmp_path: Path, law: str, n: int) -> None:
    """The sphere slides and rolls over the edges of 2 or 200 triangles: one contact."""
    plate = written(tmp_path / "plate.stl", meshes.plate(n, height=0.01))
    ends = []
    for walls in (f"fix wall all wall/gran/hysteretic zplane NULL 0.01 {law}", wall(plate, 1, law)):
        lmp = lammps()
        thrown(lmp, (-0.0003, -0.0002, 0.0069), (8.0, 5.0, 2.0), 4000, walls)
        ends.append([*state(lmp), value(lmp, "f_wall[5]"), value(lmp, "f_wall[9]")])
    assert ends[1] == pytest.approx(ends[0], rel=1e-12, abs=1e-15)
    assert ends[0][5] < 0


def test_a_sphere_that_rolls_over_edges_sees_no_bump(lammps: Any, tmp_path: Path) -> None:
    """A sphere under a force rolls over many triangles: force and overlap are equal to those on a
    plane.
    """
    plate = written(tmp_path / "plate.stl", meshes.plate(40, height=0.01))
    paths = []
    press = "fix press all addforce 0 0 2000.0"
    floor = f"fix wall all wall/gran/hysteretic zplane NULL 0.01 {FRICTION}"
    for walls in (floor, wall(plate, 1, FRICTION)):
        lmp = lammps()
        thrown(lmp, (-0.0015, -0.0007, 0.00699), (9.0, 5.0, 0.0), 0, f"{walls}\n{press}")
        rows = []
        for _ in range(100):
            lmp.command("run 100")
            rows.append([value(lmp, "f_wall"), *lmp.numpy.extract_atom("f")[0]])
        paths.append(rows)
    plane, mesh = np.array(paths)
    assert mesh == pytest.approx(plane, rel=1e-9, abs=1e-9 * np.abs(plane).max())
    assert lmp.numpy.extract_atom("x")[0][0] > -0.0005  # a triangle has 1 mm


def test_a_tube_of_facets_converges_to_the_cylinder() -> None:
    radius = 0.02
    random = np.random.default_rng(1)
    angle = random.uniform(0, 2 * np.pi, 500)
    rho = random.uniform(0.012, 0.018, 500)
    places = np.stack([rho * np.cos(angle), rho * np.sin(angle), 0 * angle], axis=-1)
    errors = []
    for n in (32, 64, 128):
        mesh = TriangleMesh(meshes.tube(n, radius, -0.01, 0.01), ANGLE)
        assert mesh.n_patches == 1
        distances, points = mesh.nearest(places, 1)
        assert np.linalg.norm(places - points, axis=1) == pytest.approx(distances, rel=1e-12)
        errors.append(np.abs(distances - (radius - rho)).max())
        assert errors[-1] == pytest.approx(radius * (1 - np.cos(np.pi / n)), rel=0.02)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.05)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2, abs=0.05)


@pytest.mark.parametrize("law", [HERTZ, FRICTION, YIELDS])
def test_energy_closes_over_folds(lammps: Any, tmp_path: Path, law: str) -> None:
    """A sphere bounces in a tube of facets and slides over several folds while it touches."""
    tube = written(tmp_path / "tube.stl", meshes.tube(720, 0.0077, -0.04, 0.04))
    lmp = lammps()
    place = (0.00332, 0.00332, 0.001)
    thrown(lmp, place, (-6.0, 10.0, 1.0), 0, wall(tube, 1, law))
    parts = "c_ke+c_spin+f_wall+f_wall[5]+f_wall[8]+f_wall[9]"
    whole = value(lmp, parts)
    energies = []
    pressed = []
    for _ in range(60):
        lmp.command("run 25")
        energies.append(value(lmp, parts))
        if value(lmp, "f_wall[1]") > 0:
            x = lmp.numpy.extract_atom("x")[0]
            pressed.append(720 * np.arctan2(x[1], x[0]) / (2 * np.pi))
    assert energies == pytest.approx([whole] * len(energies), rel=1e-5)
    assert np.ptp(pressed) > 2
    assert value(lmp, "f_wall[1]") == 0


def test_a_sphere_in_a_corner_touches_each_face_once(lammps: Any, tmp_path: Path) -> None:
    box = written(tmp_path / "box.stl", meshes.box(0.01))
    mesh = TriangleMesh(meshes.box(0.01), ANGLE)
    assert mesh.n_patches == 6
    place = np.array([[0.0071, 0.0072, 0.0073]])
    gaps = sorted(float(mesh.nearest(place, patch)[0][0]) for patch in range(1, 7))
    assert gaps == pytest.approx([0.0027, 0.0028, 0.0029, 0.0171, 0.0172, 0.0173], rel=1e-12)
    lmp = lammps()
    walls = [wall(box, k, HERTZ, f"w{k}") for k in range(1, 6)] + [wall(box, 6)]
    thrown(lmp, (0.0069, 0.0069, 0.0069), (2.0, 2.0, 2.0), 4000, "\n".join(walls))
    assert lmp.numpy.extract_atom("v")[0] == pytest.approx([-2, -2, -2], rel=1e-4)


@pytest.mark.parametrize(
    "shift", [(0.0, 0.0), (0.002, 0.0), (0.002, 0.002), (-1e-9, 0.0), (1e-9, 0.0)]
)
def test_an_outer_edge_or_corner_counts_once(shift: tuple[float, float]) -> None:
    """At edges and corners of a box exactly one patch has the contact, at the distance of the
    box.
    """
    half = 0.01
    mesh = TriangleMesh(meshes.box(half), ANGLE)
    random = np.random.default_rng(5)
    places = random.uniform(-0.014, 0.014, (3000, 3)) + np.array([*shift, 0])
    beyond = np.abs(places) - half
    outside = places[beyond.max(axis=1) > 1e-5]
    distance = np.linalg.norm(np.maximum(np.abs(outside) - half, 0), axis=1)
    each = np.stack([mesh.nearest(outside, patch)[0] for patch in range(1, 7)])
    on_edge = (np.maximum(np.abs(outside) - half, 0) > 0).sum(axis=1) > 1
    touching = np.isclose(each, distance, rtol=1e-12)
    assert (touching.sum(axis=0) == 1).all()
    assert on_edge.sum() > 100
    # a face behind the box is one too; nearer than that no other patch has a contact
    assert (np.sort(each, axis=0)[1] > distance * (1 + 1e-9)).all()


def test_a_face_of_triangles_that_do_not_share_corners_is_one() -> None:
    """A corner in the middle of a neighbour's edge, as CAD programs write them."""
    a, b, c, d = [[0.0, 0, 0], [1.0, 0, 0], [1.0, 1, 0], [0.0, 1, 0]]
    e, f, g = [[1.0, 0.5, 0], [2.0, 0, 0], [2.0, 1, 0]]
    triangles = np.array([[a, b, c], [a, c, d], [b, f, e], [f, g, e], [e, g, c]])
    mesh = TriangleMesh(triangles, ANGLE)
    assert mesh.n_patches == 1
    places = np.array([[0.999, 0.4, 0.1], [1.001, 0.6, 0.1], [1.0, 0.5, 0.1]])
    assert mesh.nearest(places, 1)[0] == pytest.approx([0.1] * 3, rel=1e-12)


def test_files_of_both_forms_are_read_alike(tmp_path: Path) -> None:
    triangles = meshes.plate(3).astype(np.float32).astype(np.float64)
    assert read_stl(meshes.stl_text(triangles).encode()) == pytest.approx(triangles, rel=0, abs=0)
    assert read_stl(meshes.stl_binary(triangles)) == pytest.approx(triangles, rel=0, abs=0)


TEXT = meshes.stl_text(meshes.plate(1))


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        (TEXT[:-30].encode(), "it is truncated"),
        (TEXT.replace("vertex", "vertex x", 1).encode(), "line 4: found"),
        (meshes.stl_binary(meshes.plate(1))[:-20], "found 164 bytes, expected an STL file"),
        (b"ply\nformat ascii 1.0\n", "expected an STL file"),
        (b"", "found 0 bytes"),
    ],
)
def test_what_is_no_stl_file_is_refused(content: bytes, fault: str) -> None:
    with pytest.raises(ValueError, match=fault):
        read_stl(content)


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        ("mesh PATH 30 2", "has patches 1 to 1, found 2"),
        ("mesh nowhere.stl 30 1", "cannot read nowhere.stl"),
        ("mesh PATH 120 1", "the angle of a patch"),
    ],
)
def test_wrong_meshes_are_refused(lammps: Any, tmp_path: Path, words: str, fault: str) -> None:
    plate = written(tmp_path / "plate.stl", meshes.plate(1))
    lmp = lammps()
    fix = f"fix wall all wall/gran/hysteretic {words.replace('PATH', str(plate))} {HERTZ}"
    with pytest.raises(Exception, match=fault):
        thrown(lmp, (0, 0, 0.01), (0, 0, 0), 0, fix)


@pytest.mark.parametrize("is_there", [True, False])
def test_the_first_rank_reads_the_file_for_all(tmp_path: Path, is_there: bool) -> None:
    """The second rank runs in another folder, as on a node without this one; none of them waits."""
    first = tmp_path / "first"
    second = tmp_path / "second"
    for folder in (first, second):
        folder.mkdir()
    if is_there:
        written(first / "plate.stl", meshes.plate(1))
    fix = wall(Path("plate.stl"))
    (first / "in.script").write_text(script_of([(0, 0, 0.01)], box=BOX, extra=f"{fix}\nrun 0\n"))
    lmp = [str(BIN / "lmp"), "-in", str(first / "in.script"), "-screen", "none", "-log", "none"]
    ranks = ["-n", "1", "-wdir", str(first), *lmp, ":", "-n", "1", "-wdir", str(second), *lmp]
    done = subprocess.run(
        [str(BIN / "mpiexec"), *ranks], capture_output=True, text=True, timeout=300, env=PLAIN
    )
    assert (done.returncode == 0) == is_there, done.stdout + done.stderr
