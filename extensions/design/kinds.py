"""Kind of the files that describe a search for a design."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from granwave.workflows.file_kinds import FileKind


def _is_design(tables: Mapping[str, Any]) -> bool:
    return "base" in tables and "variables" in tables


FILE_KINDS = (
    FileKind(
        "design",
        "Searches for a design (granwave design)",
        "granwave.extensions.design.key_sections:design_sections",
        recognises=_is_design,
        noun="a search for a design",
        command="design",
        check="granwave.extensions.design.terminal:plan_of_design",
        may_be_missing=("uncertainty", "search"),
        after="inference",
    ),
)
