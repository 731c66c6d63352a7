"""Beds: grains and contacts that are generated once and stored in files for several cases.

A bed is stored in the folder ``beds`` next to the case, under its kind and a digest of its recipe.
Processes that need the same bed read it; the process that makes it holds a lock, so that it is made
only once, and its file is complete when it appears.

    KIND-DIGEST.csv              the grains, as `packing.file` has them, and a record in comments
    KIND-DIGEST-contacts.csv     the contacts between them, with their forces
    KIND-DIGEST-springs.csv      their tangential springs, as `packing.springs` has them
"""

from __future__ import annotations

import contextlib
import dataclasses
import fcntl
import hashlib
import json
import math
import os
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.extensions.packings.insertion import nearest_image
from granwave.lammps_inputs.case.packing.grains import Grains, parse_grains
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import replace_text

_FORMAT = 4  # version of the files and of the algorithm; another version gives another digest
_DIGITS = 12  # digits of the digest in names
_MARK = "# bed: "
_CONTACT_COLUMNS = ("i", "j", "normal_force", "tangential_force")
FOLDER = "beds"


@dataclasses.dataclass(frozen=True)
class Container:
    """Walls around the grains: a box from x = y = 0, or a tube about x = y = 0.

    Attributes
    ----------
    box
        Widths along x and y, m.
    periodic
        True if the sides are periodic.
    tube
        Radius of a tube instead of the box, m; None: there is none.
    height
        Period along z, m; None: the packing is not periodic along z.
    """

    box: tuple[float, float]
    periodic: bool = False
    tube: float | None = None
    height: float | None = None

    @property
    def area(self) -> float:
        """Area of the cross-section, m^2."""
        if self.tube is not None:
            return math.pi * self.tube**2
        return math.prod(self.box)

    @property
    def period(self) -> tuple[float, float, float]:
        """Periods along x, y and z, m; infinite along axes that are not periodic."""
        x, y = self.box if self.periodic else (math.inf, math.inf)
        return x, y, self.height or math.inf


@dataclasses.dataclass(frozen=True, eq=False)
class Bed:
    """A bed that was made.

    Attributes
    ----------
    grains
        The grains; depth is +z, and the uppermost surface is at z = 0.
    contacts
        Rows of the grains in contact: (n_contacts, 2).
    normal_force, tangential_force
        Forces of the contacts: (n_contacts,), N.
    bottom
        Depth of the plane that it rests on, m.
    container
        Walls and periods around it.
    record
        How it was made.
    springs
        Tangential springs of all contacts, as `packing.springs` has them; empty if they are not
        kept.
    """

    grains: Grains
    contacts: NDArray[np.int64]
    normal_force: NDArray[np.float64]
    tangential_force: NDArray[np.float64]
    bottom: float
    container: Container
    record: Mapping[str, Any]
    springs: str

    @cached_property
    def directions(self) -> NDArray[np.float64]:
        """Unit vectors from the first to the second grain of each contact: (n_contacts, 3)."""
        first, second = self.contacts.T
        apart = self.grains.position[second] - self.grains.position[first]
        apart -= nearest_image(apart, self.container.period)
        return apart / np.linalg.norm(apart, axis=1)[:, None]

    @cached_property
    def depth(self) -> NDArray[np.float64]:
        """Depths of the contacts: (n_contacts,), m."""
        return np.asarray(self.grains.position[self.contacts, 2].mean(axis=1))


def digest_of(kind: str, made_of: Mapping[str, Any]) -> str:
    """Return the digest of the recipe of a bed: plain values by name."""
    text = json.dumps([_FORMAT, kind, made_of], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:_DIGITS]


@dataclasses.dataclass(frozen=True)
class BedFile:
    """File of a bed, which may not be there yet."""

    path: Path

    @property
    def contacts_path(self) -> Path:
        """File of the contacts."""
        return self.path.with_name(f"{self.path.stem}-contacts.csv")

    @property
    def springs_path(self) -> Path:
        """File of the tangential springs."""
        return self.path.with_name(f"{self.path.stem}-springs.csv")

    @property
    def exists(self) -> bool:
        """True if the bed was made."""
        return self.path.is_file()

    def read(self) -> Bed:
        """Read the bed.

        Raises
        ------
        InputError
            A file is damaged.
        """
        try:
            return self._read()
        except (OSError, ValueError, KeyError, IndexError) as error:
            raise InputError(
                f"{self.path}: found no bed ({error}); remove the file to generate it again"
            ) from None

    def _read(self) -> Bed:
        text = self.path.read_text(encoding="utf-8")
        record = json.loads(text.partition("\n")[0].removeprefix(_MARK))
        grains = parse_grains(text, None)
        grains.file = str(self.path)
        values = record["container"]
        container = Container(**{**values, "box": tuple(values["box"])})
        grains.period = container.box if container.periodic else None
        _, *rows = self.contacts_path.read_text(encoding="utf-8").splitlines()
        values = np.array([row.split(",") for row in rows], dtype=np.float64)
        values = values.reshape(-1, len(_CONTACT_COLUMNS))
        pairs = values[:, :2].astype(np.int64) - 1
        forces = (values[:, 2], values[:, 3])
        springs = self.springs_path.read_text(encoding="utf-8")
        return Bed(grains, pairs, *forces, record["bottom"], container, record, springs)

    def write(self, bed: Bed) -> None:
        """Write the bed; the file of the grains is written last, in one step."""
        columns = (bed.contacts + 1, bed.normal_force[:, None], bed.tangential_force[:, None])
        head = ",".join(_CONTACT_COLUMNS)
        lines = [
            f"{int(i)},{int(j)},{normal!r},{tangential!r}"
            for i, j, normal, tangential in np.hstack(columns).tolist()
        ]
        replace_text(self.contacts_path, "\n".join([head, *lines]) + "\n")
        replace_text(self.springs_path, bed.springs)
        record = json.dumps(
            {**bed.record, "bottom": bed.bottom, "container": dataclasses.asdict(bed.container)}
        )
        replace_text(self.path, f"{_MARK}{record}\n{bed.grains.text}")

    @contextlib.contextmanager
    def locked(self) -> Iterator[None]:
        """Hold the lock of the bed; wait for another process that makes the bed."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(self.path.with_suffix(".lock"), os.O_RDWR | os.O_CREAT, 0o666)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX)
            yield
        finally:
            os.close(descriptor)
