"""Report as Markdown, with tables of GitHub's form and pictures as files, by the template ``report.md.j2``."""

from __future__ import annotations

import re
from urllib.parse import quote

from granwave.analysis.document.model import Figure, Report
from granwave.analysis.reports.writers.template_files import Filters, template

_SPECIAL = re.compile(r"([\\`*_\[\]|~#$])")
_LINE_START = re.compile(r"^(\d*)([-+.)])(?=\s)")  # what a list begins with
_BLANK_LINES = re.compile(r"\n{3,}")


def markdown(report: Report, folder: str) -> tuple[str, dict[str, bytes]]:
    """Return the text, and the pictures by file name.

    Parameters
    ----------
    folder
        Name of the directory of the pictures beside the text.
    """
    pictures: dict[str, bytes] = {}

    def file(figure: Figure) -> str:
        """Keep the picture of a figure, and return its path from the text."""
        name, number = f"{figure.name}.png", 2
        while name in pictures and pictures[name] != figure.png:
            name, number = f"{figure.name}-{number}.png", number + 1
        pictures[name] = figure.png
        return f"{quote(folder)}/{name}"

    anchors = {
        section.slug: section.title.lower().replace(" ", "-") for section in report.sections
    }  # as GitHub has them
    titles = {section.slug: section.title for section in report.sections}
    filters: Filters = {"escaped": _escape, "paragraph": _paragraph, "file": file}
    text = template("report.md.j2", escapes=False, filters=filters).render(
        report=report, titles=titles, anchors=anchors
    )
    return _BLANK_LINES.sub("\n\n", text).strip() + "\n", pictures


def _paragraph(text: str) -> str:
    return _LINE_START.sub(r"\1\\\2", _escape(text))


def _escape(text: str) -> str:
    """Escape markup in a text, and put it on one line."""
    text = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return _SPECIAL.sub(r"\\\1", " ".join(text.split()))
