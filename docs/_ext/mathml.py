"""Equations of the site as MathML, which a browser shows without a script or a network."""

from __future__ import annotations

import html
import re

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.writers.html5 import HTML5Translator


def mathml_of(formula: str, display: str) -> str:
    """Return a formula as MathML; ``display`` is inline or block.

    Raises
    ------
    ExtensionError
        The formula cannot be read, or contains a command or an alignment mark that the converter
        copies as text.
    """
    # a bar is a fence only with left or right; otherwise it has the space of an operator
    fenced = re.sub(r"\\lvert\b", r"\\left\\vert ", formula)
    fenced = re.sub(r"\\rvert\b", r"\\right\\vert ", fenced)
    try:
        mathml = convert(fenced, display=display)
    except Exception as error:
        raise ExtensionError(f"the formula {formula!r} cannot be read: {error}") from error
    copied = re.findall(r"&|\\[A-Za-z]*", html.unescape(re.sub(r"<[^>]*>", " ", mathml)))
    if copied:
        raise ExtensionError(
            f"the formula {formula!r} would be shown with {', '.join(copied)} as text; "
            "write it without them, several equations as displayed formulas of their own"
        )
    return mathml


def visit_inline(writer: HTML5Translator, node: nodes.math) -> None:
    """Write an inline formula."""
    writer.body.append(mathml_of(node.astext(), "inline"))
    raise nodes.SkipNode


def visit_display(writer: HTML5Translator, node: nodes.math_block) -> None:
    """Write a displayed formula."""
    anchor = "".join(f' id="{html.escape(name)}"' for name in node["ids"][:1])
    writer.body.append(f'<div class="math"{anchor}>{mathml_of(node.astext(), "block")}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer with Sphinx."""
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
