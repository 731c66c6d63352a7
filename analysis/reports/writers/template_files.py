"""Templates of reports: a file for each format in the folder ``templates``, and the files that go into them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import jinja2

from granwave.analysis.document.model import Column

Filters = Mapping[str, Callable[..., Any]]  # by the name in a template
_FOLDER = Path(__file__).with_name("templates")


def template(name: str, *, escapes: bool, filters: Filters) -> jinja2.Template:
    """Read a template, in which an unknown name is an error.

    Parameters
    ----------
    escapes
        True if all texts are escaped for HTML.
    filters
        Functions that it applies to texts and parts of a report.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_FOLDER),
        autoescape=escapes,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters.update({"heading": _heading, **filters})
    return environment.get_template(name)


def text_of(name: str) -> str:
    """Return the text of a file of the folder."""
    return (_FOLDER / name).read_text(encoding="utf-8")


def _heading(column: Column) -> str:
    """Return the heading of a column with its unit."""
    return f"{column.heading} ({column.unit})" if column.unit else column.heading
