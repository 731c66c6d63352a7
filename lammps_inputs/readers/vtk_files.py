"""Points with radii in files of VTK: legacy files (ASCII or binary), and XML files of points (VTP,
VTU) with inline or appended data, as ParaView reads them. No format needs the library VTK.

https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
"""

from __future__ import annotations

import base64
import re
import xml.etree.ElementTree as ElementTree
import zlib
from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.message_words import show
from granwave.lammps_inputs.readers.columns import (
    CLUMP,
    DIAMETER,
    ID,
    PLACE,
    RADIUS,
    SPINS,
    TYPE,
    VELOCITIES,
    diameters_of,
    from_one,
    has_sizes,
    quantity_of,
)
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.source import FileOptions, GrainSource
from granwave.lammps_inputs.tables.digits import half_units, significant_half_units
from granwave.lammps_inputs.tables.units import in_si

NAME = "vtk"
LABEL = "VTK"
_LEGACY = "# vtk DataFile"
_XML = re.compile(r"<VTKFile\b")
_TYPES = {
    "char": "i1", "unsigned_char": "u1", "short": "i2", "unsigned_short": "u2", "int": "i4",
    "unsigned_int": "u4", "long": "i8", "unsigned_long": "u8", "float": "f4", "double": "f8",
    "vtkIdType": "i8", "vtktypeint64": "i8",
}  # fmt: skip
_XML_TYPES = {
    "Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2", "Int32": "i4", "UInt32": "u4",
    "Int64": "i8", "UInt64": "u8", "Float32": "f4", "Float64": "f8",
}  # fmt: skip
_DIGITS = {4: 7, 8: 16}  # decimal digits that a binary number of so many bytes holds

Arrays = dict[str, NDArray[np.generic]]


def recognises(source: GrainSource) -> bool:
    """Return True for a legacy or an XML file of VTK."""
    return source.head.startswith(_LEGACY) or bool(_XML.search(source.head))


def read(source: GrainSource) -> GrainTable:
    """Read the points and their arrays; raise ValueError if they have no sizes."""
    if source.head.startswith(_LEGACY):
        reader = _LegacyReader(source.content)
        points = reader.points
        arrays = reader.arrays
        texts = reader.texts
        form = f"{LABEL} legacy file"
    else:
        points, arrays, texts = _read_xml(source)
        form = f"{LABEL} XML file"
    if points is None or not len(points):
        raise ValueError("found no points, expected a point for each grain")
    return grains_of_arrays(form, points, arrays, source.options, texts)


def grains_of_arrays(
    form: str,
    points: NDArray[np.generic],
    arrays: Mapping[str, NDArray[np.generic]],
    options: FileOptions,
    texts: list[str] | None = None,
) -> GrainTable:
    """Return the grains at points with arrays of any names.

    Parameters
    ----------
    form
        Name of the format.
    points
        Centres: (n, 3), in the unit of the file.
    arrays
        Arrays of the points by name: (n,) or (n, 3).
    texts
        Some coordinates as they are written; None if they are binary.

    Raises
    ------
    ValueError
        The grains have no sizes, or an array has another length.
    """
    power = options.power()
    notes: list[str] = []
    values = _by_quantity(arrays, options, notes)
    n = len(points)
    wrong = [name for name, array in values.items() if len(array) != n]
    if wrong:
        raise ValueError(f"found {len(values[wrong[0]])} values of {wrong[0]} for {n} grains")
    if DIAMETER in values:
        values[RADIUS] = np.asarray(values[DIAMETER], dtype=np.float64) / 2
    if not has_sizes(values, options):
        diameter = _diameters_of_volumes(values, power, notes)
        if diameter is not None:
            values[RADIUS] = diameter / 10.0**power / 2
    if not has_sizes(values, options):
        raise ValueError(
            f"found no array of radii or diameters among {', '.join(arrays) or 'none'}, expected "
            "one (packing.columns can name it), or packing.diameter for all grains"
        )
    position = np.asarray(points, dtype=np.float64)
    radius = values.get(RADIUS)
    ids = values.get(ID)
    velocity = _vector(values, VELOCITIES)
    density = values.get("density")
    mass = values.get("mass")
    return GrainTable(
        format=form,
        position=in_si(position, power),
        half_unit=in_si(_half_units(points, position, texts), power),
        radius=None if radius is None else in_si(np.asarray(radius, dtype=np.float64), power),
        ids=None if ids is None else np.asarray(ids, dtype=np.int64),
        types=_names_of_types(values[TYPE]) if TYPE in values else [],
        density=None if density is None else np.asarray(density, dtype=np.float64),
        mass=None if mass is None else np.asarray(mass, dtype=np.float64),
        velocity=None if velocity is None else in_si(velocity, power),
        spin=_vector(values, SPINS),
        clump=_clumps(values, arrays),
        words={
            name: list(map(str, values[name].tolist()))
            for name in ("material", "group")
            if name in values
        },
        notes=notes,
    )


