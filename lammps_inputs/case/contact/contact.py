"""``[contact]`` and ``[[pair]]``: contact law, its constants, friction, loss and initial dents."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from granwave import _contact_laws
from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.contact.law_parameters import (
    OF_CONTACT,
    PARAMETERS,
    value_of,
    with_parameters,
)
from granwave.lammps_inputs.case.contact.tables import (
    COHESION,
    DENTS,
    LOSS,
    ROLLING,
    TWISTING,
    Cohesion,
    Dents,
    Loss,
    Resistance,
)
from granwave.lammps_inputs.case.hints import FRICTION
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.schema import (
    ErrorList,
    read_table,
    refuse_unknown,
    show,
)
from granwave.lammps_inputs.errors import Mismatch

FITTED_POISSON_RATIO = 0.30
# contact radii; the largest stress is above a depth of 0.7 for every Poisson's ratio
_DEEPEST = 3.0


def hertz_von_mises_yield_factor(poisson_ratio: float) -> float:
    """Return the exact C of the contact pressure at first yield, ``p_y = C sigma_y``, under Hertz's
    pressure.

    On the axis below the centre of a Hertzian contact of radius a and peak pressure p0, at depth z
    = zeta a (K. L. Johnson, Contact Mechanics, 1985, eq. 3.45)::

        sigma_z / p0 = -1 / (1 + zeta^2)
        sigma_r / p0 = -(1 + nu) (1 - zeta arctan(1/zeta)) + 1 / (2 (1 + zeta^2))

    The von Mises stress there is ``|sigma_z - sigma_r|``; for nu >= 0 its largest value over the
    depth is the largest in the body. Hence ``C = 1 / max |sigma_z - sigma_r|`` with p0 = 1: 1.613
    at nu = 0.30; the laws take 1.60.

    Parameters
    ----------
    poisson_ratio
        Above -1, below 0.5.
    """
    from scipy.optimize import minimize_scalar  # imported on demand: slow to load

    def stress(depth: float | np.ndarray) -> np.ndarray:
        zeta = np.maximum(depth, 1e-300)
        vertical = -1.0 / (1.0 + zeta**2)
        radial = -(1.0 + poisson_ratio) * (1.0 - zeta * np.arctan(1.0 / zeta)) + 0.5 / (
            1.0 + zeta**2
        )
        return np.abs(vertical - radial)

    deepest = minimize_scalar(
        lambda depth: -stress(depth),
        bounds=(0, _DEEPEST),
        method="bounded",
        options={"xatol": 1e-10},
    )
    return 1.0 / max(-float(deepest.fun), float(stress(0.0)))


_RIGID = (math.inf, 0.0, math.inf)  # Young's modulus, Poisson's ratio, yield strength
ALL_LAWS = _contact_laws.LAWS  # contact laws of the plugin, by name
LAWS = {name: law for name, law in ALL_LAWS.items() if not law.is_power}  # laws of two materials
NO_FORCE = "none"  # law of materials whose grains do not touch
LINES = ("half-space", "plane-strain")
INITIAL = "initial"  # directions of contact forces
NORMALS = ("current", INITIAL)
LINE = "line"  # law of crystals of cylinders only: Hertz's, with line contacts in plane strain
#: Published values of the constants of the elasto-plastic law, by name.
LAW_CONSTANTS: dict[str, float] = {
    name: parameter.default
    for name, parameter in ALL_LAWS["elastoplastic"].parameters.items()
    if parameter.optional and not parameter.of_material
}
_FIRST = ("law", "variant", "yield_factor", "constant", "exponent", "line", "beta")


@dataclasses.dataclass(frozen=True, kw_only=True)
@with_parameters(OF_CONTACT, first=_FIRST)
class Contact:
    """``[contact]``: contact law and friction.

    The parameters of the laws are fields as well, with the names of the table of laws.
    """

    law: str = schema.choice(
        'contact law; "line" is "hertz" with line = "plane-strain", only for cylinders; a TOML '
        "file with a table [contact], such as fit.toml, gives the law and its constants",
        (*ALL_LAWS, LINE),
        default="elastoplastic",
    )
    line: str = schema.choice(
        "law of a line contact between a cylinder and a plane or a parallel cylinder: elastic "
        "half-spaces loaded over the length of the cylinder, or plane strain",
        LINES,
        default="half-space",
    )
    friction: float = schema.number(
        "coefficient of Coulomb friction between spheres",
        FRICTION,
        at_least=0,
        at_most=1e4,
        default=0.0,
    )
    tangential: str = schema.choice(
        "tangential force below Coulomb's limit: mindlin_rescale (one spring, whose force is "
        "reduced as the contact circle shrinks), mindlin (one spring without this reduction, "
        "which can create energy) or partial_slip (several springs that slip from the edge "
        "inwards, after Mindlin and Deresiewicz)",
        ("mindlin_rescale", "mindlin", "partial_slip"),
        default="mindlin_rescale",
    )
    rolling: Resistance | None = schema.typed(
        "resistance to rolling: largest torque divided by effective radius and normal force, or a "
        "table of coefficient, stiffness (N/m; default: the stiffness of the tangential spring) "
        "and damping (N s/m)",
        ROLLING,
        default=None,
    )
    twisting: Resistance | str | None = schema.typed(
        "resistance to twisting: largest torque divided by normal force (m), a table of "
        "coefficient, stiffness (N m) and "
        'damping (N m s), or "marshall", which is determined by friction on the contact circle',
        TWISTING,
        default=None,
    )
    loss: Loss | None = schema.typed(
        "viscous damping of contacts, by a relaxation time, by the restitution at a "
        "velocity, or by a dashpot (Tsuji)",
        LOSS,
        default=None,
    )
    cohesion: Cohesion | None = schema.typed(
        'cohesion: kind "jkr" (elastic spheres joined by a neck, law hertz) or "dmt" (attraction '
        "while surfaces touch, any law of two materials), and the work of adhesion in J/m^2",
        COHESION,
        default=None,
    )
    normals: str = schema.choice(
        "direction of the forces: along the current line of centres, or along the line at the "
        "start, as in programs for small displacements",
        NORMALS,
        default="current",
    )
    initial_overlap: float | str | tuple[Dents, ...] = schema.typed(
        "largest overlap of the contacts before the run, which left plastic indentations: a "
        "value, values by region, or the result.h5 of an earlier run",
        DENTS,
        unit="m",
        default=0.0,
    )

    def __post_init__(self) -> None:
        """Convert the law "line" to "hertz" with plane strain."""
        if self.law == LINE:
            object.__setattr__(self, "law", "hertz")
            object.__setattr__(self, "line", "plane-strain")

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...

    @property
    def parameters(self) -> dict[str, float | str]:
        """Values of the parameters of the law for a contact, by name,
        without omitted parameters.
        """
        own = [name for name, p in self.entry.parameters.items() if not p.of_material]
        values = {name: getattr(self, name) for name in own}
        return {name: value for name, value in values.items() if value is not None}

    @property
    def constants(self) -> dict[str, float]:
        """Constants of the curve of its law that the case gives, by name."""
        values: dict[str, Any] = self.parameters
        return {name: values[name] for name in values if PARAMETERS[name].optional}

    @property
    def foreign(self) -> dict[str, float]:
        """Parameters of other laws, without a default, that the case gives, by name."""
        others = [p.name for p in OF_CONTACT if p.optional or p.required]
        values = {name: getattr(self, name) for name in others if not self.takes(name)}
        return {name: value for name, value in values.items() if value is not None}

    @property
    def entry(self) -> _contact_laws.LawEntry:
        """Entry of the law in the plugin's table."""
        return ALL_LAWS[self.law]

    @property
    def resists(self) -> bool:
        """True if contacts resist rolling or twisting."""
        both = self.rolling, self.twisting
        return any(
            one.coefficient > 0 if isinstance(one, Resistance) else one is not None for one in both
        )

    @property
    def coheres(self) -> bool:
        """True if contacts have cohesion."""
        return self.cohesion is not None and self.cohesion.energy > 0

    def between(
        self,
        materials: tuple[Material | None, Material | None],
        radii: tuple[float, float],
        **others: Any,
    ) -> _contact_laws.ContactLaw:
        """Return the compiled law between bodies of two materials (None: rigid) and radii (m;
        infinite: flat).

        Parameters
        ----------
        others
            Further arguments of the compiled law.
        """
        bodies = [(one.youngs_modulus, one.poisson_ratio, one.yield_strength or math.inf) if one else _RIGID
                  for one in materials]  # fmt: skip
        moduli, ratios, strengths = zip(*bodies, strict=True)
        parameters: dict[str, Any] = self.parameters
        for name, parameter in self.entry.parameters.items():
            if parameter.of_material:
                parameters[name] = tuple(value_of(material, parameter) for material in materials)
        if self.cohesion is not None and self.coheres:
            parameters["cohesion"] = (self.cohesion.kind, self.cohesion.energy)
        return _contact_laws.ContactLaw(
            youngs_modulus=moduli,
            poisson_ratio=ratios,
            yield_strength=strengths,
            radius=radii,
            law=self.law,
            **parameters,
            **others,
        )

    @property
    def yields(self) -> bool:
        """True if the law needs a yield strength."""
        return bool(self.entry.yields)

    def takes(self, parameter: str) -> bool:
        """Return True if the law has a parameter of this name."""
        return parameter in self.entry.parameters


