"""Values of a case that are tables, in words, for tables of results and legends: ``plate mass=5 stiffness=5e9, steel``.

A label of a scan may hold such a value as JSON; that of a point whose case lacks the key is empty text.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from granwave.analysis.formatting.numbers import plain

NONE = "none"
_NAMES = ("preset", "name")  # either says which material a table is


def as_label(value: Any) -> str:
    """A value of a case, or the label of a scan's point that stands for one."""
    if isinstance(value, str):
        value = _parsed(value)
    if isinstance(value, Mapping):
        parts = value if set(value) != {"material"} else {"wall": {}, **value}  # the only table that may say no more
        return _material(value) or ", ".join(_part(name, part) for name, part in parts.items()) or NONE
    if isinstance(value, list | tuple) and any(isinstance(part, Mapping) for part in value):
        return "; ".join(map(as_label, value))
    return _text(value) or NONE


def unique_labels(values: Sequence[Any]) -> list[str]:
    """Words for each; values that differ have different words, though only a table's main points are in them."""
    words: dict[str, str] = {}
    keys = [json.dumps(value, sort_keys=True, default=str) for value in values]
    for key, value in zip(keys, values, strict=True):
        if key not in words:
            text = shown = as_label(value)
            number = 1
            while shown in words.values():
                number += 1
                shown = f"{text} ({number})"
            words[key] = shown
    return [words[key] for key in keys]


def _parsed(label: str) -> Any:
    """The table or tables that a label holds; any other label as it is."""
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
    """A material by its name, with what is changed of a preset; empty for a table of something else."""
    name = next((str(table[key]) for key in _NAMES if table.get(key)), "")
    changed = {key: part for key, part in table.items() if key not in _NAMES} if "preset" in table else {}
    return " ".join([name, *(_part(key, part) for key, part in changed.items())]) if name else ""


def _text(value: Any) -> str:
    if isinstance(value, bool | list | tuple):
        return json.dumps(value, ensure_ascii=False)
    return plain(f"{value:.6g}") if isinstance(value, float) else str(value)
