"""Compressed files, and files of kinds without grains, identified by their first bytes."""

from __future__ import annotations

import bz2
import dataclasses
import gzip
import io
import lzma
import re
import zipfile
import zlib
from collections.abc import Callable

_TAR = b"ustar"
_PLACE_OF_TAR = 257  # bytes before the signature
_ZIP = b"PK\x03\x04"
_UNPACKERS: dict[bytes, tuple[str, Callable[[bytes], bytes]]] = {
    b"\x1f\x8b": (".gz", gzip.decompress),
    b"\xfd7zXZ\x00": (".xz", lzma.decompress),
    b"BZh": (".bz2", bz2.decompress),
}
_SPREADSHEETS = {"xl/workbook.xml": ".xlsx", "content.xml": ".ods"}
_DAMAGED = (OSError, EOFError, zlib.error, lzma.LZMAError, zipfile.BadZipFile)


@dataclasses.dataclass(frozen=True)
class OtherKind:
    """Kind of files without grains.

    Attributes
    ----------
    start
        First bytes of the file.
    label
        Its name in messages.
    remedy
        Remedy for the user.
    """

    start: bytes
    label: str
    remedy: str


_REMEDY_OF_DUMPS = "write it as text by dump custom: id type x y z radius"
_REMEDY_OF_ROWS = "write a table with a line x y z radius and a row for each grain"
_HEAD_OF_BINARY_DUMPS = (
    b"\xf8" + 7 * b"\xff" + b"DUMPATOM",  # behind the length of the word, negative
    b"\xf6" + 7 * b"\xff" + b"DUMPCUSTOM",
)
_OTHER_KINDS = (
    OtherKind(b"\x28\xb5\x2f\xfd", "a .zst file", "unpack it (unzstd)"),
    OtherKind(b"7z\xbc\xaf\x27\x1c", "a .7z file", "unpack it"),
    OtherKind(b"Rar!", "a .rar file", "unpack it"),
    OtherKind(b"\xd0\xcf\x11\xe0", "a spreadsheet (.xls)", "save it as CSV"),
    OtherKind(b"\x93NUMPY", "a NumPy array", "save it as text by numpy.savetxt"),
    OtherKind(b"MATLAB 5.0", "a MATLAB file", "save a table by writetable or writematrix"),
    OtherKind(
        b"version https://git-lfs", "a Git LFS pointer", "get the file itself with git lfs pull"
    ),
    OtherKind(b"CDF", "a NetCDF file", "write the grains by dump custom, or as a table"),
    OtherKind(b"PAR1", "a Parquet file", "save it as CSV"),
    OtherKind(_HEAD_OF_BINARY_DUMPS[0], "a binary dump of LAMMPS", _REMEDY_OF_DUMPS),
    OtherKind(_HEAD_OF_BINARY_DUMPS[1], "a binary dump of LAMMPS", _REMEDY_OF_DUMPS),
    OtherKind(b"ply\n", "a PLY file", "save a table of x, y, z and radius"),
    OtherKind(b"ball create", "commands of PFC", _REMEDY_OF_ROWS),
    OtherKind(b"$bdyty", "bodies of LMGC90", _REMEDY_OF_ROWS),
    OtherKind(b"! File BODIES", "bodies of LMGC90", _REMEDY_OF_ROWS),
    OtherKind(b"<!DOCTYPE html", "a web page", "download the file itself"),
    OtherKind(b"<html", "a web page", "download the file itself"),
    OtherKind(b"LAMMPS (", "a log of LAMMPS", _REMEDY_OF_DUMPS),
    OtherKind(b"<?xml version='1.0'?>\n<GranOO", "a domain of GranOO", _REMEDY_OF_ROWS),
    OtherKind(b"Begin ModelPartData", "a model part of Kratos", _REMEDY_OF_ROWS),
    OtherKind(b'View "" {', "a view of Gmsh", _REMEDY_OF_ROWS),
    OtherKind(b"\x80\x04\x95", "a pickle of Python", _REMEDY_OF_ROWS),
)
# signatures for which the first bytes are not sufficient
_BOOST = re.compile(rb"<!DOCTYPE boost_serialization>")
_BOOST_BINARY = re.compile(rb".{0,16}serialization::archive", re.DOTALL)
_MUSEN = re.compile(rb"0 \d+ 1 1?[0-9] 5 .{0,40} 23 [0-9A-Z]{20} 24 ")
_STL = re.compile(rb"solid\b.*\n\s*facet\s+normal", re.IGNORECASE)
_PATTERNS = {
    _BOOST: OtherKind(b"", "a simulation of YADE (O.save)", "write it by yade.export.text"),
    _BOOST_BINARY: OtherKind(b"", "a simulation of YADE (O.save)", "write it by yade.export.text"),
    _MUSEN: OtherKind(b"", "a scene of MUSEN", _REMEDY_OF_ROWS),
    _STL: OtherKind(b"", "a surface (STL)", "name it in [[wall]], and the grains here"),
}
_HEAD = 1000  # bytes that are searched for such a pattern
_ARRAYS = ".npy"  # members of a .npz


