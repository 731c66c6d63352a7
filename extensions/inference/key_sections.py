"""Tables of a case of inferred forces, for ``granwave keys``."""

from __future__ import annotations

from granwave.extensions.inference.forces.case import InferCase
from granwave.workflows.cli.keys.sections import Sections


def inference_sections() -> Sections:
    """Return the tables."""
    return {f"[{name}]": (section, "") for name, section in InferCase.SECTIONS.items()}
