"""Tables of a design file, for ``granwave keys``."""

from __future__ import annotations

from granwave.extensions.design.search.problem import DESIGN_TABLES
from granwave.workflows.cli.keys.sections import Sections


def design_sections() -> Sections:
    """Return the tables."""
    return DESIGN_TABLES
