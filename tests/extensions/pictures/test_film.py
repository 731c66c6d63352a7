"""Animations: a picture of every snapshot, a common scale, the time; files that other programs
open; errors in one line.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import time

import imageio_ffmpeg
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from granwave.analysis import analyse
from granwave.analysis.figures.style import style
from granwave.analysis.result.reader import Result
from granwave.extensions.pictures import films, terminal
from granwave.extensions.pictures.films import scene, size_of, write_film
from granwave.lammps_inputs.case.figures import CutPlane, Figures
from granwave.lammps_inputs.errors import InputError
from granwave.workflows import run_case
from granwave.workflows.cli.main import main
from tests.conftest import PLAIN
from tests.helpers.made_up import synthetic
from tests.helpers.made_up.small_cases import PULSE, case_of


@pytest.fixture(scope="module")
def packing(tmp_path_factory):
    directory = tmp_path_factory.mktemp("packing")
    case = synthetic.make_case(
        "fcc", (8, 8, 4), run={"end_time": 6e-5, "frames": 4}, output={"dump_format": "binary"}
    )
    run_case(case, directory, figures=False)
    return directory


@pytest.fixture(scope="module")
def chain(tmp_path_factory):
    directory = tmp_path_factory.mktemp("chain")
    case = case_of(6, load=PULSE, run={"end_time": 8e-5, "frames": 3}, output={"history": 8})
    run_case(case, directory, figures=False)
    return directory


@pytest.mark.parametrize(("form", "view"), [("gif", None), ("webp", "principal"), ("gif", "3d")])
def test_moving_pictures(packing, tmp_path, form, view):
    seen = []
    path = write_film(
        packing,
        tmp_path / f"a.{form}",
        view=view,
        width=240,
        progress=lambda *now: seen.append(now),
    )
    with Image.open(path) as film:
        assert film.n_frames == 4 and film.size[0] == 240 and film.size[1] % 2 == 0
        first = np.asarray(film.convert("RGB"), dtype=int)
        film.seek(2)
        assert np.abs(np.asarray(film.convert("RGB"), dtype=int) - first).max() > 50
    assert seen == [(n, 4) for n in (1, 2, 3, 4)]


def test_mp4(chain, tmp_path):
    path = write_film(chain, tmp_path / "a.mp4", width=300, rate=10)
    about = next(imageio_ffmpeg.read_frames(str(path)))
    assert about["size"][0] == 300 and about["fps"] == 10 and about["codec"] == "h264"
    assert about["duration"] == pytest.approx(8 / 10 + 1.5, abs=0.25)  # the last picture stays
    assert write_film(chain, path, width=300) == path  # its own file is replaced


@pytest.mark.parametrize("form", ["mp4", "gif", "webp"])
def test_a_full_disk_keeps_the_earlier_film(chain, tmp_path, form):
    disk = tmp_path / "disk"
    disk.mkdir()
    if subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", disk], capture_output=True
    ).returncode:
        pytest.skip("no disk can be mounted here")
    try:
        path = write_film(chain, disk / "a.mp4", width=300) if form == "mp4" else disk / f"a.{form}"
        before = path.read_bytes() if form == "mp4" else b""
        (disk / "ballast").write_bytes(bytes(shutil.disk_usage(disk).free - 4096))
        with pytest.raises(OSError, match="No space left") as error:
            write_film(chain, path, width=800)
        assert error.value.filename == str(path) and (not before or path.read_bytes() == before)
        assert {one.name for one in disk.iterdir()} == {"ballast", *([path.name] if before else [])}
    finally:
        subprocess.run(["umount", "-l", disk], check=True)


def test_a_film_that_is_stopped_leaves_nothing(chain, tmp_path):
    command = [
        sys.executable,
        "-m",
        "granwave.workflows",
        "film",
        str(chain),
        "-o",
        "a.mp4",
        "--width",
        "2400",
    ]
    film = subprocess.Popen(command, cwd=tmp_path, env=PLAIN, stderr=subprocess.PIPE, text=True)
    end = time.monotonic() + 60
    while not list(tmp_path.glob(".a.mp4.*")):
        assert film.poll() is None and time.monotonic() < end
        time.sleep(0.01)
    film.terminate()
    assert (
        film.communicate(timeout=60)[1].endswith("granwave: stopped\n") and film.returncode == 130
    )
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "view"), [("chain", None), ("packing", "section"), ("packing", "3d")]
)
def test_films_of_a_given_size(packing, chain, tmp_path, name, view):
    """The animation has exactly the requested size, with the colour bar next to the picture."""
    options = Figures(plane=CutPlane((1.0, 1.0, 0.0)), colour_map="plasma")
    directory = {"chain": chain, "packing": packing}[name]
    write_film(directory, tmp_path / "a.gif", view=view, size=(320, 180), options=options)
    with Image.open(tmp_path / "a.gif") as film:
        assert film.size == (320, 180)
    with Result(directory) as result, style():
        result.figure_options = options
        figure = scene(result, "force", view, (6.0, 3.4)).draw(1)
        bar = figure.axes[-1].get_position()
        figure.draw_without_rendering()
        bar = figure.axes[-1].get_position()
        assert bar.x0 > 0.8 and bar.height > bar.width


@pytest.mark.parametrize(
    ("name", "view"), [("packing", "orthogonal"), ("packing", "3d"), ("chain", None)]
)
def test_pictures_are_those_of_whole_figures(packing, chain, name, view):
    """A moving part below a static part gives the same picture as the complete figure."""
    with Result(packing if name == "packing" else chain) as result, style():
        pictures = list(films.film_pictures(scene(result, "force", view), 600))
        for number in (1, len(pictures) - 1):
            figure = scene(result, "force", view).draw(number)
            figure.set_dpi(600 / figure.get_figwidth())
            canvas = FigureCanvasAgg(figure)
            canvas.draw()
            whole = np.asarray(canvas.buffer_rgba())[:, :, :3].astype(int)
            height, width, _ = pictures[number].shape
            apart = np.abs(whole[:height, :width] - pictures[number]).max(axis=2)
            assert np.mean(apart > 40) < 1e-3


def test_the_time_of_a_film_is_measured(packing, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(terminal, "_MEASURED", 3)
    monkeypatch.setattr(terminal, "_WORTH_SAYING", 0.0)
    assert main(["film", str(packing), "-o", str(tmp_path / "a.gif"), "--width", "240"]) == 0
    assert re.search(r"animation: 4 frames, about 0 s left", capsys.readouterr().err)


def test_sizes():
    assert size_of("slide") == (1920, 1080) and size_of("640x480") == (640, 480)
    for text in ("slid", "640x481", "20x20", "640", "wide"):
        with pytest.raises(
            InputError, match=f"--size: found {text}, expected slide, page, or width × height"
        ):
            size_of(text)


@pytest.mark.parametrize("quantity", ["force", "velocity", "dissipation"])
def test_one_scale_and_a_clock(packing, quantity):
    with Result(packing) as result, style():
        film = scene(result, quantity, "orthogonal")
        assert np.array_equal(film.times, result.frame_times)
        scales = []
        for number in (1, 3):
            figure = film.draw(number)
            (clock,) = [text.get_text() for text in figure.texts]
            assert clock == f"{1e6 * result.frame_times[number]:.0f} µs"
            scales.append(figure.axes[-1].get_xlim())
        assert scales[0] == scales[1]


def test_chain_shows_nothing_of_the_future(chain):
    with Result(chain) as result, style():
        film = scene(result, "force", None)
        figure = film.draw(5)
        with pytest.raises(InputError, match=r"no orthogonal plane; use --view 3d or chain"):
            scene(result, "force", "orthogonal")
        (mesh,) = [one for one in figure.axes[1].collections if one.get_array() is not None]
        shown = np.ma.filled(mesh.get_array(), np.nan)
        row = int(np.searchsorted(result["chain/time"], film.times[5]))
        assert np.isnan(shown[row + 1 :]).all() and np.isfinite(shown[: row + 1]).any()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"path": "a.avi"}, r"a\.avi: expected a name that ends in \.mp4, \.gif, \.webp"),
        (
            {"quantity": "speed"},
            r"--quantity: found speed, expected one of force, velocity, dissipation",
        ),
        ({"view": "orthogonl"}, r"--view: found orthogonl, .* did you mean orthogonal\?"),
        ({"view": "3D"}, r"did you mean 3d\?"),
        ({"view": "chain"}, r"no record of a chain"),
        ({"view": "section"}, r"--view section: requires a plane; set --plane, or figures.plane"),
        ({"width": 20}, r"--width: found 20, expected 100 to 4000 pixels"),
        ({"rate": 0.0}, r"--rate: found 0, expected 0.1 to 100"),
        ({"path": "nowhere/a.gif"}, r"no such directory"),
    ],
)
def test_wrong_options(packing, tmp_path, options, message):
    path = tmp_path / options.pop("path", "a.gif")
    with pytest.raises(InputError, match=message):
        write_film(packing, path, **options)
    assert not list(tmp_path.iterdir())


@pytest.mark.validation
def test_commands(packing, granwave, tmp_path):
    done = granwave(
        "film", packing, "-o", tmp_path / "a.gif", "--width", 200, "--quantity", "velocity"
    )
    assert done.returncode == 0 and done.stdout.strip() == str(tmp_path / "a.gif"), done.stderr
    done = granwave("film", tmp_path / "nope", "-o", tmp_path / "b.gif")
    assert done.returncode == 2 and re.fullmatch(r"granwave: .*no such directory.*\n", done.stderr)
    analyse(packing, figures=False)
    done = granwave("view", packing, "--spheres", 100)
    assert done.returncode == 0 and done.stdout.splitlines()[0] == str(packing / "view.html"), (
        done.stderr
    )
    assert re.fullmatch(r"[\d.]+ MB, 100 spheres, 4 snapshots", done.stdout.splitlines()[1])
    assert "the 100 spheres nearest to the impacted sphere, of 256; --all shows all" in done.stderr
    options = (
        "--plane",
        "1,1,0",
        "--through",
        "0.04,0.04,w",
        "--colour-map",
        "viridi",
        "--force-limits",
        "9,1",
    )
    done = granwave("figures", packing, "--only", "energies", *options)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 3
    assert (
        "--plane --through: found 1,1,0 and 0.04,0.04,w" in done.stderr
        and "did you mean viridis?" in done.stderr
    )
    options = (
        "--plane",
        "1,1,0",
        "--through",
        "0.04,0.04,0",
        "--colour-map",
        "magma",
        "--formats",
        "none",
    )
    done = granwave("figures", packing, "--only", "peak_force_section", *options)
    assert done.returncode == 0 and "peak_force_section.png" in done.stdout, done.stderr
    assert not (packing / "figures" / "peak_force_section.pdf").exists()
    done = granwave("figures", packing, "--only", "peak_force_section")
    assert done.returncode == 2 and "requires a plane; set --plane x" in done.stderr
    assert (packing / "figures" / "peak_force_section.png").exists()
    done = granwave("figures", packing, "--only", "energies,directions")
    assert done.returncode == 0 and [line.split("/")[-1] for line in done.stdout.split()] == [
        "energies.png", "directions.png",
    ]  # fmt: skip
    done = granwave("figures", packing, "--only", "energie")
    assert done.returncode == 2 and "did you mean energies?" in done.stderr
    done = granwave("figures", packing, "--only", "energies,force_map")
    assert done.returncode == 2 and "--only: force_map: does not apply to this run" in done.stderr
    assert done.stdout.split()[0].endswith("energies.png")
    done = granwave("figures", packing, "--only", "energies,,directions")
    assert done.returncode == 2 and "found an empty name" in done.stderr
