"""Comparisons of kinds with texts: differences between kinds belong into their classes.

A kind of load, packing, static load, bottom or sides is a class with its behaviour as methods and
flags. ``if case.load.kind == "plate"`` elsewhere is one more place to edit for a new kind. ``python
-m tests.house.kinds`` writes the number of such lines in each file to `EXCEPTIONS`; the tests allow
no more of them, so that the list only becomes shorter.
"""

from __future__ import annotations

import ast
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from tests.house.rules import name_of, python_files

EXCEPTIONS = Path(__file__).parent / "kinds.toml"
FOLDERS = ("analysis/", "lammps_inputs/", "workflows/")

# Files and folders of the classes themselves, which read the texts of case files.
OWN = (
    "lammps_inputs/lattices.py",
    "lammps_inputs/case/packing/packing.py",
    "lammps_inputs/case/packing/reading.py",
    "lammps_inputs/case/load.py",
    "lammps_inputs/case/loads/",
    "lammps_inputs/case/boundary.py",
    "lammps_inputs/case/bounds.py",
    "lammps_inputs/case/precompression.py",
)
TABLES = ("load", "packing", "precompression", "stage", "lattice", "support")  # with a kind
KEYS = ("load.kind", "packing.kind", "precompression.kind", "boundary.bottom", "boundary.sides")
OF_BOUNDARY = ("bottom", "sides")


def comparisons(tree: ast.AST) -> Iterator[int]:
    """Lines that compare a kind with texts, match it, or look it up in a table written there."""
    names = names_of_kinds(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
            asked = any(is_kind(side, names) for side in sides) and any(map(is_text, sides))
        elif isinstance(node, ast.Match):
            asked = is_kind(node.subject, names)
        elif isinstance(node, ast.Subscript):
            asked = isinstance(node.value, ast.Dict) and is_kind(node.slice, names)
        elif isinstance(node, ast.Call):
            asked = is_get(node) and is_kind(node.args[0], names)
            asked = asked and isinstance(owner_of(node), ast.Dict)
        else:
            asked = False
        if asked:
            yield node.lineno


def names_of_kinds(tree: ast.AST) -> set[str]:
    """Names to which a file assigns a kind."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and is_kind(node.value, set()):
            names.update(target.id for target in node.targets if isinstance(target, ast.Name))
    return names


def is_kind(node: ast.AST, names: set[str]) -> bool:
    """Return True for an expression that is the text of a kind.

    Parameters
    ----------
    names
        Names of variables that hold one.
    """
    if isinstance(node, ast.Name):
        return node.id in names
    if isinstance(node, ast.Attribute):
        return is_key(last_name(node.value), node.attr)
    if isinstance(node, ast.Subscript):
        return is_key(last_name(node.value), text_of(node.slice))
    if is_get(node):
        return is_key(last_name(owner_of(node)), text_of(node.args[0]))
    return False


def is_key(table: str, key: str) -> bool:
    """Return True for the name of a key that holds a kind, in a table of a case or dotted."""
    if table == "boundary":
        return key in OF_BOUNDARY
    return key in KEYS or (key == "kind" and table in TABLES)


def is_get(node: ast.AST) -> bool:
    """Return True for a call of a method ``get`` with arguments."""
    return (
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Attribute)
        and node.func.attr == "get"
        and bool(node.args)
    )


def owner_of(call: ast.AST) -> ast.AST:
    """Object whose method a call is."""
    assert isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute)
    return call.func.value


def last_name(node: ast.AST) -> str:
    """Last name of an expression: ``load`` of ``self.case.load``, ``tables["load"]`` and
    ``tables.get("load")``.
    """
    if isinstance(node, ast.Name):
        return node.id.strip("_")
    if isinstance(node, ast.Attribute):
        return node.attr.strip("_")
    if isinstance(node, ast.Subscript):
        return text_of(node.slice)
    return text_of(node.args[0]) if is_get(node) else ""


def text_of(node: ast.AST) -> str:
    """Text of a literal; empty for others."""
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""


def is_text(node: ast.AST) -> bool:
    """Return True for a literal text, several of them, or a constant."""
    if isinstance(node, ast.Tuple | ast.List | ast.Set):
        return all(is_text(part) for part in node.elts)
    if isinstance(node, ast.Name):
        return node.id.isupper()
    return bool(text_of(node))


@cache
def lines() -> dict[str, list[int]]:
    """Lines that ask for a kind, by file."""
    found = {}
    for path in python_files():
        name = name_of(path)
        if not name.startswith(FOLDERS) or name.startswith(OWN):
            continue
        numbers = sorted(comparisons(ast.parse(path.read_text(encoding="utf-8"))))
        if numbers:
            found[name] = numbers
    return found


def exceptions() -> dict[str, int]:
    """Content of `EXCEPTIONS`."""
    return tomllib.loads(EXCEPTIONS.read_text(encoding="utf-8"))


def write_exceptions() -> None:
    """Write the list of exceptions again."""
    rows = [f'"{path}" = {len(numbers)}' for path, numbers in lines().items()]
    head = "# Written by `python -m tests.house.kinds`; the list only shrinks."
    EXCEPTIONS.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    write_exceptions()
