"""Rows of ``inputs.toml``: one invalid or unusual input each, the command, and the check of its
output.
"""

from __future__ import annotations

import contextlib
import ctypes
import dataclasses
import os
import re
import resource
import shlex
import shutil
import signal
import subprocess
import tomllib
import unicodedata
from collections.abc import Callable, Iterator, Mapping, Sequence
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import BIN, PLAIN
from tests.helpers.programs.command import command

TABLE = Path(__file__).with_name("inputs.toml")
# limits of a row: s, and bytes in addition to those used by the tests
SECONDS = 20.0
MEMORY = 2**30
PROCESS_SECONDS = 120.0
LONGEST_ID = 100  # characters in the name of a test
LONGEST_LINE = 1500  # characters; messages must be readable
OURS = re.compile(r"granwave( \w+)?: ")  # prefix of every line for the user
INNARDS = re.compile(
    r"Traceback|\b[A-Z]\w*Error\b|\bErrno\b|NoneType|<class '| object at 0x|\bPosixPath\b"
)
_OVER_FILES = 1 << 1 | 1 << 2  # CAP_DAC_OVERRIDE and CAP_DAC_READ_SEARCH
REPEATED = re.compile(r"<(\d+)\*(.)>")
USAGE = re.compile(r"usage: .*\n(?: .*\n)*")

Entries = dict[str, tuple[int, ...]]
Answer = subprocess.CompletedProcess[str]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Row:
    """Input and expected output; the keys are described at the top of ``inputs.toml``."""

    kind: str
    what: str
    granwave: str = ""
    shell: str = ""
    prepared: Sequence[str] = ()
    unchecked: bool = False
    lose: Sequence[str] = ()
    cut: Sequence[str] = ()
    files: Mapping[str, str] = dataclasses.field(default_factory=dict)
    add: str = ""
    env: Mapping[str, str] = dataclasses.field(default_factory=dict)
    status: int = 2
    says: Sequence[str] = ()
    faults: int | None = None
    prints: Sequence[str] = ()
    writes: Sequence[str] = ()
    keeps: Sequence[str] = ()
    holds: Mapping[str, Sequence[str]] = dataclasses.field(default_factory=dict)
    lacks: Mapping[str, Sequence[str]] = dataclasses.field(default_factory=dict)
    slow: bool = False


def read_rows(path: Path = TABLE) -> tuple[dict[str, str], list[Row]]:
    """Read the table.

    Returns
    -------
    folder
        Text of the files in the folder of every row, by name.
    rows
        Rows in the order of the table; one for each command of a row that has several.
    """
    tables = tomllib.loads(path.read_text(encoding="utf-8"))
    rows = []
    for kind, entry in (
        (kind, _with_repeats(entry))
        for kind, entries in tables["inputs"].items()
        for entry in entries
    ):
        lists = ("prepared", "lose", "cut", "says", "prints", "writes", "keeps")
        entry |= {name: [entry[name]] for name in lists if isinstance(entry.get(name), str)}
        commands = entry.pop("granwave", "")
        what = entry.pop("what")
        for line in [commands] if isinstance(commands, str) else commands:
            more = "" if isinstance(commands, str) else f": {line}"
            rows.append(Row(kind=kind, what=what + more, granwave=line, **entry))
    return tables["folder"], rows


def _with_repeats(value: Any) -> Any:
    """Expand repetitions in a text: ``<3*a>`` to aaa."""
    if isinstance(value, str):
        return REPEATED.sub(lambda found: int(found[1]) * found[2], value)
    if isinstance(value, list):
        return [_with_repeats(item) for item in value]
    if isinstance(value, dict):
        return {name: _with_repeats(item) for name, item in value.items()}
    return value


def parameters(rows: Sequence[Row]) -> list[Any]:
    """Rows as parameters of a test, with their marks."""
    return [pytest.param(row, id=f"{row.kind}: {row.what}"[:LONGEST_ID], marks=[pytest.mark.validation] * row.slow)
            for row in rows]  # fmt: skip


# ---------------------------------------------------------------------- running


