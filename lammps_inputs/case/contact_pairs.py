"""``[[pair]]``: contact law of two given materials, such as fitted constants or a friction coefficient."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from granwave.lammps_inputs.case.contact import Contact
from granwave.lammps_inputs.case.schema import ErrorList, read_table, refuse_unknown, show

RIGID = "rigid"  # name of a rigid wall in `Pair.materials`
_NOT_BY_PAIR = ("initial_overlap", "line")
_KEYS = tuple(field.name for field in dataclasses.fields(Contact) if field.name not in _NOT_BY_PAIR)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Pair:
    """The contact law between two materials.

    Attributes
    ----------
    materials
        Names of the two materials, which may be equal; "rigid" for a rigid wall.
    contact
        Values of ``[contact]``, overridden by those of the pair.
    """

    materials: tuple[str, str]
    contact: Contact

    def fits(self, first: str | None, second: str | None) -> bool:
        """Return True if the pair holds for materials of these names, in any order."""
        return sorted(self.materials) == sorted((str(first), str(second)))

    def to_dict(self) -> dict[str, Any]:
        """Return the pair as a table of a case file."""
        values = {name: getattr(self.contact, name) for name in _KEYS}
        return {"materials": list(self.materials)} | {
            name: value for name, value in values.items() if value is not None
        }


def read_pairs(tables: Any, contact: Any, errors: ErrorList) -> tuple[Pair, ...]:
    """Read the ``[[pair]]`` tables of a case; entry n has the dotted name ``pair.n``, from 1.

    Parameters
    ----------
    contact
        The table ``[contact]``, source of the values that a pair does not give.
    """
    if not isinstance(tables, list | tuple):
        errors.add("pair", f"found {show(tables)}, expected one or more [[pair]] tables")
        return ()
    common = {name: value for name, value in contact.items() if name in _KEYS} if isinstance(contact, Mapping) else {}
    found: list[Pair] = []
    for n, table in enumerate(tables, start=1):
        pair = _read(table, common, f"pair.{n}", errors)
        if pair is None:
            continue
        if any(other.fits(*pair.materials) for other in found):
            errors.add(f"pair.{n}.materials", f"found {show(list(pair.materials))} twice, expected each pair once")
        found.append(pair)
    return tuple(found)


def _read(table: Any, common: Mapping[str, Any], key: str, errors: ErrorList) -> Pair | None:
    if not isinstance(table, Mapping):
        errors.add(key, f"found {show(table)}, expected a table of materials and keys of [contact]")
        return None
    before = len(errors.lines)
    refuse_unknown(table, ("materials", *_KEYS), key, errors)
    names, expected = table.get("materials"), 'the names of two, such as ["steel", "brass"]'
    if "materials" not in table:
        errors.add(f"{key}.materials", f"missing; expected {expected}")
    elif not isinstance(names, list | tuple) or len(names) != 2 or not all(isinstance(one, str) for one in names):
        errors.add(f"{key}.materials", f"found {show(names)}, expected {expected}")
    own = {name: value for name, value in table.items() if name in _KEYS}
    if not own:
        errors.add(key, "changes nothing; give keys of [contact], such as friction")
    contact = read_table(Contact, {**_others(common, own), **own}, key, errors)
    if contact is None or len(errors.lines) > before or not isinstance(names, list | tuple):
        return None
    return Pair(materials=(names[0], names[1]), contact=contact)


def _others(common: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values that a pair takes from ``[contact]``: all but the constants of another law."""
    if own.get("law", common.get("law")) == common.get("law"):
        return dict(common)
    return {name: common[name] for name in ("friction", "tangential", "loss") if name in common}
