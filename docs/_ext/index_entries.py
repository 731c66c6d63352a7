"""The role ``entry``: an entry of the index that leads to an anchor of the page, such as a row of a
table.

    {entry}`zone_depth_90_m <zone-depth-90-m>` [`zone_depth_90_m`]{#zone-depth-90-m}

The role shows nothing. The entry is a main one, so that the search lists it first.
"""

from __future__ import annotations

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.util.docutils import ReferenceRole


class Entry(ReferenceRole):
    """An entry of the index that leads to the anchor in its target."""

    def run(self) -> tuple[list[nodes.Node], list[nodes.system_message]]:
        """Return the node of the index."""
        entry = ("single", self.title, self.target, "main", None)
        return [addnodes.index(entries=[entry])], []


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the role."""
    app.add_role("entry", Entry())
    return {"parallel_read_safe": True, "parallel_write_safe": True}
