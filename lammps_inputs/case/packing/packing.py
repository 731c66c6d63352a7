"""``[packing]``: a lattice of spheres, or grains at user-defined positions; sizes of lattices."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

from granwave.lammps_inputs.case import hints, schema
from granwave.lammps_inputs.case.hints import DIAMETER, LENGTH, Usual
from granwave.lammps_inputs.case.material import (
    Shape,
    Vector,
    axis_field,
    length_field,
    shape_field,
    shape_of,
)
from granwave.lammps_inputs.case.packing.contact_ways import (
    CONTACT_WAYS,
    CONTACTS,
    RELAXATION,
    RELAXATIONS,
    SPRINGS,
    TOLERANCE,
    ContactWay,
    described_ways,
)
from granwave.lammps_inputs.case.packing.grain_file import (
    FILE_FIELDS,
)
from granwave.lammps_inputs.case.packing.grains import Grains
from granwave.lammps_inputs.case.packing.made_packing import packing_makers
from granwave.lammps_inputs.case.packing.springs import SpringsType
from granwave.lammps_inputs.case.packing.values import (
    CELL,
    ENCLOSURE_FORM,
    GAPS,
    LARGEST_ID,
    SIZE,
    VACANCIES,
    WAYS,
    Enclosure,
    GrainsType,
)
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.files import available_memory
from granwave.lammps_inputs.lattices import (
    RESTART,
    ROWS,
    Lattice,
    kind_names,
    kind_of,
)
from granwave.lammps_inputs.packing_kind import PackingKind

_OF_CONTACTS = (RESTART, CONTACTS, TOLERANCE, SPRINGS, RELAXATION)
_OF_GRAINS = ("kind", "diameter", "source", "grains", "period", "cell", "enclosure", *_OF_CONTACTS)


def kinds_of_packings() -> tuple[str, ...]:
    """Return all values of ``packing.kind``, with the kinds that are made before the run."""
    return (*kind_names(), *packing_makers())


@dataclasses.dataclass(frozen=True, kw_only=True)
class PackingSection:
    """``[packing]``: lattice, size and spheres of the packing, or a file of grains."""

    kind: str = schema.choice(
        "lattice of the packing; file: grains at user-defined positions; restart: spheres of a "
        "LAMMPS restart file, whose contacts keep their plastic indentations and springs; other "
        "kinds: grains that are generated before the run, with keys of their own",
        kinds_of_packings,
    )
    size: tuple[int, ...] = schema.typed(
        "number of spheres along x, rows along y and layers along z, for the directions that the "
        "lattice has; not for a file",
        SIZE,
    )
    top_row: str = schema.choice(
        "top row of a plane crystal whose rows alternate between n and n - 1 grains: long, "
        "short, or equal (all rows have n grains)",
        ROWS,
        default="long",
    )
    diameter: float = schema.number(
        "diameter of the spheres; with a file, of grains without a diameter", DIAMETER, above=0
    )
    shape: str = shape_field()
    length: float | None = length_field()
    axis: Vector | None = axis_field()
    grains: Grains | None = schema.typed(
        "the table of a file as text; the case.toml of a run stores its grains in this form",
        GrainsType(),
        default=None,
    )
    source: str | None = schema.text(
        "name of the source of the grains, for reports; default: the name of the file, or the "
        "kind of packing that was generated",
        default=None,
    )
    period: tuple[float, float] | None = schema.typed(
        'periods along x and y of the grains of a file, for boundary.sides = "periodic"; default: '
        "the cell of the file, if it has one",
        schema.vector_type(2, "[along x, along y] in m, both above 0", lambda x, y: min(x, y) > 0),
        unit=LENGTH,
        default=None,
    )
    restart: str | None = schema.path(
        "restart file that provides the spheres and contacts; the case.toml of a run stores it in "
        "this form",
        default=None,
    )
    contacts: str | None = schema.choice(
        f"treatment of grains of a file that overlap or nearly touch: {described_ways()}; "
        "default: overlaps are rejected, unless they are rounding errors of the file; such "
        "grains then touch",
        tuple(CONTACT_WAYS),
        default=None,
    )
    touch_tolerance: float | None = schema.number(
        "largest gap or overlap of two grains of a file that touch; default: the gap error from "
        "half a unit in the last digit of its numbers",
        hints.DISPLACEMENT,
        above=0,
        default=None,
    )
    springs: str | None = schema.typed(
        'table of the tangential springs of a settled bed as text, for contacts = "keep" or '
        'relaxation = "damped"; the case.toml of a bed settled by granwave stores them in this '
        "form",
        SpringsType(),
        default=None,
    )
    relaxation: str | None = schema.choice(
        'method by which contacts = "relax" finds equilibrium: minimiser, without friction; '
        "damped: a damped run with the laws and the friction of the case, whose springs are kept; "
        "default: minimiser",
        RELAXATIONS,
        default=None,
    )
    gaps: tuple[tuple[int, float], ...] = schema.typed(
        "gaps in a chain: the sphere before each gap, and its width; negative: an overlap",
        GAPS,
        unit="m",
        default=(),
    )
    cell: tuple[tuple[float, float, float], ...] | None = schema.typed(
        "lattice vectors of the grains of a file, or of [[grains]] with their lattice, for "
        "granwave bands; default: the vectors of the file, if it has any",
        CELL,
        unit="m",
        default=None,
    )
    enclosure: Enclosure | None = schema.typed(
        "planes of the walls around grains of a file; default: planes that touch the outermost "
        "grains",
        schema.TableType(section=Enclosure, expected=ENCLOSURE_FORM),
        default=None,
    )
    diameter_scatter: float = schema.number(
        "diameter scatter: diameters lie between the nominal diameter minus this value and the "
        "nominal diameter",
        Usual("m", 1e-12, 0.1, ("mm", "µm")),
        at_least=0,
        default=0.0,
    )
    scatter_distribution: str = schema.choice(
        "distribution of the diameters in the scatter band; normal: the band is three standard "
        "deviations to either side",
        ("uniform", "normal"),
        default="uniform",
    )
    vacancies: float | tuple[int, ...] = schema.typed(
        "vacancies: a fraction of the spheres, chosen at random, or their ids",
        VACANCIES,
        default=0.0,
    )
    tilt: tuple[int, int] | None = schema.typed(
        "slight tilt of the floor of a square packing: directions along x and y (1 or -1) in "
        "which the spheres roll until they rest against each other; default: the spheres stay "
        "at the lattice sites",
        WAYS,
        default=None,
    )
    seed: int | None = schema.typed(
        "seed of all random numbers of the packing",
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
        """Treatment of grains that overlap or nearly touch; None: they are rejected."""
        return CONTACT_WAYS[self.contacts] if self.contacts else None

    @property
    def has_history(self) -> bool:
        """True if contacts continue from a settled bed, with their complete history or their
        springs.
        """
        return self.restart is not None or self.springs is not None

    @property
    def has_clumps(self) -> bool:
        """True if grains of a file move as clumps."""
        return self.grains is not None and bool(self.grains.clumps)

    def lattice(self, *, periodic: bool = False) -> Lattice:
        """Return the lattice of the packing; grains of a file have none."""
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


_KEY = "packing.size"


def check_size(packing: PackingSection, errors: ErrorList) -> bool:
    """Check that the size of a packing fits its kind; return True if it does, or if the grains are
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
                f"{show(packing.size)}: {packing.lattice().n_spheres} spheres require more than "
                f"{needed / 2**30:.1f} GiB of memory; available: {available / 2**30:.1f} GiB",
                remedy="use a smaller packing or another machine",
            ),
        ),
    )
