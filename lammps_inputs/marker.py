"""The marker of a directory of results, ``.granwave`` (JSON): its kind, the case that was run, and
the files that granwave wrote there.
"""

from __future__ import annotations

import copy
import dataclasses
import json
from pathlib import Path, PurePosixPath
from typing import Any

from granwave import __version__
from granwave.lammps_inputs import run_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_json, replacing

State = tuple[int, int, int] | None  # inode, size and time of a marker on disk; None without one


@dataclasses.dataclass
class Marker:
    """Record of the files that granwave wrote into a directory.

    Attributes
    ----------
    kind
        Kind of the results, such as `run_directory.RUN`; empty if granwave wrote nothing there.
    version
        Version of granwave that last wrote there.
    case
        Text of case.toml at the start of the run; empty if there is none.
    files
        Sizes in bytes by name relative to the directory; None for files whose size was not noted. A
        name that ends in "/" is a directory of results with a separate marker; a name with "%"
        means the files of all ranks.
    digests
        Digests of the LAMMPS input files as granwave wrote them, by name.
    sums
        CRC-32 of finished files by name, as their sizes in ``files``.
    format
        Format of the results; 0 of versions that gave none.
    """

    kind: str = ""
    version: str = __version__
    case: str = ""
    files: dict[str, int | None] = dataclasses.field(default_factory=dict)
    digests: dict[str, str] = dataclasses.field(default_factory=dict)
    sums: dict[str, int] = dataclasses.field(default_factory=dict)
    format: int = run_directory.FORMAT

    def copy(self) -> Marker:
        """Return a copy that is independent of later changes of this marker."""
        return copy.deepcopy(self)

    def write(self, path: Path) -> State:
        """Replace the file of the marker atomically; return its `state`."""
        self.version = __version__
        self.format = run_directory.FORMAT
        self.digests = {name: digest for name, digest in self.digests.items() if name in self.files}
        self.sums = {
            name: value for name, value in self.sums.items() if self.files.get(name) is not None
        }
        with replacing(path) as scratch:
            text = json.dumps(dataclasses.asdict(self), indent=1) + "\n"
            scratch.write_text(text, encoding="utf-8")
            return state(scratch)  # inode and time remain the same under the new name


def state(path: Path) -> State:
    """Return values that change when another process replaces a marker; None without a marker."""
    try:
        status = path.lstat()
    except OSError:
        return None
    return status.st_ino, status.st_size, status.st_mtime_ns


def read_marker(path: Path) -> Marker:
    """Read a marker; without a kind if the file is missing, damaged or a link.

    Raises
    ------
    InputError
        A later version wrote it, in a format unknown to this version.
    """
    content = None if path.is_symlink() else read_json(path)
    if content is None:
        return Marker()
    kind = content.get("kind")
    case = content.get("case", "")
    files = content.get("files")
    if not (isinstance(kind, str) and isinstance(case, str) and isinstance(files, dict)):
        return Marker()
    version = str(content.get("version", ""))
    made = content.get("format", 0)
    if newer := run_directory.newer_format(made, version):
        raise InputError(f"{path.parent}: {newer}")
    inside = {name: size for name, size in files.items() if _is_inside(name)}
    return Marker(
        kind, version, case, inside, _table(content, "digests"), _table(content, "sums"), made
    )


def _is_inside(name: str) -> bool:
    """Return True for a name that does not lead outside the directory."""
    path = PurePosixPath(name)
    return bool(path.parts) and not path.is_absolute() and ".." not in path.parts


def _table(content: dict[str, Any], name: str) -> dict[str, Any]:
    table = content.get(name)
    return table if isinstance(table, dict) else {}
