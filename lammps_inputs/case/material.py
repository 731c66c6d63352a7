"""Materials: elastic constants, density and yield strength, by name or by value.

A ``[material]`` table gives the values, or names a ``preset`` whose values it may override one by one.
Presets come with the package (``materials.toml``) or from the user's own ``file`` of the same form.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Mapping
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.case.hints import DENSITY, YIELD_STRENGTH, YOUNGS_MODULUS
from granwave.lammps_inputs.case.schema import (
    ErrorList,
    ValidationError,
    label,
    number,
    parse_label,
    read_table,
    refuse_unknown,
    show,
    text,
)
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_toml

SELECTORS = ("preset", "file")
MATERIALS = "materials"  # table of further materials of a case


@dataclasses.dataclass(frozen=True, kw_only=True)
class Material:
    """An isotropic elastic material that yields (von Mises) at ``yield_strength``."""

    name: str | None = label("what the material is called in figures and tables", default=None)
    youngs_modulus: float = number("Young's modulus", unit="Pa", above=0, usual=YOUNGS_MODULUS)
    poisson_ratio: float = number("Poisson's ratio", above=-1, below=0.5)
    density: float = number("mass density", unit="kg/m^3", above=0, usual=DENSITY)
    yield_strength: float | None = number(
        "uniaxial yield strength", unit="Pa", above=0, default=None, usual=YIELD_STRENGTH
    )
    source: str | None = text("where the values come from", default=None)


@cache
def presets() -> dict[str, Material]:
    """Return the materials that come with the package, by name."""
    with resources.as_file(resources.files("granwave.lammps_inputs.case") / "materials.toml") as path:
        return load_materials(path)


def material(name: str) -> Material:
    """Return the preset called ``name``.

    Raises
    ------
    InputError
        There is no such preset; the message names the most similar one.
    """
    errors = ErrorList("material")
    found = _select(name, presets(), "preset", errors)
    if found is None:
        raise InputError(errors.lines)
    return found


def sphere_mass(material: Material, radius: float) -> float:
    """Return the mass of a sphere, kg; radius in m."""
    return material.density * 4 / 3 * math.pi * radius**3


def load_materials(path: str | Path) -> dict[str, Material]:
    """Read a file of materials, one table for each.

    Raises
    ------
    InputError
        The file cannot be read, or a table in it is not a material.
    """
    errors = ErrorList(str(path))
    read = {
        name: read_table(Material, {"name": name, **table} if isinstance(table, Mapping) else table, name, errors)
        for name, table in read_toml(path).items()
    }
    if not read and not errors.lines:
        raise InputError(f"{path}: found no material, expected tables such as [my-steel] with youngs_modulus and so on")
    if errors.lines:
        raise InputError(errors.lines)
    return {name: entry for name, entry in read.items() if entry is not None}


def read_material(table: Any, errors: ErrorList, key: str = "material") -> Material | None:
    """Read a material of a case: the name of a preset, or a table of values, optionally with ``preset`` and ``file``.

    Parameters
    ----------
    key
        Dotted name of the table, for errors.
    """
    if isinstance(table, str):
        return _select(table, presets(), key, errors)
    if not isinstance(table, Mapping):
        errors.add(key, f'found {show(table)}, expected a name ("brass") or a table [{key}]')
        return None
    own = {name: value for name, value in table.items() if name not in SELECTORS}
    if "preset" not in table:
        if "file" in table:
            errors.add(f"{key}.preset", f"missing; name the material to take from {key}.file")
            return None
        return read_table(Material, own, key, errors)
    known = _library(table.get("file"), errors, f"{key}.file")
    base = None if known is None else _select(table["preset"], known, f"{key}.preset", errors, table.get("file"))
    if base is None:
        refuse_unknown(own, [field.name for field in dataclasses.fields(Material)], key, errors)
        return None
    values = {name: value for name, value in dataclasses.asdict(base).items() if value is not None}
    if own.keys() - {"name"}:
        values.pop("source", None)  # the source does not hold for changed values
    return read_table(Material, {**values, **own}, key, errors)


def _library(file: Any, errors: ErrorList, key: str) -> dict[str, Material] | None:
    if file is None:
        return presets()
    if not isinstance(file, str) or not file:
        errors.add(key, f"found {show(file)}, expected the path of a TOML file of materials")
        return None
    try:
        return load_materials(file)
    except InputError as error:
        for line in error.errors:
            errors.add(key, line)
        return None


def _select(
    name: Any, known: Mapping[str, Material], key: str, errors: ErrorList, file: str | None = None
) -> Material | None:
    if isinstance(name, str) and name in known:
        return known[name]
    near = difflib.get_close_matches(str(name).lower(), known, n=1, cutoff=0.5)
    hint = f"did you mean {near[0]}?" if near else ""
    there = f" in {file}" if file else ""
    errors.add(key, f"found {show(name)}, expected one of {', '.join(known)}{there}; {hint}".rstrip("; "))
    return None


def read_materials(tables: Any, errors: ErrorList) -> dict[str, Material]:
    """Read the tables ``[materials.NAME]`` of a case: further materials, by name."""
    if not isinstance(tables, Mapping):
        errors.add(MATERIALS, f"found {show(tables)}, expected tables such as [{MATERIALS}.soft]")
        return {}
    found: dict[str, Material] = {}
    for name, table in tables.items():
        try:
            parse_label(name)
        except ValidationError as error:
            errors.add(MATERIALS, f"found a table called {show(name)}, expected {error}")
            continue
        material = read_material(table, errors, f"{MATERIALS}.{name}")
        if material is not None:
            own_name = isinstance(table, Mapping) and "name" in table
            found[name] = material if own_name and material.name == name else dataclasses.replace(material, name=name)
            if own_name and material.name != name:
                errors.add(f"{MATERIALS}.{name}.name", f"found {show(material.name)}, expected the name of the table")
    return found


def with_named_materials(value: Any, materials: Mapping[str, Material]) -> Any:
    """Copy tables of a case, with the names of further materials in ``material`` keys replaced by their values."""
    if isinstance(value, list | tuple):
        return [with_named_materials(item, materials) for item in value]
    if not isinstance(value, Mapping):
        return value
    copy = {name: with_named_materials(item, materials) for name, item in value.items()}
    if isinstance(copy.get("material"), str) and copy["material"] in materials:
        known = dataclasses.asdict(materials[copy["material"]])
        copy["material"] = {name: one for name, one in known.items() if one is not None}
    return copy
