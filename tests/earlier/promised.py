"""Names of a version that later versions keep, in `promised.json`.

Run in a checkout of the version, before the next one begins; styles are added by hand:

    python -m tests.earlier.promised DIR

DIR is a new directory for the small runs whose values, data sets and columns are collected, and
whose results, without dumps and input scripts, make up the archive of the version:

    tar --owner=root --group=root --sort=name -C DIR -c chain scan run | xz -9e > FILE
"""

from __future__ import annotations

import argparse
import csv
import inspect
import json
import sys
import textwrap
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import h5py

import granwave
from granwave.workflows.cli.keys.reference import tables
from granwave.workflows.cli.main import main
from granwave.workflows.cli.parser import make_parser
from tests.golden import names

FILE = Path(__file__).parent / "promised.json"
FCC = ("packing.size=[4,4,3]", "run.end_time=1.5e-5", "run.frames=2")
CHAIN = ("packing.size=6", "run.end_time=2e-5", "run.frames=2")
SCAN = """\
name = "restitution"
case = "two-spheres"
[set]
run.end_time = 4e-5
run.frames = 2
[grid]
load.velocity = [0.1, 1.0]
"""
RUNS = ("run", "chain")
STYLES = "styles"
_WIDTH = 119
_KEPT = "\0"  # in place of a blank where a line must not be broken


def settings(values: Iterable[str]) -> list[str]:
    """Return the options that set these keys."""
    words: list[str] = []
    for value in values:
        words += ["--set", value]
    return words


def make_runs(place: Path) -> None:
    """Run fcc spheres and a chain in ``run`` and ``chain`` of a directory."""
    options = ["--no-figures", "-o"]
    assert main(["run", "fcc-small", *settings(FCC), *options, str(place / "run")]) == 0
    assert main(["run", "homogeneous-chain", *settings(CHAIN), *options, str(place / "chain")]) == 0


def actions() -> dict[str, dict[str, argparse.Action]]:
    """Options and arguments of each command, by their words."""
    parsers = next(
        one for one in make_parser()._actions if isinstance(one, argparse._SubParsersAction)
    )
    found: dict[str, dict[str, argparse.Action]] = {}
    for name, parser in parsers.choices.items():
        words: dict[str, argparse.Action] = {}
        for action in parser._actions:
            written = action.option_strings or [str(action.metavar or action.dest)]
            words |= dict.fromkeys(written, action)
        found[name] = {word: words[word] for word in sorted(words) if word not in names.HELP}
    return found


def choices() -> dict[str, list[str]]:
    """Values of the options that accept only some: ``law --law``."""
    return {
        f"{name} {word}": sorted(map(str, action.choices))
        for name, words in actions().items()
        for word, action in words.items()
        if action.choices
    }


def keys() -> list[str]:
    """Keys of all files: ``case:load.velocity``."""
    return sorted(
        f"{table.file}:{table.name}.{key.name}" for table in tables() for key in table.keys
    )


def summary_values(place: Path) -> list[str]:
    """Values of summary.json of the fcc spheres."""
    return sorted(json.loads((place / "run" / "summary.json").read_text(encoding="utf-8")))


def data_sets(place: Path) -> dict[str, str]:
    """Groups and data sets of result.h5, with their units."""
    found: dict[str, str] = {}
    for name in RUNS:
        with h5py.File(place / name / "result.h5") as file:
            file.visititems(lambda path, one: found.update({path: str(one.attrs.get("unit", ""))}))
    return dict(sorted(found.items()))


def columns(scan: Path) -> list[str]:
    """Columns of scan.csv of a scan."""
    with (scan / "scan.csv").open(encoding="utf-8", newline="") as stream:
        return next(csv.reader(stream))


def arguments() -> dict[str, list[str]]:
    """Parameters of the functions of Python and of methods; none of other members."""
    found: dict[str, list[str]] = {}
    for module, path in (
        (granwave, ""),
        (granwave.measures, "measures."),
        (granwave.theory, "theory."),
    ):
        found |= _arguments_of(module, path)
    return found


def _arguments_of(module: ModuleType, path: str) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for name in module.__all__:
        value = getattr(module, name)
        if inspect.isfunction(value):
            found[f"{path}{name}"] = list(inspect.signature(value).parameters)
        elif inspect.isclass(value):
            for member in sorted(_members(value)):
                found[f"{path}{name}.{member}"] = _parameters(getattr(value, member, None))
    return found


def _members(cls: type) -> set[str]:
    """Return the public members of a class, with those of a mapping."""
    mapping = dir(Mapping) if issubclass(cls, Mapping) else []
    return names.members(cls) | {name for name in mapping if not name.startswith("_")}


def _parameters(member: Any) -> list[str]:
    """Return the parameters of a method, without the first, ``self``."""
    return list(inspect.signature(member).parameters)[1:] if inspect.isfunction(member) else []


def collect(place: Path) -> dict[str, Any]:
    """Return all names, in the form of `FILE`."""
    make_runs(place)
    (place / "scan.toml").write_text(SCAN, encoding="utf-8")
    assert main(["scan", str(place / "scan.toml"), "-o", str(place / "scan"), "--jobs", "1"]) == 0
    before = json.loads(FILE.read_text(encoding="utf-8"))
    return {
        "version": granwave.__version__,
        "commands": {name: list(words) for name, words in actions().items()},
        "choices": choices(),
        "keys": keys(),
        "summary": summary_values(place),
        "result": data_sets(place),
        "scan_csv": columns(place / "scan"),
        "python": sorted(granwave.__all__),
        "arguments": arguments(),
        STYLES: before[STYLES],
    }


def text_of(content: dict[str, Any]) -> str:
    """Return the text of `FILE`: tables of lists with a line for each, others filled."""
    parts: list[str] = []
    for name, value in content.items():
        if isinstance(value, str):
            parts.append(f" {json.dumps(name)}: {json.dumps(value)}")
            continue
        is_table = isinstance(value, dict)
        entries = [
            f"{json.dumps(key)}: {json.dumps(value[key])}" if is_table else json.dumps(key)
            for key in value
        ]
        lines = name in ("commands", "choices", STYLES)
        body = ",\n".join(f"  {entry}" for entry in entries) if lines else _filled(entries)
        first, last = "{}" if is_table else "[]"
        parts.append(f" {json.dumps(name)}: {first}\n{body}\n {last}")
    listed = ",\n".join(parts)
    return f"{{\n{listed}\n}}\n"


def _filled(entries: Iterable[str]) -> str:
    joined = ", ".join(entry.replace(" ", _KEPT) for entry in entries)
    lines = textwrap.fill(
        joined,
        width=_WIDTH,
        initial_indent="  ",
        subsequent_indent="  ",
        break_long_words=False,
        break_on_hyphens=False,
    )
    return lines.replace(_KEPT, " ")


if __name__ == "__main__":
    FOLDER = Path(sys.argv[1])
    FOLDER.mkdir()
    FILE.write_text(text_of(collect(FOLDER)), encoding="utf-8")
