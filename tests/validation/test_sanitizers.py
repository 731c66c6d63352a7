"""Builds of the plugin with the sanitizers of the compiler, with which the tests of the plugin run
without any report; CONTRIBUTING.md.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.validation
ROOT = Path(__file__).parents[2]
BIN = Path(sys.prefix) / "bin"
OURS = re.compile(
    r"granwave(plugin|styles)\.so|_contact_laws\.|_number_reader\."
    r"|plugins/(styles|laws|kernels|bindings)/"
)
# LAMMPS itself does not delete a command that ends in an error
COMMAND = "create<LAMMPS_NS::Command"
KINDS = {
    "address": ("address,undefined", ["libasan.so", "libubsan.so"], ["tests/plugins"]),
    "thread": ("thread", ["libtsan.so"], ["tests/plugins/test_threads.py"]),
}
# places of Python's and MPI's own that never are given back do not concern us, races need both
# sides instrumented
OPTIONS = {
    "ASAN_OPTIONS": "detect_leaks=1:abort_on_error=1:detect_stack_use_after_return=1:alloc_dealloc_mismatch=0",
    "LSAN_OPTIONS": "exitcode=0:max_leaks=0:report_objects=0",
    "UBSAN_OPTIONS": "print_stacktrace=1",
    "TSAN_OPTIONS": "exitcode=66:ignore_noninstrumented_modules=1",
}


def build(kind: str) -> Path:
    """Build into build/sanitize; return a folder whose package `granwave` has these libraries and
    the sources of this tree.
    """
    import granwave

    folder = ROOT / "build" / "sanitize" / kind
    site = ROOT / "build" / "sanitize" / f"{kind}-python"
    dirs = subprocess.run(
        [sys.executable, "-m", "pybind11", "--cmakedir"], capture_output=True, text=True, check=True
    )
    environment = {**os.environ, "PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}"}
    settings = {
        "GRANWAVE_SANITIZE": KINDS[kind][0],
        "GRANWAVE_VERSION": granwave.__version__,
        "Python_EXECUTABLE": sys.executable,
        "pybind11_DIR": dirs.stdout.strip(),
    }
    words = [f"-D{name}={value}" for name, value in settings.items()]
    for command in (
        ["cmake", "-S", ROOT / "plugins", "-B", folder, "-G", "Ninja", *words],
        ["cmake", "--build", folder],
        ["cmake", "--install", folder, "--prefix", site / "granwave"],
    ):
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    package = site / "granwave"
    for name in ("__init__.py", "_version.py", "measures.py", "theory.py"):
        shutil.copy(Path(granwave.__file__).parent / name, package)
    for name in ("analysis", "lammps_inputs", "workflows", "extensions", "plugins/__init__.py"):
        (package / name).unlink(missing_ok=True)
        (package / name).symlink_to(ROOT / name)
    return site


def reports(folder: Path) -> list[str]:
    """Reports of the sanitizers: leaks only with a function of ours; and a note if leaks could not
    be checked.
    """
    found = []
    for path in sorted(folder.glob("report.*")):
        text = path.read_text(encoding="utf-8", errors="replace")
        if "LeakSanitizer" in text and "fatal error" not in text:
            blocks = [block for block in text.split("\n\n") if "irect leak of" in block]
            found += [block for block in blocks if OURS.search(block) and COMMAND not in block]
        else:
            found.append(text)
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_no_report(kind, tmp_path):
    _, libraries, tests = KINDS[kind]
    site = build(kind)
    paths = [
        subprocess.run(
            ["gcc", f"-print-file-name={name}"], capture_output=True, text=True, check=True
        ).stdout.strip()
        for name in libraries
    ]
    environment = {name: f"{words}:log_path={tmp_path}/report" for name, words in OPTIONS.items()}
    environment |= {
        "LD_PRELOAD": ":".join(paths),
        "PYTHONPATH": str(site),
        "PYTHONMALLOC": "malloc",
    }
    # of MPI's library UCX: libasan takes places in another process that it reads for its own,
    # libtsan and it replace the same functions
    environment |= {"UCX_TLS": "^cma", "UCX_MEM_EVENTS": "no"}
    command = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", *tests]
    done = subprocess.run(
        ["setarch", "-R", *command],
        cwd=ROOT,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    found = reports(tmp_path)
    assert not found, f"{len(found)} reports, the first:\n{found[0][:4000]}"
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
    print(done.stdout.splitlines()[-1])
