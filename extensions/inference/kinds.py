"""Kind of the files that describe measured grains."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from granwave.workflows.file_kinds import FileKind


def _is_inference(tables: Mapping[str, Any]) -> bool:
    return "infer" in tables and "packing" not in tables


FILE_KINDS = (
    FileKind(
        "inference",
        "Cases of inferred forces (granwave infer --case)",
        "granwave.extensions.inference.key_sections:inference_sections",
        recognises=_is_inference,
        noun="a case of inferred forces",
        command="infer GRAINS.csv --case",
        after="profile",
    ),
)
