"""Contact of two bodies without a packing: sphere, cylinder, plane, tube.

A body is a table such as ``{"shape": "cylinder", "radius": 0.005, "length": 0.01, "axis": "y",
"material": "brass"}``. The laws are those of runs, from `granwave.lammps_inputs.contact.law`:

point   spheres on spheres, planes and the sides of cylinders, crossed cylinders, spheres in a
        tube: any law, with the radius of the sphere that is as stiff on a plane (general elliptic
        contact)
line    cylinders on planes, and parallel ones: law hertz for half-spaces that deform over the
        length, law line for plane strain
"""

from __future__ import annotations

import dataclasses
import logging
import math
from collections.abc import Mapping, Sequence
from typing import Any

from granwave._contact_laws import ContactLaw, elliptic_radius
from granwave.lammps_inputs.case.contact.contact import ALL_LAWS, LINE, NO_FORCE, Contact
from granwave.lammps_inputs.case.material import (
    SELECTORS,
    Cylinder,
    Material,
    Shape,
    Vector,
    axis_field,
    length_field,
    read_material,
)
from granwave.lammps_inputs.case.schema import (
    ErrorList,
    choice,
    did_you_mean,
    number,
    read_table,
    refuse_unknown,
    show,
)
from granwave.lammps_inputs.contact.law import law_between
from granwave.lammps_inputs.errors import InputError, Mismatch, fault_of
from granwave.lammps_inputs.packing.cylinders import cylinder_pair

_LOG = logging.getLogger(__name__)

LAW_NAMES = (*(name for name in ALL_LAWS if name != NO_FORCE), LINE)
_SHAPES = ("sphere", "cylinder", "plane", "tube")
_WALLS = ("plane", "tube")
_SIZE = "diameter"
_KEYS = {"sphere": (_SIZE,), "cylinder": (_SIZE, "length", "axis"), "plane": (), "tube": (_SIZE,)}
_ANY_DENSITY = 1000.0  # default density, kg/m^3: forces do not depend on it
_EXAMPLE = 'two bodies such as {"shape": "sphere", "diameter": 0.01, "material": "steel"} and {"shape": "plane"}'


@dataclasses.dataclass(frozen=True, kw_only=True)
class _Table:
    """Keys of a body, without its material."""

    shape: str = choice("shape of the body", _SHAPES)
    diameter: float | None = number(
        "diameter of a sphere, cylinder or tube", "m", above=0, default=None
    )
    radius: float | None = number("radius, in place of the diameter", "m", above=0, default=None)
    length: float | None = length_field()
    axis: Vector | None = axis_field()


@dataclasses.dataclass(frozen=True)
class Body:
    """One of two bodies in contact: radius in m, infinite for a plane; material None if rigid."""

    shape: str
    radius: float
    cylinder: Shape
    material: Material | None


def contact_between_bodies(
    law: str, bodies: Sequence[Any], options: Mapping[str, Any]
) -> ContactLaw:
    """Return the law between two bodies, as tables (see the module) or the name of a shape without
    sizes (``plane``).

    Parameters
    ----------
    law
        One of `LAW_NAMES`.
    options
        Options of the law, by the names of the keys of ``[contact]``.

    Raises
    ------
    InputError
        A body, the law or an option is invalid, or the law does not apply to the contact of these
        shapes.
    """
    errors = ErrorList("contact")
    contact = _read_law(law, options, errors)
    found = _read_bodies(bodies, errors, elastic=contact is not None and not contact.yields,
                         needs_material=contact is None or not contact.entry.is_power)  # fmt: skip
    if errors.items or contact is None or found is None:
        raise InputError(errors.items)
    one, other = found
    effective_radius = None
    if other.shape == "tube":
        effective_radius = float(elliptic_radius(1 / one.radius, 1 / one.radius - 1 / other.radius))
    _refuse_unknown_contact(law, contact, one, other)
    try:
        return law_between(
            contact,
            (one.material, other.material),  # type: ignore[arg-type]  # with a power law both may be rigid
            (one.radius, math.inf if other.shape in _WALLS else other.radius),
            shapes=(one.cylinder, other.cylinder),
            plane_strain=law == LINE,
            effective_radius=effective_radius,
        )
    except ValueError as error:
        raise InputError(f"contact: law {law}: {error}") from None


def _read_law(law: Any, options: Mapping[str, Any], errors: ErrorList) -> Contact | None:
    if not isinstance(law, str) or law not in LAW_NAMES:
        expected = "one of " + ", ".join(map(show, LAW_NAMES))
        errors.add("law", Mismatch(show(law), f"{expected}{did_you_mean(law, LAW_NAMES)}"))
        return None
    entry = ALL_LAWS["hertz" if law == LINE else law]
    known = [p.name for p in entry.parameters.values() if not p.of_material]
    known += [] if entry.is_power or law == LINE else ["cohesion"]
    before = len(errors.items)
    if known:
        refuse_unknown(options, known, "", errors)
    errors.check(
        *(
            (not known, name, Mismatch(f"with law {law}, which takes no options"))
            for name in options
        )
    )
    contact = read_table(
        Contact,
        {"law": law} | {name: options[name] for name in known if name in options},
        "",
        errors,
    )
    required = [p.name for p in entry.parameters.values() if p.required]
    missing = f"missing; law {law} requires {' and '.join(required)}"
    if contact is not None and contact.cohesion is not None:
        neck = contact.cohesion.kind == "jkr" and contact.yields
        errors.check(
            (neck, "cohesion", Mismatch(f'"jkr" with law {law}; it requires law hertz', '"dmt"'))
        )
    errors.check(*((name not in options, name, missing) for name in required))
    return contact if len(errors.items) == before else None