def _clumps(values: Arrays, arrays: Mapping[str, NDArray[np.generic]]) -> NDArray[np.int64] | None:
    """Return the numbers of the clumps, 0 for none: (n,); None without an array of them."""
    if CLUMP not in values:
        return None
    head = next(name for name, array in arrays.items() if array is values[CLUMP])
    numbers = np.asarray(values[CLUMP], dtype=np.float64)
    if not (numbers == np.round(numbers)).all():
        raise ValueError(
            f"found numbers of clumps in {head} that are not whole, expected whole numbers"
        )
    clumps = from_one(numbers.astype(np.int64), head)
    if (clumps < 0).any():
        raise ValueError(f"found {clumps.min()} in {head}, expected numbers of clumps, 0 for none")
    return clumps


def _names_of_types(types: NDArray[np.generic]) -> list[str]:
    """Return types as words: (n,); whole numbers without a decimal point."""
    words = map(str, types.tolist())
    return [word.removesuffix(".0") for word in words]


def _by_quantity(
    arrays: Mapping[str, NDArray[np.generic]], options: FileOptions, notes: list[str]
) -> Arrays:
    """Return arrays by quantity; omitted arrays are noted."""
    values: Arrays = {}
    left_out: list[str] = []
    named = {str(name): quantity for quantity, name in options.names.items()}
    missing = [name for name in named if name not in arrays]
    if missing:
        raise ValueError(
            f"found no array {show(missing[0])} (packing.columns), expected one of "
            f"{', '.join(arrays)}"
        )
    for name, array in arrays.items():
        quantity = named.get(name) or quantity_of(name)[0]
        is_vector = array.ndim == 2 and array.shape[1] == len(PLACE)
        if is_vector:
            quantity = quantity_of(f"{name}_x")[0]
            parts = {"vx": VELOCITIES, "omegax": SPINS}.get(quantity)
            if parts is not None:
                values |= dict(zip(parts, array.T, strict=True))
                continue
        if array.ndim != 1 or not quantity or quantity in PLACE:
            left_out.append(name)
        else:
            values.setdefault(quantity, array)
    if left_out:
        several = "s" if len(left_out) > 1 else ""
        notes.append(f"array{several} ignored: {', '.join(left_out)}")
    return values


def _diameters_of_volumes(
    values: Mapping[str, NDArray[np.generic]], power: float, notes: list[str]
) -> NDArray[np.float64] | None:
    """Return the diameters that follow from volumes, or masses and densities: (n,), m.

    Volumes are in the cubed unit of the lengths of the file, which is this power of ten.
    """
    names = [name for name in ("volume", "mass", "density") if name in values]
    in_units = {name: np.asarray(values[name], dtype=np.float64) for name in names}
    if "volume" in in_units:
        in_units["volume"] = in_si(in_units["volume"], 3 * power)
    heads = dict(zip(names, names, strict=True))
    return diameters_of(in_units, lambda row: f"grain {row + 1}", heads, notes)


