"""Values of what varies in a scan: tables of a scan file as one set of keys and values for each point."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import Any

from granwave.lammps_inputs.case.schema import ErrorList, ValidationError, show
from granwave.workflows.scanning.header import Header
from granwave.workflows.scanning.values import MOST_POINTS, SHAPES, values_of


def variations_of(tables: Mapping[str, Any], header: Header | None, errors: ErrorList) -> list[dict[str, Any]]:
    """Make the values of each point, by dotted key, out of [grid], [[zip]] and [[points]]; a product of the first two.

    Faults go into ``errors``.
    """
    axes = [
        [{key: value} for value in values]
        for key, values in _lists(tables.get("grid", {}), "grid", errors).items()
        if values
    ]
    for n, table in enumerate(_tables(tables.get("zip", []), "zip", errors), start=1):
        zipped = _lists(table, f"zip {n}", errors)
        lengths = {key: len(values) for key, values in zipped.items()}
        if len(set(lengths.values())) > 1:
            found = ", ".join(f"{key} has {length}" for key, length in lengths.items())
            errors.add(f"zip {n}", f"found lists of different lengths ({found}), expected one length")
        elif zipped:
            axes.append([dict(zip(zipped, values, strict=True)) for values in zip(*zipped.values(), strict=True)])
    single = [
        flat(table, f"points {n}", errors)
        for n, table in enumerate(_tables(tables.get("points", []), "points", errors), start=1)
    ]
    if not axes and not single and not errors.lines:
        errors.add("grid", "nothing varies: expected [grid], [[zip]] or [[points]] with values")
    keys = [key for axis in axes for key in axis[0]]
    for key in dict.fromkeys(key for key in keys if keys.count(key) > 1):
        errors.add(key, "varies twice; let it stand in one of [grid] and [[zip]]")
    count = ((math.prod(map(len, axes)) if axes else 0) + len(single)) * (header.replicates if header else 1)
    if count > MOST_POINTS:
        errors.add("grid", f"found {count} points, expected at most {MOST_POINTS}")
    if errors.lines:
        return []
    products = itertools.product(*axes) if axes else []
    points = [{key: value for part in parts for key, value in part.items()} for parts in products] + single
    return points


def _tables(value: Any, name: str, errors: ErrorList) -> list[Mapping[str, Any]]:
    if isinstance(value, Mapping):
        value = [value]
    if not isinstance(value, list) or not all(isinstance(table, Mapping) for table in value):
        errors.add(name, f"found {show(value)}, expected tables [[{name}]]")
        return []
    for n, table in enumerate(value, start=1):
        if not table:
            errors.add(f"{name} {n}", "found an empty table, expected keys and values")
    return value


def flat(table: Any, name: str, errors: ErrorList) -> dict[str, Any]:
    """Keys and values with dotted keys, whether they were written with quotes or without."""
    if not isinstance(table, Mapping):
        errors.add(name, f"found {show(table)}, expected a table of keys and values")
        return {}
    flat: dict[str, Any] = {}
    for key, value in table.items():
        if not all(part.isidentifier() or part.isdigit() for part in key.split(".")):
            errors.add(name, f"found the key {show(key)}, expected one such as load.velocity")
            continue
        whole_table = "." in key or (key == "material" and isinstance(value, Mapping) and "preset" in value)
        if isinstance(value, Mapping) and not whole_table and not set(value) & {*SHAPES}:
            flat |= {f"{key}.{inner}": held for inner, held in value.items()}
        else:
            flat[key] = value
    return flat


def _lists(table: Any, name: str, errors: ErrorList) -> dict[str, list[Any]]:
    lists = {}
    for key, value in flat(table, name, errors).items():
        try:
            lists[key] = values_of(value)
        except ValidationError as error:
            errors.add(f"{name}: {key}", f"found {show(value)}, expected {error}")
    return lists
