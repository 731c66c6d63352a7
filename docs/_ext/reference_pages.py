"""Pages of the reference whose tables are generated from the code, kept as plain Markdown.

    python docs/_ext/reference_pages.py      # writes the tables of all pages again

A table stands between ``<!-- NAME: ARGUMENT -->`` and ``<!-- /NAME -->`` of its page, for readers
of the repository; the site shows the same table with links. A test compares the pages with the
code.
"""

from __future__ import annotations

import re
from pathlib import Path

from reference_parts import MARK, PARTS, ROOT, part_of

from granwave.lammps_inputs.files import replace_text

FOLDER = ROOT / "docs"
#: Parts that only Sphinx can show.
_OF_THE_BUILD = ("interface",)
_GENERATED = ("reference/styles", "gallery/studies")  # folders that the build writes
_ANCHOR = re.compile(r"^\(.+\)=\n", re.MULTILINE)
_TERM = re.compile(r"^(?:\[(?P<linked>\*\*`[^`]+`\*\*)\]\{#[\w-]+\}|(?=`))(?P<rest>.*)\n: ", re.MULTILINE)  # fmt: skip
_ENTRY = re.compile(r"\{entry\}`[^`]*`")
_CELL = re.compile(r"^\| \[(`[^`]+`)\]\{#[\w-]+\}", re.MULTILINE)
_USAGE = re.compile(r"^```\{code-block\} text\n:class: usage\n\n", re.MULTILINE)


def plain(text: str) -> str:
    """Return Markdown of MyST without its anchors, entries of the index, options of blocks and
    lists of definitions."""
    text = _CELL.sub(r"| \1", _ENTRY.sub("", _ANCHOR.sub("", text)))
    text = _USAGE.sub("```text\n", text)
    return _TERM.sub(lambda term: f"* {term['linked'] or ''}{term['rest']}  \n  ", text)


def filled(text: str) -> str:
    """Return the text of a page with all its tables generated anew from the code."""

    def block(mark: re.Match[str]) -> str:
        if not is_kept(mark):
            return mark[0]
        head = mark[0].partition("\n")[0]
        return f"{head}\n\n{plain(part_of(mark)).strip()}\n\n<!-- /{mark['name']} -->"

    return MARK.sub(block, text)


def is_kept(mark: re.Match[str]) -> bool:
    """Return True for the mark of a table that is kept in the page itself."""
    return mark["name"] in PARTS and mark["name"] not in _OF_THE_BUILD


def pages() -> list[Path]:
    """Return the pages that have such a table."""
    marked = []
    for page in sorted(FOLDER.rglob("*.md")):
        generated = page.parent.relative_to(FOLDER).as_posix() in _GENERATED
        text = page.read_text(encoding="utf-8")
        if not generated and any(map(is_kept, MARK.finditer(text))):
            marked.append(page)
    return marked


if __name__ == "__main__":
    for path in pages():
        replace_text(path, filled(path.read_text(encoding="utf-8")))