def _vector(values: Arrays, names: tuple[str, ...]) -> NDArray[np.float64] | None:
    """Return a vector quantity: (n, 3); None unless all its components are present."""
    if not all(name in values for name in names):
        return None
    return np.stack([np.asarray(values[name], dtype=np.float64) for name in names], axis=1)


def _half_units(
    points: NDArray[np.generic], position: NDArray[np.float64], texts: list[str] | None
) -> NDArray[np.float64]:
    """Return half a unit of the last digit of each coordinate: (n, 3), in the unit of the file."""
    if texts is not None:
        return half_units(texts, position)
    return significant_half_units(position, _DIGITS[points.dtype.itemsize])


class _LegacyReader:
    """Points, and arrays of points, of a legacy file.

    Parameters
    ----------
    content
        Bytes of the file.

    Raises
    ------
    ValueError
        The file is truncated.
    """

    def __init__(self, content: bytes) -> None:
        self.content = content
        lines = content.split(b"\n", 4)
        self.is_binary = len(lines) > 2 and lines[2].strip().upper() == b"BINARY"
        self.place = sum(len(line) + 1 for line in lines[:3])
        self.points: NDArray[np.generic] | None = None
        self.arrays: Arrays = {}
        self.texts: list[str] | None = None
        self.n_points = 0
        self.n_rows = 0  # points or cells of the section that is read
        self.of_points = True
        while (words := self._line()) is not None:
            self._read_section(words)

    def _line(self) -> list[str] | None:
        """Return the words of the next line that is not empty; None at the end."""
        while self.place < len(self.content):
            end = self.content.find(b"\n", self.place)
            end = len(self.content) if end < 0 else end
            words = self.content[self.place : end].decode("latin-1").split()
            self.place = end + 1
            if words:
                return words
        return None

    def _read_section(self, words: list[str]) -> None:
        """Read the section that a line begins; other lines are skipped."""
        keyword = words[0].upper()
        try:
            self._read_values(keyword, words)
        except (IndexError, OverflowError):
            raise ValueError(
                f"found {show(' '.join(words))} without its numbers: the file is damaged"
            ) from None

    def _read_values(self, keyword: str, words: list[str]) -> None:
        """Read the values of a section; raise IndexError if its first line lacks a word."""
        if keyword == "METADATA":
            self._pass_metadata()
        elif keyword == "POINTS":
            self.n_points = int(words[1])
            self.points = self._numbers(3 * self.n_points, words[2]).reshape(-1, 3)
        elif keyword in ("POINT_DATA", "CELL_DATA"):
            self.of_points = keyword == "POINT_DATA"
            self.n_rows = int(words[1])
        elif keyword == "SCALARS":
            n_parts = int(words[3]) if len(words) > 3 else 1
            self._pass_lookup_table()
            self._keep(words[1], self._numbers(n_parts * self.n_rows, words[2]), n_parts)
        elif keyword in ("VECTORS", "NORMALS"):
            self._keep(words[1], self._numbers(3 * self.n_rows, words[2]), 3)
        elif keyword == "TENSORS":
            self._numbers(9 * self.n_rows, words[2])
        elif keyword == "FIELD":
            for _ in range(int(words[2])):
                self._read_array(self._line() or [])

    def _read_array(self, words: list[str]) -> None:
        """Read an array of a field; arrays of words are skipped."""
        if words and words[0].upper() == "METADATA":
            self._pass_metadata()
            words = self._line() or []
        name, parts, rows, kind = words[:4]
        if kind == "string":
            for _ in range(int(parts) * int(rows)):
                self._line()
            return
        values = self._numbers(int(parts) * int(rows), kind)
        if int(rows) == self.n_points:
            self._keep(name, values, int(parts))

    def _pass_lookup_table(self) -> None:
        """Skip the line LOOKUP_TABLE, which some programs omit."""
        place = self.place
        words = self._line() or [""]
        if words[0].upper() != "LOOKUP_TABLE":
            self.place = place

    def _pass_metadata(self) -> None:
        """Skip the lines of a block METADATA, which ends with an empty line."""
        end = re.compile(rb"\r?\n[ \t]*\r?\n").search(self.content, self.place - 1)
        self.place = len(self.content) if end is None else end.end()

    def _keep(self, name: str, values: NDArray[np.generic], n_parts: int) -> None:
        if self.of_points:
            self.arrays[name] = values if n_parts == 1 else values.reshape(-1, n_parts)

    def _numbers(self, n: int, kind: str) -> NDArray[np.generic]:
        """Return the next numbers."""
        if kind not in _TYPES:
            raise ValueError(f"found data of type {show(kind)}, expected {', '.join(_TYPES)}")
        dtype = np.dtype(_TYPES[kind])
        if self.is_binary:
            raw = self.content[self.place : self.place + n * dtype.itemsize]
            self.place += len(raw)
            values: NDArray[np.generic] = np.frombuffer(raw, dtype.newbyteorder(">"))
            values = values.astype(dtype)
        else:
            values = self._ascii_numbers(n, dtype)
        if len(values) != n:
            raise ValueError(f"found {len(values)} of {n} numbers: the file is truncated")
        return values

    def _ascii_numbers(self, n: int, dtype: np.dtype[np.generic]) -> NDArray[np.generic]:
        """Return the next numbers of an ASCII file, which may be on any number of lines."""
        words: list[str] = []
        while len(words) < n and (line := self._line()) is not None:
            words += line
        if self.texts is None:
            self.texts = words
        try:
            values = np.array(words[:n], dtype=np.float64)
        except ValueError:
            raise ValueError("found a word among numbers: the file is truncated") from None
        return values if dtype.kind == "f" else values.astype(dtype)