def _read_bodies(
    bodies: Any, errors: ErrorList, *, elastic: bool, needs_material: bool
) -> tuple[Body, Body] | None:
    """Return two bodies, a wall last; None with errors."""
    if isinstance(bodies, str | Mapping) or not isinstance(bodies, Sequence) or len(bodies) != 2:
        errors.add("bodies", Mismatch(show(bodies), f"{_EXAMPLE}"))
        return None
    read = [_read_body(table, f"bodies[{n}]", errors, elastic=elastic, needs_material=needs_material)
            for n, table in enumerate(bodies)]  # fmt: skip
    both = [body for body in read if body is not None]
    if len(both) < 2:
        return None
    one, other = sorted(both, key=lambda body: body.shape in _WALLS)
    in_tube = other.shape == "tube" and one.shape not in _WALLS
    errors.check(
        (
            one.shape in _WALLS,
            "bodies",
            Mismatch(f"a {one.shape} and a {other.shape}", "at least one sphere or cylinder"),
        ),
        (
            in_tube and one.shape == "cylinder",
            "bodies",
            Mismatch("a cylinder in a tube", "a sphere in the tube, or a plane"),
        ),
        (
            in_tube and one.shape == "sphere" and one.radius >= other.radius,
            "bodies",
            Mismatch(
                f"a sphere of radius {one.radius:g} m in a tube of radius {other.radius:g} m",
                "a smaller one",
            ),
        ),
    )
    return one, other


def _read_body(
    table: Any, key: str, errors: ErrorList, *, elastic: bool, needs_material: bool
) -> Body | None:
    if isinstance(table, str):
        table = {"shape": table}
    if not isinstance(table, Mapping):
        errors.add(key, Mismatch(show(table), f"one of {_EXAMPLE}"))
        return None
    before = len(errors.items)
    read = read_table(
        _Table, {name: value for name, value in table.items() if name != "material"}, key, errors
    )
    if read is None:
        return None
    shape = read.shape
    takes = _KEYS[read.shape]
    material = table.get("material")
    sized = _SIZE in takes
    sizes = (read.diameter is not None) + (read.radius is not None)
    given = "radius" if read.diameter is None else "diameter"
    errors.check(
        (
            sized and not sizes,
            f"{key}.diameter",
            f"missing; a {shape} requires a diameter or a radius (m)",
        ),
        (
            sized and sizes == 2,
            f"{key}.radius",
            Mismatch(
                f"{show(read.radius)} together with a diameter", remedy="specify only one of them"
            ),
        ),
        (not sized and sizes, f"{key}.{given}", Mismatch(f"with a {shape}", "none")),
        *(
            (
                name not in takes and getattr(read, name) is not None,
                f"{key}.{name}",
                Mismatch(f"with a {shape}", "only with a cylinder"),
            )
            for name in ("length", "axis")
        ),
        (
            "length" in takes and read.length is None,
            f"{key}.length",
            "missing; a cylinder requires a length (m)",
        ),
        (
            material is None and shape not in _WALLS and needs_material,
            f"{key}.material",
            f"missing; a {shape} requires one (planes and tubes without a material are rigid)",
        ),
    )
    if isinstance(material, Mapping) and not set(SELECTORS) & set(material):
        material = {"density": _ANY_DENSITY, **material}
    if material is not None and not isinstance(material, Material):
        material = read_material(material, errors, f"{key}.material")
    if material is not None and not elastic and material.yield_strength is None:
        errors.add(f"{key}.material.yield_strength", "missing; the law requires it (Pa)")
    if len(errors.items) > before:
        return None
    radius = math.inf if shape == "plane" else read.radius or (read.diameter or 0.0) / 2
    cylinder = (
        Cylinder(read.length or 0.0, read.axis or (0.0, 1.0, 0.0)) if shape == "cylinder" else None
    )
    return Body(shape, radius, cylinder, material)


def _refuse_unknown_contact(law: str, contact: Contact, one: Body, other: Body) -> None:
    """Reject a law that does not apply to a contact of these shapes; the first is not a wall."""
    if contact.entry.is_power:
        return
    pair = cylinder_pair(one.cylinder, other.cylinder) if (one.cylinder or other.cylinder) else None
    if pair is not None and pair.nearly_parallel and other.shape == "cylinder":
        found = "cylinders whose axes are less than 1 degree from parallel"
        fault = Mismatch(found, "parallel ones, or a larger angle")
        raise InputError(fault_of(fault, source="contact", key="bodies"))
    if contact.cohesion is not None and (one.cylinder or other.cylinder):
        fault = Mismatch(f"a {one.shape} and a {other.shape}", "spheres, planes or tubes")
        raise InputError(fault_of(fault, source="contact", key="cohesion"))
    along_line = one.cylinder is not None and (
        other.shape == "plane" or (pair is not None and pair.parallel)
    )
    if law == LINE and not along_line:
        fault = Mismatch(
            f"line for a {one.shape} and a {other.shape}, which touch at a point",
            "a cylinder on a plane or on a parallel cylinder, or law hertz",
        )
        raise InputError(fault_of(fault, source="contact", key="law"))
    if contact.yields and along_line:
        _LOG.warning("law %s: a %s and a %s touch along a line and stay elastic, as in runs: law "
            "hertz is used",
                     law, one.shape, other.shape)  # fmt: skip
