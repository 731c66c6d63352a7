"""Cases and scans from Python: names, files, mappings and keywords; and errors with the Python
names of options.
"""

from __future__ import annotations

import contextlib
import dataclasses
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import tomli_w

from granwave.analysis.notebook.run import Run
from granwave.lammps_inputs.case.case import case_keys
from granwave.lammps_inputs.case.parse import apply_overrides, parse_overrides
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError, InputFault, RunError
from granwave.lammps_inputs.extensions import missing_package
from granwave.lammps_inputs.files import read_toml, with_absolute_paths
from granwave.lammps_inputs.run_directory import CASE_FILE
from granwave.workflows import library
from granwave.workflows.file_kinds import SCAN
from granwave.workflows.solvers import AnyCase, CaseKind, case_commands, solver_of

CaseLike = str | Path | Mapping[str, Any] | AnyCase

_OWN_NAMES = {
    "case": Path("case"),
    "scan": Path("scan"),
}  # in place of files, in messages and as default names


def read_case(
    source: CaseLike, changes: Mapping[str, Any] | None, keys: Mapping[str, Any]
) -> tuple[Any, CaseKind]:
    """Make a case from a source and changes, and return it with its kind.

    Raises
    ------
    InputError
        There is no such case, or it is invalid; the message has a line for each fault.
    """
    tables, path = _tables(source)
    changed = given_changes(changes, keys)
    kind = solver_of(tables)
    return kind.read(apply_overrides(tables, changed), path, overridden=changed), kind


def _tables(source: CaseLike) -> tuple[dict[str, Any], Path]:
    """Return the tables of a case, and the name of its file in messages."""
    if isinstance(source, Run):
        source = source.directory / CASE_FILE
    if isinstance(source, str | Path):
        path = library.find_for(str(home(source)), *case_commands())
        return read_toml(path), path
    if isinstance(source, Mapping):
        return with_absolute_paths(plain(source), Path()), _OWN_NAMES["case"]
    if hasattr(source, "to_dict"):
        return source.to_dict(), _OWN_NAMES["case"]
    raise InputError(
        f"case: found {show(source)}, expected a name, the path of a file, a mapping or a case"
    )


def given_changes(changes: Mapping[str, Any] | None, keys: Mapping[str, Any]) -> dict[str, Any]:
    """Return changes of a case by dotted key, from a mapping and from keywords with double
    underscores.

    Raises
    ------
    InputError
        A key is given twice, or has one underscore instead of two for its dot.
    """
    if changes is not None and not isinstance(changes, Mapping):
        raise InputError(
            f'found {show(changes)}, expected a mapping such as {{"load.velocity": 10}}'
        )
    if flat := [
        name
        for name in keys
        if name not in case_keys() and name.replace("_", ".", 1) in case_keys()
    ]:
        raise InputError(
            f"{name}: unknown key; did you mean {name.replace('_', '__', 1)}, with two underscores for the dot?"
            for name in flat
        )
    dotted = {name.replace("__", "."): value for name, value in keys.items()}
    given = {str(name): value for name, value in (changes or {}).items()}
    if twice := sorted(set(dotted) & set(given)):
        raise InputError(f"{name}: given twice, in the mapping and as a keyword" for name in twice)
    return parse_overrides(plain(given | dotted))


def read_scan(
    source: str | Path | Mapping[str, Any], changes: Mapping[str, Any], *, here: bool
) -> Any:
    """Make a scan from a source and changes of all points; ``here`` as in `load_scan`.

    Raises
    ------
    InputError
        There is no such scan, or the scan or one of its points is invalid.
    """
    from granwave.workflows.scanning.scan_file import load_scan, scan_from_dict

    if isinstance(source, str | Path):
        return load_scan(home(source), changes, here=here)
    if not isinstance(source, Mapping):
        raise InputError(
            f"scan: found {show(source)}, expected a name, the path of a file or a mapping"
        )
    data = dict(source)
    template = None
    comment = ""
    if "case" in data and not isinstance(data["case"], str | Path):
        template = {"name": "case", **_tables(data["case"])[0]}
        data["case"] = str(template["name"])
        comment = "# The case was given in Python:\n#\n" + "".join(
            f"# {line}\n" for line in tomli_w.dumps(template).splitlines()
        )
    data = with_absolute_paths(plain(data), Path())
    return scan_from_dict(
        data,
        _OWN_NAMES["scan"],
        changes,
        here=here,
        text=comment + tomli_w.dumps(data),
        template=template,
    )


def plain(value: Any) -> Any:
    """Convert a value to TOML types: numbers and arrays of numpy, paths and tuples; other values
    are unchanged.
    """
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "tolist") and hasattr(value, "dtype"):
        return plain(value.tolist())
    return value


def home(path: str | Path) -> str:
    """Replace a ``~``, as a shell does."""
    return os.path.expanduser(path)


# options of the command line in messages, and of ranks in processes of their own; and what they are
# called here
_WORDS = (
    (re.compile(r"--(force|resume)\b"), r"\1=True"),
    (re.compile(r" with -o\b"), " with directory=..."),
    (re.compile(r"--np (\d+)"), r"ranks=\1"),
    (re.compile(r"--quantity\b"), "quantities"),
    (re.compile(r"--as\b"), "measured_as"),
    (re.compile(r"--only\b"), "only"),
    (re.compile(r"--to (\w+)"), r'to="\1"'),
)


def _gives_a_command(line: str) -> bool:
    """Return True if a message gives a command to type that runs a case or a scan, or analyses."""
    commands = "|".join((*case_commands(), SCAN, "analyse"))
    return re.search(rf"\bgranwave ({commands})\b", line) is not None


@contextlib.contextmanager
def words_of_python(*options: str) -> Iterator[None]:
    """Use the Python names of options in messages of errors; commands to type are unchanged.

    Parameters
    ----------
    options
        Further options of the command line, such as "frame-rate"; their Python names have
        underscores.

    Raises
    ------
    InputError
        A package that an extension needs is not installed, or the block raised this error.
    """
    try:
        yield
    except InputError as error:
        faults = [_fault_in_python(fault, options) for fault in error.items]
        raise InputError(faults) from error.__cause__
    except RunError as error:
        raise RunError(in_python(str(error), options)) from error.__cause__
    except ModuleNotFoundError as error:
        if missing := missing_package(error):
            raise InputError(missing) from error
        raise


def _fault_in_python(fault: InputFault, options: Sequence[str]) -> InputFault:
    """Replace the options of the command line in a fault."""
    if fault.sentence:
        return dataclasses.replace(fault, sentence=in_python(fault.sentence, options))
    return dataclasses.replace(fault, remedy=in_python(fault.remedy, options))


def in_python(line: str, options: Sequence[str] = ()) -> str:
    """Replace the options of the command line in a message without a command to type.

    ``options`` is described in `words_of_python`.
    """
    if _gives_a_command(line):
        return line
    for pattern, word in _WORDS:
        line = pattern.sub(word, line)
    for option in options:
        line = re.sub(rf"--{option}\b", option.replace("-", "_"), line)
    return line
