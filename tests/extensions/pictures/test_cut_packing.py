"""Packings cut open: which runs have the figures, and hidden surfaces of the renderer."""

from __future__ import annotations

import numpy as np
import pytest

from granwave.analysis import Result, write_result
from granwave.analysis.figures.run_figures import run_figures
from granwave.extensions.pictures import packing3d, sphere_renderer
from granwave.workflows import run_case
from tests.helpers.made_up import synthetic

BOTH = {"packing_3d", "packing_3d_dissipation"}


@pytest.fixture(autouse=True)
def small_pictures(monkeypatch):
    monkeypatch.setattr(packing3d, "_PIXELS", 120)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        *(({"kind": kind, "size": (6, 6, 4)}, BOTH) for kind in ("fcc", "hcp", "bcc", "sc")),
        ({"kind": "square", "size": (5, 5)}, BOTH),
        ({"law": "hertz"}, {"packing_3d"}),
        ({"kind": "chain", "size": 12}, set()),
        ({"size": (1, 1, 1)}, set()),
    ],
)
def test_runs_that_have_the_figures(tmp_path, options, expected):
    write_result(synthetic.write_run(tmp_path, synthetic.make_case(**options)))
    with Result(tmp_path) as result:
        drawn = {name for name in BOTH if run_figures()[name].draw(result) is not None}
    assert drawn == expected


def render(centres, radius, colours, camera, width, axes=None):
    """Surface and pixels of spheres and cylinders."""
    surface = sphere_renderer.lit_surface(centres, radius, camera, width, axes)
    return surface, sphere_renderer.painted(surface, colours)


def test_the_arrow_of_an_oblique_impact_in_a_layer_is_shown_whole(tmp_path):
    striker = {"touches": [1], "velocity": [0.2, 0.2, 0.0]}
    case = synthetic.make_case("square", (6, 5), striker=[striker], law="hertz")
    run_case(case, tmp_path, figures=False)
    with Result(tmp_path) as result:
        axes = run_figures()["packing_3d"].draw(result).figure.axes[0]
    arrow = next(text for text in axes.texts if text.arrow_patch is not None)
    left, right = axes.get_xlim()
    bottom, top = axes.get_ylim()
    for x, y in (arrow.xy, arrow.xyann):
        assert left < x < right
        assert bottom < y < top


def test_sphere_in_front_hides_the_one_behind():
    """Seen from above, only the upper of two spheres is visible; a third one next to them is
    visible as well.
    """
    camera = sphere_renderer.Camera.looking(0.0, 90.0, np.array([0.0, 0.0, 1.0]))
    centres = np.array([[0.0, 0, 0], [0, 0, 2], [2, 0, 0]])
    surface, pixels = render(centres, 1.0, np.eye(3), camera, 64)
    assert surface.visible.tolist() == [1, 2]
    middle = pixels[np.any(pixels[..., 3] == 1, axis=1)]
    assert np.all(
        middle[..., 0][middle[..., 3] == 1] < 0.4
    )  # the red one is hidden (apart from gloss, white)


@pytest.mark.parametrize("radii", [[0.5], [1.0, 0.5]])
def test_picture_covers_the_discs(radii):
    camera = sphere_renderer.Camera.looking(
        30.0, 90.0 if len(radii) > 1 else 20.0, np.array([0.0, 0.0, 1.0])
    )
    centres = np.array([[0.0, 0, 0], [3, 0, 0]])[: len(radii)]
    surface, pixels = render(centres, np.array(radii), np.ones((len(radii), 3)), camera, 300)
    assert covered(surface, pixels) == pytest.approx(np.pi * np.square(radii).sum(), rel=1e-2)


def covered(surface, pixels):
    """Area that is not blank, m^2."""
    left, right, bottom, top = surface.extent
    return pixels[..., 3].mean() * (right - left) * (top - bottom)


def test_both_ways_of_painting_agree():
    place = np.random.default_rng(3).uniform(10, 90, (40, 2))
    fronts = []
    for paint in (sphere_renderer._paint_by_sphere, sphere_renderer._paint_by_pixel):
        fronts.append(np.full((100, 100), -1, dtype=np.int32))
        paint(fronts[-1], place, np.full(40, 6.3))
    assert np.mean(fronts[0] != fronts[1]) < 1e-3  # single precision at the edges
    assert np.any(fronts[0] >= 0)


def test_the_surface_of_a_packing_is_found_once(tmp_path, monkeypatch):
    """Both pictures of a cut packing share one surface; another result has a separate surface."""
    found = []
    find = packing3d.lit_surface
    monkeypatch.setattr(packing3d, "lit_surface", lambda *rest: found.append(0) or find(*rest))
    write_result(synthetic.write_run(tmp_path / "one", synthetic.make_case("fcc", (6, 6, 4))))
    for count in (1, 2):
        with Result(tmp_path / "one") as result:
            pictures = [packing3d.packing_3d(result), packing3d.packing_3d_dissipation(result)]
        assert len(found) == count
        first, second = (picture.figure.axes[0].images[0].get_array() for picture in pictures)
        assert first.shape == second.shape and not np.array_equal(first, second)
        assert np.array_equal(first[..., 3], second[..., 3])


@pytest.mark.parametrize("half", [(0.0, 0.0, 1.5), (1.5, 0.0, 0.0), (0.6, -0.5, 1.1)])
def test_a_cylinder_covers_its_outline(half):
    """The area of a cylinder in a picture: a rectangle and an ellipse, by its inclination."""
    camera = sphere_renderer.Camera.looking(25.0, 35.0, np.array([0.0, 0.0, 1.0]))
    radius = 0.5
    axis = np.array([half])
    surface, pixels = render(np.zeros((1, 3)), radius, np.ones((1, 3)), camera, 400, axis)
    length = np.linalg.norm(half)
    tilt = abs(camera.project(axis)[0, 2]) / length
    assert covered(surface, pixels) == pytest.approx(
        4 * radius * length * np.sqrt(1 - tilt**2) + np.pi * radius**2 * tilt, rel=5e-3
    )


def test_cylinders_hide_spheres_and_each_other():
    """Seen from above, an upright cylinder hides the sphere below it, and is partly hidden by a
    horizontal cylinder above it.
    """
    camera = sphere_renderer.Camera.looking(0.0, 90.0, np.array([0.0, 0.0, 1.0]))
    centres = np.array([[0.0, 0, 0], [0, 0, 2], [0, 0, 3.2]])
    axes = np.array([[0.0, 0, 0], [0, 0, 1], [2, 0, 0]])
    surface, pixels = render(centres, np.array([0.9, 1.0, 0.2]), np.eye(3), camera, 200, axes)
    assert surface.visible.tolist() == [1, 2]
    height, width = pixels.shape[:2]
    assert np.argmax(pixels[height // 2, width // 2, :3]) == 2  # the lying one
    beside = pixels[height // 2, :, :3].sum(axis=0)  # along y
    assert np.argmax(beside) == 1  # the end of the upright one
