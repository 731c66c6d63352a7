"""Packings that are made before a case is read: kinds of ``[packing]`` that extensions add.

A case names such a kind, and how its grains are made. While the case is read, the `PackingMaker` of
the kind replaces the table by one of ``packing.kind = "file"`` with the grains: the case is then a
case with grains of a file, and the case that a run stores is complete without the maker. A
generator stores its packings in files, which it reads when they are needed again.
"""

from __future__ import annotations

import abc
import contextlib
import dataclasses
import itertools
from collections.abc import Iterator, Mapping, Sequence
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

from granwave.lammps_inputs.case.material import Material, read_material
from granwave.lammps_inputs.case.schema import ErrorList
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.extensions import added

Row = tuple[str, str]  # name and value in words

#: Placeholder for the table of a packing whose faults were reported.
NOT_MADE = object()

_PACKING = "packing"
_MAKES: ContextVar[bool] = ContextVar("makes packings", default=True)


@dataclasses.dataclass(frozen=True)
class PackingToMake:
    """A packing that is not made yet.

    Attributes
    ----------
    file
        File in which it is to be kept.
    time
        Expected time to generate it on one core, s.
    memory
        Expected memory to generate it, bytes.
    rows
        Description and cost, as names and values in words.
    """

    file: Path
    time: float
    memory: float
    rows: tuple[Row, ...]


class PackingNotMadeError(InputError):
    """Error of packings whose grains are not made yet, and may not be made now.

    Parameters
    ----------
    message
        Missing packing, and the command that generates it.
    packings
        Packings that are missing, each of them once.
    """

    def __init__(self, message: str, packings: Sequence[PackingToMake]) -> None:
        super().__init__(message)
        self.packings = tuple(packings)


@dataclasses.dataclass(frozen=True)
class MakerInput:
    """Recipe of a packing that is made before the run.

    Attributes
    ----------
    tables
        Tables of the case.
    material
        Material of the grains.
    source
        File of the case, or its name.
    make
        False: grains that are not there yet are not made.
    """

    tables: Mapping[str, Any]
    material: Material
    source: Path
    make: bool = True


class PackingMaker(abc.ABC):
    """A kind of packing that is made before the case is read.

    Attributes
    ----------
    kind
        Value of ``packing.kind``.
    section
        Dataclass of its keys in ``[packing]``, which has ``kind`` among them.
    """

    kind: ClassVar[str]
    section: ClassVar[type]

    @abc.abstractmethod
    def tables(self, given: MakerInput, errors: ErrorList) -> dict[str, Any] | None:
        """Return the tables of the case with the grains instead of the recipe.

        None with faults, which are added to ``errors``.

        Raises
        ------
        PackingNotMadeError
            The grains are not there, and ``given.make`` is false.
        """


@contextlib.contextmanager
def nothing_made() -> Iterator[None]:
    """Read cases without making their grains: `PackingNotMadeError` is raised where they are
    missing.
    """
    before = _MAKES.set(False)
    try:
        yield
    finally:
        _MAKES.reset(before)


@cache
def packing_makers() -> dict[str, PackingMaker]:
    """Return the makers of packings by the names of their kinds."""
    return {maker.kind: maker for maker in itertools.chain.from_iterable(added("packings"))}


def is_made(tables: Mapping[str, Any]) -> bool:
    """Return True if the tables of a case name a packing that is made before the case is read."""
    packing = tables.get(_PACKING)
    kind = packing.get("kind") if isinstance(packing, Mapping) else None
    return isinstance(kind, str) and kind in packing_makers()


def with_made_grains(
    tables: Mapping[str, Any], source: str | Path, errors: ErrorList
) -> Mapping[str, Any]:
    """Return the tables of a case, with the grains of a packing that is made before the case is
    read.

    With faults, which are added to ``errors``, the packing is `NOT_MADE`.

    Raises
    ------
    PackingNotMadeError
        The grains are not there, and this is within `nothing_made`.
    """
    if not is_made(tables):
        return tables
    maker = packing_makers()[tables[_PACKING]["kind"]]
    # the reader of the material reports its faults
    given = maker_input(tables, source, ErrorList(errors.source))
    made = maker.tables(given, errors) if given is not None else None
    return {**tables, _PACKING: NOT_MADE} if made is None else made


def maker_input(
    tables: Mapping[str, Any], source: str | Path, errors: ErrorList
) -> MakerInput | None:
    """Return the recipe of a packing, from the tables of a case; None with faults of its
    material, which are added to ``errors``.
    """
    material = read_material(tables.get("material"), errors)
    if material is None:
        return None
    return MakerInput(tables, material, Path(source), _MAKES.get())
