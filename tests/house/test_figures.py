"""House figures count code, not docstrings and comments."""

from __future__ import annotations

import pytest

from tests.house.figures import PACKAGES, counts_of_text, table

TEXT = '''"""Title."""

# a comment


def function(x):
    """Docstring
    of two lines.
    """
    a, b = 1, 2
    return a if x else b
'''


def test_counts_of_a_module() -> None:
    counts = counts_of_text(TEXT)
    assert counts.lines == 11
    assert counts.code_lines == 3
    assert counts.tokens == 6 + 7 + 6
    assert counts.statements == 3
    assert counts.tuple_assignments == 1
    assert counts.conditionals == 1
    assert counts.functions == 1


@pytest.mark.validation
def test_the_table_has_all_packages() -> None:
    names = [line.split(" | ")[0] for line in table([])]
    assert names[2:-1] == [f"| {name}" for name in PACKAGES]
