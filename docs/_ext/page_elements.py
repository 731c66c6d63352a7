"""Pictures and code of the pages, for narrow screens.

A picture is a link to its file, so that a click or a tap enlarges it; below a picture that is wider
than a telephone, a telephone says so. Names in code may break after an underscore, a dot and a
slash, and not within a word. A number stays on one line with its unit.
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
#: Width of a picture that fits a telephone, pixels.
NARROW = 450
_BREAK = re.compile(r"(?<=[A-Za-z])([_./])(?=\w)")
_TEXT = re.compile(
    r"<(?P<kept>pre|code|script|style|math|svg)\b.*?</(?P=kept)>|<[^>]+>|(?P<text>[^<]+)", re.DOTALL
)
_NUMBER_AND_UNIT = re.compile(
    r"(?<=\d) (?=(?:%|°|[µmkMG]?(?:m|s|N|J|g|Pa|Hz|GB)(?:/[mskg]{1,2}[²³]?)?)(?:[\s<,;.)]|$))"
)


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
        if width_of(source[1]) > NARROW:
            kind = 'class="picture wide"'
        parts.append(f'<a {kind} href="{source[1]}">{tag[0]}</a>')
        end = tag.end()
    return "".join(parts) + body[end:]


def with_breaks(body: str) -> str:
    """Return a page whose code may break after separators within names."""
    return _CODE.sub(lambda code: _BREAK.sub(r"\1<wbr>", code[0]), body)


def with_units(body: str) -> str:
    """Return a page whose text has a no-break space between a number and its unit; code and
    formulas remain as they are.
    """

    def joined(piece: re.Match[str]) -> str:
        if piece["text"] is None:
            return piece[0]
        return _NUMBER_AND_UNIT.sub("\N{NO-BREAK SPACE}", piece[0])

    return _TEXT.sub(joined, body)


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
        body = with_linked_pictures(context["body"], _widths(app))
        context["body"] = with_units(with_breaks(body))


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the extension."""
    app.connect("html-page-context", _change)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
