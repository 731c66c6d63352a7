"""Case of a continuum run, as read from a TOML file: block, punch and material."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from granwave.extensions.continuum.frame import ElementCase
from granwave.lammps_inputs.case.hints import DIAMETER, INTERVAL, MASS, TIME, VELOCITY, Usual
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.schema import ErrorList, count, number, positive_or_auto
from granwave.lammps_inputs.errors import Mismatch

AUTO_END_TIME = 5e-3  # s, upper limit of `end_time = "auto"`
ELEMENTS = 62_500
TAPER = 0.01  # taper over the punch's diameter, in the built-in case

# Largest von Mises stress at the edge / largest mean pressure in elastic finite elements:
# 1.54, 2.11 and 3.00 for 4000, 16 000 and 62 500 elements, as the stress grows with the root of
# the distance to the edge; 2.97 for a punch of 4.45 g in place of 100 g
_STRESS_AT_EDGE = 3.0  # ratio of stresses for `ELEMENTS`
_LARGEST_TAPER = 0.1  # diameters; larger values do not give the contact of a flat punch


@dataclasses.dataclass(frozen=True, kw_only=True)
class Block:
    """``[block]``: a cylinder with a fixed bottom and otherwise free surfaces."""

    diameter: float = number(
        "diameter of the block", Usual("m", 1e-5, 10.0, ("mm", "µm")), above=0, default=0.10
    )
    height: float = number(
        "height of the block", Usual("m", 1e-5, 10.0, ("mm", "µm")), above=0, default=0.10
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Punch:
    """``[punch]``: a rigid, flat, frictionless punch with an edge of radius ``taper``."""

    diameter: float = number("diameter of the punch", DIAMETER, above=0, default=0.010)
    mass: float = number("mass of the punch", MASS, above=0, default=0.10)
    velocity: float = number(
        "velocity of the punch, into the block", VELOCITY, above=0, default=10.0
    )
    taper: float = number(
        "radius of the rounded edge", Usual("m", 1e-9, 0.1, ("mm", "µm")), at_least=0, default=1e-4
    )

    @property
    def energy(self) -> float:
        """Initial kinetic energy of the punch, which is the energy input, J."""
        return (
            0.5 * self.mass * self.velocity * self.velocity
        )  # products overflow to infinity, powers raise an error


@dataclasses.dataclass(frozen=True, kw_only=True)
class PunchRunSettings:
    """``[run]``: end time, mesh, timestep and snapshots."""

    end_time: float | Literal["auto"] = positive_or_auto(
        "end of the run; auto: when the punch has left and dissipation grows by less than 1e-4 of "
        "the energy input in 10 µs",
        TIME,
    )
    elements: int = count(
        "approximate number of elements of the mesh",
        at_least=100,
        at_most=1_000_000_000,
        default=ELEMENTS,
    )
    timestep: float | Literal["auto"] = positive_or_auto(
        "timestep; auto: just below the stability limit", INTERVAL
    )
    edge_size: float | Literal["auto"] = positive_or_auto(
        "width of the elements at the punch's edge; auto: derived from elements (32 µm for 62500 "
        "elements and a punch of 10 mm)",
        Usual("m", 1e-9, 0.1, ("mm", "µm")),
    )
    frame_interval: float = number(
        "time between snapshots of the fields; doubled whenever there are more than 64. While the "
        "punch touches the block or elements yield, up to 25 further snapshots are stored",
        INTERVAL,
        above=0,
        default=2e-6,
    )

    @property
    def longest(self) -> float:
        """Latest time that the run can reach, s."""
        return AUTO_END_TIME if isinstance(self.end_time, str) else self.end_time


def yield_velocity(material: Material, punch: Punch, elements: int = ELEMENTS) -> float | None:
    """Return the smallest velocity of a punch at which the block yields at its edge, m/s.

    A rigid punch of radius a and mass m on an elastic half-space, of stiffness 2 a E/(1 - nu^2),
    reaches the mean pressure v sqrt(k m)/(pi a^2). The stress at its edge is a multiple of it,
    which grows with the number of elements. Elastic runs on 4000 to 62 500 elements with tapers of
    0.5 to 10 % of the diameter, Poisson ratios of 0 to 0.45 and punches of 2 to 100 g agree within
    20 %.

    Returns
    -------
    float or None
        None for a material without a yield strength, and for an edge that is rounded by more than
        a tenth of the diameter.
    """
    if material.yield_strength is None or punch.taper > _LARGEST_TAPER * punch.diameter:
        return None
    modulus = material.youngs_modulus / (1 - material.poisson_ratio**2)
    impedance = math.sqrt(modulus * punch.diameter * punch.mass)
    area = math.pi * punch.diameter**2 / 4
    stress = _STRESS_AT_EDGE * (elements / ELEMENTS) ** 0.25
    return material.yield_strength * area / (stress * impedance)


@dataclasses.dataclass(frozen=True, kw_only=True)
class ContinuumCase(ElementCase):
    """Impact of a punch on a block."""

    SECTIONS: ClassVar[Mapping[str, type]] = {
        "block": Block,
        "punch": Punch,
        "run": PunchRunSettings,
    }

    material: Material
    block: Block = dataclasses.field(default_factory=Block)
    punch: Punch = dataclasses.field(default_factory=Punch)
    run: PunchRunSettings = dataclasses.field(default_factory=PunchRunSettings)

    @property
    def yield_velocity(self) -> float | None:
        """Smallest velocity of the punch at which the block yields, m/s; see `yield_velocity`."""
        return yield_velocity(self.material, self.punch, self.run.elements)

    @property
    def energy_unit(self) -> float:
        """Energy unit sigma_y^2 D^3/E with the diameter of the punch, J."""
        material = self.material
        assert material.yield_strength is not None  # checked when read
        return material.yield_strength**2 * self.punch.diameter**3 / material.youngs_modulus

    @staticmethod
    def _complete(parts: dict[str, Any], data: Mapping[str, Any], errors: ErrorList) -> None:
        block: Block | None = parts["block"]
        punch: Punch | None = parts["punch"]
        run: PunchRunSettings | None = parts["run"]
        material: Material | None = parts.get("material")
        if material is not None:
            _check_material(material, errors)
        if punch is not None:
            _check_punch(punch, block, run, errors)
        if run is not None and not isinstance(run.timestep, str) and run.timestep > run.longest:
            errors.add(
                "run.timestep",
                Mismatch(f"{run.timestep:g} s", f"at most run.end_time, {run.longest:g} s"),
            )


def _check_material(material: Material, errors: ErrorList) -> None:
    """Check that a material has a yield strength, and no property that a block cannot have."""
    if material.yield_strength is None:
        errors.add(
            "material.yield_strength",
            "missing; a continuum case requires it: set a number (Pa)",
        )
    for key, what in (("hardening", "harden"), ("rate_sensitivity", "depend on the rate")):
        value = getattr(material, key)
        if value:
            expected = f"none; a block does not {what}"
            errors.add(f"material.{key}", Mismatch(f"{value:g}", expected))


def _check_punch(
    punch: Punch, block: Block | None, run: PunchRunSettings | None, errors: ErrorList
) -> None:
    """Check the energy of a punch, and its size compared with the block and the elements."""
    radius = punch.diameter / 2
    narrow = f"expected at most the radius of the punch, {radius:g} m"
    if not 0 < punch.energy < math.inf:
        errors.add(
            "punch",
            Mismatch(
                f"{punch.mass:g} kg at {punch.velocity:g} m/s, an energy of {punch.energy:g} J as "
                "a number",
                remedy="check that they are in SI units",
            ),
        )
    if punch.taper > radius:
        errors.add("punch.taper", Mismatch(f"{punch.taper:g} m, {narrow}"))
    if block is not None and punch.diameter >= block.diameter:
        errors.add(
            "punch.diameter",
            Mismatch(
                f"{punch.diameter:g} m",
                f"less than block.diameter, {block.diameter:g} m",
                "use a narrower punch or a wider block",
            ),
        )
    if run is not None and not isinstance(run.edge_size, str) and run.edge_size > radius:
        errors.add("run.edge_size", Mismatch(f"{run.edge_size:g} m, {narrow}"))