def unpacked(raw: bytes) -> bytes:
    """Return the content of a file, unpacked if it is a .gz, .xz, .bz2, or a .zip of one file.

    Raises
    ------
    ValueError
        It is damaged, or of a kind without grains; the message states the remedy.
    """
    for start, (ending, unpack) in _UNPACKERS.items():
        if raw.startswith(start):
            return _checked(_without_package(raw, ending, unpack))
    if raw.startswith(_ZIP):
        return _checked(_without_package(raw, ".zip", _file_of_zip))
    return _checked(raw)


def _checked(raw: bytes) -> bytes:
    """Return the content of a file; raise ValueError if it is of a kind that holds no grains."""
    if raw.startswith(_TAR, _PLACE_OF_TAR):
        raise ValueError(
            "found an archive (.tar), expected a file of grains; unpack it and name the file"
        )
    kinds = [kind for kind in _OTHER_KINDS if _starts_with(raw, kind.start)]
    kinds += [kind for pattern, kind in _PATTERNS.items() if _fits(raw, pattern)]
    for kind in kinds:
        raise ValueError(f"found {kind.label}, expected a file of grains; {kind.remedy}")
    return raw


def _starts_with(raw: bytes, start: bytes) -> bool:
    """Return True if a file begins with some bytes, in small or capital letters."""
    return raw[: len(start)].lower() == start.lower()


def _fits(raw: bytes, pattern: re.Pattern[bytes]) -> bool:
    """Return True if a file begins with a pattern; the pattern of YADE is below the line of XML."""
    head = raw[:_HEAD]
    return bool(pattern.search(head) if pattern is _BOOST else pattern.match(head))


def _without_package(raw: bytes, ending: str, unpack: Callable[[bytes], bytes]) -> bytes:
    """Return the content of a packed file; raise ValueError if it is damaged."""
    try:
        return unpack(raw)
    except _DAMAGED as error:
        reason = str(error) or type(error).__name__
        raise ValueError(
            f"found a {ending} file that cannot be unpacked ({reason}); copy it again"
        ) from None


def _file_of_zip(raw: bytes) -> bytes:
    """Return the only file of an archive; raise ValueError if it has others."""
    with zipfile.ZipFile(io.BytesIO(raw)) as archive:
        names = [item.filename for item in archive.infolist() if not item.is_dir()]
        for part, ending in _SPREADSHEETS.items():
            if part in names:
                raise ValueError(
                    f"found a spreadsheet ({ending}), expected a file of grains; save it as CSV"
                )
        if names and all(name.endswith(_ARRAYS) for name in names):
            raise ValueError(
                f"found arrays of NumPy (.npz: {', '.join(names)}), expected a file of grains; "
                "save one table of x, y, z and radius as text by numpy.savetxt"
            )
        if len(names) != 1:
            raise ValueError(
                f"found a .zip with {len(names)} files, expected one of them; unpack it and name "
                "the file of the grains"
            )
        try:
            return archive.read(names[0])
        except (RuntimeError, NotImplementedError) as error:  # a password, an unknown method
            raise ValueError(f"found a .zip that cannot be unpacked: {error}") from None
