"""Packages and directions of imports: workflows -> analysis -> lammps_inputs -> bindings of the
plugin, and within each.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

pytestmark = pytest.mark.xdist_group("layers")  # each module is read once
ROOT = Path(__file__).parents[2]
PACKAGES = ("extensions", "workflows", "analysis", "lammps_inputs", "plugins")

# From top to bottom: a file imports from its own folder and from folders on lower levels. A name
# denotes a folder or a file.
FLOORS = """
extensions/__init__ workflows/package workflows/__main__
extensions/design
extensions/continuum extensions/inference extensions/packings extensions/pictures extensions/waves
workflows/cli workflows/python
workflows/bench_lists
workflows/bench
workflows/scanning
workflows/cluster
workflows/run
workflows/library
workflows/file_kinds
workflows/solvers
workflows/check_part
analysis/reports
analysis/notebook
analysis/exports
analysis/studies
analysis/scans analysis/contact_law
analysis/document
analysis/pipeline
analysis/figures analysis/summary analysis/summary_table
analysis/measures
analysis/result
analysis/lammps_output
analysis/formatting
analysis/quantities analysis/statistics analysis/errors analysis/versions analysis/progress_bar analysis/products
lammps_inputs/functions_of_case
lammps_inputs/deck
lammps_inputs/load_case
lammps_inputs/planning lammps_inputs/checks
lammps_inputs/statics
lammps_inputs/contact
lammps_inputs/packing
lammps_inputs/case
lammps_inputs/readers
lammps_inputs/tables
lammps_inputs/result_directory
lammps_inputs/own_files
lammps_inputs/directories lammps_inputs/marker lammps_inputs/restart_file
lammps_inputs/result_kinds lammps_inputs/rounding
lammps_inputs/lattices lammps_inputs/run_directory
lammps_inputs/packing_kind lammps_inputs/extensions
lammps_inputs/files lammps_inputs/script_words lammps_inputs/interrupts lammps_inputs/roots lammps_inputs/processes lammps_inputs/streams
lammps_inputs/message_words
lammps_inputs/errors
plugins plugins/package plugins/upstream
"""
FLOOR = {room: -number for number, line in enumerate(FLOORS.split("\n")) for room in line.split()}
FACES = {
    f"{name}/__init__" for name in PACKAGES
}  # re-export names to users; no file of ours imports from them


def modules(packages: Iterable[str]) -> dict[str, Path]:
    """Python files of packages by their dotted name."""
    found = {}
    for package in packages:
        for path in (ROOT / package).rglob("*.py"):
            parts = path.relative_to(ROOT).with_suffix("").parts
            found["granwave." + ".".join(parts).removesuffix(".__init__")] = path
    return found


MODULES = modules(PACKAGES)
CORE = [name for name in sorted(MODULES) if not name.startswith("granwave.extensions")]
MADE_BY_THE_BUILD = {"granwave._contact_laws", "granwave._number_reader", "granwave._version"}


@cache
def import_statements(module: str) -> list[ast.Import | ast.ImportFrom]:
    """Import statements anywhere in a module, including those for types."""
    tree = ast.parse(MODULES[module].read_text(encoding="utf-8"))
    return [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)]


def imports(module: str) -> Iterator[str]:
    """Modules of ours that a module imports."""
    for node in import_statements(module):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("granwave"):
            for alias in node.names:
                name = f"{node.module}.{alias.name}"
                yield name if name in MODULES else str(node.module)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in MODULES)


def others_imported(module: str) -> set[str]:
    """Other modules of ours that a module imports."""
    return {other for other in imports(module) if other in MODULES and other != module}


@cache
def names_in(module: str) -> set[str]:
    """Words in the text of a module."""
    return {word for word in re.findall(r"\w+", MODULES[module].read_text(encoding="utf-8"))}


def circles(graph: dict[str, set[str]]) -> set[str]:
    """Modules in a cycle of imports, or between two cycles."""
    left = {name: set(others) for name, others in graph.items()}
    while ends := [
        name
        for name, others in left.items()
        if not others & set(left) or not any(name in found for found in left.values())
    ]:
        for name in ends:
            del left[name]
    return set(left)


def room_of(module: str) -> str:
    """Folder of a module, or the file itself if it is directly in its package."""
    return "/".join(module.split(".")[1:][:2])


def test_every_file_has_its_room() -> None:
    rooms = {
        room_of(name)
        for name, path in MODULES.items()
        if f"{path.parent.name}/{path.stem}" not in FACES
    }
    assert sorted(rooms - set(FLOOR)) == []
    assert (
        sorted(
            room
            for room in FLOOR
            if not (ROOT / room).is_dir() and not (ROOT / f"{room}.py").exists()
        )
        == []
    )


@pytest.mark.parametrize("module", sorted(MODULES))
def test_imports_run_downwards(module: str) -> None:
    room = room_of(module)
    if f"{room}/__init__" in FACES or room in PACKAGES:
        return
    for other in others_imported(module):
        there = room_of(other)
        assert there == room or FLOOR[there] < FLOOR[room], (
            f"{module} imports {other}, which is not on a lower floor"
        )


#: Imports our extensions for type checkers alone; `tests/workflows/test_python.py` holds its names to
#: those that the extensions give.
FACE_FOR_TYPES = "granwave.workflows.package"


@pytest.mark.parametrize("module", CORE)
def test_the_core_imports_no_extension(module: str) -> None:
    """Extensions list their additions; see `granwave.lammps_inputs.extensions.Extension`."""
    source = MODULES[module].read_text(encoding="utf-8")
    if "granwave.extensions" not in source:
        return
    tree = ast.parse(source)
    if module == FACE_FOR_TYPES:
        tree.body = [node for node in tree.body if not isinstance(node, ast.If)]
    text = ast.unparse(tree)
    assert "granwave.extensions." not in text and "from granwave.extensions" not in text


@pytest.mark.parametrize("module", sorted(MODULES))
def test_what_is_imported_exists(module: str) -> None:
    """Modules of ours, and names in them; mypy passes over modules that it does not find."""
    for node in import_statements(module):
        if not isinstance(node, ast.ImportFrom) or not (node.module or "").startswith("granwave."):
            continue
        source = str(node.module)
        if source in MADE_BY_THE_BUILD:
            continue
        assert source in MODULES, source
        for alias in node.names:
            assert f"{source}.{alias.name}" in MODULES or alias.name in names_in(source), (
                f"{source}.{alias.name}"
            )


def test_there_is_no_circle_of_imports() -> None:
    left = circles({module: others_imported(module) for module in MODULES})
    assert left == set(), f"these import each other: {', '.join(sorted(left))}"


#: Rooms of C++ without LAMMPS, and the rooms below each.
ROOMS_BELOW = {
    "laws": (),
    "kernels": ("laws",),
    "bindings": ("laws", "kernels"),
}  # fmt: skip


def test_includes_run_downwards() -> None:
    """C++: laws include laws, kernels also kernels, and bindings also bindings; none of them
    includes LAMMPS or styles. No header includes itself via others.
    """
    headers = {path.name: path for path in (ROOT / "plugins").rglob("*.h")}
    graph = {}
    for path in (ROOT / "plugins").rglob("*.[ch]*"):
        if path.suffix in (".h", ".cpp"):
            lines = [
                line.split('"')[1]
                for line in path.read_text().splitlines()
                if line.startswith('#include "')
            ]
            graph[path] = {headers[Path(line).name] for line in lines if Path(line).name in headers}
            if path.parent.name in ROOMS_BELOW:
                outside = [line for line in lines if Path(line).name not in headers]
                assert outside == [], (
                    f"{path.name} includes {outside}: headers of LAMMPS belong into styles/"
                )
                rooms = {path.parent.name, *ROOMS_BELOW[path.parent.name]}
                upwards = [other.name for other in graph[path] if other.parent.name not in rooms]
                assert upwards == [], f"{path.parent.name}/{path.name} includes {upwards}"
    assert (
        circles({path.name: {other.name for other in others} for path, others in graph.items()})
        == set()
    )


def test_no_circle_of_includes():
    """The sources of a header belong to it: pair_gran_hysteretic_forces.cpp to
    pair_gran_hysteretic.h.
    """
    sources = sorted((ROOT / "plugins").rglob("*.h")) + sorted((ROOT / "plugins").rglob("*.cpp"))
    headers = {path.stem for path in sources if path.suffix == ".h"}

    def unit(path: Path) -> str:
        return max(
            (name for name in headers if f"{path.stem}_".startswith(f"{name}_")),
            key=len,
            default=path.stem,
        )

    graph: dict[str, set[str]] = {}
    for path in sources:
        found = re.findall(
            r'^#include "(?:[^"]*/)?([^"/]+)\.h"', path.read_text(encoding="utf-8"), re.MULTILINE
        )
        graph.setdefault(unit(path), set()).update(set(found) & headers - {unit(path)})
    assert set(graph) >= headers
    list(TopologicalSorter(graph).static_order())  # CycleError names a circle


#: May name a source.
NAME_A_SOURCE = (
    "lammps_inputs/case/materials.toml",  # cites the origin of its values
)  # fmt: skip


def test_the_packages_name_no_source() -> None:
    """Printed values of other authors belong into reproductions/."""
    word = re.compile(r"(?<![a-z])(thesis|errat(a|um)|source 00[123])(?![a-z])", re.IGNORECASE)
    files = [path for name in PACKAGES[:4] for path in sorted((ROOT / name).rglob("*.*"))]
    files = [path for path in files if path.is_file() and path.parent.name != "__pycache__"]
    found = [
        f"{name}:{number}"
        for path in files
        if not (name := path.relative_to(ROOT).as_posix()).startswith(NAME_A_SOURCE)
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1)
        if word.search(line)
    ]
    assert found == []