def _read_xml(
    source: GrainSource,
) -> tuple[NDArray[np.generic] | None, Arrays, list[str] | None]:
    """Return points, arrays of points by name, and coordinates as text of an XML file."""
    content = source.content
    blob = b""
    start = content.find(b"<AppendedData")
    if start >= 0:  # may be raw, which is no XML
        begin = content.find(b"_", content.find(b">", start)) + 1
        blob = content[begin:]
        content = content[:start] + b"</VTKFile>"
    try:
        root = ElementTree.fromstring(content)
    except ElementTree.ParseError as error:
        raise ValueError(f"found XML that is damaged or truncated ({error})") from None
    sources = [element.get("file") or element.get("Source") for element in root.iter()]
    if names := [name for name in sources if name]:
        raise ValueError(
            f"found a list of other files ({names[0]} ...), expected points; give one "
            "of them, or save all as one file"
        )
    reader = _XmlReader(root, blob, is_raw=b'encoding="raw"' in source.content[start:][:200])
    pieces = [_read_piece(reader, piece) for piece in root.iter("Piece")]
    filled = [piece for piece in pieces if piece is not None]
    if not filled:
        return None, {}, None
    points = np.concatenate([piece[0] for piece in filled])
    arrays: Arrays = {}
    for name in filled[0][1]:
        parts = [piece[1][name] for piece in filled if name in piece[1]]
        if len(parts) == len(filled):
            arrays[name] = np.concatenate(parts)
    texts: list[str] = []
    for piece in filled:
        texts += piece[2]
    return points, arrays, texts or None


def _read_piece(
    reader: _XmlReader, piece: ElementTree.Element
) -> tuple[NDArray[np.generic], Arrays, list[str]] | None:
    """Return points, arrays and coordinates as text of a piece; None if it has no points."""
    element = piece.find("Points/DataArray")
    if element is None or piece.get("NumberOfPoints") == "0":
        return None
    points = reader.rows(element, len(PLACE))
    if not len(points):
        return None
    texts = (element.text or "").split() if element.get("format") == "ascii" else []
    arrays: Arrays = {}
    for array in piece.iterfind("PointData/DataArray"):
        n_parts = array.get("NumberOfComponents") or "1"
        name = array.get("Name") or ""
        if not n_parts.isdigit():
            raise ValueError(f"found {show(n_parts)} components of {name}, expected a number")
        arrays[name] = reader.rows(array, int(n_parts))
    return points, arrays, texts


