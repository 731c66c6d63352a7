"""The kind of packings that this extension makes, ``packing.kind = "poured"``.

What the case does not say follows from the bed: walls at the places where the grains settled,
friction in contacts, and a static stage under gravity that starts from the overlaps of the bed.
"""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Callable, Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from granwave.extensions.packings.bed import FOLDER, Bed, BedFile, digest_of
from granwave.extensions.packings.insertion import column_height, insert
from granwave.extensions.packings.keys import PouredSection
from granwave.extensions.packings.settling import (
    Container,
    SettlingLaw,
    fall_time,
    settle,
)
from granwave.extensions.packings.sizes import volume
from granwave.lammps_inputs.case.grains import Grains
from granwave.lammps_inputs.case.made_packing import MakerInput, PackingMaker, PackingNotMadeError
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.precompression import Gravity, Precompression
from granwave.lammps_inputs.case.schema import ErrorList, read_table
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.extensions import extensions
from granwave.workflows.run.progress import Progress

_PARTS = 1000  # of a progress bar
_SPEED = 4e6  # steps of grains in a second on one core, measured with some hundred grains
_FALLS = 4.0  # times of the fall until grains are at rest, as seen with a restitution of 0.5
_LEAST_WIDTH = 2.0  # of a container, in largest diameters


@dataclasses.dataclass(frozen=True)
class Recipe:
    """All that a bed is made of.

    Attributes
    ----------
    keys
        Keys of ``[packing]``.
    material
        Material of the grains.
    friction
        Coefficient of friction while they settle.
    acceleration
        Acceleration of gravity, m/s^2.
    periodic
        True if the sides are periodic.
    """

    keys: PouredSection
    material: Material
    friction: float
    acceleration: float
    periodic: bool

    @property
    def container(self) -> Container:
        """Walls that the grains settle in."""
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

    def plain(self) -> dict[str, Any]:
        """Return the recipe as plain values by name."""
        material = self.material
        return {
            **dataclasses.asdict(self.keys),
            "friction": self.friction,
            "acceleration": self.acceleration,
            "periodic": self.periodic,
            "youngs_modulus": material.youngs_modulus,
            "poisson_ratio": material.poisson_ratio,
            "density": material.density,
        }

    @property
    def expected_height(self) -> float:
        """Height of the column that grains fall from, estimated with the mean diameter, m."""
        mean = self.keys.diameter.mean
        return column_height(self.keys.grains * math.pi / 6 * mean**3, self.container.area)

    @property
    def expected_time(self) -> float:
        """Estimate of the time that it takes on one core, s."""
        duration = _FALLS * fall_time(self.expected_height, self.acceleration)
        steps = duration / self.law.timestep(self.keys.diameter.bounds[0])
        return steps * self.keys.grains / _SPEED

    def make(self, report: Callable[[float, str], None]) -> Bed:
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
            "period": list(container.box) if container.periodic else None,
        }
        forces = (settled.normal_force, settled.tangential_force)
        return Bed(grains, settled.contacts, *forces, -top, record)


class PouredMaker(PackingMaker):
    """Grains poured into a box or a tube."""

    kind = "poured"
    section = PouredSection

    def tables(self, given: MakerInput, errors: ErrorList) -> dict[str, Any] | None:
        """Return the tables of the case with the grains of its bed."""
        recipe = read_recipe(given, errors)
        if recipe is None:
            return None
        return tables_of(given.tables, recipe, bed_of(recipe, given))


MAKERS = (PouredMaker(),)


def read_recipe(given: MakerInput, errors: ErrorList) -> Recipe | None:
    """Read how a bed is made; faults are added to ``errors``, and None is returned with any."""
    before = len(errors.items)
    keys = read_table(PouredSection, given.tables["packing"], "packing", errors)
    if keys is None:
        return None
    contact = _table(given.tables, "contact")
    boundary = _table(given.tables, "boundary")
    stage = _table(given.tables, "precompression")
    friction = contact.get("friction", 0.0) if keys.friction is None else keys.friction
    acceleration = stage.get("acceleration", Precompression.acceleration)
    periodic = boundary.get("sides") == "periodic"
    _check(keys, errors, periodic=periodic)
    if len(errors.items) > before or not _are_numbers(friction, acceleration):
        return None
    return Recipe(keys, given.material, float(friction), float(acceleration), periodic)


