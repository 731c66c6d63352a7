"""``[contact]`` and ``[[pair]]``: contact law, its constants, friction, loss and initial dents."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from granwave import _contact_laws
from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.hints import FRICTION, POSSIBLE, VELOCITY
from granwave.lammps_inputs.case.law_parameters import (
    OF_CONTACT,
    PARAMETERS,
    value_of,
    with_parameters,
)
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.schema import (
    ErrorList,
    ValidationError,
    read_table,
    refuse_unknown,
    show,
)

_DENT_FORM = "a number in m, the path of a result.h5, or tables {overlap = ...} or {force = ...} with low and high = [x, y, z]"


def parse_dents(value: Any) -> float | str | tuple[Dents, ...]:
    if isinstance(value, str) and value:
        return value
    if isinstance(value, Mapping):
        value = [value]
    if isinstance(value, list | tuple) and value:
        return tuple(map(_parse_dent, value))
    return _parse_size(value)


def _parse_size(value: Any) -> float:
    size = schema.finite(value, _DENT_FORM)
    schema.refuse_if(size < 0, f"{_DENT_FORM}, not negative")
    return size


def _parse_dent(table: Any) -> Dents:
    schema.inner_table(table, _DENT_FORM, ("overlap", "force", "low", "high"))
    schema.refuse_if(("overlap" in table) == ("force" in table), _DENT_FORM)
    found = {name: _parse_size(table[name]) for name in ("overlap", "force") if name in table}
    corners = {
        name: schema.parse_point(table[name], _DENT_FORM)
        for name in ("low", "high")
        if name in table
    }
    if len(corners) == 2 and any(
        a > b for a, b in zip(corners["low"], corners["high"], strict=True)
    ):
        raise ValidationError("low of a box of dents below its high, along each axis")
    return Dents(**found, **corners)  # type: ignore[arg-type]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Dents:
    """Initial dents of the contacts in a box, given by the largest earlier overlap (m) or force
    (N).
    """

    overlap: float | None = None
    force: float | None = None
    low: tuple[float, float, float] | None = None
    high: tuple[float, float, float] | None = None


LOSS_FORM = (
    "{time = ...} in s, {restitution = ..., velocity = ...} with the velocity in m/s, "
    "{dashpot = ...} or {dashpot = {restitution = ...}}"
)
_KINDS = ("time", "restitution", "dashpot")
_LONGEST_TIME = 1.0  # s
_GAIN = "below 0 a contact would gain energy, and restitution exceed 1"


@dataclasses.dataclass(frozen=True, kw_only=True)
class DashpotRestitution:
    """Restitution that a dashpot gives a Hertzian contact, at any speed."""

    restitution: float


@dataclasses.dataclass(frozen=True, kw_only=True)
class Loss:
    """Viscous loss of contacts: one of the three kinds.

    Attributes
    ----------
    time
        Loss time A, s.
    restitution, velocity
        Restitution of a head-on collision, and its speed of approach, m/s; the loss time follows
        from both.
    dashpot
        Factor of Tsuji's dashpot, or the restitution that it gives a Hertzian contact.
    """

    time: float | None = None
    restitution: float | None = None
    velocity: float | None = None
    dashpot: float | DashpotRestitution | None = None


def parse_loss(value: Any) -> Loss:
    """Read a loss; raise `ValidationError` for anything but one of the three kinds."""
    kinds = [
        name
        for name in _KINDS
        if name in schema.inner_table(value, LOSS_FORM, (*_KINDS, "velocity"))
    ]
    schema.refuse_if(
        len(kinds) > 1, f"one of {LOSS_FORM}; {' and '.join(kinds[:2])} exclude each other"
    )
    if kinds == ["restitution"]:
        if "velocity" not in value:
            of_dashpot = (
                f"{{dashpot = {{restitution = {show(value['restitution'])}}}}} holds at any"
            )
            missing = "the velocity at which the restitution holds is missing"
            raise ValidationError(f"{LOSS_FORM}; {missing}, and {of_dashpot}")
        velocity = schema.finite(value["velocity"], LOSS_FORM)
        if not POSSIBLE["m/s"][0] <= velocity <= VELOCITY.high * 1e3:
            raise ValidationError("a velocity above 0 (m/s), at which the restitution holds")
        return Loss(restitution=_parse_restitution(value["restitution"]), velocity=velocity)
    schema.refuse_if("velocity" in value, f"{LOSS_FORM}; a velocity belongs to a restitution")
    if kinds == ["time"]:
        time = schema.finite(value["time"], LOSS_FORM)
        form = f"a loss time from 0 to {_LONGEST_TIME:g} s"
        schema.refuse_if(time < 0, f"{form}; {_GAIN}")
        schema.refuse_if(time > _LONGEST_TIME, f"{form}; {time:g} us is {time:g}e-6")
        return Loss(time=time)
    if isinstance(factor := value["dashpot"], Mapping):
        schema.inner_table(factor, LOSS_FORM, ("restitution",))
        return Loss(
            dashpot=DashpotRestitution(restitution=_parse_restitution(factor["restitution"]))
        )
    factor = schema.finite(factor, LOSS_FORM)
    schema.refuse_if(factor < 0, f"a factor of the dashpot from 0 up; {_GAIN}")
    return Loss(dashpot=factor)


def _parse_restitution(value: Any) -> float:
    restitution = schema.finite(value, LOSS_FORM)
    schema.refuse_if(not 0 < restitution <= 1, "a restitution above 0 and at most 1")
    return restitution


MARSHALL = "marshall"  # resistance to twisting by the friction of the contact circle
_MOST = {"coefficient": 10.0, "stiffness": 1e15, "damping": 1e9}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Resistance:
    """Spring, dashpot and slider that resist the rolling or the twisting of a contact.

    Attributes
    ----------
    coefficient
        Largest force over the normal force: a number for rolling, a length (m) for twisting.
    stiffness
        N/m for rolling, N m for twisting; None: it follows the contact circle.
    damping
        N s/m for rolling, N m s for twisting.
    """

    coefficient: float
    stiffness: float | None = None
    damping: float = 0.0


def _parse_resistance(value: Any, form: str) -> Resistance:
    """Read a coefficient or a table; 0 is no resistance, also where a pair takes back that of
    [contact].
    """
    table = value if isinstance(value, Mapping) else {"coefficient": value}
    table = schema.inner_table(table, form, _MOST, needed=("coefficient",))
    found = {name: schema.finite(number, form) for name, number in table.items()}
    for name, number in found.items():
        schema.refuse_if(
            not 0 <= number <= _MOST[name], f"{form}; {name} from 0 to {_MOST[name]:g}"
        )
    schema.refuse_if(
        found.get("stiffness") == 0,
        f"{form}; a stiffness above 0, or none, to follow the contact circle",
    )
    return Resistance(**found)


def parse_rolling(value: Any) -> Resistance:
    """Read a resistance to rolling; raise `ValidationError` for anything else."""
    return _parse_resistance(
        value, "a coefficient, or {coefficient = ..., stiffness = (N/m), damping = (N s/m)}"
    )


def parse_twisting(value: Any) -> Resistance | str:
    """Read a resistance to twisting; raise `ValidationError` for anything else."""
    form = 'a coefficient in m, {coefficient = (m), stiffness = (N m), damping = (N m s)}, or "marshall"'
    return MARSHALL if value == MARSHALL else _parse_resistance(value, form)


COHESIONS = ("jkr", "dmt")
_MOST_ADHESION = 1e4  # J/m^2


@dataclasses.dataclass(frozen=True, kw_only=True)
class Cohesion:
    """Cohesion of contacts.

    Attributes
    ----------
    kind
        ``jkr``: after Johnson, Kendall and Roberts; ``dmt``: after Derjaguin, Muller and Toporov.
    energy
        Work of adhesion of both surfaces together, J/m^2; 0: none, as where a pair takes back that
        of [contact].
    """

    kind: str
    energy: float


def parse_cohesion(value: Any) -> Cohesion:
    """Read a cohesion; raise `ValidationError` for anything else."""
    form = '{kind = "jkr" or "dmt", energy = (work of adhesion, J/m^2)}'
    schema.inner_table(value, form, ("kind", "energy"), needed=("kind", "energy"))
    kind = value["kind"]
    energy = schema.finite(value["energy"], form)
    schema.refuse_if(kind not in COHESIONS, f"{form}; kind = {show(kind)} is neither")
    schema.refuse_if(
        not 0 <= energy <= _MOST_ADHESION, f"{form}; energy from 0 to {_MOST_ADHESION:g}"
    )
    return Cohesion(kind=kind, energy=energy)


FITTED_POISSON_RATIO = 0.30
_DEEPEST = 3.0  # in contact radii; the largest stress lies above 0.7 for every Poisson's ratio


def hertz_von_mises_yield_factor(poisson_ratio: float) -> float:
    """Return the exact C of the contact pressure at first yield, ``p_y = C sigma_y``, under Hertz's
    pressure.

    On the axis below the centre of a Hertzian contact of radius a and peak pressure p0, at depth z = zeta a
    (K. L. Johnson, Contact Mechanics, 1985, eq. 3.45)::

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
    from scipy.optimize import minimize_scalar  # takes longer to load than most commands need

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
LAWS = {name: law for name, law in ALL_LAWS.items() if not law.is_power}  # those of two materials
NO_FORCE = "none"  # law of materials whose grains do not touch each other
LINES = ("half-space", "plane-strain")
LINE = "line"  # law of crystals of cylinders alone: Hertz's, with lines in plane strain
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
        'contact law; "line" is "hertz" with line = "plane-strain", for cylinders alone',
        (*ALL_LAWS, LINE),
        default="elastoplastic",
    )
    line: str = schema.choice(
        "contact along a line, of a cylinder on a plane or beside another: with bodies that give way over its length "
        "(half-space), or in plane strain",
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
        "friction below Coulomb's limit: one spring, its force scaled down as the contact circle shrinks, or kept, "
        "which can create energy; or a row of them that slip from its edge inwards (Mindlin, Deresiewicz)",
        ("mindlin_rescale", "mindlin", "partial_slip"),
        default="mindlin_rescale",
    )
    rolling: Resistance | None = schema.custom(
        "resistance to rolling: largest torque over effective radius and normal force, or a table of coefficient, "
        "stiffness (N/m; that of the spring of friction if left out) and damping (N s/m)",
        parse_rolling,
        default=None,
    )
    twisting: Resistance | str | None = schema.custom(
        "resistance to twisting: largest torque over normal force (m), a table of coefficient, stiffness (N m) and "
        'damping (N m s), or "marshall", by the friction of the contact circle',
        parse_twisting,
        default=None,
    )
    loss: Loss | None = schema.custom(
        "loss by the rate of the overlap: by a time, by the restitution at a velocity, or by a dashpot (Tsuji)",
        parse_loss,
        default=None,
    )
    cohesion: Cohesion | None = schema.custom(
        'cohesion: kind "jkr" (elastic spheres held by a neck, law hertz) or "dmt" (a pull while surfaces touch, any '
        "law of two materials), and the work of adhesion in J/m^2",
        parse_cohesion,
        default=None,
    )
    initial_overlap: float | str | tuple[Dents, ...] = schema.custom(
        "largest overlap that the contacts had before the run, their dents: a value, values by region, or an earlier "
        "run's result.h5",
        parse_dents,
        unit="m",
        default=0.0,
    )

    def __post_init__(self) -> None:
        """Take the law of lines for what it is."""
        if self.law == LINE:
            object.__setattr__(self, "law", "hertz")
            object.__setattr__(self, "line", "plane-strain")

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...

    @property
    def parameters(self) -> dict[str, float | str]:
        """Values of the parameters that the law has for a contact, by name; without those that are
        left out.
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
_NOT_BY_PAIR = ("initial_overlap", "line")
_OF_ANY_LAW = ("friction", "tangential", "rolling", "twisting", "loss", "cohesion")
_KEYS = tuple(field.name for field in dataclasses.fields(Contact) if field.name not in _NOT_BY_PAIR)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Pair:
    """The contact law between two materials.

    Attributes
    ----------
    materials
        Names of the two materials, which may be equal; "rigid" for a rigid wall.
    contact
        Values of ``[contact]``, overridden by those of the pair.
    """

    materials: tuple[str, str]
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
        The table ``[contact]``, source of the values that a pair does not give: all but the
        constants of another law.
    """
    if not isinstance(tables, list | tuple):
        errors.add("pair", f"found {show(tables)}, expected one or more [[pair]] tables")
        return ()
    common = (
        {name: value for name, value in contact.items() if name in _KEYS}
        if isinstance(contact, Mapping)
        else {}
    )
    found: list[Pair] = []
    for key, table in schema.numbered("pair", tables).items():
        if not isinstance(table, Mapping):
            errors.add(
                key, f"found {show(table)}, expected a table of materials and keys of [contact]"
            )
            continue
        before = len(errors.lines)
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
            (not two, f"{key}.materials", (f"found {show(names)}, " if "materials" in table else "missing; ")
             + 'expected the names of two, such as ["steel", "brass"]'),
            (not own, key, "changes nothing; give keys of [contact], such as friction"),
            (two and any(other.fits(*names) for other in found), f"{key}.materials",
             f"found {show(names)} twice, expected each pair once"),
        )  # fmt: skip
        law = read_table(Contact, shared | own, key, errors)
        if law is not None and len(errors.lines) == before:
            found.append(Pair(materials=(names[0], names[1]), contact=law))
    return tuple(found)