class _XmlReader:
    """Arrays of an XML file of VTK.

    Parameters
    ----------
    root
        The file.
    blob
        Appended data, from the byte behind the underscore on.
    is_raw
        True if these are bytes, and no base64.
    """

    def __init__(self, root: ElementTree.Element, blob: bytes, *, is_raw: bool) -> None:
        self.blob = blob
        self.is_raw = is_raw
        is_little = root.get("byte_order", "LittleEndian") == "LittleEndian"
        self.order: Literal["<", ">"] = "<" if is_little else ">"
        header_type = root.get("header_type") or "UInt32"
        if header_type not in _XML_TYPES:
            raise ValueError(f"found header_type {show(header_type)}, expected UInt32 or UInt64")
        self.header = np.dtype(_XML_TYPES[header_type]).newbyteorder(self.order)
        compressor = root.get("compressor", "")
        if compressor not in ("", "vtkZLibDataCompressor"):
            raise ValueError(
                f"found data packed by {compressor}, expected vtkZLibDataCompressor or none; "
                "save the file without compression"
            )
        self.is_packed = bool(compressor)

    def rows(self, element: ElementTree.Element, n_parts: int) -> NDArray[np.generic]:
        """Return an array of one or more numbers per point: (n,) or (n, n_parts); raise ValueError
        as     `values`.
        """
        values = self.values(element)
        if n_parts <= 1:
            return values
        if len(values) % n_parts:
            name = element.get("Name") or "Points"
            raise ValueError(
                f"found {len(values)} numbers of {name}, expected {n_parts} for each point: the "
                "file is damaged"
            )
        return values.reshape(-1, n_parts)

    def values(self, element: ElementTree.Element) -> NDArray[np.generic]:
        """Return the numbers of an array.

        Raises
        ------
        ValueError
            They are damaged, or of an unknown type.
        """
        name = element.get("Name") or "Points"
        kind = element.get("type") or ""
        if kind not in _XML_TYPES:
            return np.zeros(0)
        dtype = np.dtype(_XML_TYPES[kind])
        text = element.text or ""
        try:
            if element.get("format") == "ascii":
                return np.array(text.split(), dtype=np.float64).astype(dtype)
            if element.get("format") == "appended":
                raw = self._bytes(self.blob[int(element.get("offset") or 0) :], self.is_raw)
            else:
                raw = self._bytes(text.strip().encode("ascii"), False)
            return np.frombuffer(raw, dtype.newbyteorder(self.order)).astype(dtype)
        except (ValueError, zlib.error, IndexError) as error:
            raise ValueError(f"found an array {name} that is damaged ({error})") from None

    def _bytes(self, content: bytes, is_raw: bool) -> bytes:
        """Return the bytes of an array, which begins with its size or with the size
        of its blocks.
        """
        size = self.header.itemsize
        if not self.is_packed:
            head = _decode(content, size, is_raw)
            n = int(np.frombuffer(head, self.header)[0])
            return _decode(content, size + n, is_raw)[size:]
        n_blocks = int(np.frombuffer(_decode(content, size, is_raw), self.header)[0])
        n_head = (3 + n_blocks) * size
        head = _decode(content, n_head, is_raw)
        lengths = np.frombuffer(head, self.header)[3:].tolist()
        after = content[n_head if is_raw else _n_of_base64(n_head) :]
        packed = _decode(after, sum(lengths), is_raw)
        parts: list[bytes] = []
        place = 0
        for length in lengths:
            parts.append(zlib.decompress(packed[place : place + length]))
            place += length
        return b"".join(parts)


def _n_of_base64(n: int) -> int:
    """Return the number of characters of ``n`` bytes in base64."""
    return 4 * ((n + 2) // 3)


def _decode(content: bytes, n: int, is_raw: bool) -> bytes:
    """Return the first ``n`` bytes of data; raise ValueError if there are fewer."""
    raw = content[:n] if is_raw else base64.b64decode(content[: _n_of_base64(n)])[:n]
    if len(raw) < n:
        raise ValueError(f"{len(raw)} of {n} bytes: the file is truncated")
    return raw