def _table(tables: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Return a table of a case, empty if it has none."""
    table = tables.get(name, {})
    return table if isinstance(table, Mapping) else {}


def _are_numbers(*values: Any) -> bool:
    """Return True if values are numbers that make sense; their own readers show the faults."""
    return all(
        isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value < math.inf
        for value in values
    )


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
            Mismatch('"periodic" with packing.tube', remedy="leave it out: the tube is the side"),
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


def bed_of(recipe: Recipe, given: MakerInput) -> Bed:
    """Return a bed, from its file or made and kept there.

    Raises
    ------
    PackingNotMadeError
        It is not there, and ``given.make`` is false.
    """
    file = bed_file(recipe, given.source)
    if not file.exists and not given.make:
        raise PackingNotMadeError(
            f"{given.source}: packing: its bed is not made yet: {file.path}", plan_of(recipe, file)
        )
    if not file.exists:
        _make(recipe, file)
    return file.read()


def plan_of(recipe: Recipe, file: BedFile) -> list[tuple[str, str]]:
    """Return what a bed would be and cost, as names and values in words."""
    from granwave.analysis.formatting.numbers import duration

    container = recipe.container
    width, depth = container.box
    shape = f"a tube of radius {container.tube:g} m" if container.tube is not None else (
        f"a box of {width:g} m x {depth:g} m"
    )  # fmt: skip
    low, high = recipe.keys.diameter.bounds
    sizes = f"{low:g} m" if low == high else f"{low:g} to {high:g} m"
    return [
        ("bed", f"{recipe.keys.grains} grains of {sizes} in {shape}, not made yet"),
        ("making it", f"about {duration(recipe.expected_time)} on one core"),
        ("made by", "granwave bed CASE, or by granwave run before the run"),
        ("kept in", str(file.path)),
    ]


def _make(recipe: Recipe, file: BedFile) -> None:
    """Make a bed and write it, unless another process did so meanwhile."""
    with file.locked():
        if file.exists:
            return
        progress = Progress(_PARTS, "bed", enabled=True)
        try:
            file.write(recipe.make(lambda share, note: progress.update(int(_PARTS * share), note)))
            progress.update(_PARTS, "at rest", last=True)
        finally:
            progress.close()


def bed_file(recipe: Recipe, source: Path) -> BedFile:
    """Return the file of a bed: beside the case, or for built-in cases in the working directory."""
    digest = digest_of(recipe.keys.kind, recipe.plain())
    folder = source.absolute().parent
    if not source.is_file() or _is_built_in(folder) or not os.access(folder, os.W_OK):
        folder = Path.cwd()
    return BedFile(folder / FOLDER / f"{recipe.keys.kind}-{digest}.csv")


def _is_built_in(folder: Path) -> bool:
    """Return True for a folder of cases that come with the package or an extension."""
    homes = [Path(str(resources.files("granwave.workflows")))]
    homes += [extension.folder for extension in extensions() if extension.folder is not None]
    return any(folder.resolve().is_relative_to(home.resolve()) for home in homes)


def tables_of(tables: Mapping[str, Any], recipe: Recipe, bed: Bed) -> dict[str, Any]:
    """Return the tables of a case with the grains of a bed, and what follows from it."""
    container = recipe.container
    enclosure: dict[str, Any] = {"bottom": bed.bottom}
    sides: Any = "wall"
    packing: dict[str, Any] = {
        "kind": "file",
        "grains": bed.grains,
        "diameter": recipe.keys.diameter.mean,
    }
    if container.tube is not None:
        sides = {"tube": {"radius": container.tube}}
    elif container.periodic:
        sides = "periodic"
        packing["period"] = list(container.box)
    else:
        enclosure |= {axis: [0.0, width] for axis, width in zip("xy", container.box, strict=True)}
    packing["enclosure"] = enclosure
    implied = {
        "packing": packing,
        "boundary": {"sides": sides, "bottom": "wall", **_table(tables, "boundary")},
    }
    stage = _table(tables, "precompression")
    if stage.get("kind", Gravity.name) == Gravity.name:
        implied["precompression"] = {"kind": Gravity.name, "overlaps": True, **stage}
        if _table(tables, "contact").get("friction"):
            packing |= {"contacts": "relax", "relaxation": "damped"}
    return {**tables, **implied}
