"""Poured beds: grains that fall into a box or a tube, and settle there.

Missing keys of the case follow from the bed: walls at the positions where the grains settled,
friction in contacts, and a static stage under gravity that starts from the overlaps of the bed.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from granwave.extensions.packings.bed import Bed, Container
from granwave.extensions.packings.insertion import column_height, insert
from granwave.extensions.packings.keys import PouredSection
from granwave.extensions.packings.lammps_grains import Report
from granwave.extensions.packings.recipe import (
    SPEED,
    BedMaker,
    Recipe,
    are_numbers,
    table_of,
)
from granwave.extensions.packings.settling import SettlingLaw, fall_time, settle
from granwave.extensions.packings.sizes import volume
from granwave.lammps_inputs.case.packing.grains import Grains
from granwave.lammps_inputs.case.packing.made_packing import MakerInput
from granwave.lammps_inputs.case.precompression import Precompression
from granwave.lammps_inputs.case.schema import ErrorList, read_table
from granwave.lammps_inputs.errors import Mismatch

# times of the fall until grains are at rest, measured with 100 and 400 grains and a restitution of
# 0.5; steps with friction take longer, which is included
_FALLS = 5.5
_FALLS_WITHOUT_FRICTION = 15.0
_LEAST_WIDTH = 2.0  # smallest width of a container, in largest diameters


@dataclasses.dataclass(frozen=True)
class PouredRecipe(Recipe):
    """Recipe of a poured bed.

    Attributes
    ----------
    acceleration
        Acceleration of gravity, m/s^2.
    periodic
        True if the sides are periodic.
    """

    kind = "poured"

    keys: PouredSection
    acceleration: float
    periodic: bool

    @property
    def container(self) -> Container:
        """Walls between which the grains settle."""
        radius = self.keys.tube
        if radius is not None:
            return Container((2 * radius, 2 * radius), tube=radius)
        assert self.keys.box is not None
        return Container(self.keys.box, periodic=self.periodic)

    @property
    def law(self) -> SettlingLaw:
        """Contacts while grains settle."""
        return SettlingLaw(
            self.material,
            self.friction,
            self.keys.rolling,
            self.keys.restitution,
            self.acceleration,
        )

    @property
    def words(self) -> str:
        """Container, in words."""
        container = self.container
        if container.tube is not None:
            return f"a tube of radius {container.tube:g} m"
        width, depth = container.box
        return f"a box of {width:g} m × {depth:g} m"

    @property
    def expected_height(self) -> float:
        """Height of the column from which the grains fall, estimated with the mean diameter, m."""
        mean = self.keys.diameter.mean
        return column_height(self.keys.grains * math.pi / 6 * mean**3, self.container.area)

    @property
    def expected_time(self) -> float:
        """Estimated time on one core, s."""
        falls = _FALLS if self.friction else _FALLS_WITHOUT_FRICTION
        duration = falls * fall_time(self.expected_height, self.acceleration)
        steps = duration / self.law.timestep(self.keys.diameter.bounds[0])
        return steps * self.keys.grains / SPEED

    def make(self, report: Report) -> Bed:
        """Make the bed."""
        random = np.random.default_rng(self.keys.seed)
        diameter = self.keys.diameter.draw(self.keys.grains, random)
        container = self.container
        height = column_height(volume(diameter), container.area)
        places = insert(
            diameter,
            container.box,
            height,
            random,
            periodic=container.periodic,
            tube=container.tube,
        )
        settled = settle(places, diameter, container, self.law, report)
        n = self.keys.grains
        top = float((settled.position[:, 2] - diameter / 2).min())
        position = settled.position - [0.0, 0.0, top]
        if container.periodic:
            position[:, :2] = np.mod(position[:, :2], container.box)
        still = np.zeros((n, 3))
        grains = Grains(position, diameter, ("",) * n, ("",) * n, still)
        record = {
            "kind": self.keys.kind,
            "made_of": self.plain(),
            "residual": settled.residual,
            "steps": settled.steps,
        }
        forces = (settled.normal_force, settled.tangential_force)
        return Bed(grains, settled.contacts, *forces, -top, container, record, settled.springs)


class PouredMaker(BedMaker):
    """Grains poured into a box or a tube."""

    kind = PouredRecipe.kind
    section = PouredSection

    def read(self, given: MakerInput, errors: ErrorList) -> PouredRecipe | None:
        """Read the recipe of a bed; faults are added to ``errors``, and the result is then None."""
        before = len(errors.items)
        keys = read_table(PouredSection, given.tables["packing"], "packing", errors)
        if keys is None:
            return None
        contact = table_of(given.tables, "contact")
        boundary = table_of(given.tables, "boundary")
        stage = table_of(given.tables, "precompression")
        friction = contact.get("friction", 0.0) if keys.friction is None else keys.friction
        acceleration = stage.get("acceleration", Precompression.acceleration)
        periodic = boundary.get("sides") == "periodic"
        _check(keys, errors, periodic=periodic)
        if len(errors.items) > before or not are_numbers(friction, acceleration):
            return None
        return PouredRecipe(keys, given.material, float(friction), float(acceleration), periodic)


def _check(keys: PouredSection, errors: ErrorList, *, periodic: bool) -> None:
    """Check that there is one container, wide enough for the grains."""
    largest = keys.diameter.bounds[1]
    least = _LEAST_WIDTH * largest
    width = 2 * keys.tube if keys.tube is not None else min(keys.box or (math.inf,))
    errors.check_first(
        (
            keys.box is None and keys.tube is None,
            "packing.box",
            "missing; grains are poured into a box = [along x, along y] or a tube = radius, in m",
        ),
        (
            keys.box is not None and keys.tube is not None,
            "packing.tube",
            Mismatch("both box and tube", "one of them"),
        ),
        (
            keys.tube is not None and periodic,
            "boundary.sides",
            Mismatch(
                '"periodic" with packing.tube', remedy="remove it, since the tube is the side wall"
            ),
        ),
        (
            width < least,
            "packing.box" if keys.tube is None else "packing.tube",
            Mismatch(
                f"a width of {width:g} m for grains of {largest:g} m",
                f"at least {least:g} m, {_LEAST_WIDTH:g} diameters",
            ),
        ),
    )
