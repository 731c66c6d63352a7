"""Contact law from another file: ``law = "fit.toml"`` in ``[contact]`` or a ``[[pair]]``.

The file has a table ``[contact]``, such as the output of ``granwave fit``, or is another case. Its
keys replace ``law``; keys of the case itself take precedence. The case that a run stores contains
the constants, so that it needs no other file.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.case.schema import ErrorList, numbered, show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import TOML_SUFFIX, read_toml

_CONTACT = "contact"
_PAIR = "pair"
_LAW = "law"


def with_law_of_file(data: Mapping[str, Any], errors: ErrorList) -> dict[str, Any]:
    """Return the tables of a case with the laws of other files instead of the names of the files.

    Faults of a file are added to ``errors``.
    """
    tables = dict(data)
    if _CONTACT in tables:
        tables[_CONTACT] = _with_law(tables[_CONTACT], _CONTACT, errors)
    pairs = tables.get(_PAIR)
    if isinstance(pairs, list | tuple):
        entries = numbered(_PAIR, pairs).items()
        tables[_PAIR] = [_with_law(pair, key, errors) for key, pair in entries]
    return tables


def _with_law(table: Any, key: str, errors: ErrorList) -> Any:
    """Return a table with the keys of the file named by its law; without the law if there is a
    fault.
    """
    if not isinstance(table, Mapping):
        return table
    law = table.get(_LAW)
    if not isinstance(law, str) or not law.endswith(TOML_SUFFIX):
        return table
    own = {name: value for name, value in table.items() if name != _LAW}
    try:
        return {**_read(Path(law)), **own}
    except InputError as error:
        for fault in error.items:
            errors.add(f"{key}.{_LAW}", str(fault))
    return own


def _read(path: Path) -> Mapping[str, Any]:
    """Read the table ``[contact]`` of a file.

    Raises
    ------
    InputError
        There is no such file or table, or its law is that of another file again.
    """
    table = read_toml(path).get(_CONTACT)
    if not isinstance(table, Mapping) or _LAW not in table:
        raise InputError(
            f"{path}: found no law in a table [contact], expected a table such as granwave fit "
            "writes to fit.toml"
        )
    if str(table[_LAW]).endswith(TOML_SUFFIX):
        raise InputError(
            f"{path}: found law = {show(table[_LAW])} in it, which is another file; name that file"
        )
    return table
