"""JSON Schema (2020-12) of the files that a user writes, made of the records of their keys; editors
complete from it.

What a field says of its values is there: types, bounds, words. What concerns several keys is not:
``granwave check`` says that. Where a key has a reader of its own, its schema is as wide as the
types that this reader, its example and its description name.
"""

from __future__ import annotations

import contextlib
import re
import tomllib
from functools import cache
from typing import Any

from granwave import __version__
from granwave.lammps_inputs.case.case import OPTIONAL, RECORD
from granwave.lammps_inputs.case.material import MATERIALS, presets
from granwave.workflows.cli.keys import CASE, FILES, TITLES, Key, Table, tables, type_of

DIALECT = "https://json-schema.org/draft/2020-12/schema"
#: Signs in the description of the accepted values that tell a type; words do where no reader can be asked.
_SIGNS = {"object": ("{",), "array": ("[", "list"), "string": ('"',)}
_WORDS = {"object": ("table",), "string": ("name", "path")}
_MAY_BE_MISSING = (*OPTIONAL, "partner", "ranks", "uncertainty", "search", "slurm")
#: Required keys that something else may give: a preset, the first sphere, the table of grains.
_NOT_ALWAYS = re.compile(r"(material|partner)\..*|packing\.(size|diameter)")

Schema = dict[str, Any]


@cache
def schema_of(file: str) -> Schema:
    """Return the JSON Schema of a kind of files, one of `granwave.workflows.cli.keys.FILES`."""
    assert file in FILES
    found = [table for table in tables() if table.file == file]
    root = _object(next((table for table in found if not table.heading), None))
    for table in sorted((one for one in found if one.heading), key=lambda one: one.name.count(".")):
        _put(root, table, table.name.split("."))
    if "material" in root["properties"]:
        of_material = [
            one for one in tables() if one.name == "material"
        ]  # first that of cases, which others share
        root["$defs"] = {
            "material": _object(
                next((one for one in of_material if one.file == file), of_material[0])
            )
        }
        root["properties"]["material"] = _MATERIAL
    if file == CASE:
        root["properties"][MATERIALS] = {
            "type": "object",
            "additionalProperties": {"$ref": "#/$defs/material"},
        }
        root["properties"][RECORD] = {
            "type": "object",
            "description": "derived values of a run; ignored",
        }
    return {
        "$schema": DIALECT,
        "$comment": f"granwave {__version__}",
        "title": TITLES[file],
        **root,
    }


_MATERIAL: Schema = {
    "description": "the name of a material, or a table of its values",
    "anyOf": [{"enum": sorted(presets())}, {"type": "string"}, {"$ref": "#/$defs/material"}],
}


def _put(root: Schema, table: Table, path: list[str]) -> None:
    """Enter a table below the tables, or keys that may be tables, of its dotted name."""
    here = root
    for name in path[:-1]:
        here = _table_of(here, name)
    made = _object(table)
    name = path[-1]
    if table.heading.startswith("[["):
        made = {"type": "array", "items": made, "description": table.description}
    elif here is root and made.get("required") and name not in _MAY_BE_MISSING:
        root.setdefault("required", []).append(name)
    there = here["properties"].get(name)
    here["properties"][name] = (
        {"anyOf": [there, made], "description": table.description} if there else made
    )


def _table_of(parent: Schema, name: str) -> Schema:
    """Return the table of a name; a key that takes other values too gets one beside these, with a
    material.
    """
    there = parent["properties"].setdefault(name, _object(None))
    if "properties" in there:
        return there  # type: ignore[no-any-return]
    kinds = there.get("anyOf", [])
    if not kinds or "properties" not in kinds[-1]:
        words = {key: there.pop(key) for key in ("enum", "type") if key in there}
        kinds = there["anyOf"] = [words, _object(None) | {"properties": {"material": _MATERIAL}}]
    return kinds[-1]  # type: ignore[no-any-return]


def _object(table: Table | None) -> Schema:
    found: Schema = {"type": "object", "additionalProperties": False, "properties": {}}
    if table is None:
        return found
    found["description"] = table.description
    found["properties"] = {key.name: _of_key(key) for key in table.keys}
    required = [
        key.name
        for key in table.keys
        if key.required and not _NOT_ALWAYS.fullmatch(f"{table.name}.{key.name}")
    ]
    return found | ({"required": required} if required else {})


def _of_key(key: Key) -> Schema:
    """Return the schema of the values of a key, with what is known of it in words."""
    if key.name == "material" and "table" in key.accepts:
        return dict(_MATERIAL)
    unit = f", {key.unit}" if key.unit else ""
    found: Schema = {
        "description": f"{key.description}{unit}; {key.accepts}",
        "examples": [_value(key.example)],
    }
    found |= key.json
    if not isinstance(key.json.get("type"), str):
        told = [_SIGNS, *([] if key.json else [_WORDS])]
        wide = {
            kind
            for signs in told
            for kind, words in signs.items()
            if any(word in key.accepts for word in words)
        }
        wide |= {type_of(_value(key.example)), *found.pop("type", ())}
        found |= {} if key.json.keys() - {"type"} else {"type": sorted(wide)}
    with contextlib.suppress(tomllib.TOMLDecodeError):  # of defaults in words
        found |= {"default": _value(f"{key.name} = {key.default}")} if key.default else {}
    return found


def _value(written: str) -> Any:
    """Return the value of ``key = value``."""
    ((_, value),) = tomllib.loads(written).items()
    return value
