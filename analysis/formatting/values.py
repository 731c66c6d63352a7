"""Values of a case for readers: labels of values that are tables, units of keys, names of grains.

A label is as ``plate mass=5 stiffness=5e9, steel``. The label of a scan's point may hold such a
value as JSON; it is empty if the case of the point lacks the key.
"""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cache
from typing import Any

from granwave.analysis.formatting.numbers import plain, superscript
from granwave.lammps_inputs.case.case import unit_of as granular_unit_of
from granwave.lammps_inputs.case.loads.registry import load_kinds
from granwave.lammps_inputs.extensions import added
from granwave.lammps_inputs.packing.cylinders import GRAINS, SPHERES, grains_called

NONE = "none"
#: "over" of a ratio: not of a spread, sum or mean, and not before a range of values.
_RATIO = re.compile(
    r"(?<!spread)(?<!sums)(?<!sum)(?<!mean)(?<!average)(,?) over "
    r"(?!all |two |which |the numbers |time)"
)
_POWER_OF_TEN = re.compile(r"1e([+-]?\d+)")  # unit of values in thousandths and the like
_MICRO = re.compile(r"^u(?=[a-zA-Z]$)")
_NAMES = ("preset", "name")  # keys that identify a material
#: Key whose unit follows from the kind of the load, and the key of that.
AMPLITUDE = "load.amplitude"
LOAD_KIND = "load.kind"


@dataclasses.dataclass(frozen=True)
class Naming:
    """Label, symbol (in mathtext), unit in print, and the size of this unit in SI units.

    Attributes
    ----------
    si
        SI unit of a key of an extension's cases; units of other keys are in the schema of the case.
    """

    label: str
    symbol: str = ""
    unit: str = ""
    scale: float = 1.0
    si: str = ""


@cache
def more_keys() -> dict[str, Naming]:
    """Return the naming of keys of the cases of extensions, by dotted key."""
    found: dict[str, Naming] = {}
    for keys in added("case_keys"):
        found |= keys
    return found


def as_label(value: Any) -> str:
    """Return the label of a value of a case, or of the JSON text of such a value."""
    if isinstance(value, str):
        value = _parsed(value)
    if isinstance(value, Mapping):
        parts = (
            value if set(value) != {"material"} else {"wall": {}, **value}
        )  # a table with a material only is a wall
        return (
            _material(value) or ", ".join(_part(name, part) for name, part in parts.items()) or NONE
        )
    if isinstance(value, list | tuple) and any(isinstance(part, Mapping) for part in value):
        return "; ".join(map(as_label, value))
    return _text(value) or NONE


def unique_labels(values: Sequence[Any]) -> list[str]:
    """Return a label for each value; different values get different labels, by a number if
    necessary.
    """
    labels: dict[str, str] = {}
    keys = [json.dumps(value, sort_keys=True, default=str) for value in values]
    for key, value in zip(keys, values, strict=True):
        if key not in labels:
            labels[key] = distinct(as_label(value), labels.values())
    return [labels[key] for key in keys]


def distinct(label: str, taken: Collection[str]) -> str:
    """Return a label with the first number that makes it differ from the taken ones, if any."""
    number = 1
    shown = label
    while shown in taken:
        number += 1
        shown = f"{label} ({number})"
    return shown


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
    changed = (
        {key: part for key, part in table.items() if key not in _NAMES} if "preset" in table else {}
    )
    return " ".join([name, *(_part(key, part) for key, part in changed.items())]) if name else ""


def _text(value: Any) -> str:
    if isinstance(value, bool | list | tuple):
        return json.dumps(value, ensure_ascii=False)
    return plain(f"{value:.6g}") if isinstance(value, float) else str(value)


def unit_of(key: str) -> str:
    """Return the unit of a dotted key, such as ``load.velocity``; empty if it has none.

    The unit of `AMPLITUDE` follows from the kind of the load: `amplitude_unit`.
    """
    if key == AMPLITUDE:
        return ""
    if unit := granular_unit_of(key):
        return unit
    return more_keys()[key].si if key in more_keys() else ""


def amplitude_unit(kinds: Iterable[str]) -> str:
    """Return the unit of `AMPLITUDE` for loads of these kinds; empty if they differ, or none has an
    amplitude.
    """
    units = {load_kinds()[kind].amplitude_unit if kind in load_kinds() else "" for kind in kinds}
    return units.pop() if len(units) == 1 else ""


def shown_unit(key: str) -> str:
    """Unit of a dotted key in print: kg/m³."""
    return printed_unit(unit_of(key))


def unit_in_cases(key: str, cases: Iterable[Mapping[str, Any]]) -> str:
    """Unit in print of a dotted key of cases, each given by dotted keys."""
    if key == AMPLITUDE:
        return amplitude_unit(str(case.get(LOAD_KIND)) for case in cases if key in case)
    return shown_unit(key)


def printed_unit(unit: str) -> str:
    """Unit in print: kg/m³ for kg/m^3."""
    return unit.replace("^2", "²").replace("^3", "³")


def grains_called_in(summaries: Iterable[Mapping[str, Any]]) -> str:
    """Return ``spheres``, ``cylinders``, or ``grains`` if runs have both."""
    found = {
        grains_called(summary.get("n_spheres") or 0, summary.get("n_cylinders") or 0)
        for summary in summaries
        if summary.get("n_spheres")
    }
    if not found:
        return SPHERES
    return found.pop() if len(found) == 1 else GRAINS


def readable_unit(unit: str) -> str:
    """Return a unit as it is printed: ``µm`` for ``um``, ``10⁻³`` for ``1e-3``."""
    power = _POWER_OF_TEN.fullmatch(unit)
    if power:
        sign = "⁻" if int(power[1]) < 0 else ""
        return f"10{sign}{superscript(abs(int(power[1])))}"
    return _MICRO.sub("µ", unit).replace("^2", "²").replace("^3", "³")


def with_unit(number: str, unit: str) -> str:
    """Return a number with its unit: ``3 µm``, ``7 × 10⁻³``."""
    if _POWER_OF_TEN.fullmatch(unit):
        return f"{number} × {readable_unit(unit)}"
    return f"{number} {readable_unit(unit)}".rstrip()


def ratio_in_words(name: str) -> str:
    """Return the name of a quantity with ratios as ``A divided by B`` in place of ``A over B``.

    "over" stays where it is a range: ``spread over the numbers``, ``largest over all n``.
    """
    return _RATIO.sub(r"\1 divided by ", name)
