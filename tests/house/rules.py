"""Rules on code lines that no linter checks, on the syntax tree.

``python -m tests.house.rules`` writes the number of violations in each file to `EXCEPTIONS`; the
tests allow no more of them, so that the list only becomes shorter.
"""

from __future__ import annotations

import argparse
import ast
import json
import subprocess
import sys
import tomllib
from collections import Counter
from collections.abc import Callable
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
EXCEPTIONS = Path(__file__).parent / "exceptions.toml"
FOLDERS = (
    "analysis",
    "lammps_inputs",
    "workflows",
    "plugins",
    "extensions",
    "reproductions",
    "docs",
    "tests",
)
MOST_COLUMNS = 100
COMPLEXITY = ("C901", "PLR0912", "PLR0915")  # rules of ruff, with the limits in pyproject.toml

Comprehension = ast.ListComp | ast.SetComp | ast.DictComp | ast.GeneratorExp


def is_tuple_assignment(node: ast.AST) -> bool:
    """Return True for a tuple of values assigned to as many names; swaps are excepted."""
    if not isinstance(node, ast.Assign) or not isinstance(node.value, ast.Tuple):
        return False
    target = node.targets[0]
    if not isinstance(target, ast.Tuple) or len(target.elts) != len(node.value.elts):
        return False
    return not names_in(target) & names_in(node.value)


def names_in(node: ast.AST) -> set[str]:
    """Names, and attributes with their owners, in an expression."""
    parts = (ast.Name, ast.Attribute, ast.Subscript)
    return {ast.unparse(part) for part in ast.walk(node) if isinstance(part, parts)}


def is_product_with_truth(node: ast.AST) -> bool:
    """Return True for a text, list or tuple multiplied by a comparison or a negation."""
    if not isinstance(node, ast.BinOp) or not isinstance(node.op, ast.Mult):
        return False
    sides = (node.left, node.right)
    return any(map(is_sequence, sides)) and any(map(is_truth, sides))


def is_sequence(node: ast.AST) -> bool:
    """Return True for a literal text, list or tuple."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, str)
    return isinstance(node, ast.List | ast.Tuple | ast.JoinedStr)


def is_truth(node: ast.AST) -> bool:
    """Return True for a comparison, ``and``, ``or``, ``not x`` or ``bool(x)``."""
    if isinstance(node, ast.UnaryOp):
        return isinstance(node.op, ast.Not)
    if isinstance(node, ast.Call):
        return ast.unparse(node.func) == "bool"
    return isinstance(node, ast.Compare | ast.BoolOp)


def is_nested_comprehension(node: ast.AST) -> bool:
    """Return True for a comprehension with two loops, or with another comprehension inside."""
    if not isinstance(node, Comprehension):
        return False
    inner = [part for part in ast.walk(node) if isinstance(part, Comprehension)]
    return len(node.generators) > 1 or len(inner) > 1


def is_long_conditional(node: ast.AST) -> bool:
    """Return True for a conditional expression of several lines, or with another inside."""
    if not isinstance(node, ast.IfExp):
        return False
    arms = (node.body, node.orelse)
    return node.end_lineno != node.lineno or any(isinstance(arm, ast.IfExp) for arm in arms)


RULES: dict[str, Callable[[ast.AST], bool]] = {
    "tuple_assignments": is_tuple_assignment,
    "products_with_truth": is_product_with_truth,
    "nested_comprehensions": is_nested_comprehension,
    "long_conditionals": is_long_conditional,
}
LONG_LINES = "long_lines"


def python_files() -> list[Path]:
    """Python files of the repository."""
    return sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py"))


def name_of(path: Path) -> str:
    """Path from the root of the repository."""
    return path.relative_to(ROOT).as_posix()


def violations(path: Path) -> dict[str, list[int]]:
    """Lines of a file that break each rule."""
    text = path.read_text(encoding="utf-8")
    lines = broken_lines(ast.parse(text))
    lines[LONG_LINES] = [
        number
        for number, line in enumerate(text.splitlines(), start=1)
        if len(line) > MOST_COLUMNS and "fmt: skip" not in line
    ]
    return {rule: numbers for rule, numbers in lines.items() if numbers}


def broken_lines(tree: ast.AST) -> dict[str, list[int]]:
    """Lines of a syntax tree that break each rule."""
    lines: dict[str, list[int]] = {rule: [] for rule in RULES}
    for node in ast.walk(tree):
        for rule, breaks in RULES.items():
            if breaks(node):
                lines[rule].append(node.lineno)
    return {rule: sorted(numbers) for rule, numbers in lines.items()}


def public_classes() -> dict[str, list[str]]:
    """Public names of classes of the packages, each with the files that define it."""
    places: dict[str, list[str]] = {}
    for folder in FOLDERS[:5]:
        for path in sorted((ROOT / folder).rglob("*.py")):
            for node in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                    places.setdefault(node.name, []).append(name_of(path))
    return places


def complex_functions() -> dict[str, list[str]]:
    """Functions that ruff finds too complex, by file."""
    command = [sys.executable, "-m", "ruff", "check", "--select", ",".join(COMPLEXITY)]
    command += ["--output-format", "json", "--exit-zero", "--no-cache", *FOLDERS]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    functions: dict[str, set[str]] = {}
    for fault in json.loads(done.stdout):
        path = Path(fault["filename"])
        name = function_at(path, fault["location"]["row"])
        functions.setdefault(name_of(path), set()).add(name)
    return {path: sorted(names) for path, names in sorted(functions.items())}


def function_at(path: Path, row: int) -> str:
    """Name of the function whose definition is in a line of a file."""
    line = path.read_text(encoding="utf-8").splitlines()[row - 1]
    return line.split("def ", 1)[1].split("(", 1)[0].strip()


def exceptions() -> dict[str, dict]:
    """Content of `EXCEPTIONS`."""
    return tomllib.loads(EXCEPTIONS.read_text(encoding="utf-8"))


@cache
def counts() -> dict[str, dict[str, int]]:
    """Number of violations of each rule in each file."""
    table: dict[str, Counter[str]] = {rule: Counter() for rule in (*RULES, LONG_LINES)}
    for path in python_files():
        for rule, numbers in violations(path).items():
            table[rule][name_of(path)] = len(numbers)
    return {rule: dict(sorted(files.items())) for rule, files in table.items()}


def write_exceptions() -> None:
    """Write the list of exceptions again; its reasons are kept."""
    accepted = exceptions().get("accepted", {}) if EXCEPTIONS.is_file() else {}
    lines = [
        "# Written by `python -m tests.house.rules`, but for [accepted]; each list only shrinks.",
        "",
        "[accepted]  # functions that stay complex, with the reason",
    ]
    lines += [f'"{function}" = {json.dumps(reason)}' for function, reason in accepted.items()]
    lines += ["", "[complex_functions]  # to be taken apart"]
    for path, names in complex_functions().items():
        left = [name for name in names if f"{path}:{name}" not in accepted]
        if left:
            lines.append(f'"{path}" = {json.dumps(left)}')
    lines += ["", "[classes]  # names that stand in several files"]
    for name, paths in sorted(public_classes().items()):
        if len(paths) > 1:
            lines.append(f"{name} = {len(paths)}")
    for rule, files in counts().items():
        lines += ["", f"[{rule}]"]
        lines += [f'"{path}" = {count}' for path, count in files.items()]
    EXCEPTIONS.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    write_exceptions()
