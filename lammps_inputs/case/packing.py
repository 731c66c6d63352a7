"""``[packing]``: a lattice of spheres, or grains at places of their own; sizes of lattices."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case import hints, schema
from granwave.lammps_inputs.case.contact_ways import (
    CONTACT_WAYS,
    CONTACTS,
    KEEP,
    RELAXATION,
    RELAXATIONS,
    SPRINGS,
    TOLERANCE,
    ContactWay,
    described_ways,
)
from granwave.lammps_inputs.case.grain_file import (
    FILE_FIELDS,
    FORM_OF_FILE,
    TYPES,
    GrainFileSection,
    read_grain_file,
)
from granwave.lammps_inputs.case.grains import Grains, parse_grains
from granwave.lammps_inputs.case.hints import DIAMETER, LENGTH, Usual
from granwave.lammps_inputs.case.made_packing import NOT_MADE
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
from granwave.lammps_inputs.case.springs import SpringsType
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.files import available_memory
from granwave.lammps_inputs.lattices import (
    FILE,
    RESTART,
    ROWS,
    Lattice,
    kind_names,
    kind_of,
    lattice_kinds,
)
from granwave.lammps_inputs.packing_kind import PackingKind
from granwave.lammps_inputs.restart_file import NO_CLUMPS, RestartSpheres, read_restart

LARGEST_ID = schema.LARGEST_COUNT
_ACROSS = 1e-9  # largest component of a direction along another that it is normal to
_FORM_OF_RESTART = "the path of a file that write_restart of LAMMPS wrote, of spheres in SI units"
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
_OF_FILE = (*FILE_FIELDS, "grains", "period", "enclosure", RESTART, SPRINGS)
_OF_CONTACTS = (RESTART, CONTACTS, TOLERANCE, SPRINGS, RELAXATION)
_OF_GRAINS = ("kind", "diameter", "grains", "period", "cell", "enclosure", *_OF_CONTACTS)
_OF_SHAPE = ("shape", "length", "axis")
_WAYS_FORM = (
    "[1, 1], [1, -1], [-1, 1] or [-1, -1]: the ways along x and y in which the spheres roll"
)
_SIZE_FORM = (
    "whole numbers from 1 up: [nx, ny, nz], [nx, ny] (square), [nx, nz] (crystals in the plane) or "
    "n (chain)"
)
_VACANCIES_FORM = "a share of the spheres, 0 or more and below 1, or a list of ids"
_GAPS_FORM = "a list of [sphere, width], such as [[14, 3e-4], [15, 3e-4]], each sphere once"
_RANGE_FORM = "[from, to] in m, the second one larger"
_RANGE = schema.vector_type(2, _RANGE_FORM, lambda low, high: low < high)
_ENCLOSURE_FORM = "{x = [0.0, 0.1], y = [0.0, 0.1], bottom = 0.05}, each of which may be left out"
_CELL_FORM = "one, two or three vectors [x, y, z] in m that point in different directions"
_GRAINS_FORM = "a table of grains as text, as it stands in packing.file"


def _both_ways(ways: tuple[float, float]) -> tuple[int, int]:
    x, y = ways
    schema.refuse_if(abs(x) != 1 or abs(y) != 1, _WAYS_FORM)
    return int(x), int(y)


def _size(counts: tuple[int, ...]) -> tuple[int, ...]:
    is_too_large = math.prod(counts) > LARGEST_ID
    schema.refuse_if(is_too_large, f"at most {LARGEST_ID} spheres in all")
    return counts


def _different_ids(ids: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(sorted(set(ids)))


@dataclasses.dataclass(frozen=True)
class GapType(schema.ValueType):
    """Type of a gap of a chain: the sphere before it and its width."""

    expected: str = _GAPS_FORM

    def read(self, value: Any) -> tuple[int, float]:
        """Return sphere and width, m."""
        is_pair = isinstance(value, list | tuple) and len(value) == 2
        schema.refuse_if(not is_pair, self.expected)
        sphere, width = value
        return schema.whole(sphere, self.expected), schema.finite(width, self.expected)

    @property
    def json(self) -> dict[str, Any]:
        """A list of two numbers."""
        return schema.vector_type(2, self.expected).json


def _gaps(gaps: tuple[tuple[int, float], ...]) -> tuple[tuple[int, float], ...]:
    spheres = {sphere for sphere, _ in gaps}
    schema.refuse_if(len(spheres) < len(gaps), _GAPS_FORM)
    return gaps


def _cell(
    vectors: tuple[tuple[float, float, float], ...],
) -> tuple[tuple[float, float, float], ...]:
    lengths = [math.hypot(*vector) for vector in vectors]
    schema.refuse_if(not all(lengths), _CELL_FORM)
    directions = np.array(vectors) / np.array(lengths)[:, None]
    schema.refuse_if(np.linalg.matrix_rank(directions) < len(vectors), _CELL_FORM)
    return vectors


def _read_text(text: str) -> Grains:
    try:
        return parse_grains(text, None)
    except ValueError as error:
        raise ValidationError(f"{_GRAINS_FORM}: {error}") from None


@dataclasses.dataclass(frozen=True)
class GrainsType(schema.ValueType):
    """Type of a table of grains: its text, or the grains that were read of a file."""

    expected: str = _GRAINS_FORM
    kind: ClassVar[str] = "string"

    def read(self, value: Any) -> Grains:
        """Return the grains."""
        if isinstance(value, Grains):
            return value
        schema.refuse_if(not isinstance(value, str), self.expected)
        return _read_text(value)

    @property
    def json(self) -> dict[str, Any]:
        """A string."""
        return {"type": "string"}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Enclosure:
    """Planes of the walls around grains of a file."""

    x: tuple[float, float] | None = schema.typed(
        "planes of the walls across x", _RANGE, unit="m", default=None
    )
    y: tuple[float, float] | None = schema.typed(
        "planes of the walls across y", _RANGE, unit="m", default=None
    )
    bottom: float | None = schema.number("depth of the bottom plane", "m", default=None)

    def around(self, faces: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the planes, those of the outermost grains where none is given: (2, 3), m.

        Parameters
        ----------
        faces
            Lowest and highest coordinates of surfaces of grains: (2, 3), m.
        """
        planes = faces.copy()
        for axis, ends in enumerate((self.x, self.y)):
            if ends is not None:
                planes[:, axis] = ends
        if self.bottom is not None:
            planes[1, 2] = self.bottom
        return planes


