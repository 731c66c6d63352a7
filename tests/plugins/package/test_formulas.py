"""Formulas of the manual pages in the format of LAMMPS's documentation."""

from __future__ import annotations

import importlib
import re

import pytest

from tests.helpers.manual import PAGES

PAGE = r"""# fix toy command

With $\alpha_y$ and $|x_i|*R^*$ (see `$(v_x) $y$`), $R^*$: the cost is \$5.

$$
F_y = \frac{4}{3} E^* \sqrt{R^*}\, \alpha_y^{3/2}
$$

* A list has $k_t$-values:

  $$
  \begin{split}
  a_* &= |b_i| \\
  c &= d \quad \text{if $|F_t|$}
  \end{split}
  $$

| column | quantity |
|---|---|
| $p_1$ | a sum, $\sum_i p_i$ |

```LAMMPS
variable a equal $(v_b*2) $c
```
"""
INLINE = [r"\alpha_y", "|x_i|*R^*", "R^*", "k_t", "p_1", r"\sum_i p_i"]
DISPLAYED = [
    r"F_y = \frac{4}{3} E^* \sqrt{R^*}\, \alpha_y^{3/2}",
    "\\begin{aligned}\na_* &= |b_i| \\\\\nc &= d \\quad \\text{if $|F_t|$}\n\\end{aligned}",
]


@pytest.fixture
def lammps_pages(monkeypatch):
    monkeypatch.syspath_prepend(str(PAGES.parent / "package"))
    return importlib.import_module("lammps_pages").lammps_pages


def doctree(text: str):
    core = pytest.importorskip("docutils.core")
    settings = {"report_level": 2, "halt_level": 2, "syntax_highlight": "none"}
    return core.publish_doctree(text, settings_overrides=settings)


def test_formulas_become_roles_and_directives(lammps_pages, tmp_path):
    """The characters of markup in a formula are not escaped; dollars in code stay."""
    (tmp_path / "fix_toy.md").write_text(PAGE, encoding="utf-8")
    (tmp_path / "other_commands.toml").write_text("section = []\n", encoding="utf-8")
    (text,) = lammps_pages(tmp_path).values()
    from docutils import nodes

    # docutils does not have the directive of Sphinx for the index
    tree = doctree(text.partition("\n")[2])
    assert [node.astext() for node in tree.findall(nodes.math)] == INLINE
    assert [node.astext() for node in tree.findall(nodes.math_block)] == DISPLAYED
    assert [node.astext() for node in tree.findall(nodes.literal)] == ["$(v_x) $y$"]
    assert "variable a equal $(v_b*2) $c\n" in text
    assert "the cost is $5." in tree.astext()
    assert r":math:`k_t`-values" in text


def test_every_formula_of_the_pages_is_converted(lammps_pages):
    """None is left with its dollars, outside of code. Spaces are escaped only within lines."""
    for page, text in lammps_pages(PAGES).items():
        source = (PAGES / f"{page}.md").read_text(encoding="utf-8")
        assert not re.search(r"(?m)^ *\\ ", text), page
        displayed = len(re.findall(r"^ *\$\$$", source, re.MULTILINE)) / 2
        assert text.count(".. math::\n") == displayed, page
        prose = re.sub(
            r"(?m)^( *)\.\. (code-block|parsed-literal|math)::.*\n(\1 .*\n|\n)*", "", text
        )
        assert "$" not in re.sub(r"``.*?``|:math:`.*?`", "", prose, flags=re.DOTALL), page
