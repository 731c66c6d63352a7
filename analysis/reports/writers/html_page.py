"""Report as one self-contained HTML page with style, script and pictures."""

from __future__ import annotations

import base64
import hashlib

from markupsafe import Markup, escape

from granwave.analysis.document.model import Report
from granwave.analysis.reports.writers.template_files import Filters, template, text_of


def html_page(report: Report) -> str:
    """Return the page; its Content-Security-Policy allows only its own script, style and embedded pictures."""
    css, script = text_of("report.css"), text_of("report.js")
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
    filters: Filters = {"data_uri": data_uri, "breakable": breakable}
    form = template("report.html.j2", escapes=True, filters=filters)
    page = form.render(report=report, titles=titles, css=Markup(css), script=Markup(script), policy=policy)
    return page.lstrip()


def data_uri(png: bytes) -> str:
    """Return the data URI of a picture."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def breakable(name: str) -> Markup:
    """Allow line breaks after dots and underscores of a key."""
    text = str(escape(name))
    return Markup(text.replace(".", ".<wbr>").replace("_", "_<wbr>"))


def _hash(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")
