"""The studies that come with the package: case files in `cases/`, found by name."""

from __future__ import annotations

import difflib
from importlib import resources
from pathlib import Path

from granwave.lammps_inputs.errors import InputError

_SUFFIX = ".toml"


def _folder() -> Path:
    # the package is always unpacked on disk: it holds a shared library
    return Path(str(resources.files("granwave.workflows") / "cases"))


def names() -> list[str]:
    """Names of the built-in studies."""
    return sorted(path.name.removesuffix(_SUFFIX) for path in _folder().glob(f"*{_SUFFIX}"))


def find(case: str) -> Path:
    """The file of a case: a path, or the name of a built-in study.

    Raises
    ------
    InputError
        It is neither; the nearest name is given.
    """
    path = Path(case)
    if path.is_file():
        return path
    built_in = _folder() / f"{case}{_SUFFIX}"
    if "/" not in case and built_in.is_file():
        return built_in
    if path.exists():
        raise InputError(f"{case}: found a directory, expected a case file or one of: {', '.join(names())}")
    near = difflib.get_close_matches(case, names(), n=1)
    hint = f"did you mean {near[0]}?" if near else f"built-in studies: {', '.join(names())}"
    raise InputError(f"{case}: neither a file nor a built-in study; {hint}")


def text(name: str) -> str:
    """The case file of a built-in study, comments and all."""
    return find(name).read_text(encoding="utf-8")


def title(name: str) -> str:
    """What the study is: the first comment of its file."""
    first = text(name).splitlines()[0]
    return first.removeprefix("#").strip()
