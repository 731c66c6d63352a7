"""Compressed packings: random grains in a box that shrinks to a solid fraction or a pressure.

If all sides are periodic, the packing is an infinite, periodic crystal. Otherwise there are planes
at the bottom and the top, and at the sides unless these are periodic. A case with these grains has
no plane at the top: gravity holds the grains.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.extensions.packings.bed import Bed, Container
from granwave.extensions.packings.compression import (
    CompressedGrains,
    CompressionTarget,
    compress,
    start_lengths,
)
from granwave.extensions.packings.insertion import scatter
from granwave.extensions.packings.keys import CompressedSection
from granwave.extensions.packings.lammps_grains import Report
from granwave.extensions.packings.recipe import (
    SPEED,
    BedMaker,
    Recipe,
    are_numbers,
    table_of,
)
from granwave.extensions.packings.settling import SettlingLaw
from granwave.extensions.packings.sizes import volume
from granwave.lammps_inputs.case.bounds import EndlessBottom, EndlessSides
from granwave.lammps_inputs.case.packing.grains import Grains
from granwave.lammps_inputs.case.packing.made_packing import MakerInput
from granwave.lammps_inputs.case.precompression import Overlaps
from granwave.lammps_inputs.case.schema import ErrorList, read_table
from granwave.lammps_inputs.errors import Mismatch

_RESTITUTION = 0.5  # restitution of contacts with friction, while grains come to rest
_ROLLING = 0.01  # coefficient of rolling resistance with friction; it ends slow rolling
_STEPS = 100_000  # steps or iterations of a compression, measured with some hundred grains
_STEPS_WITH_FRICTION = 50_000  # the same
_MOST_OF_MODULUS = 0.01  # pressure over Young's modulus, beyond which overlaps are large
_LEAST_WIDTH = 3.0  # smallest width of the initial box, in largest diameters


@dataclasses.dataclass(frozen=True)
class CompressedRecipe(Recipe):
    """Recipe of a compressed packing.

    Attributes
    ----------
    periodic
        True if the sides are periodic.
    endless
        True if it is periodic along z too.
    """

    kind = "compressed"
    rests_under_gravity = False

    keys: CompressedSection
    periodic: bool
    endless: bool

    @property
    def words(self) -> str:
        """Container, in words."""
        if self.endless:
            sides = "a periodic box"
        elif self.periodic:
            sides = "a box with periodic sides"
        else:
            sides = "a box"
        if self.keys.pressure is not None:
            return f"{sides}, compressed to {self.keys.pressure:g} Pa"
        return f"{sides}, compressed to a solid fraction of {self.keys.solid_fraction:g}"

    @property
    def expected_time(self) -> float:
        """Estimated time on one core, s."""
        steps = _STEPS_WITH_FRICTION if self.friction else _STEPS
        return steps * self.keys.grains / SPEED

    def make(self, report: Report) -> Bed:
        """Make the packing."""
        random = np.random.default_rng(self.keys.seed)
        diameter = self.keys.diameter.draw(self.keys.grains, random)
        proportions = np.array(self.keys.proportions)
        periodic = (self.periodic, self.periodic, self.endless)
        places = scatter(diameter, start_lengths(diameter, proportions), periodic, random)
        restitution = _RESTITUTION if self.friction else 1.0
        law = SettlingLaw(self.material, self.friction, _ROLLING, restitution, acceleration=0.0)
        target = CompressionTarget(self.keys.solid_fraction, self.keys.pressure)
        made = compress(places, diameter, proportions, periodic, law, target, report)
        return self._bed(made, diameter)

    def _bed(self, made: CompressedGrains, diameter: NDArray[np.float64]) -> Bed:
        """Return a packing whose uppermost surface, or whose end, is at z = 0."""
        x, y, z = made.lengths.tolist()
        position = made.position.copy()
        if self.periodic:
            position[:, :2] = np.mod(position[:, :2], (x, y))
        if self.endless:
            position[:, 2] = np.mod(position[:, 2], z)
            top = 0.0
        else:
            top = float((position[:, 2] - diameter / 2).min())
            position[:, 2] -= top
        n = len(diameter)
        container = Container((x, y), self.periodic, height=z if self.endless else None)
        record = {
            "kind": self.kind,
            "made_of": self.plain(),
            "residual": made.residual,
            "steps": made.steps,
            "pressure": made.pressure,
            "solid_fraction": volume(diameter) / math.prod((x, y, z)),
            "ceiling": None if self.endless else -top,
        }
        return Bed(
            Grains(position, diameter, ("",) * n, ("",) * n, np.zeros((n, 3))),
            made.contacts,
            made.normal_force,
            made.tangential_force,
            z - top,
            container,
            record,
            springs=made.springs,
        )

    def tables(self, tables: Mapping[str, Any], bed: Bed) -> dict[str, Any]:
        """Return the tables of a case with the grains and derived keys."""
        height = bed.container.height
        if height is None:
            return super().tables(tables, bed)
        lengths = (*bed.container.box, height)
        packing = {
            "kind": "file",
            "grains": bed.grains,
            "diameter": self.diameter.mean,
            "cell": np.diag(lengths).tolist(),
        }
        stage = {"kind": Overlaps.name, **table_of(tables, "precompression")}
        # the cell says how they repeat
        repeats = ("sides", "bottom")
        boundary = table_of(tables, "boundary").items()
        others = {name: value for name, value in boundary if name not in repeats}
        return {**tables, "packing": packing, "precompression": stage, "boundary": others}


class CompressedMaker(BedMaker):
    """Random grains, compressed to a solid fraction or a pressure."""

    kind = CompressedRecipe.kind
    section = CompressedSection

    def read(self, given: MakerInput, errors: ErrorList) -> CompressedRecipe | None:
        """Read the recipe of a packing; faults are added to ``errors``, and the result is then
        None.
        """
        before = len(errors.items)
        keys = read_table(CompressedSection, given.tables["packing"], "packing", errors)
        if keys is None:
            return None
        boundary = table_of(given.tables, "boundary")
        friction = keys.friction
        if friction is None:
            friction = table_of(given.tables, "contact").get("friction", 0.0)
        periodic = boundary.get("sides") == EndlessSides.name
        endless = boundary.get("bottom") == EndlessBottom.name
        _check(keys, errors, given.material.youngs_modulus, periodic=periodic, endless=endless)
        if len(errors.items) > before or not are_numbers(friction):
            return None
        return CompressedRecipe(keys, given.material, float(friction), periodic, endless)


def _check(
    keys: CompressedSection, errors: ErrorList, modulus: float, *, periodic: bool, endless: bool
) -> None:
    """Check that there is one target, and a box wide enough for the grains."""
    largest = keys.diameter.bounds[1]
    sizes = np.full(keys.grains, keys.diameter.mean)
    width = float(start_lengths(sizes, np.array(keys.proportions)).min())
    least = _LEAST_WIDTH * largest
    most = _MOST_OF_MODULUS * modulus
    pressure = keys.pressure or 0.0
    errors.check_first(
        (
            keys.solid_fraction is None and keys.pressure is None,
            "packing.solid_fraction",
            "missing; set a solid_fraction or a pressure (Pa) to which the grains are compressed",
        ),
        (
            keys.solid_fraction is not None and keys.pressure is not None,
            "packing.pressure",
            Mismatch("both solid_fraction and pressure", "one of them"),
        ),
        (
            pressure > most,
            "packing.pressure",
            Mismatch(
                f"{pressure:g} Pa", f"at most {most:g} Pa, {_MOST_OF_MODULUS:g} of the modulus"
            ),
        ),
        (
            endless and not periodic,
            "boundary.bottom",
            Mismatch('"periodic" without periodic sides', remedy='add sides = "periodic"'),
        ),
        (
            width < least,
            "packing.grains",
            Mismatch(
                f"{keys.grains} grains, which gives a box of {width:.3g} m for grains of "
                f"{largest:g} m",
                f"at least {least:.3g} m",
                "add grains, or use more equal packing.proportions",
            ),
        ),
    )
