"""Laws and batches compile unchanged as code for a graphics card: LLVM's assembler code for
NVIDIA cards by clang's OpenMP offloading.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

PLUGINS = Path(__file__).parents[3] / "plugins"
SOURCE = Path(__file__).parent / "device_laws.cpp"
#: sm_70: any card since 2017; no LAMMPS header is in the path.
FLAGS = [
    "-std=c++17", "-O1", "-ffp-contract=off", "-fopenmp", "-fopenmp-targets=nvptx64-nvidia-cuda", "-Xopenmp-target", "-march=sm_70",
    "-nogpulib", "--offload-device-only", "-S",
]  # fmt: skip
KERNELS = 11  # eight laws, any law, friction, batches


def compiled(source: Path, to: Path) -> subprocess.CompletedProcess[str]:
    """Compile with the newest available clang.

    Raises
    ------
    Skipped
        There is no clang, or it cannot generate code for a card.
    """
    found = [
        name
        for version in (22, 21, 20, 19, 18, 17, 16)
        if (name := shutil.which(f"clang++-{version}"))
    ]
    compiler = next(iter(found), shutil.which("clang++"))
    if not compiler:
        pytest.skip("no clang++ in the path")
    trial = to.with_name("trial.cpp")
    trial.write_text("void f(int *a)\n{\n#pragma omp target map(tofrom : a[:1])\n  a[0]++;\n}\n")
    if subprocess.run(
        [compiler, *FLAGS, trial, "-o", to], capture_output=True, check=False
    ).returncode:
        pytest.skip(f"{compiler} makes no code for nvptx64")
    return subprocess.run(
        [compiler, *FLAGS, f"-I{PLUGINS}", source, "-o", to],
        capture_output=True,
        text=True,
        check=False,
    )


def test_laws_and_batches_are_device_code(tmp_path):
    done = compiled(SOURCE, tmp_path / "laws.s")
    assert done.returncode == 0, done.stderr[:3000]
    code = (tmp_path / "laws.s").read_text()
    assert len(re.findall(r"\.entry\b", code)) == KERNELS
    # all functions and constants are in it but the run time of OpenMP, the square root, and the end
    # of a variant without a value
    outside = set(
        re.findall(
            r"\.extern\s+\.\w+(?:\s+\.align\s+\d+\s+\.\w+)?\s*(?:\([^)]*\)\s*)?([\w$]+)", code
        )
    )
    assert {name for name in outside if not name.startswith("__kmpc_")} <= {"__nv_sqrt", "abort"}
    assert ".callprototype" not in code  # no function is called by a pointer: none is virtual
    assert "fma.rn.f64" not in code  # products and sums are rounded one by one, as on processors
