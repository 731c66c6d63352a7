"""Recipes of beds, and the generation of a bed once for all its users."""

from __future__ import annotations

import abc
import dataclasses
import math
import os
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any, ClassVar

from granwave.extensions.packings.bed import FOLDER, Bed, BedFile, digest_of
from granwave.extensions.packings.lammps_grains import Report
from granwave.extensions.packings.sizes import SizeDistribution
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.packing.made_packing import (
    MakerInput,
    PackingMaker,
    PackingNotMadeError,
    PackingToMake,
    Row,
)
from granwave.lammps_inputs.case.precompression import Gravity
from granwave.lammps_inputs.case.schema import ErrorList
from granwave.lammps_inputs.extensions import extensions
from granwave.workflows.run.progress import Progress

_OWN_VALUES = ("keys", "material")  # fields of a recipe that are written value by value
_PARTS = 1000  # steps of a progress bar
_GIB = 2**30
# bytes, of Python with LAMMPS and of a grain while a bed is made, measured with 100 and 1000 grains
_MEMORY = 1.6e8
_MEMORY_OF_GRAIN = 4e4
SPEED = 4e6  # steps of grains in a second on one core, measured with some hundred grains


@dataclasses.dataclass(frozen=True)
class Recipe(abc.ABC):
    """Recipe of a bed.

    Attributes
    ----------
    kind
        Value of ``packing.kind``.
    rests_under_gravity
        True if the grains are in balance under gravity.
    keys
        Keys of ``[packing]``.
    material
        Material of the grains.
    friction
        Coefficient of friction while it is made.
    """

    kind: ClassVar[str]
    rests_under_gravity: ClassVar[bool] = True

    keys: Any
    material: Material
    friction: float

    @property
    def diameter(self) -> SizeDistribution:
        """Distribution of the diameters."""
        sizes: SizeDistribution = self.keys.diameter
        return sizes

    def plain(self) -> dict[str, Any]:
        """Return the recipe as plain values by name."""
        others = [field.name for field in dataclasses.fields(self) if field.name not in _OWN_VALUES]
        material = self.material
        return {
            **dataclasses.asdict(self.keys),
            **{name: getattr(self, name) for name in others},
            "youngs_modulus": material.youngs_modulus,
            "poisson_ratio": material.poisson_ratio,
            "density": material.density,
        }

    @property
    @abc.abstractmethod
    def expected_time(self) -> float:
        """Estimated time on one core, s."""

    @property
    @abc.abstractmethod
    def words(self) -> str:
        """Container, in words."""

    @abc.abstractmethod
    def make(self, report: Report) -> Bed:
        """Make the bed."""

    def tables(self, tables: Mapping[str, Any], bed: Bed) -> dict[str, Any]:
        """Return the tables of a case with the grains of a bed and derived keys."""
        return tables_of_bed(tables, bed, self.diameter.mean, balanced=self.rests_under_gravity)


class BedMaker(PackingMaker):
    """A kind of packing that is made as a bed."""

    @abc.abstractmethod
    def read(self, given: MakerInput, errors: ErrorList) -> Recipe | None:
        """Read the recipe of a bed; faults are added to ``errors``, and the result is then None."""

    def tables(self, given: MakerInput, errors: ErrorList) -> dict[str, Any] | None:
        """Return the tables of the case with the grains of its bed."""
        recipe = self.read(given, errors)
        if recipe is None:
            return None
        return recipe.tables(given.tables, bed_of(recipe, given))


def table_of(tables: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Return a table of a case, empty if it has none."""
    table = tables.get(name, {})
    return table if isinstance(table, Mapping) else {}


def are_numbers(*values: Any) -> bool:
    """Return True if values are numbers that make sense; the readers of the keys report faults."""
    return all(
        isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value < math.inf
        for value in values
    )


def bed_of(recipe: Recipe, given: MakerInput) -> Bed:
    """Return a bed: read from its file, or made and stored there.

    Raises
    ------
    PackingNotMadeError
        It is not there, and ``given.make`` is false.
    """
    file = bed_file(recipe, given.source)
    if not file.exists and not given.make:
        raise PackingNotMadeError(
            f"{given.source}: packing: its bed is not generated yet: {file.path}",
            [_to_make(recipe, file)],
        )
    if not file.exists:
        _make(recipe, file)
    return file.read()


def _to_make(recipe: Recipe, file: BedFile) -> PackingToMake:
    """Return the description and cost of a bed."""
    memory = _MEMORY + _MEMORY_OF_GRAIN * recipe.keys.grains
    rows = tuple(_rows_of(recipe, file, memory))
    return PackingToMake(file.path, recipe.expected_time, memory, rows)


def _rows_of(recipe: Recipe, file: BedFile, memory: float) -> list[Row]:
    """Return the description and cost of a bed, as names and values in words; memory in bytes."""
    from granwave.analysis.formatting.numbers import duration

    low, high = recipe.diameter.bounds
    sizes = f"{low:g} m" if low == high else f"{low:g} to {high:g} m"
    return [
        ("bed", f"{recipe.keys.grains} grains of {sizes} in {recipe.words}, not generated yet"),
        ("time to generate it", f"about {duration(recipe.expected_time)} on one core"),
        ("memory", f"about {memory / _GIB:.2f} GiB while it is generated"),
        ("made by", "granwave bed CASE, or by granwave run before the run"),
        ("kept in", str(file.path)),
    ]


def _make(recipe: Recipe, file: BedFile) -> None:
    """Make and write a bed, unless another process has done so meanwhile."""
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
    """Return the file of a bed: next to the case, or for built-in cases in the working
    directory.
    """
    digest = digest_of(recipe.kind, recipe.plain())
    folder = source.absolute().parent
    if not source.is_file() or _is_built_in(folder) or not os.access(folder, os.W_OK):
        folder = Path.cwd()
    return BedFile(folder / FOLDER / f"{recipe.kind}-{digest}.csv")


def _is_built_in(folder: Path) -> bool:
    """Return True for a folder of cases that come with the package or an extension."""
    homes = [Path(str(resources.files("granwave.workflows")))]
    homes += [extension.folder for extension in extensions() if extension.folder is not None]
    return any(folder.resolve().is_relative_to(home.resolve()) for home in homes)


def tables_of_bed(
    tables: Mapping[str, Any], bed: Bed, diameter: float, *, balanced: bool
) -> dict[str, Any]:
    """Return the tables of a case with the grains of a bed on a bottom plane, under gravity.

    Parameters
    ----------
    diameter
        Mean diameter, m.
    balanced
        True if the grains are in equilibrium under gravity; otherwise they move until they are.
    """
    container = bed.container
    enclosure: dict[str, Any] = {"bottom": bed.bottom}
    sides: Any = "wall"
    packing: dict[str, Any] = {"kind": "file", "grains": bed.grains, "diameter": diameter}
    packing["source"] = table_of(tables, "packing").get("kind")
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
        "boundary": {"sides": sides, "bottom": "wall", **table_of(tables, "boundary")},
    }
    stage = table_of(tables, "precompression")
    if stage.get("kind", Gravity.name) == Gravity.name:
        implied["precompression"] = {"kind": Gravity.name, "overlaps": True, **stage}
        if not balanced:
            packing["contacts"] = "relax"
        if table_of(tables, "contact").get("friction"):
            packing |= {"contacts": "relax", "relaxation": "damped"}
            if bed.springs:
                packing["springs"] = bed.springs
    return {**tables, **implied}
