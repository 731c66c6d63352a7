"""What varies in a scan, as its tables and figures show it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from granwave.analysis.scan_result import Scalar


def label_of(key: str, value: Any) -> Scalar:
    """A setting as tables and figures show it.

    Parameters
    ----------
    key
        Dotted name of what varies.
    value
        Of the point, as in a case file: a table becomes text, materials and bottoms in words.
    """
    if isinstance(value, bool | int | float | str):
        return value
    if key == "material" and isinstance(value, Mapping):
        named = value.get("name") or value.get("preset")
        if named:
            others = {k: v for k, v in value.items() if k not in ("name", "preset")} if "preset" in value else {}
            return " ".join([str(named), *(f"{k}={v}" for k, v in others.items())])
    if key == "boundary.bottom" and isinstance(value, Mapping):
        rest_on: dict[str, Any] = {} if set(value) - {"material"} else {"wall": {}}
        return ", ".join(_words(name, part) for name, part in (rest_on | dict(value)).items())
    return json.dumps(value, ensure_ascii=False)


def _words(name: str, value: Any) -> str:
    """A part of a bottom, such as ``plate mass=5 stiffness=5e+09``; its material by name."""
    if name == "material":
        return str(label_of(name, value))
    parts = value.items() if isinstance(value, Mapping) else [("", value)]
    texts = [f"{key}={part:g}" if isinstance(part, float) else f"{key}={part}" for key, part in parts]
    return " ".join([name, *texts])
