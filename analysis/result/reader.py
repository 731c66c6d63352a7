"""Reader of ``result.h5``: arrays on demand, and the case they belong to."""

from __future__ import annotations

import json
import tomllib
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.lammps_output.dumps import rows_of
from granwave.analysis.result.trajectory import GROUP, QUANTITIES
from granwave.analysis.result.writer import RESULT_FILE
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import Assembly, assemble, struck_of

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw


class Result:
    """The result of one run.

    ``result["contacts/peak_force"]`` reads a data set as a numpy array; it is read once and kept.

    Parameters
    ----------
    source
        Directory of a run, or its result.h5.

    Raises
    ------
    MissingOutputError
        There is no result.h5.
    OutputFormatError
        The file is not the result of a run.
    """

    def __init__(self, source: str | Path) -> None:
        path = Path(source)
        self.path = path / RESULT_FILE if path.is_dir() else path
        if not self.path.exists():
            raise MissingOutputError(f"{self.path} is missing: make it with  granwave analyse {self.path.parent}")
        try:
            self.file = h5py.File(self.path, "r")
        except OSError as error:
            raise OutputFormatError(f"{self.path}: {error}; expected the result.h5 of a run") from None
        if "case" not in self.file.attrs or "spheres" not in self.file:
            self.file.close()
            raise OutputFormatError(f"{self.path} has no /spheres or no case: expected the result.h5 of a run")
        self._read: dict[str, NDArray] = {}

    def __enter__(self) -> Result:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __contains__(self, name: str) -> bool:
        return name in self.file

    def __getitem__(self, name: str) -> NDArray:
        """A data set, such as ``energy/time``.

        Raises
        ------
        KeyError
            There is no such data set.
        """
        if name not in self._read:
            found = self.file.get(name)
            if not isinstance(found, h5py.Dataset):
                raise KeyError(f"{self.path} has no data set {name}")
            self._read[name] = found.asstr()[()] if h5py.check_string_dtype(found.dtype) else found[()]
        return self._read[name]

    def get(self, name: str) -> NDArray | None:
        """A data set, or None where the run has no such thing."""
        if name not in self:
            return None
        return self[name]

    def close(self) -> None:
        """Close the file; arrays that were read stay."""
        self.file.close()

    def names(self, group: str) -> list[str]:
        """What a group holds; empty when there is no such group."""
        return list(self.file[group]) if group in self.file else []

    def unit(self, name: str) -> str:
        """Unit of a data set, "1" if it has no dimension."""
        return str(self.file[name].attrs["unit"])

    @cached_property
    def case(self) -> Case:
        """The case that was run."""
        return case_from_dict(tomllib.loads(self.file.attrs["case"]), self.path.parent / "case.toml")

    @cached_property
    def assembly(self) -> Assembly:
        """All bodies of the case."""
        return assemble(self.case)

    @cached_property
    def record(self) -> dict[str, Any]:
        """What the driver noted of the run."""
        return json.loads(self.file.attrs["run"])

    @cached_property
    def versions(self) -> dict[str, str]:
        """Versions of the programs that made the result."""
        return json.loads(self.file.attrs["versions"])

    @cached_property
    def law(self) -> ContactLaw:
        """The law between two spheres."""
        return sphere_contact(self.case)

    @property
    def yields(self) -> bool:
        """Whether contacts of this run can yield, so that alpha_y and F_y mean something."""
        return self.case.contact.yields

    @property
    def has_law_limit(self) -> bool:
        """Whether the law was fitted up to an overlap that a contact may exceed."""
        return bool(self.case.contact.entry.fitted)

    @cached_property
    def struck(self) -> tuple[int, ...]:
        """Ids of the spheres that the load acts on, the central one first; of strikers alone those that move."""
        return struck_of(self.assembly)

    @property
    def origin(self) -> NDArray[np.float64]:
        """Centre of the struck sphere of the packing at the start: (3,), m."""
        sphere = self.struck[0] if self.struck else int(self["spheres/id"][0])
        while sphere > self.assembly.lattice.n_spheres:  # a striker: what it strikes
            sphere = self.case.striker[sphere - self.assembly.lattice.n_spheres - 1].touches[0]
        return self["spheres/position"][self.rows(sphere)]

    def rows(self, ids: ArrayLike) -> NDArray[np.int64]:
        """Rows of the spheres with these ids: ids - 1, unless spheres were left out of the packing.

        Raises
        ------
        KeyError
            There is no such sphere.
        """
        return rows_of(self["spheres/id"], ids)

    @property
    def ends(self) -> NDArray[np.int64]:
        """Rows of the two spheres of each contact: (n_contacts, 2)."""
        return self.rows(np.stack([self["contacts/i"], self["contacts/j"]], axis=1))

    @property
    def in_packing(self) -> NDArray[np.bool_]:
        """Which spheres are of the packing, and no strikers: (n_spheres,)."""
        return self["spheres/id"] <= self.assembly.lattice.n_spheres

    def beyond_law(self, share: float) -> NDArray[np.bool_]:
        """Which contacts were pressed beyond a share of R*: (n_contacts,); none where the law has no such limit."""
        if not self.has_law_limit:
            return np.zeros(len(self["contacts/i"]), dtype=bool)
        return self["contacts/peak_overlap"] > share * self["contacts/effective_radius"]

    def has(self, name: str) -> bool:
        """There is such a data set, and some value in it is not zero."""
        return name in self and bool(np.any(self[name]))

    @property
    def n_spheres(self) -> int:
        """How many spheres there are."""
        return len(self["spheres/id"])

    @property
    def energy_input(self) -> float:
        """Work done on the packing up to the end, J."""
        return float(self["energy/input"][-1])

    @property
    def n_frames(self) -> int:
        """How many snapshots there are."""
        return len(self.file[f"{GROUP}/position/step"])

    @property
    def frame_times(self) -> NDArray[np.float64]:
        """Times of the snapshots: (n_frames,), s."""
        return self[f"{GROUP}/position/time"]

    @property
    def quantities(self) -> tuple[str, ...]:
        """What a snapshot holds, see `frame`; results of older versions lack ``elastic_energy``."""
        return tuple(name for name in QUANTITIES if name in self.file[GROUP])

    def frame(self, number: int, quantity: str) -> NDArray[np.float64]:
        """One quantity of one snapshot, such as ``displacement``: (n_spheres,) or (n_spheres, 3), SI."""
        return self.file[f"{GROUP}/{quantity}/value"][number]
