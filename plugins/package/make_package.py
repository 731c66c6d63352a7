"""Make the package GRANWAVE, as one drops it into LAMMPS's sources, from the sources and pages of
the plugin.

    python plugins/package/make_package.py [FOLDER] [--into LAMMPS] [--lmp LMP]

The folder, by default build/GRANWAVE, mirrors that of LAMMPS: src/GRANWAVE, cmake, doc/src,
examples and unittest. Files that are not styles get the prefix granwave_, since the traditional
make has all files of LAMMPS in one folder.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import textwrap
import tomllib
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path

from lammps_pages import lammps_pages

PLUGINS = Path(__file__).resolve().parents[1]
HERE = PLUGINS / "package"
PLUGIN_ONLY = {"granwaveplugin.cpp", "add_styles.cpp", "all_styles.h"}
STYLE_FILE = re.compile(r"(pair|fix|compute)_|gran_dents")
STYLE = re.compile(r"^(Pair|Fix|Compute|Command)Style\(([\w/]+),", re.MULTILINE)
EXAMPLE = re.compile(
    r"(?<=\n\n)((?:.+\n)+)\n```LAMMPS\n# Complete example: (\w+)\n((?:.*\n)*?)```\n"
)
EXAMPLES = "examples/PACKAGES/granwave"


def sources() -> dict[str, str]:
    """Text of the C++ files by their names in the package, with includes that find each other in
    one folder.
    """
    found = {
        path.name: path.read_text(encoding="utf-8")
        for room in ("styles", "kernels", "laws")
        for path in sorted((PLUGINS / room).iterdir())
        if path.suffix in (".h", ".cpp") and path.name not in PLUGIN_ONLY
    }
    new = {name: name if STYLE_FILE.match(name) else f"granwave_{name}" for name in found}

    def include(line: re.Match[str]) -> str:
        return f'#include "{new.get(line[1], line[1])}"'

    return {
        new[name]: re.sub(
            r'^#include "(?:\.\./(?:laws|kernels)/)?([^"]+)"', include, text, flags=re.MULTILINE
        )
        for name, text in found.items()
    }


def examples() -> Iterator[tuple[str, str]]:
    """Names and scripts of the complete examples of the pages, with their descriptions as
    comments.
    """
    for page in sorted((PLUGINS / "doc").glob("*.md")):
        for what, name, script in EXAMPLE.findall(page.read_text(encoding="utf-8")):
            plain = (
                re.sub(r"\[([^\]]*)\]\([^)]*\)|\*(\S[^*]*)\*", r"\1\2", what)
                .replace("`", "")
                .strip()
                .rstrip(":.")
            )
            yield (
                name,
                textwrap.fill(f"{plain}.", 100, initial_indent="# ", subsequent_indent="# ")
                + f"\n\n{script}",
            )


def write(folder: Path) -> None:
    """Write the package. Files of an earlier one are removed first."""
    shutil.rmtree(folder, ignore_errors=True)
    source = folder / "src" / "GRANWAVE"
    pages = folder / "doc" / "src"
    tests = folder / "unittest" / "force-styles" / "tests"
    for place in (
        source,
        pages,
        tests,
        folder / EXAMPLES / "manual",
        folder / "cmake" / "Modules" / "Packages",
    ):
        place.mkdir(parents=True)
    for name, text in sources().items():
        (source / name).write_text(text, encoding="utf-8")
    shutil.copy(HERE / "Install.sh", source)
    shutil.copy(HERE / "GRANWAVE.cmake", folder / "cmake" / "Modules" / "Packages")
    version = tomllib.loads((PLUGINS.parent / "pyproject.toml").read_text(encoding="utf-8"))[
        "project"
    ]["version"]
    styles = [
        f"{kind.lower()} {name}"
        for text in sources().values()
        for kind, name in STYLE.findall(text)
    ]
    readme = (HERE / "README.txt").read_text(encoding="utf-8").replace("VERSION", version)
    listed = textwrap.fill(
        ", ".join(sorted(styles)), 120, initial_indent="Styles: ", subsequent_indent="    "
    )
    (source / "README").write_text(readme.replace("Styles: STYLES", listed), encoding="utf-8")
    for name, text in lammps_pages(PLUGINS / "doc").items():
        (pages / f"{name}.rst").write_text(text, encoding="utf-8")
    for name, text in examples():
        (folder / EXAMPLES / "manual" / f"in.{name}").write_text(text, encoding="utf-8")
    for room, place in (("examples", folder / EXAMPLES), ("unittest", tests)):  # as they are
        for path in sorted((PLUGINS / room).glob("*")):
            if path.suffix not in (".md", ".py") and path.is_file():
                shutil.copy(path, place)


def run(scripts: list[Path], lmp: str, mpiexec: str, numbers: list[int]) -> None:
    """Run examples on each number of ranks, and write their logs next to them.

    Logs are named in the same way as those in the examples of LAMMPS.
    """
    for script in scripts:
        for ranks in numbers:
            with tempfile.TemporaryDirectory() as place:
                shutil.copytree(script.parent, place, dirs_exist_ok=True)
                command = [lmp, "-in", script.name, "-screen", "none"]
                if ranks > 1:
                    command = [mpiexec, "-n", str(ranks), *command]
                done = subprocess.run(command, cwd=place, capture_output=True, text=True)
                path = Path(place) / "log.lammps"
                log = path.read_text(encoding="utf-8") if path.exists() else ""
            if done.returncode or "Total wall time" not in log:
                raise SystemExit(
                    f"{script.name} on {ranks} ranks failed:\n{log[-2000:]}{done.stderr}"
                )
            date = re.search(r"^LAMMPS \((\d+ \w+ \d+)", log, re.MULTILINE)
            day = datetime.strptime(date[1], "%d %b %Y").strftime("%-d%b%y") if date else "unknown"
            name = f"log.{day}.{script.name.removeprefix('in.')}.g++.{ranks}"
            (script.parent / name).write_text(log, encoding="utf-8")


def put_into(folder: Path, lammps: Path) -> None:
    """Copy the package into LAMMPS's sources, and put its name into the lists of their CMake file."""
    cmake = lammps / "cmake" / "CMakeLists.txt"
    if not (lammps / "src" / "pair.h").exists() or not cmake.exists():
        raise SystemExit(
            f"{lammps} has no src/pair.h and cmake/CMakeLists.txt, expected the folder of LAMMPS's sources"
        )
    text = cmake.read_text(encoding="utf-8")
    if "GRANWAVE" not in text:
        text, packages = re.subn(r"(?m)^  GRANULAR$", "  GRANULAR\n  GRANWAVE", text)
        text, includes = re.subn(r"(foreach\(PKG_WITH_INCL CORESHELL)", r"\1 GRANWAVE", text)
        if (packages, includes) != (1, 1):
            raise SystemExit(
                f"{cmake} has other lists of packages than expected: add GRANWAVE by hand (README)"
            )
    shutil.copytree(folder, lammps, dirs_exist_ok=True)
    cmake.write_text(text, encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "folder", nargs="?", type=Path, default=PLUGINS.parent / "build" / "GRANWAVE"
    )
    parser.add_argument(
        "--into",
        type=Path,
        metavar="LAMMPS",
        help="folder of LAMMPS's sources that gets the package",
    )
    parser.add_argument(
        "--lmp", help="LAMMPS with the styles, which runs the examples for their logs"
    )
    parser.add_argument(
        "--mpiexec", help="starts it on ranks (default: the launcher next to it, or in PATH)"
    )
    parser.add_argument(
        "--ranks", type=int, nargs="+", default=[1, 4], help="numbers of ranks (default: 1 4)"
    )
    parser.add_argument(
        "--only", nargs="+", metavar="NAME", help="examples that are run (default: all)"
    )
    chosen = parser.parse_args()
    if (
        chosen.folder.exists()
        and any(chosen.folder.iterdir())
        and not (chosen.folder / "src" / "GRANWAVE").exists()
    ):
        raise SystemExit(
            f"{chosen.folder} contains other files than the package: choose another folder"
        )
    write(chosen.folder)
    if chosen.lmp:
        lmp = os.path.abspath(chosen.lmp) if os.sep in chosen.lmp else chosen.lmp
        beside = Path(lmp).with_name("mpiexec")
        scripts = sorted((chosen.folder / EXAMPLES).rglob("in.*"))
        if chosen.only:
            scripts = [
                script for script in scripts if script.name.removeprefix("in.") in chosen.only
            ]
        run(
            scripts,
            lmp,
            chosen.mpiexec or (str(beside) if beside.exists() else "mpiexec"),
            chosen.ranks,
        )
    if chosen.into:
        put_into(chosen.folder, chosen.into)
    print(f"The package: {chosen.folder}", file=sys.stderr)


if __name__ == "__main__":
    main()
