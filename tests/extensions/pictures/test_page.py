"""Page of a run: its content, no network requests, and its controls in a browser."""

from __future__ import annotations

import base64
import re
import shutil
import time
import zlib
from itertools import pairwise

import msgpack
import numpy as np
import pytest
from PIL import Image

from granwave.analysis import write_result
from granwave.analysis.result.reader import Result
from granwave.extensions.pictures.view import page, scene
from granwave.extensions.pictures.view.fields import LEVELS, fields
from granwave.extensions.pictures.view.instants import instants_of
from granwave.lammps_inputs.case.figures import Figures
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows.run.driver import run_case
from tests.helpers.made_up import synthetic
from tests.helpers.programs.chromium import Browser

CHROMIUM = (
    shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
)
SOFTWARE_GL = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Packing of 144 spheres with four snapshots."""
    case = synthetic.make_case("fcc", (6, 6, 4), boundary={"bottom": "wall", "sides": "wall"})
    directory = synthetic.write_run(tmp_path_factory.mktemp("run"), case)
    for wall in ("xlo", "xhi", "ylo", "yhi"):
        synthetic.write_custom(
            directory / "dumps" / f"wall_{wall}.dump",
            synthetic.WALL_COLUMNS,
            np.empty((0, 9)),
            synthetic.STEPS,
        )
    time = np.arange(0, synthetic.STEPS + 1, 5)
    rows = np.column_stack([time, time * synthetic.TIMESTEP, *np.ones((5, len(time)))])
    synthetic.write_table(
        directory / "dumps" / "walls.txt", "step time bottom xlo xhi ylo yhi", rows
    )
    write_result(directory)
    return directory


def plot_in(path):
    """Content of the plot on a page."""
    (data,) = re.findall(r"var data = '([^']+)'", path.read_text(encoding="utf-8"))
    return msgpack.unpackb(zlib.decompress(base64.b64decode(data)), strict_map_key=False)


def arrays(series):
    return {float(key): np.frombuffer(zlib.decompress(value["compressed_data"]) if "compressed_data" in value
                                      else value["data"], dtype=value["dtype"]) for key, value in series.items()}  # fmt: skip


def test_values_on_the_page(run, tmp_path):
    """Every field has all spheres at all snapshots, within a step of the colour scale."""
    made = page.write_view(run, tmp_path / "a.html")
    assert (made.n_spheres, made.n_frames, made.note) == (144, 4, "")
    assert made.size == (tmp_path / "a.html").stat().st_size > 1e6
    plot = plot_in(tmp_path / "a.html")
    spheres = {one["name"]: one for one in plot["objects"] if one["type"] == "Points"}
    assert {"contact force", "speed", "peak force", "dissipated energy"} <= set(spheres)
    assert [one["visible"] for one in spheres.values()].count(True) == 1
    with Result(run) as result:
        (force,) = [
            one
            for one in fields(result, instants_of(result).at(range(4)), np.arange(144))
            if one.name == "peak force"
        ]
        shown = arrays(spheres["peak force"]["attribute"])
        assert list(shown) == pytest.approx(1e6 * result.frame_times)
        true = result.frame(2, "peak_force")
        level = list(shown.values())[2]
        above = true > force.low
        found = force.low * (force.high / force.low) ** level
        step = (force.high / force.low) ** (1 / LEVELS)
        assert np.all(
            (found[above] >= true[above] / 1.001) & (found[above] <= 1.001 * step * true[above])
        )
        assert not level[~above].any()
        place = arrays({"0": spheres["speed"]["positions"]})[0.0].reshape(-1, 3)
        assert np.allclose(place, 1e3 * (result["spheres/position"] - result.origin), atol=1e-3)


def test_walls_cuts_and_texts(run, tmp_path):
    page.write_view(run, tmp_path / "a.html")
    plot = plot_in(tmp_path / "a.html")
    names = {one["name"] for one in plot["objects"]}
    assert {"bottom", "wall xlo", "wall yhi", "clock", "title", "colour bar of speed"} <= names
    given = plot["plot"]["customData"]
    assert {"across x", "across y", "at a depth", "principal plane", "orthogonal plane"} == set(
        given["cuts"]
    )
    assert given["cut"] == "orthogonal plane" and given["fields"][0] == "contact force"
    for low, high, start in (cut[3:] for cut in given["cuts"].values()):
        assert low <= start < high
    (title,) = [one["text"] for one in plot["objects"] if one["name"] == "title"]
    assert "144 spheres" in title and "mm" in title


@pytest.mark.parametrize(
    ("kind", "size"),
    [pytest.param("chain", 12, marks=pytest.mark.validation), ("square", (5, 5))],
)
def test_other_packings(tmp_path, kind, size):
    """Chains and layers have no hidden spheres, and are shown uncut."""
    write_result(synthetic.write_run(tmp_path, synthetic.make_case(kind, size)))
    made = page.write_view(tmp_path)
    assert made.path == tmp_path / "view.html"
    given = plot_in(made.path)["plot"]["customData"]
    assert given["cut"] == "none"
    assert page.write_view(tmp_path).size > 0  # its own file is replaced


def test_a_chain_has_its_history():
    """Forces of the beads are the largest of their contacts, at the instants of the record."""
    time = np.linspace(0, 1, 11)
    force = np.zeros((11, 3))
    force[:, 0] = time
    force[:, 1] = 2 * time[::-1]
    beads = {"chain/velocity": np.ones((11, 3)), "chain/displacement": np.zeros((11, 3))}
    ends = {
        "chain/contact_i": np.array([1, 2, 3]),
        "chain/contact_j": np.array([2, 3, 9]),
    }  # 9: the face of a bar

    class Record(dict):
        n_frames = 2
        n_spheres = 3

        def rows(self, ids):
            return np.asarray(ids) - 1

    tables = {"chain/time": time, "chain/id": np.array([1, 2, 3]), "chain/contact_force": force}
    instants = instants_of(Record({"chain": 0, **tables, **beads, **ends}))
    assert np.allclose(instants.times, time)
    assert np.allclose(instants.values(10, "contact_force"), [1.0, 1.0, 0.0])
    assert np.allclose(instants.values(10, "peak_force"), [1.0, 2.0, 2.0])
    assert np.allclose(instants.values(3, "velocity"), [[0, 0, 1]] * 3)


def test_fewer_spheres_and_snapshots(run, tmp_path, monkeypatch):
    """The spheres nearest to the impacted sphere are kept, and the page states this."""
    made = page.write_view(run, tmp_path / "a.html", spheres=20, frames=3)
    assert (made.n_spheres, made.n_frames) == (20, 3)
    assert "the 20 spheres nearest to the impacted sphere, of 144, 3 of 4 snapshots" in made.note
    spheres = [one for one in plot_in(made.path)["objects"] if one["type"] == "Points"]
    away = np.linalg.norm(arrays({"0": spheres[0]["positions"]})[0.0].reshape(-1, 3), axis=1)
    with Result(run) as result:
        distances = 1e3 * np.linalg.norm(result["spheres/position"] - result.origin, axis=1)
    assert np.allclose(np.sort(away), np.sort(distances)[:20], atol=1e-3)
    assert any(
        made.note in one.get("text", "")
        for one in plot_in(made.path)["objects"]
        if one["name"] == "title"
    )
    monkeypatch.setattr(page, "MOST_VALUES", 1)
    monkeypatch.setattr(page, "_FEWEST_FRAMES", 2)
    assert page.write_view(run, tmp_path / "a.html").n_frames == 2


def test_colours_and_limits_of_the_case(run):
    with Result(run) as result:
        result.figure_options = Figures(colour_map="cividis", force_limits=(0.5, 50.0))
        force, *_ = fields(result, instants_of(result).at([0, 3]), np.arange(144))
        unit = result.law.yield_force
        assert (force.map, force.low, force.high) == ("cividis", 0.5 * unit, 50.0 * unit)
        assert (
            force.colours.shape[1] == 4 and force.colours[0, 0] == 0 and force.colours[-1, 0] == 1
        )


def test_only_data_is_loaded(run, tmp_path):
    """The page forbids all external content."""
    text = page.write_view(run, tmp_path / "a.html").path.read_text(encoding="utf-8")
    (policy,) = re.findall(r'http-equiv="Content-Security-Policy" content="([^"]+)"', text)
    assert policy.startswith("default-src 'none'") and "http" not in policy and "*" not in policy
    assert not re.findall(r"""<(?:script|link|img)[^>]+(?:src|href)=["']?(?!data:)""", text)
    (source,) = re.findall(r"k3dCompressed = '([^']+)'", text)
    assert b",url(fonts/" not in zlib.decompress(base64.b64decode(source))
    assert "<title>synthetic-fcc - granwave</title>" in text


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("a.txt", r"a\.txt: expected a name that ends in \.html"),
        ("nowhere/a.html", "no such directory"),
        ("mine.html", "granwave did not write it"),
    ],
)
def test_wrong_files(run, tmp_path, name, message):
    (tmp_path / "mine.html").write_text("<!doctype html>mine")
    with pytest.raises(InputError, match=message):
        page.write_view(run, tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.html"]
    assert (tmp_path / "mine.html").read_text() == "<!doctype html>mine"


@pytest.mark.skipif(
    CHROMIUM is None, reason="no chromium on this machine (Debian: apt install chromium)"
)
def test_in_a_browser(run, tmp_path):
    """No requests and no errors; field, time and cut change the picture."""
    path = page.write_view(run, tmp_path / "a.html").path
    with Browser(CHROMIUM, tmp_path / "profile", timeout=120, flags=SOFTWARE_GL) as browser:
        browser.open(path.as_uri(), 800, 600)
        wait_for(
            browser, "Boolean(window.K3DInstance)"
        )  # set by a script that may end after the page's load event
        browser.evaluate("K3DInstance.then((plot) => (window.plot = plot)); 0")
        panel = "window.plot?.gui.folders.find((one) => one._title === 'View')"
        wait_for(browser, f"Boolean({panel}?.controllers.length === 6)")
        names = browser.evaluate(f"{panel}.controllers.map((one) => one._name).join()")
        assert names == "field,time (µs),play / stop,cut,cut at (mm),keep"
        wait_for(browser, "plot.parameters.clippingPlanes.length === 1")
        pictures = [picture(browser, tmp_path)]
        for change, done in (
            (
                "controllers[1].setValue(1e9)",
                "plot.parameters.time === Math.max(...plot.parameters.customData.times)",
            ),
            ("controllers[0].setValue('speed')", "document.body.innerHTML.includes('Speed (m/s)')"),
            ("controllers[3].setValue('none')", "plot.parameters.clippingPlanes.length === 0"),
            ("controllers[3].setValue('at a depth')", "plot.parameters.clippingPlanes[0][2] === 1"),
        ):
            browser.evaluate(f"{panel}.{change}; 0")
            wait_for(browser, done)
            pictures.append(picture(browser, tmp_path))
        assert all(np.abs(a - b).max() > 50 for a, b in pairwise(pictures))
        assert [line for line in browser.complaints() if not re.search("K3D|WebGL", line)] == []
        asked = {url for url in browser.requests() if not url.startswith(("data:", "blob:"))}
        assert asked == {path.as_uri()}


@pytest.mark.skipif(
    CHROMIUM is None, reason="no chromium on this machine (Debian: apt install chromium)"
)
@pytest.mark.parametrize(
    ("flags", "missing"), [(SOFTWARE_GL, False), (("--disable-3d-apis",), True)]
)
def test_a_browser_that_cannot_draw_shows_a_message(run, tmp_path, flags, missing):
    path = page.write_view(run, tmp_path / "a.html").path
    with Browser(CHROMIUM, tmp_path / "profile", timeout=120, flags=flags) as browser:
        browser.open(path.as_uri(), 390, 844)
        shown = "Boolean(document.querySelector('#no-webgl')?.textContent.includes('WebGL 2'))"
        assert browser.evaluate(shown) is missing


def wait_for(browser, expression, limit=60.0):
    """Wait until an expression is true in the page."""
    end = time.monotonic() + limit
    while not browser.evaluate(expression):
        assert time.monotonic() < end, expression
        time.sleep(0.05)
    time.sleep(0.2)  # the next picture


def picture(browser, folder):
    browser.screenshot(folder / "seen.png", whole=False)
    with Image.open(folder / "seen.png") as image:
        return np.asarray(image.convert("RGB"), dtype=int)


def test_a_tube_is_drawn_as_rims_and_lines(tmp_path):
    grains = [{"ring": {"n": 4, "radius": 0.01, "z": 0.005}, "diameter": 0.008}]
    tables = {
        "name": "row", "material": "brass", "packing": {"kind": "chain", "size": 2, "diameter": 0.01},
        "grains": grains,
        "boundary": {"bottom": "free", "sides": {"tube": {"radius": 0.014}}},
        "run": {"end_time": 2e-6, "frames": 2},
    }  # fmt: skip
    run_case(case_from_dict(tables), tmp_path, figures=False)
    with Result(tmp_path) as result:
        lines = [np.asarray(one.vertices) for one in scene._walls(result)]
    assert len(lines) == 6
    for line in lines:
        assert np.hypot(*line.T[:2]) == pytest.approx(np.full(len(line), 14.0), rel=1e-5)


def test_numbers_along_a_chain_do_not_cover_its_name(tmp_path):
    tables = {
        "name": "row", "material": "steel", "packing": {"kind": "chain", "size": 15, "diameter": 4.76e-3},
        "run": {"end_time": 2e-6, "frames": 2},
    }  # fmt: skip
    run_case(case_from_dict(tables), tmp_path, figures=False)
    with Result(tmp_path) as result:
        place = 1e3 * (result["spheres/position"] - result.origin)
        labels = scene._depths_of_chain(result, place)
    *numbers, name = labels
    assert [one.text for one in numbers] == ["0", "20", "40", "60"]
    assert name.text == "depth (mm)"
    assert [one.position[2] for one in numbers] == pytest.approx([0, 20, 40, 60])
    below = {one.position[0] for one in numbers}
    assert max(below) < place[:, 0].min() - 2.3 and name.position[0] > place[:, 0].max() + 2.3
