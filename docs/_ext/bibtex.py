"""BibTeX entries of CITATION.cff: the program, and the works that are to be cited with it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import yaml

Work = Mapping[str, Any]
_ENTRY = {"software": "software", "article": "article", "thesis": "phdthesis"}
_FIELDS = {  # fields of BibTeX, and the corresponding keys of CFF
    "journal": ("journal",),
    "school": ("institution", "name"),
    "year": ("year",),
    "volume": ("volume",),
    "pages": ("start",),
    "version": ("version",),
    "doi": ("doi",),
}
_SPECIAL = re.compile(r"([&%$#_])")


def bibtex(citation: str) -> str:
    """Return the entries of a citation file, the program first.

    Raises
    ------
    ValueError
        The type of a work has no corresponding kind of entry.
    """
    program = yaml.safe_load(citation)
    return "\n\n".join(map(_entry, [program, *program.get("references", [])]))


def _entry(work: Work) -> str:
    if work["type"] not in _ENTRY:
        raise ValueError(
            f"CITATION.cff: found type {work['type']}, expected one of: {', '.join(_ENTRY)}"
        )
    found = {
        "author": " and ".join(map(_author, work["authors"])),
        "title": f"{{{_escape(work['title'])}}}",
    }
    if released := work.get("date-released"):
        found["year"] = str(released.year)
    found |= {
        field: _escape(value)
        for field, keys in _FIELDS.items()
        if (value := _value(work, keys)) is not None
    }
    width = max(map(len, found))
    lines = [f"  {field:<{width}} = {{{value}}}," for field, value in found.items()]
    return "\n".join([f"@{_ENTRY[work['type']]}{{{_name(work)},", *lines, "}"])


def _value(work: Work, keys: Sequence[str]) -> object:
    value: Any = work
    for key in keys:
        value = value.get(key) if isinstance(value, Mapping) else None
    return value


def _author(author: Work) -> str:
    if "family-names" in author:
        return f"{_escape(author['family-names'])}, {_escape(author['given-names'])}"
    return f"{{{_escape(author['name'])}}}"  # braces: no person's name


def _name(work: Work) -> str:
    """Return the name of an entry: the name of the program, or first author and year."""
    if work["type"] == "software":
        return str(work["title"]).partition(":")[0]
    return re.sub(r"\W", "", work["authors"][0]["family-names"].lower()) + str(work["year"])


def _escape(value: object) -> str:
    return _SPECIAL.sub(r"\\\1", str(value))
