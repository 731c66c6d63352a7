"""Overrides of a case from the command line or a scan: ``KEY=VALUE`` with dotted keys and TOML values.

Bare words are strings: ``packing.kind=hcp``, ``material=steel``. Only the named key changes. The name of a table
replaces the whole table: ``material=steel`` drops the keys of an earlier ``[material]``. Entries of an array of tables
are numbered from 1: ``replace.2.index=8``.
"""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Iterable, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.named_files import with_absolute_paths

_BARE_WORD = re.compile(r"""[^\s"'\[\]{}=,#][^"'\[\]{}=,#\r\n]*""")
_KEY = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*")


def parse_override(override: str) -> tuple[str, Any]:
    """Split ``KEY=VALUE`` into the dotted key and the value.

    Raises
    ------
    InputError
        There is no ``=``, the key is not a dotted path, or the value is neither TOML nor a bare word.
    """
    key, equals, written = (part.strip() for part in override.partition("="))
    if not equals or not _KEY.fullmatch(key):
        raise InputError(f"--set: found {show(override)}, expected KEY=VALUE such as load.velocity=10")
    try:
        document = tomllib.loads(f"value = {written}")
    except tomllib.TOMLDecodeError:
        document = {}
    if list(document) == ["value"]:
        return key, document["value"]
    if _BARE_WORD.fullmatch(written):
        return key, written
    hint = f"; a list is [{written}]" if "," in written and "[" not in written else ""
    raise InputError(f"--set: {key}: found {show(written)}, expected a TOML value or a bare word{hint}")


def parse_overrides(overrides: Iterable[str] | Mapping[str, Any]) -> dict[str, Any]:
    """Parse overrides into a mapping of dotted keys to values; all errors are raised at once.

    Relative paths in them start from the working directory.
    """
    if isinstance(overrides, Mapping):
        return dict(with_absolute_paths(overrides, Path()))
    if isinstance(overrides, str):
        overrides = [overrides]
    parsed: dict[str, Any] = {}
    errors: list[str] = []
    for override in overrides:
        try:
            key, value = parse_override(override)
        except InputError as error:
            errors += error.errors
        else:
            parsed.pop(key, None)  # the last override of a key counts, and is applied last
            parsed[key] = value
    if errors:
        raise InputError(errors)
    return dict(with_absolute_paths(parsed, Path()))


def apply_overrides(data: Mapping[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of the case ``data`` with ``overrides`` (dotted key to value) applied.

    Raises
    ------
    InputError
        Part of a dotted key names a value that is not a table.
    """
    result = copy.deepcopy(dict(data))
    errors: list[str] = []
    for key, value in overrides.items():
        *path, last = key.split(".")
        table = result
        for name, following in pairwise([*path, last]):
            if following.isdigit() and name not in table:
                errors.append(
                    f"--set: {key}: found no [[{name}]] tables, expected {following} or more; give them whole"
                )
                break
            inner = table.setdefault(name, {})
            if name == "material" and isinstance(inner, str):
                inner = table[name] = {"preset": inner}
            if isinstance(inner, list) and following.isdigit():
                inner = table[name] = _Numbered(inner)
            if not isinstance(inner, dict):
                errors.append(f"--set: {key}: found {name} = {show(inner)}, expected a table [{name}]")
                break
            if isinstance(inner, _Numbered) and following not in inner:
                errors.append(f"--set: {key}: found {len(inner)} [[{name}]] tables, expected {following} or more")
                break
            table = inner
        else:
            table[last] = copy.deepcopy(value)
    if errors:
        raise InputError(errors)
    return _with_lists(result)


class _Numbered(dict[str, Any]):
    """An array of tables as a mapping from the number of an entry, from 1, as in dotted keys."""

    def __init__(self, entries: list[Any]) -> None:
        super().__init__({str(n): entry for n, entry in enumerate(entries, start=1)})


def _with_lists(value: Any) -> Any:
    if isinstance(value, _Numbered):
        return [_with_lists(item) for item in value.values()]
    if isinstance(value, dict):
        return {name: _with_lists(item) for name, item in value.items()}
    return value
