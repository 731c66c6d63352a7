"""The continuum case that a packing compares with, or the reverse, for ``granwave check``.

Packing and continuum are compared at equal energy divided by sigma_y^2 D^3/E, with the diameter D
of the spheres or of the punch. The counterpart has the same material and D, so that equal energies
are equal inputs.
"""

from __future__ import annotations

import dataclasses
import math
import shlex
from typing import TYPE_CHECKING, Any

from granwave.extensions.continuum.punch.case import TAPER, Punch, yield_velocity
from granwave.lammps_inputs.case.material import Material, presets, sphere_mass
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.lattices import KINDS
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.packing.motion import struck_of, velocities_of
from granwave.lammps_inputs.planning.encounters import expected_energy
from granwave.lammps_inputs.planning.impact_input import ImpactInput
from granwave.lammps_inputs.planning.timestep import expected_peak_overlap
from granwave.workflows.check_part import CheckPart, input_rows, input_values

if TYPE_CHECKING:
    from granwave.extensions.continuum.punch.case import ContinuumCase
    from granwave.lammps_inputs.case.case import Case

# built-in cases from which counterparts are made
_BLOCK = "half-space"
_PACKING = "fcc-small"
_NARROWEST = 2.0  # punch diameters: a narrower block is not a half-space
_WITHIN_LAW = 0.2  # overlap / R* where the contact law ends
_STRUCK = (1, 3, 7)  # values of load.spheres
_FEWEST = (4, 4, 2)  # spheres along x, y and z of the packing
_DIGITS = 12


@dataclasses.dataclass(frozen=True)
class Counterpart:
    """Case of equal input, as a command for the shell; or the reason why there is none.

    Attributes
    ----------
    yield_velocity
        Velocity from which the counterpart yields, m/s; None where there is no estimate.
    velocity
        Velocity of its impact, m/s.
    """

    command: str = ""
    reason: str = ""
    velocity: float | None = None
    yield_velocity: float | None = None

    @property
    def stays_elastic(self) -> bool:
        """True if the counterpart is not expected to yield."""
        if self.velocity is None or self.yield_velocity is None:
            return False
        return self.velocity < self.yield_velocity


def check(assembly: Assembly) -> CheckPart:
    """Return the output of ``granwave check`` on the continuum case of a packing."""
    found = continuum_of(assembly)
    return CheckPart(lines=_lines("continuum", found), further_values=_values(found))


def check_of_punch(case: ContinuumCase) -> CheckPart:
    """Return the output of ``granwave check`` on a continuum case: inputs, first yield, packing."""
    inputs = inputs_of_continuum(case)
    found = packing_of(case)
    values = input_values(inputs) | _values(found)
    return CheckPart(
        rows=(*input_rows(inputs), ("first yield", _first_yield(case))),
        lines=_lines("packing", found),
        further_values=values | {"yield_velocity_m_s": case.yield_velocity},
    )


def _lines(what: str, found: Counterpart) -> list[str]:
    """Return the lines on a counterpart, a packing or a continuum, that follow a table."""
    command = found.command or f"none, {found.reason}"
    lines = ["", f"{what} of equal input: {command}"]
    if found.stays_elastic:
        body = "block" if what == "continuum" else "packing"
        velocity = f"{found.yield_velocity:.2g} m/s"
        lines.append(f"The {body} stays elastic; it would yield above about {velocity}.")
    return lines


def _values(found: Counterpart) -> dict[str, Any]:
    """Return the values of a counterpart for ``granwave check --json``."""
    return {
        "counterpart": {
            "command": found.command or None,
            "reason": found.reason or None,
            "yield_velocity_m_s": found.yield_velocity,
            "stays_elastic": found.stays_elastic,
        }
    }


def _first_yield(case: ContinuumCase) -> str:
    """Return the smallest velocity of the punch at which the block of a continuum case yields."""
    velocity = case.yield_velocity
    if velocity is None:
        return ""
    elastic = ": this impact is elastic" if case.punch.velocity < velocity else ""
    return f"from about {velocity:.2g} m/s, at the edge of the punch{elastic}"


def inputs_of_continuum(case: ContinuumCase) -> ImpactInput:
    """Return the inputs of the impact of a punch."""
    energy = case.punch.energy
    return ImpactInput(energy, None, energy / case.energy_unit, None)


