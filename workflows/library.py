"""The studies that come with the package, found by name: cases in `cases/`, scans of them in `scans/`."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import load_case as load_case_file

CASES, SCANS = "cases", "scans"
_SUFFIX = ".toml"
_WHAT = {CASES: "case", SCANS: "scan"}


def _folder(kind: str) -> Path:
    # the package is always unpacked on disk: it holds a shared library
    return Path(str(resources.files("granwave.workflows") / kind))


def names(kind: str = CASES) -> list[str]:
    """Names of the built-in studies: cases, or scans."""
    return sorted(path.name.removesuffix(_SUFFIX) for path in _folder(kind).glob(f"*{_SUFFIX}"))


def find(study: str, kind: str = CASES) -> Path:
    """The file of a case or a scan: a path, or the name of a built-in study.

    Raises
    ------
    InputError
        It is neither; the nearest name is given.
    """
    path = Path(study)
    if path.is_file():
        return path
    built_in = _folder(kind) / f"{study}{_SUFFIX}"
    if "/" not in study and built_in.is_file():
        return built_in
    what = _WHAT[kind]
    if path.is_dir():
        raise InputError(f"{study}: found a directory, expected a {what} file or one of: {', '.join(names(kind))}")
    other = SCANS if kind == CASES else CASES
    if study in names(other):
        verb = "scan" if other == SCANS else "run"
        raise InputError(f"{study}: is a {_WHAT[other]}, expected a {what}: granwave {verb} {study}")
    near = difflib.get_close_matches(study, names(kind), n=1)
    hint = f"did you mean {near[0]}?" if near else f"built-in {kind}: {', '.join(names(kind))}"
    raise InputError(f"{study or '(empty)'}: neither a file nor a built-in {what}; {hint}")


def load_case(case: str | Path, overrides: Iterable[str] | Mapping[str, Any] = ()) -> Case:
    """Read a case: a file, or a built-in study by its name.

    Parameters
    ----------
    overrides
        ``KEY=VALUE`` strings, or a mapping of dotted keys to values.

    Raises
    ------
    InputError
        There is no such case, or it is wrong; every fault is named.
    """
    return load_case_file(find(str(case)), overrides)


def text(name: str) -> str:
    """The file of a built-in study, case or scan, comments and all."""
    return find(name, SCANS if name in names(SCANS) else CASES).read_text(encoding="utf-8")


def title(name: str) -> str:
    """What the study is: the first comment of its file."""
    return text(name).splitlines()[0].removeprefix("#").strip()
