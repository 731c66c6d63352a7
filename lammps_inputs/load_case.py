"""Loading of a case file: read, check, warn, with the assembly that the checks made; and reading of
the case of a finished run.  The case of a finished run is only parsed: it was checked before the
run, and it is not compared with the memory, the cores or the disk of this machine. A result can
therefore be opened on any machine.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.case.case import MEANT, RECORD, Case, PartialCase, case_keys
from granwave.lammps_inputs.case.parse import apply_overrides, parse_case, parse_overrides
from granwave.lammps_inputs.case.schema import ErrorList
from granwave.lammps_inputs.checks.checks import check_case, check_together
from granwave.lammps_inputs.checks.warnings import warn_about
from granwave.lammps_inputs.errors import InputError, fault_of
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.found_contacts import with_contacts
from granwave.lammps_inputs.packing.places import centred
from granwave.lammps_inputs.planning.bar_echoes import echo_warnings
from granwave.lammps_inputs.statics.stiffening import rearranged_bed, stiffened_bed


def load_case(path: str | Path, overrides: Iterable[str] | Mapping[str, Any] = ()) -> Case:
    """Read a case file.

    Parameters
    ----------
    overrides
        ``KEY=VALUE`` strings (dotted keys, TOML values; bare words are strings), or a mapping of
        dotted keys to values.

    Raises
    ------
    InputError
        The file or an override is invalid; the message lists all faults.
    """
    return load_assembly(path, overrides).case


def load_assembly(path: str | Path, overrides: Iterable[str] | Mapping[str, Any] = ()) -> Assembly:
    """Read a case file as `load_case` does, and return all bodies of the case."""
    changes = parse_overrides(overrides)
    record = [key for key in changes if key.split(".")[0] == RECORD]
    if record:
        sentence = f"[{RECORD}] is a record of a run and cannot be set"
        raise InputError(fault_of(sentence, key=key, changed=True) for key in record)
    data = apply_overrides(read_toml(path), changes)
    return assembly_from_dict(data, path, overridden=changes)


def case_from_dict(
    data: Mapping[str, Any], source: str | Path = "case", overridden: Iterable[str] = ()
) -> Case:
    """Make a case from the nested mapping of a case file, and check it; paths start from the
    working directory.

    Parameters
    ----------
    source
        Name of the file in messages; its stem is the default name of the case.
    overridden
        Dotted keys that are none of the file, but of changes of the case.

    Raises
    ------
    InputError
        The case is invalid; the message lists all faults.
    """
    return assembly_from_dict(data, source, overridden).case


def assembly_from_dict(
    data: Mapping[str, Any], source: str | Path = "case", overridden: Iterable[str] = ()
) -> Assembly:
    """Make a case as `case_from_dict` does, and return all its bodies."""
    errors = ErrorList(str(source), tuple(overridden), case_keys())
    parts = parse_case(data, source, errors)
    parts["chosen"] = frozenset(key for key in MEANT if _is_given(key, data))
    with_contacts(parts, errors)
    check_together(PartialCase(parts), errors)
    errors.report(parts["name"])
    parts["striker"] = centred(parts["striker"], parts["packing"], parts["boundary"])
    assembly = _checked(Case(**parts), errors)
    stiffened = stiffened_bed(assembly) or rearranged_bed(assembly)
    if stiffened is not None:
        errors.notes.append(stiffened.note)
        assembly = _checked(stiffened.case_of(assembly.case), errors)
    warn_about(assembly, echo_warnings(assembly))
    return assembly


def _is_given(key: str, data: Mapping[str, Any]) -> bool:
    """Return True if nested tables have a value for a dotted key."""
    table, _, name = key.partition(".")
    values = data.get(table)
    return isinstance(values, Mapping) and name in values


def _checked(case: Case, errors: ErrorList) -> Assembly:
    """Check a case, and return all its bodies."""
    assembly = check_case(case, errors)
    errors.report(case.name)
    assert assembly is not None  # it is None only with errors
    return assembly


def read_stored_case(path: str | Path) -> Case:
    """Read the case.toml of a run, see `stored_case`."""
    return stored_case(read_toml(path), path)


def stored_case(data: Mapping[str, Any], source: str | Path = "case") -> Case:
    """Return the case of a run from its nested mapping; it is parsed, not checked.

    Parameters
    ----------
    source
        Name of the file in messages; its stem is the default name of the case.

    Raises
    ------
    InputError
        The mapping is not a case, for example from a damaged file; the message lists all faults.
    """
    errors = ErrorList(str(source))
    parts = parse_case(data, source, errors, stored=True)
    if errors.items:
        raise InputError(errors.items)
    parts["striker"] = centred(parts["striker"], parts["packing"], parts["boundary"])
    return Case(**parts)
