"""Report as one self-contained HTML page with style, script and pictures; the PDF prints the same page."""

from __future__ import annotations

import base64
import dataclasses
import hashlib

from markupsafe import Markup, escape

from granwave.analysis.document.model import Report, Table
from granwave.analysis.reports.writers.template_files import Filters, template, text_of

_ACROSS = 12  # most columns of a table on a page of paper
_MOST_KEYS = 4  # key columns that are repeated in its parts


def html_page(report: Report, *, paper: bool = False) -> str:
    """Return the page; its Content-Security-Policy allows only its own script, style and embedded pictures.

    Parameters
    ----------
    paper
        True for the page that the PDF prints: unfolded, without script, policy and links to files.
    """
    css, script = text_of("report.css") + text_of("print.css"), text_of("report.js")
    policy = "; ".join(
        [
            "default-src 'none'",
            "img-src data:",
            f"style-src '{_hash(css)}'",
            f"script-src '{_hash(script)}'",
            "base-uri 'none'",
            "form-action 'none'",
        ]
    )
    titles = {section.slug: section.title for section in report.sections}
    filters: Filters = {"data_uri": data_uri, "breakable": breakable, "parts": parts}
    form = template("report.html.j2", escapes=True, filters=filters)
    page = form.render(report=report, titles=titles, css=Markup(css), script=Markup(script), policy=policy, paper=paper)
    return page.lstrip()


def data_uri(png: bytes) -> str:
    """Return the data URI of a picture."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def breakable(name: str) -> Markup:
    """Allow line breaks after dots and underscores of a key."""
    text = str(escape(name))
    return Markup(text.replace(".", ".<wbr>").replace("_", "_<wbr>"))


def parts(table: Table) -> list[Table]:
    """Split a table into tables that are narrow enough for paper, each with the key columns.

    The other columns are shared out evenly; the captions count the parts.
    """
    keys = [n for n, column in enumerate(table.columns) if column.key][:_MOST_KEYS]
    others = [n for n in range(len(table.columns)) if n not in keys]
    number = -(-len(others) // (_ACROSS - len(keys)))
    if number < 2:
        return [table]
    found = []
    for part in range(number):
        kept = [*keys, *others[part * len(others) // number : (part + 1) * len(others) // number]]
        found.append(
            dataclasses.replace(
                table,
                caption=f"{table.caption}, part {part + 1} of {number}",
                columns=tuple(table.columns[n] for n in kept),
                rows=tuple(tuple(row[n] for n in kept) for row in table.rows),
                captioned=True,
            )
        )
    return found


def _hash(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")
