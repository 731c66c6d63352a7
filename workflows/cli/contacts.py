"""Command about single contacts: ``granwave law``."""

from __future__ import annotations

import argparse
import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.case.contact.contact import LAWS
from granwave.lammps_inputs.case.contact.law_parameters import PARAMETERS, laws_with
from granwave.lammps_inputs.case.contact.tables import COHESION, Cohesion
from granwave.lammps_inputs.case.material import Material, load_materials, material, sphere_mass
from granwave.lammps_inputs.case.schema import ValidationError
from granwave.lammps_inputs.contact.law import contact_of
from granwave.lammps_inputs.errors import InputError


def law(options: argparse.Namespace) -> int:
    """Execute ``granwave law``."""
    from granwave.analysis.contact_law import curves

    output = options.output or Path("restitution.png" if options.restitution else "law.png")
    speed = options.velocity
    at_most_two(options)
    _check_law(options, output)
    parameters = _parameters(options)
    materials = [
        dataclasses.replace(material_of(name), **parameters["material"])
        for name in options.material
    ]
    cohesion = _cohesion(options)
    constants = parameters["contact"]
    spheres = _contact(materials, options.radius, options.law, constants, cohesion)
    names = " on ".join(text.rpartition(":")[2] for text in options.material)
    if not options.restitution:
        title = f"{names}, {speed:g} m/s" if speed else names
        curves.write_law(spheres, output, options.max_overlap, title, speed)
    else:
        first = sphere_mass(materials[0], options.radius[0])
        flat = (options.radius[0], math.inf)
        wall = _contact((materials[0], None), flat, options.law, constants)
        if math.isinf(options.radius[-1]):
            contacts = {"sphere and plane": (spheres, first)}
        else:
            second = sphere_mass(materials[-1], options.radius[-1])
            contacts = {"two spheres": (spheres, first * second / (first + second))}
        contacts["sphere and rigid wall"] = (wall, first)
        title = f"{names}, {options.law}"
        curves.write_restitution(contacts, output, max_overlap=options.max_overlap, title=title)
    print(output)
    return 0


def _check_law(options: argparse.Namespace, output: Path) -> None:
    """Raise InputError for incompatible options of ``granwave law``."""
    rate = options.rate_sensitivity
    speed = options.velocity
    contact_law = LAWS[options.law]
    published = options.variant not in (None, "continuous")
    takes_rate = contact_law.yields and "rate_sensitivity" in contact_law.parameters
    other = (
        "applies to all velocities: remove --restitution"
        if rate
        else "has no effect: add --rate-sensitivity"
    )
    for wrong, fault in (
        (
            output.suffix not in (".png", ".pdf", ".csv"),
            f"-o {output}: expected a name that ends in .png, .pdf or .csv",
        ),
        (
            not output.absolute().parent.is_dir(),
            f"-o {output}: no such directory: {output.absolute().parent}",
        ),
        (not are_radii(options.radius), RADII),
        (
            options.restitution and not contact_law.yields,
            f"--restitution: a contact of law {options.law} returns all energy; choose another "
            "--law",
        ),
        (
            rate and not takes_rate,
            f"--rate-sensitivity: found with law {options.law}, which does not depend on the "
            "strain rate",
        ),
        (
            rate and published,
            f"--rate-sensitivity: found with variant {options.variant}, expected continuous",
        ),
        (
            speed and (not rate or options.restitution),
            f"--velocity: found {speed:g}, which {other}",
        ),
    ):
        if wrong:
            raise InputError(fault)


def _parameters(options: argparse.Namespace) -> dict[str, dict[str, Any]]:
    """Return the parameters of the law that are given, of ``contact`` and of each ``material``.

    As in a case, parameters with a default are also accepted with a law that does not use them.
    """
    law = LAWS[options.law]
    slow = {"rate_sensitivity": None}  # unless a rate is given
    parameters: dict[str, dict[str, Any]] = {"contact": {}, "material": slow}
    for name, parameter in PARAMETERS.items():
        value = getattr(options, name, None)
        if value is None or value == parameter.default:
            continue
        if name in law.parameters:
            parameters["material" if parameter.of_material else "contact"][name] = value
        elif parameter.optional:
            flag = name.replace("_", "-")
            laws = " or ".join(laws_with(parameter))
            raise InputError(f"--{flag}: found with law {options.law}; it applies only to {laws}")
    return parameters


def _contact(
    materials: Sequence[Material | None],
    radii: Sequence[float],
    law: str,
    constants: dict[str, Any],
    cohesion: Cohesion | None = None,
) -> ContactLaw:
    """Return the law between two bodies; raise InputError if its parameters are incompatible."""
    try:
        return contact_of(materials, radii, law, constants, cohesion=cohesion)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"law {law}: {error}") from None


def _cohesion(options: argparse.Namespace) -> Cohesion | None:
    """Read ``--cohesion``; None without it."""
    if not options.cohesion:
        return None
    kind, energy = options.cohesion
    try:
        found: Cohesion = COHESION.read({"kind": kind, "energy": float(energy)})
    except (ValueError, ValidationError):
        raise InputError(
            f"--cohesion: found {kind} {energy}, expected jkr or dmt, and the work of adhesion in J/m^2"
        ) from None
    if kind == "jkr" and LAWS[options.law].yields:
        raise InputError(
            f"--cohesion: found jkr with law {options.law}, but is a law of elastic spheres: use "
            "--law hertz, or dmt"
        )
    if options.restitution:
        raise InputError("--cohesion: cannot be combined with --restitution")
    return found


#: Message for radii that `are_radii` rejects.
RADII = "--radius: expected positive lengths in m (the second may be inf, a plane)"


def are_radii(radii: Sequence[float]) -> bool:
    """Return True for one finite radius, and optionally a second radius, which may be infinite."""
    return math.isfinite(radii[0]) and all(radius > 0 for radius in radii)


def at_most_two(options: argparse.Namespace) -> None:
    """Raise InputError if there are more than two materials or radii."""
    for name, values in (("--material", options.material), ("--radius", options.radius)):
        if len(values) > 2:
            raise InputError(f"{name}: found {len(values)} values, expected one or two")


def material_of(text: str) -> Material:
    """Return a preset, or the material FILE.toml:NAME from a file of the user."""
    path, colon, name = text.rpartition(":")
    if not colon:
        return material(text)
    known = load_materials(path)
    if name not in known:
        raise InputError(
            f"--material {text}: found no {name} in {path}, expected one of {', '.join(known)}"
        )
    return known[name]
