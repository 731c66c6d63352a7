"""Pictures and code of the pages, for narrow screens.

A picture is a link to its file, so that a click or a tap enlarges it. Names in code may break after
an underscore, a dot and a slash, and not within a word.
"""

from __future__ import annotations

import re
from typing import Any

from sphinx.application import Sphinx

_TAG = re.compile(r"<(?P<name>/?a|img)\b[^>]*>")
_SOURCE = re.compile(r'\bsrc="([^":]+)"')  # a file of the site
_CODE = re.compile(r'(?<=<span class="pre">)[^<]+(?=</span>)')
_BREAK = re.compile(r"(?<=[A-Za-z])([_./])(?=\w)")


def with_linked_pictures(body: str) -> str:
    """Return a page with a link to the file around each picture that is not in a link."""
    parts: list[str] = []
    end = 0
    is_in_link = False
    for tag in _TAG.finditer(body):
        name = tag["name"]
        if name != "img":
            is_in_link = name == "a"
            continue
        source = _SOURCE.search(tag[0])
        if is_in_link or source is None:
            continue
        parts.append(body[end : tag.start()])
        parts.append(f'<a class="picture" href="{source[1]}">{tag[0]}</a>')
        end = tag.end()
    return "".join(parts) + body[end:]


def with_breaks(body: str) -> str:
    """Return a page whose code may break after separators within names."""
    return _CODE.sub(lambda code: _BREAK.sub(r"\1<wbr>", code[0]), body)


def _change(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    if doctree is not None and "body" in context:
        context["body"] = with_breaks(with_linked_pictures(context["body"]))


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the extension."""
    app.connect("html-page-context", _change)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
