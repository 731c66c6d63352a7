"""``[packing]``: a lattice of spheres, or grains at places of their own; sizes of lattices."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from granwave.lammps_inputs.case import hints, schema
from granwave.lammps_inputs.case.grains import Grains, parse_grains, read_cell, read_grains
from granwave.lammps_inputs.case.hints import DIAMETER, LENGTH, Usual
from granwave.lammps_inputs.case.material import (
    Shape,
    Vector,
    axis_field,
    check_shape,
    length_field,
    shape_field,
    shape_of,
)
from granwave.lammps_inputs.case.schema import ErrorList, ValidationError, read_table, show
from granwave.lammps_inputs.files import available_memory
from granwave.lammps_inputs.lattices import (
    FILE,
    KINDS,
    ROWS,
    Lattice,
    PackingKind,
    kind_names,
    kind_of,
)

LARGEST_ID = schema.LARGEST_COUNT
_ACROSS = 1e-9  # largest component of a direction along another that it is normal to
_FORM_OF_FILE = (
    "the path of a table of grains (x, y, z, diameter in m), or of a file that ASE reads"
)
_NOT_OF_FILE = (
    "size",
    "top_row",
    "gaps",
    "diameter_scatter",
    "scatter_distribution",
    "vacancies",
    "tilt",
    "seed",
)
_OF_FILE = ("file", "grains", "period")
_OF_SHAPE = ("shape", "length", "axis")
_BOTH_WAYS = schema.numbers(
    2,
    "[1, 1], [1, -1], [-1, 1] or [-1, -1]: the ways along x and y in which the spheres roll",
    lambda x, y: abs(x) == abs(y) == 1,
)


def _parse_size(value: Any) -> tuple[int, ...]:
    expected = "whole numbers from 1 up: [nx, ny, nz], [nx, ny] (square), [nx, nz] (crystals in the plane) or n (chain)"
    counts = value if isinstance(value, list | tuple) else [value]
    size = tuple(schema.whole(count, expected) for count in counts)
    schema.refuse_if(not 1 <= len(size) <= 3, expected)
    schema.refuse_if(math.prod(size) > LARGEST_ID, f"at most {LARGEST_ID} spheres in all")
    return size


def _parse_vacancies(value: Any) -> float | tuple[int, ...]:
    expected = "a share of the spheres, 0 or more and below 1, or a list of ids"
    if isinstance(value, list | tuple):
        return tuple(sorted({schema.whole(one, expected) for one in value}))
    share = schema.finite(value, expected)
    schema.refuse_if(not 0 <= share < 1, expected)
    return share


def _parse_gaps(value: Any) -> tuple[tuple[int, float], ...]:
    expected = "a list of [sphere, width], such as [[14, 3e-4], [15, 3e-4]], each sphere once"
    if not isinstance(value, list | tuple) or not all(
        isinstance(one, list | tuple) and len(one) == 2 for one in value
    ):
        raise ValidationError(expected)
    found = tuple(
        (schema.whole(sphere, expected), schema.finite(width, expected)) for sphere, width in value
    )
    schema.refuse_if(not found or len({sphere for sphere, _ in found}) < len(found), expected)
    return found


def _parse_cell(value: Any) -> tuple[tuple[float, float, float], ...]:
    expected = "one, two or three vectors [x, y, z] in m that point in different directions"
    schema.refuse_if(not isinstance(value, list | tuple) or not 1 <= len(value) <= 3, expected)
    vectors = tuple(schema.parse_point(one, expected) for one in value)
    lengths = [math.hypot(*one) for one in vectors]
    if not all(lengths) or np.linalg.matrix_rank(
        np.array(vectors) / np.array(lengths)[:, None]
    ) < len(vectors):
        raise ValidationError(expected)
    return vectors


def _parse_grains(value: Any) -> Grains:
    if isinstance(value, Grains):
        return value
    expected = "a table of grains as text, as it stands in packing.file"
    schema.refuse_if(not isinstance(value, str), expected)
    try:
        return parse_grains(value, None)
    except ValueError as error:
        raise ValidationError(f"{expected}: {error}") from None


@dataclasses.dataclass(frozen=True, kw_only=True)
class PackingSection:
    """``[packing]``: lattice, size and spheres of the packing, or a file of grains."""

    kind: str = schema.choice("lattice; file: grains at places of their own", kind_names())
    size: tuple[int, ...] = schema.custom(
        "spheres along x, rows along y, layers along z, as far as the kind has them; not of a file",
        _parse_size,
    )
    top_row: str = schema.choice(
        "struck row of a crystal in the plane: a long one of rows that alternate between n and n - 1 grains, a short "
        "one, or all rows have n",
        ROWS,
        default="long",
    )
    diameter: float = schema.number(
        "diameter of the spheres; in a file, of grains for which it has none", DIAMETER, above=0
    )
    shape: str = shape_field()
    length: float | None = length_field()
    axis: Vector | None = axis_field()
    grains: Grains | None = schema.custom(
        "the table of a file as text; a case that was run holds its grains so",
        _parse_grains,
        default=None,
    )
    period: tuple[float, float] | None = schema.custom(
        'periods along x and y of grains of a file, for boundary.sides = "periodic"; those of the file\'s cell if it '
        "has one",
        schema.numbers(2, "[along x, along y] in m, both above 0", lambda x, y: min(x, y) > 0),
        unit=LENGTH,
        default=None,
    )
    gaps: tuple[tuple[int, float], ...] = schema.custom(
        "gaps in a chain: after which sphere, and how wide; negative: an overlap",
        _parse_gaps,
        unit="m",
        default=(),
    )
    cell: tuple[tuple[float, float, float], ...] | None = schema.custom(
        "vectors after which the grains of a file, or [[grains]] with their lattice, repeat, for granwave bands; by "
        "default those of the file, if it has",
        _parse_cell,
        unit="m",
        default=None,
    )
    diameter_scatter: float = schema.number(
        "tolerance: the diameters lie between this much less and the nominal one",
        Usual("m", 1e-12, 0.1, ("mm", "um")),
        at_least=0,
        default=0.0,
    )
    scatter_distribution: str = schema.choice(
        "distribution of the diameters in the tolerance band; normal: three standard deviations to either side",
        ("uniform", "normal"),
        default="uniform",
    )
    vacancies: float | tuple[int, ...] = schema.custom(
        "spheres left out: a share of them, chosen at random, or their ids",
        _parse_vacancies,
        default=0.0,
    )
    tilt: tuple[int, int] | None = schema.custom(
        "slight tilt of a square packing's floor: ways along x and y, 1 or -1 each, in which the spheres roll until "
        "they lean on each other; left out: they stay at the sites of the lattice",
        lambda value: tuple(map(int, _BOTH_WAYS(value))),
        default=None,
    )
    seed: int | None = schema.custom(
        "seed of all that is random in the packing",
        lambda value: schema.whole(value, f"a whole number from 0 to {LARGEST_ID}", at_least=0),
        default=None,
    )

    @property
    def rule(self) -> PackingKind:
        """Properties of the kind."""
        return kind_of(self.kind)

    def lattice(self, *, periodic: bool = False) -> Lattice:
        """Return the lattice of the packing; that of grains of a file is none."""
        top_row = self.top_row if self.rule.is_plane_crystal else "equal"
        return Lattice(self.kind, self.size, self.diameter, periodic, top_row)

    @property
    def n_spheres(self) -> int:
        """Number of spheres, or of grains of a file; vacancies count."""
        return self.lattice().n_spheres if self.grains is None else len(self.grains)

    @property
    def of_grain(self) -> Shape:
        """Shape of the grains of a lattice."""
        return shape_of(self, self.rule.cylinder_axis)

    def keys(self) -> dict[str, Any]:
        """Return the keys of the packing, as a case file has them."""
        keys: dict[str, Any] = {
            field.name: getattr(self, field.name) for field in dataclasses.fields(self)
        }
        if self.grains is not None:
            own = {name: keys[name] for name in ("kind", "diameter", "grains", "period", "cell")}
            return {
                name: value
                for name, value in (own | {"grains": self.grains.text}).items()
                if value is not None
            }
        unused = {"cell": True, "gaps": not self.gaps, "top_row": not self.rule.is_plane_crystal,
                  "shape": self.shape == "sphere"}  # fmt: skip
        size = self.size[0] if len(self.size) == 1 else self.size
        return {
            name: value for name, value in (keys | {"size": size}).items() if not unused.get(name)
        }


def read_packing(table: Any, errors: ErrorList) -> PackingSection | None:
    """Read ``[packing]``; missing and wrong values are added to ``errors``.

    The grains of ``packing.file`` become ``packing.grains``, so that the case is complete without
    the file.
    """
    if not isinstance(table, Mapping):
        return read_table(PackingSection, table, "packing", errors)
    kind = table.get("kind")
    before = len(errors.lines)
    if kind == FILE:
        text = 'does not belong to packing.kind = "file", whose grains are all in the file'
        foreign = dict.fromkeys((*_NOT_OF_FILE, *_OF_SHAPE), text)
    else:  # a cell may come with [[grains]]: see `parse_case`
        foreign = dict.fromkeys(
            _OF_FILE, f'belongs to packing.kind = "file"; found {show(table.get("kind", ""))}'
        )
        if kind in list(KINDS) and not KINDS[kind].is_plane_crystal:
            able = " or ".join(show(name) for name, rule in KINDS.items() if rule.is_plane_crystal)
            foreign["top_row"] = f"belongs to packing.kind = {able}; found {show(kind)}"
    errors.check(*((name in table, f"packing.{name}", text) for name, text in foreign.items()))
    rest = {name: value for name, value in table.items() if name not in (*foreign, "file")}
    if kind != FILE:
        found = read_table(PackingSection, rest, "packing", errors)
        before = len(errors.lines)
        if found is not None:
            _check_cylinders(found, errors)
        return found if len(errors.lines) == before else None
    if "grains" not in table:
        rest["grains"] = grains = _from_file(table, errors)
        if grains is not None and grains.period is not None:
            rest.setdefault("period", grains.period)
    elif "file" in table:
        errors.add("packing.file", "found beside packing.grains; give one of them")
    if len(errors.lines) > before:
        return None
    if "cell" not in table and "file" in table and (cell := read_cell(Path(table["file"]))):
        rest["cell"] = cell
    # The rest is read with stand-ins for what follows from the grains.
    section = read_table(PackingSection, {"diameter": 1e-3, **rest, "size": 1}, "packing", errors)
    if section is None or section.grains is None:
        return None
    diameter = section.diameter if "diameter" in table else section.grains.usual_diameter
    return dataclasses.replace(section, size=(len(section.grains),), diameter=diameter)


def _check_cylinders(packing: PackingSection, errors: ErrorList) -> None:
    """Check the shape of the grains of a lattice: cylinders lie in a plane, with contacts across
    their axes.
    """
    check_shape(packing, "packing", errors)
    if (shape := packing.of_grain) is None:
        return
    along = np.abs(packing.rule.contact_directions @ shape.vector).max()
    flat = [name for name, kind in KINDS.items() if kind.dimension < len("xyz")]
    errors.check_first(
        (packing.kind not in flat, "packing.shape",
         f'found "cylinder" for {packing.kind}, expected a packing in a plane: {", ".join(flat)}'),
        (along > _ACROSS, "packing.axis",
         f"found {show(list(shape.axis))}, expected a direction across all contacts of {packing.kind}"),
    )  # fmt: skip


def _from_file(table: Mapping[str, Any], errors: ErrorList) -> Grains | None:
    diameter = table.get("diameter")
    if "file" not in table:
        errors.add("packing.file", f'missing; packing.kind = "file" needs {_FORM_OF_FILE}')
        return None
    if isinstance(diameter, bool) or not isinstance(diameter, int | float) or not diameter > 0:
        diameter = None
    name = table["file"]
    grains = schema.read_named(
        "packing.file", name, _FORM_OF_FILE, lambda path: read_grains(path, diameter), errors
    )
    if grains and (
        odd := hints.unusual([float(grains.diameter.max()), float(grains.diameter.min())], DIAMETER)
    ):
        errors.notes.append(f"packing.file: {name}: diameter: {odd}")
    return grains


_KEY = "packing.size"


def check_size(packing: PackingSection, errors: ErrorList) -> bool:
    """Check that a packing has a size of its kind; return True if it has, or if its grains come
    from a file.
    """
    axes = packing.rule.axes
    size = show(packing.size)
    in_rows = packing.rule.is_plane_crystal
    form = f"a number {packing.rule.size_form}" if len(axes) == 1 else packing.rule.size_form
    return packing.grains is not None or errors.check_first(
        (len(packing.size) != len(axes), _KEY, f"found {size}, expected {form} for {packing.kind}"),
        (in_rows and packing.top_row != "equal" and packing.size[0] <= 1, _KEY,
         f"found {size}: the short rows would be empty; expected 2 or more in a row"),
    )  # fmt: skip


def check_memory_of_sites(
    packing: PackingSection, n_sites: int, bytes_of_site: float, errors: ErrorList
) -> bool:
    """Check that the memory suffices for arrays over so many sites of a lattice; return True if it
    does.
    """
    needed = n_sites * bytes_of_site
    available = available_memory()
    return errors.check_first(
        (needed > available, _KEY,
         f"found {show(packing.size)}: {packing.lattice().n_spheres} spheres need more than {needed / 2**30:.1f} GiB "
         f"of memory, there is {available / 2**30:.1f} GiB; make the packing smaller or change machine"),
    )  # fmt: skip
