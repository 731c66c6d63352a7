"""House figures: density of the Python code of packages, to be compared with other projects.

``python -m tests.house.figures [DIRECTORY ...]`` prints a table of the packages of this repository
and of the named directories, such as an unpacked wheel. Tests in the named directories count too.
Python 3.12 and later split an f-string into several tokens, so compare tables of the same Python.
"""

from __future__ import annotations

import argparse
import ast
import dataclasses
import io
import json
import subprocess
import sys
import tokenize
from collections.abc import Iterable, Iterator
from pathlib import Path

from tests.house.rules import ROOT, is_tuple_assignment

PACKAGES = (
    "lammps_inputs",
    "analysis",
    "workflows",
    "plugins",
    "extensions",
    "reproductions",
    "tests",
    "docs",
)
CORE = PACKAGES[:5]  # installed
COLUMNS_OF_OTHERS = 88  # the longest line of most projects
MOST_COMPLEXITY = 10

_LAYOUT = {
    tokenize.COMMENT,
    tokenize.DEDENT,
    tokenize.ENCODING,
    tokenize.ENDMARKER,
    tokenize.INDENT,
    tokenize.NEWLINE,
    tokenize.NL,
}
_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
_FUNCTION = (ast.FunctionDef, ast.AsyncFunctionDef)


@dataclasses.dataclass
class CodeCounts:
    """Counts of some Python files.

    Attributes
    ----------
    lines
        All lines.
    code_lines
        Lines with a token, docstrings and comments excepted.
    tokens
        Tokens, docstrings, comments and ends of lines excepted.
    statements
        Statements, docstrings excepted.
    tuple_assignments
        Assignments of a tuple of values to as many names, swaps and recurrences excepted.
    conditionals
        Conditional expressions.
    functions, complex_functions
        Functions and methods; those of a cyclomatic complexity above `MOST_COMPLEXITY`.
    long_lines
        Lines of more than `COLUMNS_OF_OTHERS` columns.
    """

    lines: int = 0
    code_lines: int = 0
    tokens: int = 0
    statements: int = 0
    tuple_assignments: int = 0
    conditionals: int = 0
    functions: int = 0
    complex_functions: int = 0
    long_lines: int = 0

    def __add__(self, other: CodeCounts) -> CodeCounts:
        names = [field.name for field in dataclasses.fields(self)]
        return CodeCounts(*(getattr(self, name) + getattr(other, name) for name in names))


def counts_of_text(text: str) -> CodeCounts:
    """Count in the text of a module; complex functions are left at 0."""
    tree = ast.parse(text)
    docstrings = set(docstring_lines(tree))
    code_lines: set[int] = set()
    n_tokens = 0
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type in _LAYOUT or token.start[0] in docstrings:
            continue
        n_tokens += 1
        code_lines.update(range(token.start[0], token.end[0] + 1))
    nodes = list(ast.walk(tree))
    n_statements = sum(isinstance(node, ast.stmt) for node in nodes)
    lines = text.splitlines()
    return CodeCounts(
        lines=len(lines),
        code_lines=len(code_lines),
        tokens=n_tokens,
        statements=n_statements - sum(has_docstring(node) for node in nodes),
        tuple_assignments=sum(map(is_tuple_assignment, nodes)),
        conditionals=sum(isinstance(node, ast.IfExp) for node in nodes),
        functions=sum(isinstance(node, _FUNCTION) for node in nodes),
        long_lines=sum(len(line) > COLUMNS_OF_OTHERS for line in lines),
    )


def has_docstring(node: ast.AST) -> bool:
    """Return True for a module, class or function with a docstring."""
    return isinstance(node, _DOCUMENTED) and ast.get_docstring(node, clean=False) is not None


def docstring_lines(tree: ast.AST) -> Iterator[int]:
    """Lines of docstrings."""
    for node in ast.walk(tree):
        if has_docstring(node):
            docstring = node.body[0]
            yield from range(docstring.lineno, docstring.end_lineno + 1)


def python_files(directory: Path) -> list[Path]:
    """Python files of a directory and its folders."""
    return sorted(directory.rglob("*.py"))


def complex_functions(directory: Path) -> int:
    """Count the functions of a directory that are too complex for ruff."""
    command = [sys.executable, "-m", "ruff", "check", "--isolated", "--no-cache", "--exit-zero"]
    command += ["--select", "C901", "--output-format", "json"]
    command += ["--config", f"lint.mccabe.max-complexity = {MOST_COMPLEXITY}", "--ignore-noqa"]
    command += ["--no-respect-gitignore", str(directory)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return sum(fault["code"] == "C901" for fault in json.loads(done.stdout))


def counts_of(directory: Path) -> CodeCounts:
    """Count in all Python files of a directory."""
    total = CodeCounts(complex_functions=complex_functions(directory))
    for path in python_files(directory):
        total += counts_of_text(path.read_text(encoding="utf-8"))
    return total


def row(name: str, counts: CodeCounts) -> str:
    """Return the row of the table for a directory."""
    thousand_statements = counts.statements / 1000
    cells = (
        name,
        f"{counts.code_lines}",
        f"{counts.tokens / counts.code_lines:.1f}",
        f"{counts.tuple_assignments / thousand_statements:.1f}",
        f"{counts.conditionals / thousand_statements:.1f}",
        f"{100 * counts.complex_functions / counts.functions:.1f} %",
        f"{100 * counts.long_lines / counts.lines:.1f} %",
    )
    return f"| {' | '.join(cells)} |"


HEADINGS = (
    "code",
    "code lines",
    "tokens a code line",
    "tuple assignments, a thousand statements",
    "conditional expressions, a thousand statements",
    f"functions of complexity above {MOST_COMPLEXITY}",
    f"lines beyond {COLUMNS_OF_OTHERS} columns",
)


def table(others: Iterable[Path]) -> list[str]:
    """Return the lines of the table: packages of this repository, their core, and others."""
    lines = [f"| {' | '.join(HEADINGS)} |", "|---" * len(HEADINGS) + "|"]
    counts = {name: counts_of(ROOT / name) for name in PACKAGES if (ROOT / name).is_dir()}
    present = {name: count for name, count in counts.items() if count.code_lines}
    lines += [row(name, count) for name, count in present.items()]
    core = [count for name, count in present.items() if name in CORE]
    lines.append(row("all that is installed", sum(core, CodeCounts())))
    lines += [row(directory.name, counts_of(directory)) for directory in others]
    return lines


def main() -> None:
    """Print the table of this repository and of the directories that are named."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("directory", nargs="*", type=Path, help="of other packages")
    options = parser.parse_args()
    for directory in options.directory:
        if not any(directory.rglob("*.py")):
            parser.error(f"{directory}: found no Python files, expected a directory with some")
    print("\n".join(table(options.directory)))


if __name__ == "__main__":
    main()
