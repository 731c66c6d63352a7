"""Headings of groups in the menu of the site.

Furo shows the captions of tables of contents on the first page only. This extension also shows the
captions of the other pages: above the first page of each group, in the menu at the left.
"""

from __future__ import annotations

import html
import re
from typing import Any

from sphinx import addnodes
from sphinx.application import Sphinx

_MENU = "furo_navigation_tree"
_AFTER_FURO = 900  # priority of the event; 500 is the default


def groups(app: Sphinx) -> dict[str, str]:
    """Return the captions of groups by the name of their first page, without the first page's."""
    found = {}
    for page in app.env.toctree_includes:
        if page == app.config.root_doc:
            continue
        for contents in app.env.get_doctree(page).findall(addnodes.toctree):
            if contents["caption"] and contents["entries"]:
                _, first = contents["entries"][0]
                found[first] = contents["caption"]
    return found


def add_groups(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: Any
) -> None:
    """Put the captions of the groups into the menu of a page."""
    menu = context.get(_MENU)
    if menu is None:
        return
    for first, caption in app.menu_groups.items():  # type: ignore[attr-defined]
        link = "#" if first == page else app.builder.get_relative_uri(page, first)
        entry = re.compile(rf'<li class="toctree-l2[^>]*><a [^>]*href="{re.escape(link)}"')
        heading = f'<li class="menu-group">{html.escape(caption)}</li>'
        found = entry.search(menu)
        if found:
            menu = f"{menu[: found.start()]}{heading}{menu[found.start() :]}"
    context[_MENU] = menu


def _read_groups(app: Sphinx, environment: Any) -> None:
    app.menu_groups = groups(app)  # type: ignore[attr-defined]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the extension."""
    app.connect("env-updated", _read_groups)
    app.connect("html-page-context", add_groups, priority=_AFTER_FURO)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
