"""Built-in studies by name: cases in `cases/`, scans in `scans/`."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from importlib import resources
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.extensions import extensions, left_out, of_left_out
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.lattices import kind_names, kind_of
from granwave.lammps_inputs.load_case import load_assembly as load_assembly_file
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.run_directory import CASE_FILE
from granwave.workflows.file_kinds import SCAN, file_kinds, other_than_a_case
from granwave.workflows.solvers import GRANULAR, case_kinds, solver_of

CASES = "cases"
SCANS = "scans"
_PACKINGS = "Packings"
_CHAINS = "Chains and single contacts"
_SCANS = "Scans"
_SUITES = "Suites of scans"
_SUFFIX = ".toml"
_WHAT = {CASES: "case", SCANS: "scan"}
_OF_CHECKOUT = "reproductions"  # folder of the repository that is not installed


@cache
def _files(kind: str) -> dict[str, Path]:
    """Return the files of the built-in studies of a kind by name, with those of extensions."""
    # the package is always unpacked on disk: it holds a shared library
    folders = [Path(str(resources.files("granwave.workflows")))]
    folders += [one.folder for one in extensions() if one.folder is not None]
    paths = dict[str, Path]()
    for folder in reversed(folders):
        found = sorted((folder / kind).glob(f"*{_SUFFIX}"))
        paths |= {path.name.removesuffix(_SUFFIX): path for path in found}
    return paths


def names(kind: str = CASES) -> list[str]:
    """Return the names of the built-in studies: cases, or scans."""
    return sorted(_files(kind))


def find(study: str, kind: str = CASES, directory: Path = Path()) -> Path:
    """Find the file of a case or a scan, given as a path or as the name of a built-in study.

    Parameters
    ----------
    directory
        Folder that a relative path starts from.

    Raises
    ------
    InputError
        It is neither; the message suggests the most similar name.
    """
    path = directory / study
    if _is(path.is_file):
        return path
    built_in = {known: _files(known)[study] for known in _WHAT if study in _files(known)}
    if kind in built_in:
        return built_in[kind]
    if built_in:
        other = next(iter(built_in.values()))
        raise _other_word(study, verb_of(other), SCAN if kind == SCANS else GRANULAR.verb)
    what = _WHAT[kind]
    known = "granwave cases lists the built-in ones"
    if _is(path.is_dir):
        case = path / CASE_FILE
        hint = f"its case is {case}" if case.is_file() else known
        raise InputError(f"{study or '(empty)'}: found a directory, expected a {what} file; {hint}")
    try:
        os.stat(path)
    except PermissionError as error:
        raise InputError(f"{study}: cannot be read: {error.strerror}") from None
    except (OSError, ValueError):
        pass
    if owner := _owner_left_out(study):
        raise InputError(f"{study}: {owner}")
    if Path(study).parts[:1] == (_OF_CHECKOUT,):
        raise InputError(
            f"{study}: not found; the folder {_OF_CHECKOUT} is only in a checkout of the "
            "repository: run the command there, in its top folder"
        )
    folder = path.parent
    is_path = len(Path(study).parts) > 1
    files = [file.stem for file in folder.glob(f"*{_SUFFIX}")] if _is(folder.is_dir) else []
    stem = _nearest(path.name.removesuffix(_SUFFIX), files)
    file = str(Path(study).with_name(f"{stem}{_SUFFIX}")) if stem else ""
    near = (
        (file if is_path else "")
        or _nearest(study, names(kind))
        or _nearest(study, _all_names())
        or file
    )
    hint = f"did you mean {near}?" if near else known
    raise InputError(
        f"{show(study)[1:-1] or '(empty)'}: neither a file nor a built-in {what}; {hint}"
    )


def _owner_left_out(study: str) -> str:
    """Return a message if a built-in study belongs to a disabled extension; empty if not."""
    for extension in left_out():
        if extension.folder is None:
            continue
        files = [extension.folder / kind / f"{study}{_SUFFIX}" for kind in _WHAT]
        if any(_is(file.is_file) for file in files):
            return of_left_out(extension.name)
    return ""


def _is(question: Callable[[], bool]) -> bool:
    """Ask the file system; False if the path is invalid or cannot be accessed."""
    try:
        return question()
    except (OSError, ValueError):
        return False


def _nearest(name: str, options: Iterable[str]) -> str:
    """Return the option most similar to a name; empty if none is similar."""
    return next(iter(difflib.get_close_matches(name.lower(), list(options), n=1)), "")


def find_for(study: str, *verbs: str, directory: Path = Path()) -> Path:
    """Find the file of a study that one of these commands runs; ``directory`` as in `find`.

    Raises
    ------
    InputError
        There is none, or another command runs it.
    """
    path = find(study, SCANS if verbs == (SCAN,) else CASES, directory)
    try:
        verb = verb_of(path)
    except InputError as error:
        items = [item if item.source else item.inside(study) for item in error.items]
        raise InputError(items) from None
    if verb not in verbs:
        raise _other_word(study, verb, verbs[0])
    return path


def verb_of(path: Path) -> str:
    """Return the command that reads a file, such as run or scan."""
    tables = read_toml(path)
    other = other_than_a_case(tables)
    return solver_of(tables).verb if other is None else other.command


def _all_names() -> list[str]:
    return [*chain.from_iterable(map(names, _WHAT))]


def _other_word(study: str, found: str, wanted: str) -> InputError:
    """Return the error for a file that belongs to another command."""
    cases = {kind.verb: kind.noun for kind in reversed(case_kinds())}
    others = {kind.command: kind.noun for kind in file_kinds() if kind.recognises is not None}
    if found in others or wanted in others:
        cases = dict.fromkeys(cases, "a case")
    nouns = cases | others
    return InputError(
        f"{study}: is {nouns[found]}, expected {nouns[wanted]}: granwave {found} {study}"
    )


def load_case(case: str | Path, overrides: Iterable[str] | Mapping[str, Any] = ()) -> Case:
    """Read a case: a file, or a built-in study by its name.

    Parameters
    ----------
    overrides
        ``KEY=VALUE`` strings, or a mapping of dotted keys to values.

    Raises
    ------
    InputError
        There is no such case, or it is invalid; the message lists all faults.
    """
    return load_assembly(case, overrides).case


def load_assembly(case: str | Path, overrides: Iterable[str] | Mapping[str, Any] = ()) -> Assembly:
    """Read a case as `load_case` does, and return all bodies of the case."""
    return load_assembly_file(find_for(str(case), GRANULAR.verb), overrides)


class Entry(NamedTuple):
    """A built-in study: ``case`` or ``scan``, its name, the group that it is listed in, and its
    description.
    """

    kind: str
    name: str
    group: str
    title: str


def entries() -> list[Entry]:
    """Return all built-in studies, in the order of their groups."""
    found = []
    for kind, word in _WHAT.items():
        for name, path in sorted(_files(kind).items()):
            tables = read_toml(path)
            group = _group_of_scan(tables) if kind == SCANS else _group_of_case(tables)
            found.append(Entry(word, name, group, title(name)))
    headings = dict.fromkeys(kind.heading for kind in case_kinds() if kind is not GRANULAR)
    groups = (_PACKINGS, _CHAINS, *headings, _SCANS, _SUITES)
    return sorted(found, key=lambda entry: groups.index(entry.group))


def _group_of_scan(tables: Mapping[str, Any]) -> str:
    return _SUITES if "scans" in tables else _SCANS


def _group_of_case(tables: Mapping[str, Any]) -> str:
    kind = solver_of(tables)
    if kind is not GRANULAR:
        return kind.heading
    packing = tables["packing"]["kind"]
    is_chain = packing in kind_names() and kind_of(packing).is_chain
    return _CHAINS if is_chain else _PACKINGS


def text(name: str) -> str:
    """Return the text of the file of a built-in study, with its comments."""
    nearest = difflib.get_close_matches(name, [*names(CASES), *names(SCANS)], n=1)
    return find(name, SCANS if set(nearest) & set(names(SCANS)) else CASES).read_text(
        encoding="utf-8"
    )


def title(name: str) -> str:
    """Return the description of a case or scan: the first comment of its file."""
    return text(name).splitlines()[0].removeprefix("#").strip()
