"""Names of ``import granwave`` for type checkers, with those of our extensions."""

from __future__ import annotations

import ast
from pathlib import Path

import granwave as gw
from granwave.lammps_inputs.extensions import added_by_name


def names_for_types() -> tuple[list[str], list[str]]:
    """Names that the package imports for type checkers, and its __all__ for them."""
    tree = ast.parse(Path(gw.__file__).read_text(encoding="utf-8"))
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    imported = [
        alias.name
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    ]
    (listed,) = (node.value for node in block.body if isinstance(node, ast.Assign))
    return sorted(imported), ast.literal_eval(listed)


def test_types_see_what_is_there():
    """The names for type checkers are those of the module, with those of our extensions."""
    imported, listed = names_for_types()
    assert imported == listed == gw.__all__
    assert set(added_by_name("python")) <= set(listed)
    assert set(gw.__all__) <= set(dir(gw))
