"""Report as one self-contained HTML page with style, script and pictures."""

from __future__ import annotations

import base64
import hashlib
from functools import cache
from pathlib import Path

import jinja2
from markupsafe import Markup, escape

from granwave.analysis.document.model import Report

_TEMPLATES = Path(__file__).with_name("templates")


def html_page(report: Report) -> str:
    """Return the page; its Content-Security-Policy allows only its own script, style and embedded pictures."""
    css, script = _text("report.css"), _text("report.js")
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
    page = _template().render(report=report, titles=titles, css=Markup(css), script=Markup(script), policy=policy)
    return page.lstrip()


def data_uri(png: bytes) -> str:
    """Return the data URI of a picture."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def breakable(name: str) -> Markup:
    """Allow line breaks after dots and underscores of a key."""
    text = str(escape(name))
    return Markup(text.replace(".", ".<wbr>").replace("_", "_<wbr>"))


@cache
def _template() -> jinja2.Template:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["data_uri"] = data_uri
    environment.filters["breakable"] = breakable
    return environment.get_template("report.html.j2")


@cache
def _text(name: str) -> str:
    return (_TEMPLATES / name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")