def continuum_of(assembly: Assembly) -> Counterpart:
    """Return the continuum case of equal input: a punch with the mass and velocity of the impacted
    spheres.

    The block is as high as the packing, and as wide as its narrower side.
    """
    case = assembly.case
    lattice = assembly.lattice
    diameter = case.packing.diameter
    if not case.contact.yields or case.material.yield_strength is None:
        return Counterpart(reason="the contacts do not yield")
    if not _strikes_along_z(assembly):
        return Counterpart(reason="it is available only for impacts and strikers along z")
    low, high = lattice.bounds()
    width = min(high[:2] - low[:2]) + diameter
    height = high[2] - low[2] + diameter
    if not lattice.rule.is_lattice:
        return Counterpart(reason="grains of a file do not form a block")
    if lattice.rule.dimension < 3 or width < _NARROWEST * diameter:
        return Counterpart(
            reason="the packing is not a block: a chain, a single layer, or too narrow"
        )
    mass = sum(map(assembly.mass_of, struck_of(assembly)))
    velocity = math.sqrt(2 * expected_energy(assembly) / mass)
    taper = TAPER * diameter
    punch = Punch(diameter=diameter, mass=mass, velocity=velocity, taper=taper)
    changes = {
        **_material(case.material),
        "block.diameter": width,
        "block.height": height,
        "punch.diameter": diameter,
        "punch.mass": mass,
        "punch.velocity": velocity,
        "punch.taper": taper,
    }
    command = _command("continuum", _BLOCK, changes, f"{case.name}-continuum")
    return Counterpart(
        command, velocity=velocity, yield_velocity=yield_velocity(case.material, punch)
    )


def _strikes_along_z(assembly: Assembly) -> bool:
    """Return True for impacted spheres, or one striker, that move along z into a packing at
    rest.
    """
    load = assembly.case.load
    if not load.strikes:
        return False
    moving = velocities_of(assembly)
    struck = struck_of(assembly)
    together = load.gives_velocity or len(struck) == 1
    return (
        together
        and set(moving) == set(struck)
        and all(v[2] > 0 and not any(v[:2]) for v in moving.values())
    )


def packing_of(case: ContinuumCase) -> Counterpart:
    """Return the FCC packing of equal input: spheres as wide as the punch, in a packing as large as
    the block.

    The number of impacted spheres is the smallest, up to seven, that keeps the expected overlap
    within the contact law.
    """
    diameter = case.punch.diameter
    rule = KINDS["fcc"]
    if case.material.yield_strength is None:
        return Counterpart(reason="the material does not yield")
    extents = (case.block.diameter, case.block.diameter, case.block.height)
    pitches = (*rule.pitch, rule.layer_spacing)
    size = [
        max(round((extent / diameter - 1) / pitch) + 1, fewest)
        for extent, pitch, fewest in zip(extents, pitches, _FEWEST, strict=True)
    ]
    changes: dict[str, Any] = {}
    velocity = 0.0
    for spheres in _STRUCK:
        mass = spheres * sphere_mass(case.material, diameter / 2)
        velocity = math.sqrt(2 * case.punch.energy / mass)
        changes = {
            **_material(case.material),
            "packing.size": size,
            "packing.diameter": diameter,
            "load.spheres": spheres,
            "load.velocity": velocity,
        }
        packing = _small_packing(case.material, changes)
        overlap = expected_peak_overlap(assemble(packing))
        if overlap <= _WITHIN_LAW * sphere_contact(packing).effective_radius:
            break
    command = _command("run", _PACKING, changes, f"{case.name}-packing")
    return Counterpart(command, velocity=velocity, yield_velocity=_yield_velocity(packing))


def _yield_velocity(packing: Case) -> float:
    """Return the smallest velocity of a head-on impact at which two spheres yield, m/s."""
    law = sphere_contact(packing)
    return math.sqrt(4 * law.loading_work(law.yield_overlap) / packing.sphere_mass)


def _small_packing(material: Material, changes: dict[str, Any]) -> Case:
    """Return a small packing of the spheres and the impact of a counterpart."""
    tables = {
        "name": "packing",
        "material": {
            name: value for name, value in dataclasses.asdict(material).items() if value is not None
        },
        "packing": {"kind": "fcc", "size": list(_FEWEST), "diameter": changes["packing.diameter"]},
        "load": {"spheres": changes["load.spheres"], "velocity": changes["load.velocity"]},
    }
    return case_from_dict(tables, "counterpart")


def _material(material: Material) -> dict[str, Any]:
    """Return the overrides that set a material: the name of a preset, or the values."""
    if presets().get(material.name or "") == material:
        return {"material": material.name}
    names = ("youngs_modulus", "poisson_ratio", "density", "yield_strength")
    return {f"material.{name}": getattr(material, name) for name in names}


def _command(verb: str, base: str, changes: dict[str, Any], directory: str) -> str:
    words = ["granwave", verb, base]
    for key, value in changes.items():
        words += ["--set", f"{key}={_written(value)}"]
    return shlex.join([*words, "-o", directory])


def _written(value: Any) -> str:
    """Write a value in the form that ``--set`` accepts."""
    if isinstance(value, float):
        return f"{value:.{_DIGITS}g}"
    return str(value).replace(" ", "")
