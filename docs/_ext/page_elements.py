"""Pictures and code of the pages, for narrow screens.

A picture is a link to its file, so that a click or a tap enlarges it. A picture that is wider than
a telephone scrolls sideways in a box of its own, in the width at which its letters can be read.
Names in code may break after an underscore, a dot and a slash, and not within a word.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from PIL import Image
from sphinx.application import Sphinx

_TAG = re.compile(r"<(?P<name>/?a|img)\b[^>]*>")
_SOURCE = re.compile(r'\bsrc="([^":]+)"')  # a file of the site
_CODE = re.compile(r'(?<=<span class="pre">)[^<]+(?=</span>)')
#: Pixels: width of a picture that fits a telephone, and least width of a wider one.
NARROW = 450
LEAST = 600
#: Width at which the letters of a wide picture can be read, divided by its own width.
READABLE = 0.55
_BREAK = re.compile(r"(?<=[A-Za-z])([_./])(?=\w)")


def readable_width(width: int) -> int:
    """Return the width at which a picture of some width in pixels is shown on a narrow screen; 0 if
    it fits.
    """
    if width <= NARROW:
        return 0
    return min(width, max(LEAST, round(READABLE * width)))


def with_linked_pictures(body: str, width_of: Callable[[str], int] = lambda source: 0) -> str:
    """Return a page with a link to the file around each picture that is not in a link.

    Parameters
    ----------
    width_of
        Width in pixels of a picture by its address on the page; 0 if it is not known.
    """
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
        kind = 'class="picture"'
        if width := readable_width(width_of(source[1])):
            kind = f'class="picture wide" style="--readable: {width}px"'
        parts.append(f'<a {kind} href="{source[1]}">{tag[0]}</a>')
        end = tag.end()
    return "".join(parts) + body[end:]


def with_breaks(body: str) -> str:
    """Return a page whose code may break after separators within names."""
    return _CODE.sub(lambda code: _BREAK.sub(r"\1<wbr>", code[0]), body)


def _widths(app: Sphinx) -> Callable[[str], int]:
    """Return the function that returns the width of a picture of the site."""
    files = {name: Path(app.srcdir) / path for path, name in app.builder.images.items()}

    def width_of(source: str) -> int:
        path = files.get(source.rpartition("/")[2])
        if path is None or not path.is_file() or path.suffix == ".svg":
            return 0
        with Image.open(path) as picture:
            if getattr(picture, "is_animated", False):  # the eye follows the whole of it
                return 0
            return int(picture.width)

    return width_of


def _change(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    if doctree is not None and "body" in context:
        context["body"] = with_breaks(with_linked_pictures(context["body"], _widths(app)))


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the extension."""
    app.connect("html-page-context", _change)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
