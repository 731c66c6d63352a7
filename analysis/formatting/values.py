"""Labels of values of a case that are tables, for results and legends: ``plate mass=5 stiffness=5e9, steel``.

The label of a scan's point may hold such a value as JSON; it is empty if the case of the point lacks the key.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from granwave.analysis.formatting.numbers import plain

NONE = "none"
_NAMES = ("preset", "name")  # keys that identify a material


def as_label(value: Any) -> str:
    """Return the label of a value of a case, or of the JSON text of such a value."""
    if isinstance(value, str):
        value = _parsed(value)
    if isinstance(value, Mapping):
        parts = value if set(value) != {"material"} else {"wall": {}, **value}  # a table with a material only is a wall
        return _material(value) or ", ".join(_part(name, part) for name, part in parts.items()) or NONE
    if isinstance(value, list | tuple) and any(isinstance(part, Mapping) for part in value):
        return "; ".join(map(as_label, value))
    return _text(value) or NONE


def unique_labels(values: Sequence[Any]) -> list[str]:
    """Return a label for each value; different values get different labels, by a number if necessary."""
    labels: dict[str, str] = {}
    keys = [json.dumps(value, sort_keys=True, default=str) for value in values]
    for key, value in zip(keys, values, strict=True):
        if key not in labels:
            text = shown = as_label(value)
            number = 1
            while shown in labels.values():
                number += 1
                shown = f"{text} ({number})"
            labels[key] = shown
    return [labels[key] for key in keys]


def _parsed(label: str) -> Any:
    """Parse a label that holds a table or tables as JSON; return others unchanged."""
    if not label.startswith(("{", "[{")):
        return label
    try:
        return json.loads(label)
    except ValueError:
        return label


def _part(name: str, value: Any) -> str:
    if isinstance(value, Mapping):
        material = _material(value)
        return material or " ".join([name, *(_part(key, part) for key, part in value.items())])
    return str(value) if name == "material" else f"{name}={_text(value)}"


def _material(table: Mapping[str, Any]) -> str:
    """Return the label of a material: its name and the changes of a preset; empty for other tables."""
    name = next((str(table[key]) for key in _NAMES if table.get(key)), "")
    changed = {key: part for key, part in table.items() if key not in _NAMES} if "preset" in table else {}
    return " ".join([name, *(_part(key, part) for key, part in changed.items())]) if name else ""


def _text(value: Any) -> str:
    if isinstance(value, bool | list | tuple):
        return json.dumps(value, ensure_ascii=False)
    return plain(f"{value:.6g}") if isinstance(value, float) else str(value)
