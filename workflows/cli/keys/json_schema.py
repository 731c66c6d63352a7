"""JSON Schema (2020-12) of the files that a user writes, derived from the declarations of their
keys; editors use it for completion.

The schema contains the declared types of keys: bounds, words, and nested tables. It does not
contain conditions on several keys, which ``granwave check`` tests.
"""

from __future__ import annotations

import contextlib
import re
import tomllib
from functools import cache
from typing import Any

from granwave import __version__
from granwave.lammps_inputs.case.case import OPTIONAL, RECORD
from granwave.lammps_inputs.case.material import MATERIAL, MATERIALS
from granwave.lammps_inputs.case.packing.made_packing import packing_makers
from granwave.workflows.cli.keys.reference import Key, KeyTable, tables
from granwave.workflows.file_kinds import CASE_FILE, FileKind, file_kinds

DIALECT = "https://json-schema.org/draft/2020-12/schema"
#: Required keys that may be set otherwise: by a preset or the table of grains.
_NOT_ALWAYS = re.compile(r"material\..*|packing\.(size|diameter)")

Schema = dict[str, Any]


@cache
def schema_of(file: str) -> Schema:
    """Return the JSON Schema of a kind of files by its name."""
    (kind,) = (kind for kind in file_kinds() if kind.name == file)
    own = {table.name: table for table in tables() if table.file == file}
    root = _object(own.get(file), kind)
    for name, table in own.items():
        if table.heading and "." not in name and name not in root["properties"]:
            _put(root, table, kind)
    if kind == CASE_FILE:
        for name in packing_makers():
            _add_kind(root["properties"]["packing"], _object(own[f"packing.{name}"], kind))
    if "material" in root["properties"]:
        of_case = next(table for table in tables() if table.name == "material")
        root["$defs"] = {"material": _object(own.get("material", of_case), kind)}
        root["properties"]["material"] = {"description": MATERIAL.expected, **MATERIAL.json}
    if kind == CASE_FILE:
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
        "title": kind.title,
        **root,
    }


def _put(root: Schema, table: KeyTable, kind: FileKind) -> None:
    """Add a table; its nested tables are part of the types of its keys."""
    made = _object(table, kind)
    may_be_missing = (*OPTIONAL, *kind.may_be_missing)
    if table.heading.startswith("[["):
        made = {"type": "array", "items": made, "description": table.description}
    elif made.get("required") and table.name not in may_be_missing:
        root.setdefault("required", []).append(table.name)
    root["properties"][table.name] = made


def _add_kind(packing: Schema, made: Schema) -> None:
    """Add the keys of a kind of packing to the keys of other kinds; a common key accepts both
    types.
    """
    known = packing["properties"]
    for name, schema in made["properties"].items():
        known[name] = {"anyOf": [known[name], schema]} if name in known else schema


def _object(table: KeyTable | None, kind: FileKind) -> Schema:
    found: Schema = {"type": "object", "additionalProperties": False, "properties": {}}
    if table is None:
        return found
    found["description"] = table.description
    found["properties"] = {key.name: _of_key(key) for key in table.keys}
    if table.name in kind.given_elsewhere:
        return found
    required = [
        key.name
        for key in table.keys
        if key.required and not _NOT_ALWAYS.fullmatch(f"{table.name}.{key.name}")
    ]
    return found | ({"required": required} if required else {})


def _of_key(key: Key) -> Schema:
    """Return the schema of the values of a key, with its description, example and default."""
    unit = f", {key.unit}" if key.unit else ""
    found: Schema = {
        "description": f"{key.description}{unit}; {key.accepts}",
        "examples": [_value(key.example)],
        **key.json,
    }
    if key.default and key.default != "[]":  # an empty list means a missing key
        with contextlib.suppress(tomllib.TOMLDecodeError):  # defaults that are words
            found["default"] = _value(f"{key.name} = {key.default}")
    return found


def _value(written: str) -> Any:
    """Return the value of ``key = value``."""
    ((_, value),) = tomllib.loads(written).items()
    return value