def damage(row: Row, folder: Path) -> None:
    """Change the files of the folder as specified by the row."""
    for path in _named(folder, row.lose):
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    for path in _named(folder, row.cut):
        with path.open("r+b") as file:
            file.truncate(path.stat().st_size // 2)
    for name, text in row.files.items():
        for path in _named(folder, [name]) if "*" in name else [folder / name]:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
    if row.add:
        with (folder / "case.toml").open("a", encoding="utf-8") as file:
            file.write(row.add + "\n")


def _named(folder: Path, names: Sequence[str]) -> list[Path]:
    found = {name: sorted(folder.glob(name)) for name in names}
    assert all(found.values()), f"not there: {[name for name in found if not found[name]]}"
    return [path for paths in found.values() for path in paths]


def run_here(
    words: Sequence[str],
    folder: Path,
    env: Mapping[str, str],
    capfd: pytest.CaptureFixture[str],
    seconds: float = SECONDS,
) -> Answer:
    """Run the command line in this process, from ``folder``, with limits of time and memory."""
    with pytest.MonkeyPatch.context() as patch, _within_bounds(seconds), without_power_over_files():
        for name, value in env.items():
            patch.setenv(name, value)
        return command(words, folder, capfd)


def run_row(row: Row, folder: Path, capfd: pytest.CaptureFixture[str]) -> Answer:
    """Run the command of the row in its folder; a line of a shell in a process, with the command
    ``granwave``.
    """
    if not row.shell:
        seconds = PROCESS_SECONDS if row.slow else SECONDS
        return run_here(shlex.split(row.granwave), folder, row.env, capfd, seconds)
    paths = os.pathsep.join([str(BIN), os.environ.get("PATH", "")])
    return subprocess.run(
        ["/bin/bash", "-o", "pipefail", "-c", row.shell], cwd=folder, capture_output=True, text=True, errors="replace",
        timeout=PROCESS_SECONDS, env={**PLAIN, "PATH": paths, **row.env},
    )  # fmt: skip


@contextlib.contextmanager
def without_power_over_files() -> Iterator[None]:
    """Enforce the read and write permissions of files for all users, including root."""
    libc = ctypes.CDLL(None, use_errno=True)
    # the version of the kernel's interface, two words of 32 bits for each set, and this process
    header = (ctypes.c_uint32 * 2)(0x20080522, 0)
    sets = (ctypes.c_uint32 * 6)()

    def call(function: Callable[..., int]) -> None:
        if function(header, sets):
            raise OSError(ctypes.get_errno(), "capabilities")

    call(libc.capget)
    before = sets[0]  # the effective ones
    sets[0] = before & ~_OVER_FILES
    call(libc.capset)
    try:
        yield
    finally:
        sets[0] = before
        call(libc.capset)


class OverTime(BaseException):
    """Exceeded time limit of a row; not caught by error handlers."""


@contextlib.contextmanager
def _within_bounds(seconds: float) -> Iterator[None]:
    """Limit the time of the processor, that on a clock to ten times as much, and the memory."""

    def stop(*_: object) -> None:
        raise OverTime(f"longer than {seconds:g} s")

    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    timers = {
        signal.SIGPROF: (signal.ITIMER_PROF, seconds),
        signal.SIGALRM: (signal.ITIMER_REAL, 10 * seconds),
    }
    before = {name: signal.signal(name, stop) for name in timers}
    for timer, limit in timers.values():
        signal.setitimer(timer, limit)
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + MEMORY, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
        for name, (timer, _) in timers.items():
            signal.setitimer(timer, 0.0)
            signal.signal(name, before[name])


# ---------------------------------------------------------------------- judging


def entries_of(folder: Path) -> Entries:
    """Files and folders below a folder by path: mode, and for files the size and, unless empty, the
    modification time.
    """
    found: Entries = {}
    for place, directories, files in os.walk(folder):
        for name in (*directories, *files):
            path = os.path.join(place, name)
            entry = os.lstat(path)
            key = os.path.relpath(path, folder)
            if name in directories and not os.path.islink(path):
                found[key] = (entry.st_mode,)
            else:
                found[key] = (
                    entry.st_mode,
                    entry.st_size,
                    entry.st_mtime_ns if entry.st_size else 0,
                )
    return found


def judge(row: Row, answer: Answer, folder: Path, before: Entries, after: Entries) -> None:
    """Assert that the output is the one expected by the row."""
    shown = f"\n{shown_answer(row.shell or row.granwave, answer)}"
    assert answer.returncode == row.status, shown
    assert len(faults_in(answer.stderr)) == (
        bool(row.status) if row.faults is None else row.faults
    ), shown
    for fragments, text in ((row.says, answer.stderr), (row.prints, answer.stdout)):
        assert not [one for one in fragments if one not in text], (
            f"not all of {fragments} are said{shown}"
        )
    changed = sorted(name for name in {*before, *after} if before.get(name) != after.get(name))
    places = [os.path.normpath(f"{folder.name}/{place}") for place in row.writes]
    # the list of files written by granwave, to which a file is added before it is rewritten
    changed = [
        name for name in changed if os.path.basename(name) != ".granwave" or name not in before
    ]
    unasked = [name for name in changed if not any(_is_at(name, place) for place in places)]
    assert not unasked, f"written or changed: {unasked}{shown}"
    for place in places:
        assert any(_is_at(name, place) for name in after), f"{place} was not written{shown}"
    for name in row.keeps:
        assert f"{folder.name}/{name}" in before and f"{folder.name}/{name}" not in changed, (
            f"{name} was not kept{shown}"
        )
    for wanted, files in ((True, row.holds), (False, row.lacks)):
        for name, fragments in files.items():
            text = (folder / name).read_text(encoding="utf-8")
            assert all((one in text) == wanted for one in fragments), (
                f"{fragments} in {name}: expected {wanted}"
            )


def shown_answer(command: str, answer: Answer) -> str:
    """Output for the message of a failed test; asserts that it contains no traceback or the like."""
    shown = f"{command}\nstatus {answer.returncode}\n{answer.stdout}{answer.stderr}"
    assert not INNARDS.search(answer.stdout + answer.stderr), shown
    return shown


def faults_in(err: str) -> list[str]:
    """Error lines of standard error; asserts that all lines are readable messages.

    Warnings, progress lines in a log and the usage line of argparse are not errors.
    """
    lines = USAGE.sub("", err).splitlines()
    for line in lines:
        assert len(line) <= LONGEST_LINE, f"{len(line)} characters in a line: {line[:300]} ..."
        odd = [c for c in line if unicodedata.category(c) in ("Cc", "Cs") and c != "\t"]
        assert not odd, f"control characters {odd} in {line!r}"
    return [
        line for line in lines if OURS.match(line) and not line.startswith("granwave: warning: ")
    ]


def _is_at(name: str, place: str) -> bool:
    """True if ``name`` is the ``place`` (a path, possibly with * and ?), or is in it."""
    parts = name.split("/")
    return any(fnmatch("/".join(parts[:n]), place) for n in range(1, len(parts) + 1))
