"""``[contact]``: contact law, its constants, friction, loss and initial dents."""

from __future__ import annotations

import dataclasses
from typing import Any, Literal

from granwave import _contact_laws
from granwave.lammps_inputs.case.dents import Dents, parse_dents
from granwave.lammps_inputs.case.loss import Loss, parse_loss
from granwave.lammps_inputs.case.schema import choice, custom, number
from granwave.lammps_inputs.case.si_values import FRICTION
from granwave.lammps_inputs.case.yield_factor import DEFAULT_YIELD_FACTOR

ALL_LAWS = _contact_laws.LAWS  # contact laws of the plugin, by name
LAWS = {name: law for name, law in ALL_LAWS.items() if not law.is_power}  # those of two materials
NO_FORCE = "none"  # law of materials whose grains do not touch each other
LINES = ("half-space", "plane-strain")
LINE = "line"  # law of crystals of cylinders alone: Hertz's, with lines in plane strain
LAW_CONSTANTS = tuple(_contact_laws.LAW_CONSTANTS)  # names of the constants of the elasto-plastic law

_CONSTANT: dict[str, Any] = {"above": 0, "default": None}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Contact:
    """``[contact]``: contact law and friction."""

    law: str = choice(
        'contact law; "line" is "hertz" with line = "plane-strain", for cylinders alone',
        (*ALL_LAWS, LINE),
        default="elastoplastic",
    )
    variant: Literal["continuous", "published"] = choice(
        "constants of the elasto-plastic law: made continuous, or as printed",
        ("continuous", "published"),
        default="continuous",
    )
    yield_factor: float = number(
        "C = p_y / sigma_y, contact pressure at first yield", at_least=0.1, at_most=10, default=DEFAULT_YIELD_FACTOR
    )
    constant: float | None = number("law power: K of F = K overlap^p, N/m^p", above=0, default=None)
    exponent: float | None = number("law power: p", at_least=1, default=None)
    line: str = choice(
        "contact along a line, of a cylinder on a plane or beside another: with bodies that give way over its length "
        "(half-space), or in plane strain",
        LINES,
        default="half-space",
    )
    beta: float = number("bilinear law: residual overlap over the largest overlap", at_least=0, below=1, default=0.8)
    friction: float = number(
        "coefficient of Coulomb friction between spheres", at_least=0, at_most=1e4, default=0.0, usual=FRICTION
    )
    tangential: Literal["mindlin_rescale", "mindlin"] = choice(
        "spring of friction where its circle shrinks: force scaled down with it, or kept, which can create energy",
        ("mindlin_rescale", "mindlin"),
        default="mindlin_rescale",
    )
    loss: Loss | None = custom(  # noqa: RUF009
        "loss by the rate of the overlap: by a time, by the restitution at a velocity, or by a dashpot (Tsuji)",
        parse_loss,
        default=None,
    )
    initial_overlap: float | str | tuple[Dents, ...] = custom(
        "largest overlap that the contacts had before the run, their dents: a value, values by region, or an earlier "
        "run's result.h5",
        parse_dents,
        unit="m",
        default=0.0,
    )

    # Constants of the elasto-plastic law, for materials whose curve differs from the published one (None: published).
    # a = alpha/alpha_y; pressure in units of sigma_y, area in units of pi R* alpha_y.
    pressure_limit: float | None = number("c1 of p = c1 - (c1 - 2C/3) exp(-c2 (a-1)); 2.48 if left out", **_CONSTANT)
    pressure_rate: float | None = number("c2 of the same; 0.098 if left out", at_least=1e-4, at_most=10, default=None)
    area_switch: float | None = number(
        "a from which the area is A = c4 a - c5, a power of a below; 177.6 if left out", above=1, default=None
    )
    area_slope: float | None = number("c4 of the area; 2.37 if left out", **_CONSTANT)
    area_offset: float | None = number("c5 of the area; 59.96 if left out", default=None)
    residual_slope: float | None = number(
        "c6 of a_R = c6 a_max - c7 + (c7 - c6) exp(-c8 (a_max - 1)); 0.95 if left out", **_CONSTANT
    )
    residual_offset: float | None = number("c7 of the same; 25.94 if left out", default=None)
    residual_rate: float | None = number("c8 of the same; 0.015 if left out", **_CONSTANT)
    unloading_exponent: float | None = number(
        "n of f = f_max ((a - a_R)/(a_max - a_R))^n; 1.35 if left out", at_least=1, default=None
    )

    def __post_init__(self) -> None:
        """Take the law of lines for what it is."""
        if self.law == LINE:
            object.__setattr__(self, "law", "hertz")
            object.__setattr__(self, "line", "plane-strain")

    @property
    def constants(self) -> dict[str, float]:
        """Constants of the elasto-plastic law that the case gives, by name."""
        given = {name: getattr(self, name) for name in LAW_CONSTANTS}
        return {name: value for name, value in given.items() if value is not None}

    @property
    def entry(self) -> _contact_laws.LawEntry:
        """Entry of the law in the plugin's table."""
        return ALL_LAWS[self.law]

    @property
    def yields(self) -> bool:
        """True if the law needs a yield strength."""
        return bool(self.entry.yields)

    def takes(self, option: str) -> bool:
        """Return True if the law has an option: such as ``variant``, ``yield_factor`` or ``beta``."""
        return option in self.entry.options