RIGID = "rigid"  # name of a rigid wall in `Pair.materials`
_NOT_BY_PAIR = ("initial_overlap", "line", "normals")
_OF_ANY_LAW = ("friction", "tangential", "rolling", "twisting", "loss", "cohesion")
_KEYS = tuple(field.name for field in dataclasses.fields(Contact) if field.name not in _NOT_BY_PAIR)
_NAMES_FORM = 'two names of materials; "rigid" for a rigid wall'
_NAMES = schema.ListType(
    item=schema.TextType(expected=_NAMES_FORM), expected=_NAMES_FORM, at_least=2, at_most=2
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Pair:
    """The contact law between two materials.

    Attributes
    ----------
    contact
        Values of ``[contact]``, overridden by the values of the pair.
    """

    materials: tuple[str, str] = schema.typed("materials of the two bodies", _NAMES)
    contact: Contact

    def fits(self, first: str | None, second: str | None) -> bool:
        """Return True if the pair holds for materials of these names, in any order."""
        return sorted(self.materials) == sorted((str(first), str(second)))

    def to_dict(self) -> dict[str, Any]:
        """Return the pair as a table of a case file."""
        values = {name: getattr(self.contact, name) for name in _KEYS}
        return {"materials": list(self.materials)} | {
            name: value for name, value in values.items() if value is not None
        }


def read_pairs(tables: Any, contact: Any, errors: ErrorList) -> tuple[Pair, ...]:
    """Read the ``[[pair]]`` tables of a case; entry n has the dotted name ``pair.n``, from 1.

    Parameters
    ----------
    contact
        The table ``[contact]``, source of the values that a pair does not set, except the constants
        of another law.
    """
    if not isinstance(tables, list | tuple):
        errors.add("pair", Mismatch(show(tables), "one or more [[pair]] tables"))
        return ()
    common = (
        {name: value for name, value in contact.items() if name in _KEYS}
        if isinstance(contact, Mapping)
        else {}
    )
    found: list[Pair] = []
    for key, table in schema.numbered("pair", tables).items():
        if not isinstance(table, Mapping):
            errors.add(key, Mismatch(show(table), "a table of materials and keys of [contact]"))
            continue
        before = len(errors.items)
        names = table.get("materials", "nothing")
        refuse_unknown(table, ("materials", *_KEYS), key, errors)
        two = (
            isinstance(names, list | tuple)
            and len(names) == 2
            and all(isinstance(one, str) for one in names)
        )
        own = {name: value for name, value in table.items() if name in _KEYS}
        same_law = own.get("law", common.get("law")) == common.get("law")
        shared = {name: value for name, value in common.items() if same_law or name in _OF_ANY_LAW}
        errors.check(
            (
                not two,
                f"{key}.materials",
                (f"found {show(names)}, " if "materials" in table else "missing; ")
                + 'expected the names of two materials, such as ["steel", "brass"]',
            ),
            (not own, key, "has no effect; add keys of [contact], such as friction"),
            (
                two and any(other.fits(*names) for other in found),
                f"{key}.materials",
                Mismatch(f"{show(names)} twice", "each pair once"),
            ),
        )
        law = read_table(Contact, shared | own, key, errors)
        if law is not None and len(errors.items) == before:
            found.append(Pair(materials=(names[0], names[1]), contact=law))
    return tuple(found)