_SIZE = schema.ListType(
    item=schema.CountType(form=_SIZE_FORM),
    expected=_SIZE_FORM,
    at_most=3,
    alone=True,
    finish=_size,
)
_GAPS = schema.ListType(item=GapType(), expected=_GAPS_FORM, finish=_gaps)
_CELL = schema.ListType(
    item=schema.vector_type(3, _CELL_FORM), expected=_CELL_FORM, at_most=3, finish=_cell
)
_VACANCIES = schema.EitherType(
    types=(
        schema.ListType(
            item=schema.CountType(form=_VACANCIES_FORM),
            expected=_VACANCIES_FORM,
            at_least=0,
            finish=_different_ids,
        ),
        schema.NumberType(at_least=0, below=1, form=_VACANCIES_FORM),
    ),
    form=_VACANCIES_FORM,
)
_WAYS = schema.ListType(
    item=schema.NumberType(form=_WAYS_FORM),
    expected=_WAYS_FORM,
    at_least=2,
    at_most=2,
    finish=_both_ways,
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class PackingSection:
    """``[packing]``: lattice, size and spheres of the packing, or a file of grains."""

    kind: str = schema.choice(
        "lattice; file: grains at places of their own; restart: spheres of a restart file of "
        "LAMMPS, whose contacts keep their dents and springs",
        kind_names,
    )
    size: tuple[int, ...] = schema.typed(
        "spheres along x, rows along y, layers along z, as far as the kind has them; not of a file",
        _SIZE,
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
    grains: Grains | None = schema.typed(
        "the table of a file as text; a case that was run holds its grains so",
        GrainsType(),
        default=None,
    )
    period: tuple[float, float] | None = schema.typed(
        'periods along x and y of grains of a file, for boundary.sides = "periodic"; those of the file\'s cell if it '
        "has one",
        schema.vector_type(2, "[along x, along y] in m, both above 0", lambda x, y: min(x, y) > 0),
        unit=LENGTH,
        default=None,
    )
    restart: str | None = schema.path(
        "restart file that spheres and contacts go on from; a case of kind restart that was run "
        "holds its file so",
        default=None,
    )
    contacts: str | None = schema.choice(
        f"contacts of grains of a file that overlap or nearly touch: {described_ways()}; left out: "
        "overlaps are refused, but for those that the digits of the file explain, which touch",
        tuple(CONTACT_WAYS),
        default=None,
    )
    touch_tolerance: float | None = schema.number(
        "largest gap or overlap of two grains of a file that touch; by default what half a unit of "
        "the last place of its numbers makes of a gap",
        hints.DISPLACEMENT,
        above=0,
        default=None,
    )
    springs: str | None = schema.typed(
        'table of the tangential springs of a settled bed as text, for contacts = "keep" or '
        'relaxation = "damped"; a case of a bed that granwave has settled holds them so',
        SpringsType(),
        default=None,
    )
    relaxation: str | None = schema.choice(
        'how contacts = "relax" finds balance: minimiser, without friction; damped: a damped run '
        "with the laws and the friction of the case, whose springs stay; by default the minimiser",
        RELAXATIONS,
        default=None,
    )
    gaps: tuple[tuple[int, float], ...] = schema.typed(
        "gaps in a chain: after which sphere, and how wide; negative: an overlap",
        _GAPS,
        unit="m",
        default=(),
    )
    cell: tuple[tuple[float, float, float], ...] | None = schema.typed(
        "vectors after which the grains of a file, or [[grains]] with their lattice, repeat, for granwave bands; by "
        "default those of the file, if it has",
        _CELL,
        unit="m",
        default=None,
    )
    enclosure: Enclosure | None = schema.typed(
        "planes of the walls around grains of a file; by default they touch the outermost grains",
        schema.TableType(section=Enclosure, expected=_ENCLOSURE_FORM),
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
    vacancies: float | tuple[int, ...] = schema.typed(
        "spheres left out: a share of them, chosen at random, or their ids",
        _VACANCIES,
        default=0.0,
    )
    tilt: tuple[int, int] | None = schema.typed(
        "slight tilt of a square packing's floor: ways along x and y, 1 or -1 each, in which the spheres roll until "
        "they lean on each other; left out: they stay at the sites of the lattice",
        _WAYS,
        default=None,
    )
    seed: int | None = schema.typed(
        "seed of all that is random in the packing",
        schema.CountType(at_least=0, form=f"a whole number from 0 to {LARGEST_ID}"),
        default=None,
    )

    FURTHER_KEYS: ClassVar[dict[str, Any]] = FILE_FIELDS

    @property
    def rule(self) -> PackingKind:
        """Properties of the kind."""
        return kind_of(self.kind)

    @property
    def contact_way(self) -> ContactWay | None:
        """Way to start contacts of grains that overlap or nearly touch; None: they are refused."""
        return CONTACT_WAYS[self.contacts] if self.contacts else None

    @property
    def has_history(self) -> bool:
        """True if contacts go on from a bed that was settled, whole or with their springs."""
        return self.restart is not None or self.springs is not None

    @property
    def has_clumps(self) -> bool:
        """True if grains of a file move as clumps."""
        return self.grains is not None and bool(self.grains.clumps)

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
            own = {name: keys[name] for name in _OF_GRAINS}
            return {
                name: value
                for name, value in (own | {"grains": self.grains.text}).items()
                if value is not None
            }
        unused = dict.fromkeys(("cell", "enclosure", *_OF_CONTACTS), True) | {
            "gaps": not self.gaps,
            "top_row": not self.rule.is_plane_crystal,
            "shape": self.shape == "sphere",
        }
        size = self.size[0] if len(self.size) == 1 else self.size
        return {
            name: value for name, value in (keys | {"size": size}).items() if not unused.get(name)
        }


def read_packing(table: Any, errors: ErrorList) -> PackingSection | None:
    """Read ``[packing]``; missing and wrong values are added to ``errors``.

    The grains of ``packing.file`` become ``packing.grains``, so that the case is complete without
    the file.
    """
    if table is NOT_MADE:
        return None
    if not isinstance(table, Mapping):
        return read_table(PackingSection, table, "packing", errors)
    before = len(errors.items)
    foreign = _foreign_keys(table.get("kind"))
    for name, text in foreign.items():
        if name in table:
            errors.add(f"packing.{name}", text)
    if table.get("kind") == RESTART:
        table = _of_restart(table, errors)
    own = {name: value for name, value in table.items() if name not in (*foreign, *FILE_FIELDS)}
    if table.get("kind") != FILE:
        return _read_lattice(own, errors)
    given = _given_grains(table, errors)
    if len(errors.items) > before:
        return None
    # the rest is read with stand-ins for what follows from the grains
    rest = {"diameter": 1e-3, **given, **own, "size": 1}
    section = read_table(PackingSection, rest, "packing", errors)
    if section is None or section.grains is None:
        return None
    diameter = section.diameter if "diameter" in table else section.grains.usual_diameter
    return dataclasses.replace(section, size=(len(section.grains),), diameter=diameter)


def _foreign_keys(kind: Any) -> dict[str, str]:
    """Return the keys that a kind of packing does not have, each with the fault."""
    if kind in (FILE, RESTART):
        text = f'does not belong to packing.kind = "{kind}", whose grains are all in the file'
        return dict.fromkeys((*_NOT_OF_FILE, *_OF_SHAPE), text)
    # a cell may come with [[grains]]: see `parse_case`
    found = show("" if kind is None else kind)
    foreign = dict.fromkeys(_OF_FILE, f'belongs to packing.kind = "file"; found {found}')
    rule = lattice_kinds().get(kind) if isinstance(kind, str) else None
    if rule is not None and not rule.is_plane_crystal:
        plane = [name for name, other in lattice_kinds().items() if other.is_plane_crystal]
        able = " or ".join(map(show, plane))
        foreign["top_row"] = f"belongs to packing.kind = {able}; found {show(kind)}"
    return foreign


def _of_restart(table: Mapping[str, Any], errors: ErrorList) -> dict[str, Any]:
    """Return the packing of a restart file as one of grains of a file that start as they are."""
    file = table.get("file")
    kept = {name: value for name, value in table.items() if name not in ("file", TYPES)}
    kept |= {"kind": FILE, "grains": None}
    for name, allowed in ((CONTACTS, KEEP.name), ("diameter", None), ("grains", None)):
        if name in table and table[name] != allowed:
            fault = Mismatch(show(table[name]), remedy="take it out: the restart file has it")
            errors.add(f"packing.{name}", fault)
    if file is None:
        errors.add("packing.file", f'missing; packing.kind = "restart" needs {_FORM_OF_RESTART}')
        return kept
    spheres = schema.read_named("packing.file", file, _FORM_OF_RESTART, read_restart, errors)
    if spheres is None:
        return kept
    if spheres.bodies.any():
        first, second = (1 + np.flatnonzero(spheres.bodies == spheres.bodies.max()))[:2].tolist()
        found = f"spheres {first} and {second} of one body (the same number in fix property/atom)"
        errors.add("packing.file", Mismatch(found, "spheres that move one by one", NO_CLUMPS))
    materials = _materials_of(spheres, table.get(TYPES), errors)
    n = len(spheres.radius)
    still = np.zeros((n, 3))  # their velocities stay in the file
    grains = Grains(spheres.position, 2 * spheres.radius, materials, [""] * n, still)
    return kept | {"grains": grains, CONTACTS: KEEP.name, RESTART: file}


def _materials_of(spheres: RestartSpheres, types: Any, errors: ErrorList) -> list[str]:
    """Return the names of the materials of the spheres of a restart file, by their types."""
    none = [""] * len(spheres.kind)
    section = read_table(
        GrainFileSection, {} if types is None else {TYPES: types}, "packing", errors
    )
    if section is None:
        return none
    there = [str(kind) for kind in np.unique(spheres.kind).tolist()]
    names = section.types or {}
    if not names and len(there) == 1:
        return none
    missing = [name for name in there if name not in names]
    unused = [name for name in names if name not in there]
    if missing or unused:
        what = f"no material of the type {missing[0]}" if missing else f"no type {unused[0]}"
        expected = f"a material for each of the types {', '.join(there)}"
        errors.add(f"packing.{TYPES}", Mismatch(what, expected))
        return none
    return [names[str(kind)] for kind in spheres.kind.tolist()]


def _read_lattice(table: Mapping[str, Any], errors: ErrorList) -> PackingSection | None:
    """Read the packing of a lattice."""
    packing = read_table(PackingSection, table, "packing", errors)
    before = len(errors.items)
    if packing is not None:
        _check_cylinders(packing, errors)
    return packing if len(errors.items) == before else None


def _given_grains(table: Mapping[str, Any], errors: ErrorList) -> dict[str, Any]:
    """Return grains, periods and cell of the file that a packing names, as values of its keys."""
    given: dict[str, Any] = {}
    if "grains" in table:
        for name in FILE_FIELDS:
            if name in table:
                beside = Mismatch("beside packing.grains", remedy="give one of them")
                errors.add(f"packing.{name}", beside)
        return given
    grains = _from_file(table, errors)
    given["grains"] = grains
    if grains is not None and grains.period is not None:
        given["period"] = grains.period
    if grains is not None and "cell" not in table and grains.cell:
        given["cell"] = grains.cell
    return given


def _check_cylinders(packing: PackingSection, errors: ErrorList) -> None:
    """Check the shape of the grains of a lattice: cylinders lie in a plane, with contacts across
    their axes.
    """
    check_shape(packing, "packing", errors)
    if (shape := packing.of_grain) is None:
        return
    along = np.abs(packing.rule.contact_directions @ shape.vector).max()
    flat = [name for name, kind in lattice_kinds().items() if kind.dimension < len("xyz")]
    errors.check_first(
        (
            packing.kind not in flat,
            "packing.shape",
            Mismatch(f'"cylinder" for {packing.kind}', f"a packing in a plane: {', '.join(flat)}"),
        ),
        (
            along > _ACROSS,
            "packing.axis",
            Mismatch(show(list(shape.axis)), f"a direction across all contacts of {packing.kind}"),
        ),
    )


def _from_file(table: Mapping[str, Any], errors: ErrorList) -> Grains | None:
    diameter = table.get("diameter")
    if "file" not in table:
        errors.add("packing.file", f'missing; packing.kind = "file" needs {FORM_OF_FILE}')
        return None
    if isinstance(diameter, bool) or not isinstance(diameter, int | float) or not diameter > 0:
        diameter = None
    name = table["file"]
    grains = read_grain_file(table, diameter, errors)
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
        (len(packing.size) != len(axes), _KEY, Mismatch(size, f"{form} for {packing.kind}")),
        (
            in_rows and packing.top_row != "equal" and packing.size[0] <= 1,
            _KEY,
            Mismatch(f"{size}: the short rows would be empty", "2 or more in a row"),
        ),
    )


def check_memory_of_sites(
    packing: PackingSection, n_sites: int, bytes_of_site: float, errors: ErrorList
) -> bool:
    """Check that the memory suffices for arrays over so many sites of a lattice; return True if it
    does.
    """
    needed = n_sites * bytes_of_site
    available = available_memory()
    return errors.check_first(
        (
            needed > available,
            _KEY,
            Mismatch(
                f"{show(packing.size)}: {packing.lattice().n_spheres} spheres need "
                f"more than {needed / 2**30:.1f} GiB of memory, there is "
                f"{available / 2**30:.1f} GiB",
                remedy="make the packing smaller or change machine",
            ),
        ),
    )
