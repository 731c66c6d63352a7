"""Folders and files that cannot be given as text, by their names in ``inputs.toml`` under
``prepared``.
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import h5py

LOCK = ".granwave-lock"


def empty_folder(folder: Path) -> None:
    """Make an empty ``place/``."""
    (folder / "place").mkdir()


def folder_with_notes(folder: Path) -> None:
    """Make ``place/`` with files of the user whose names are not those of results."""
    (folder / "place" / "figures").mkdir(parents=True)
    for name in ("thesis.tex", "data.csv", "figures/photo.png"):
        (folder / "place" / name).write_text("years of work", encoding="utf-8")


def folder_of_somebody(folder: Path) -> None:
    """Make ``place/`` with files of the user, also with names of results of runs and scans."""
    folder_with_notes(folder)
    for name in ("case.toml", "summary.json", "scan.toml", "scan.csv"):
        (folder / "place" / name).write_text("years of work", encoding="utf-8")


def read_only_folder(folder: Path) -> None:
    """Make ``place/`` without write permission."""
    (folder / "place").mkdir()
    (folder / "place").chmod(0o555)


def closed_folder(folder: Path) -> None:
    """Make ``place/`` without read permission."""
    (folder / "place").mkdir()
    (folder / "place").chmod(0)


def unreadable_files(folder: Path) -> None:
    """Make the case and the scan file unreadable."""
    for name in ("case.toml", "scan.toml"):
        (folder / name).chmod(0)


def busy_folder(folder: Path) -> None:
    """Make ``place/``, in use by another process."""
    (folder / "place").mkdir()
    _HELD.append((folder / "place" / LOCK).open("w"))
    fcntl.flock(_HELD[-1], fcntl.LOCK_EX)


def stale_lock(folder: Path) -> None:
    """Make ``place/`` with the lock of a run that was killed."""
    (folder / "place").mkdir()
    (folder / "place" / LOCK).touch()


def odd_files(folder: Path) -> None:
    """Make a pipe, a loop of links, links to a missing file and to endless zeros, and large files."""
    os.mkfifo(folder / "pipe.toml")
    (folder / "loop.toml").symlink_to("loop.toml")
    (folder / "dangling.toml").symlink_to("nowhere.toml")
    (folder / "zeros.toml").symlink_to("/dev/zero")
    for name in ("large.toml", "large.csv", "large.txt"):
        with (folder / name).open("wb") as file:
            file.write(b"# ")
            file.truncate(100_000_000)


def odd_bytes(folder: Path) -> None:
    """Write the case in other encodings and with bytes that are not UTF-8 text, each as
    ``NAME.toml``.
    """
    text = (folder / "case.toml").read_text(encoding="utf-8")
    for name, content in {
        "bom": b"\xef\xbb\xbf" + text.encode(),
        "crlf": text.replace("\n", "\r\n").encode(),
        "mac": text.replace("\n", "\r").encode(),
        "latin1": text.replace("small", "kl\u00f6in").encode("latin-1"),
        "utf16": text.encode("utf-16"),
        "nul": text.replace("small", "sm\0all").encode(),
        "noise": bytes(range(256)) * 40,
        "png": b"\x89PNG\r\n\x1a\n" + bytes(64),
    }.items():
        (folder / f"{name}.toml").write_bytes(content)
    (folder / "noise.csv").write_bytes(bytes(range(256)) * 40)


def other_h5(folder: Path) -> None:
    """Make ``run/result.h5`` an HDF5 file that is not a result of a run."""
    with h5py.File(folder / "run" / "result.h5", "w") as file:
        file["music"] = [1, 2, 3]


def wrong_types_in_h5(folder: Path) -> None:
    """Make ``run/result.h5`` with a data set in place of a group of data sets."""
    with h5py.File(folder / "run" / "result.h5", "r+") as file:
        del file["contacts"]
        file["contacts"] = "none"


def run_with_a_markup_name(folder: Path) -> None:
    """Make a run in a directory whose name is HTML markup."""
    (folder / "run").rename(folder / "a<b onclick=x>&")


def edited_case(folder: Path) -> None:
    """Write ``run/case.toml`` with another velocity."""
    path = folder / "run" / "case.toml"
    text = path.read_text(encoding="utf-8")
    assert "velocity = 5.0" in text
    path.write_text(text.replace("velocity = 5.0", "velocity = 6.0"), encoding="utf-8")


def noise_for_spheres(folder: Path) -> None:
    """Write ``run/dumps/spheres.bin`` with bytes that are no snapshot."""
    (folder / "run" / "dumps" / "spheres.bin").write_bytes(bytes(range(256)) * 100)


def _change_last_contact(folder: Path, words: dict[int, str]) -> None:
    path = folder / "run" / "dumps" / "contacts.dump"
    *rows, last = path.read_text(encoding="utf-8").splitlines()
    last = " ".join(words.get(k, word) for k, word in enumerate(last.split()))
    path.write_text("\n".join([*rows, last]) + "\n", encoding="utf-8")


def nan_in_contacts(folder: Path) -> None:
    """Make the first value of the last contact invalid."""
    _change_last_contact(folder, {2: "nan"})


def strangers_in_contacts(folder: Path) -> None:
    """Make the last contact one of two spheres that do not exist."""
    _change_last_contact(folder, {0: "1000", 1: "1001"})


def deep_nesting(folder: Path) -> None:
    """Write ``deep.toml`` with 100 000 brackets, ``long.toml`` with a number of 100 000 digits."""
    (folder / "deep.toml").write_text("a = " + "[" * 100_000, encoding="utf-8")
    (folder / "long.toml").write_text("a = " + "1" * 100_000, encoding="utf-8")


PLACES: Mapping[str, Callable[[Path], None]] = {
    made.__name__: made
    for made in (
        empty_folder, folder_with_notes, folder_of_somebody, read_only_folder, closed_folder, unreadable_files, busy_folder, stale_lock,
        odd_files, odd_bytes, other_h5, wrong_types_in_h5, deep_nesting, run_with_a_markup_name, edited_case,
        noise_for_spheres, nan_in_contacts, strangers_in_contacts,
    )
}  # fmt: skip
_HELD: list[Any] = []  # open locks


def release(folder: Path) -> None:
    """Release the locks, and make all files below ``folder`` removable."""
    while _HELD:
        _HELD.pop().close()
    for place in folder.iterdir():
        if place.is_dir() and not place.is_symlink():
            place.chmod(0o755)
