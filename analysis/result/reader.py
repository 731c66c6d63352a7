"""Reader of ``result.h5``: arrays on demand, with the case and its law; and the error of the energy
balance.

The error is |kinetic + elastic + dissipated - input|. It is divided by the largest |input| up to
then. A prescribed displacement also gives the moved grains their kinetic energy, and removes it
when they stop; this energy is excluded from that input. Otherwise the error of a run in which a
grain is pushed in fast and then held would be divided by an energy that no other grain ever had.
"""

from __future__ import annotations

import contextlib
import json
import math
import tomllib
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave._contact_laws import ContactLaw
from granwave.analysis.errors import MissingDataError, MissingOutputError, OutputFormatError
from granwave.analysis.result.hdf5_file import AT_ONCE, rows_of, rows_of_all
from granwave.analysis.result.not_a_run import damage_of, why_no_run
from granwave.analysis.result.trajectory import GROUP, QUANTITIES
from granwave.analysis.versions import RESULTS_FORMAT
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.figures import Figures, read_figures
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.files import read_tables, regular
from granwave.lammps_inputs.load_case import stored_case
from granwave.lammps_inputs.own_files import AnyPath
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.packing.motion import impacted_of, struck_of, struck_site
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import CASE_FILE, FIGURES_TABLE, RESULT_FILE, newer_format


def moved_mass(assembly: Assembly) -> float:
    """Return the mass of the grains with a prescribed displacement, kg; 0 for other loads."""
    if not assembly.case.load.prescribes_motion:
        return 0.0
    return sum(assembly.mass_of(sphere) for sphere in struck_of(assembly))


def misfit(ledger: Mapping[str, Any]) -> Any:
    """Return |kinetic + elastic + dissipated - input| of a row, or of columns, of the energy
    record, J.
    """
    return abs(ledger["kinetic"] + ledger["elastic"] + ledger["dissipated"] - ledger["input"])


def work_on_packing(ledger: Mapping[str, Any], moved: float) -> Any:
    """Return the magnitude of the input without the kinetic energy of the moved grains, of mass
    ``moved`` (kg), J.
    """
    return (
        abs(ledger["input"] - moved * ledger["struck_velocity"] ** 2 / 2)
        if moved
        else abs(ledger["input"])
    )


_AT_CENTRE = 1e-9  # distance of a centroid from a centre that is due to rounding, diameters
_ROUNDING = 1e-12  # relative error of the sum of the kinds of dissipation of a sphere
_PARALLEL = 1e-9  # cosine of the angle between axes of crossed cylinders
_REASONS = {
    "truncated file": "it was cut",
    "signature not found": "it is not an HDF5 file",
}  # remedies by message of HDF5


class Result:
    """Result of one run.

    ``result["contacts/peak_force"]`` reads a data set as a numpy array, which is cached.

    Parameters
    ----------
    source
        Directory of a run, or its result.h5.
    at_once
        Largest number of rows that `blocks` gives.
    assembly
        All bodies of the case that was run, if it was read before.
    checked
        True if the file has been opened before, and is known to be the result of a run.

    Raises
    ------
    MissingOutputError
        There is no result.h5.
    OutputFormatError
        The file is not the result of a run.
    """

    def __init__(
        self,
        source: AnyPath,
        at_once: int = AT_ONCE,
        assembly: Assembly | None = None,
        *,
        checked: bool = False,
    ) -> None:
        path = Path(source)
        self.at_once = at_once
        self._assembly = assembly
        self.path = path / RESULT_FILE if path.is_dir() else path
        self.results = ResultDirectory.at(source if path.is_dir() else path.parent)
        if not self.path.exists():
            raise MissingOutputError(why_no_run(path))
        try:
            if changed := self.results.changed_result([self.path.name]):
                raise OutputFormatError(changed)
            self.file = h5py.File(regular(self.path), "r")
        except OSError as error:
            raise OutputFormatError(self._not_opened(path, error)) from None
        if not checked:
            self._check()
        self._read: dict[str, NDArray] = {}
        # rows of some spheres, and what was read of them
        self._part: tuple[slice, dict[str, NDArray]] | None = None

    def _check(self) -> None:
        """Close the file and raise OutputFormatError if it is not the result of a run."""
        fault = ""
        try:
            made = json.loads(self.file.attrs.get("versions", "{}"))
            if "case" not in self.file.attrs or "spheres" not in self.file:
                kind = self.file.attrs.get("kind", "")
                what = f"is of a {kind} run" if kind else "has no /spheres or no case"
                fault = f"{self.path} {what}: expected the result.h5 of a run of spheres"
            elif damage := damage_of(self.file):
                fault = self.damaged(damage)
            elif newer := newer_format(made.get(RESULTS_FORMAT), made.get("granwave")):
                fault = f"{self.path}: {newer}"
        except (
            AttributeError,
            KeyError,
            OSError,
            RuntimeError,
            ValueError,
        ) as error:  # checksums of HDF5 itself, JSON
            fault = self.damaged(" ".join(str(error).split()))
        if fault:
            self.file.close()
            raise OutputFormatError(fault)

    def _not_opened(self, given: Path, error: OSError) -> str:
        """Describe why the file cannot be opened."""
        if not self.path.is_file():
            return f"{self.path}: is not a file, expected the result.h5 of a run"
        if isinstance(error, PermissionError):
            return f"{self.path}: cannot be read: {error.strerror or error}"
        if given.is_file() and given.name != RESULT_FILE and not h5py.is_hdf5(given):
            return why_no_run(given)
        return self.damaged(
            _REASONS.get(next((known for known in _REASONS if known in str(error)), ""), error)
        )

    def damaged(self, why: object) -> str:
        """Return the message that the file is damaged."""
        return (
            f"{self.path} is damaged ({why}): recreate it with  granwave analyse {self.path.parent}"
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (
            self.path,
            self.at_once,
        )  # opened again, as open files cannot be sent to other processes

    def __enter__(self) -> Result:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __contains__(self, name: str) -> bool:
        with self._intact(name):
            return name in self.file

    @contextlib.contextmanager
    def _intact(self, name: str) -> Iterator[None]:
        """Raise OutputFormatError if HDF5 cannot read a data set, according to its checksums."""
        try:
            yield
        except (KeyError, OSError, RuntimeError) as error:
            raise OutputFormatError(
                self.damaged(f"{name}: {' '.join(str(error).split())}")
            ) from None

    def __getitem__(self, name: str) -> NDArray:
        """Read a data set, such as ``energy/time``, and keep it; raise as `read`."""
        rows, kept = self._part if self._part and name.startswith("spheres/") else ((), self._read)
        if name not in kept:
            kept[name] = self.read(name, rows)
        return kept[name]

    def read(self, name: str, rows: slice | tuple[()] = ()) -> NDArray:
        """Read a data set, or some of its rows, without keeping it.

        Raises
        ------
        MissingDataError
            There is no such data set (also a KeyError).
        OutputFormatError
            The data set is damaged.
        """
        if name in self._read:
            return self._read[name][rows]
        with self._intact(name):
            found = self.file.get(name)
            if isinstance(found, h5py.Dataset):
                return found.asstr()[rows] if h5py.check_string_dtype(found.dtype) else found[rows]
        remedy = f"recreate it with  granwave analyse {self.path.parent}"
        raise MissingDataError(f"{self.path} has no data set {name}; {remedy}")

    def blocks(self, *names: str) -> Iterator[tuple[NDArray, ...]]:
        """Iterate over the rows of columns of one table, in blocks that need little memory; raise
        as `read`.

        The columns of a small table are kept as by ``[]``.
        """
        n_rows = len(self.file[names[0]]) if names[0] in self else 0
        if n_rows <= self.at_once:
            yield tuple(self[name] for name in names)
            return
        for first in range(0, n_rows, self.at_once):
            yield tuple(self.read(name, slice(first, first + self.at_once)) for name in names)

    def get(self, name: str) -> NDArray | None:
        """Read a data set; None if the run does not have it."""
        if name not in self:
            return None
        return self[name]

    def close(self) -> None:
        """Close the file; arrays that were read remain valid."""
        self.file.close()

    def names(self, group: str) -> list[str]:
        """Return the names in a group; empty if there is no such group."""
        return list(self.file[group]) if group in self.file else []

    def unit(self, name: str) -> str:
        """Return the unit of a data set, "1" if dimensionless."""
        return str(self.file[name].attrs["unit"])

    @cached_property
    def case(self) -> Case:
        """Case that was run."""
        if self._assembly is not None:
            return self._assembly.case
        return stored_case(tomllib.loads(self.file.attrs["case"]), self.path.parent / CASE_FILE)

    @cached_property
    def figure_options(self) -> Figures:
        """Table ``[figures]`` of the case.toml next to the result, which may be edited; otherwise
        of the stored case.
        """
        path = self.path.parent / CASE_FILE
        tables = read_tables(path)
        return (
            self.case.figures
            if tables is None
            else read_figures(tables.get(FIGURES_TABLE, {}), str(path))
        )

    @cached_property
    def assembly(self) -> Assembly:
        """All bodies of the case."""
        return self._assembly or assemble(self.case)

    @cached_property
    def record(self) -> dict[str, Any]:
        """Record of the run by the driver."""
        return json.loads(self.file.attrs["run"])

    @cached_property
    def versions(self) -> dict[str, str]:
        """Versions of the programs that made the result."""
        return json.loads(self.file.attrs["versions"])

    @cached_property
    def law(self) -> ContactLaw:
        """Contact law between two spheres of the packing."""
        return sphere_contact(self.case)

    @property
    def has_yield_force(self) -> bool:
        """True if contacts between two grains of the packing can yield, so that alpha_y and F_y
        exist.
        """
        return self.case.contact.yields and math.isfinite(self.law.yield_force)

    @property
    def yields(self) -> bool:
        """True if contacts of this run can yield; False for parallel cylinders only."""
        return self.has_yield_force or (self.case.contact.yields and self.has("contacts/yielded"))

    @property
    def has_law_limit(self) -> bool:
        """True if the law was fitted up to a limited overlap."""
        return bool(self.case.contact.entry.fitted)

    @cached_property
    def struck(self) -> tuple[int, ...]:
        """Ids of the loaded spheres, the central sphere first; for a load by strikers the moving
        strikers.
        """
        return struck_of(self.assembly)

    @property
    def origin(self) -> NDArray[np.float64]:
        """Initial centre of the impacted sphere of the packing: (3,), m."""
        sphere = struck_site(self.assembly)
        row = 0 if sphere is None else int(self.rows(sphere))
        return self.read("spheres/position", slice(row, row + 1))[0]

    @cached_property
    def impact_axis(self) -> NDArray[np.float64]:
        """Position of the impact axis in x and y: the centroid of the impacted spheres' initial
        centres, (2,), m.

        The axis is along z. With periodic sides the images nearest to the impacted sphere count.
        """
        origin = self.origin[:2]
        impacted = np.sort(self.rows(np.array(impacted_of(self.assembly), dtype=np.int64)))
        if len(impacted) < 2:
            return origin
        place = self.read("spheres/position", slice(impacted[0], impacted[-1] + 1))
        offset = self.across(place[impacted - impacted[0]][:, :2] - origin)
        middle = offset.mean(axis=0)
        diameter = self.case.packing.diameter
        return origin + np.where(np.abs(middle) > _AT_CENTRE * diameter, middle, 0.0)

    def across(self, offset: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert distances in x and y, (n, 2), m, to distances to the nearest images if the sides
        are periodic.
        """
        if not self.case.boundary.periodic:
            return offset
        periods = np.array(self.assembly.lattice.lengths)[:2]
        return offset - periods * np.round(offset / periods)

    def distance_from_axis(self, position: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the distances of points, (n, 3), m, from the impact axis, or from its nearest
        image if the sides are periodic: (n,), m.
        """
        offset = self.across(position[:, :2] - self.impact_axis)
        return np.asarray(np.hypot(offset[:, 0], offset[:, 1]))

    def rows(self, ids: ArrayLike) -> NDArray[np.int64]:
        """Return the rows of the spheres with these ids: ids - 1, unless there are vacancies.

        Raises
        ------
        KeyError
            There is no such sphere.
        """
        if "spheres/id" not in self._read:  # the check may be unnecessary
            last = self.read("spheres/id", slice(self.n_spheres - 1, None))
            if len(last) and last[0] == self.n_spheres:
                return rows_of_all(self.n_spheres, np.asarray(ids, dtype=np.int64))
        return rows_of(self._read.setdefault("spheres/id", self.read("spheres/id")), ids)

    @property
    def ends(self) -> NDArray[np.int64]:
        """Rows of the two spheres of each contact: (n_contacts, 2)."""
        return self.rows(np.stack([self["contacts/i"], self["contacts/j"]], axis=1))

    def of_pairs(
        self, column: str, first: ArrayLike, second: ArrayLike, missing: float = 0.0
    ) -> NDArray[np.float64]:
        """Return a column of ``/contacts``, such as ``peak_force``, of pairs of ids, including
        contacts with bars: (n_pairs,). Faces of bars have ids. ``missing`` is the value of pairs
        that are not in contact.
        """
        i, j, values = (self[f"contacts/{name}"] for name in ("i", "j", column))
        for bar in self.assembly.bars:
            here = self["wall_contacts/wall"] == bar.name
            beads = self["wall_contacts/id"][here]
            i = np.append(i, beads)
            j = np.append(j, np.full(len(beads), bar.face))
            values = np.append(values, self[f"wall_contacts/{column}"][here])
        pairs = np.sort(np.stack([first, second]), axis=0)
        stride = 1 + max(j.max(initial=0), pairs.max(initial=0))
        keys = i * stride + j
        wanted = pairs[0] * stride + pairs[1]
        order = np.argsort(keys, kind="stable")
        keys = np.append(keys[order], -1)
        values = np.append(values[order], missing)
        place = np.searchsorted(keys[:-1], wanted)
        return np.where(keys[place] == wanted, values[place], missing)

    def along_chain(self, column: str) -> NDArray[np.float64]:
        """Return a column of ``/contacts`` in the order of the chain, with the faces of bars:
        (n_contacts,).
        """
        return self.of_pairs(column, self["chain/contact_i"], self["chain/contact_j"])

    def beyond_law(self, share: float) -> NDArray[np.bool_]:
        """Return True for contacts with overlaps beyond ``share`` R*, if the law has such a limit:
        (n_contacts,).

        A line contact has a limit with any law: 0.2 R* is 0.1 R of equal cylinders.
        """
        limited = self.has_law_limit or (self.assembly.has_cylinders and self.along_lines)
        return limited & (self["contacts/peak_overlap"] > share * self["contacts/effective_radius"])

    @property
    def along_lines(self) -> NDArray[np.bool_]:
        """True for contacts of parallel cylinders: (n_contacts,)."""
        axes = np.array(
            [one.axis if one else (0.0, 0.0, 0.0) for one in self.assembly.grain_shapes()]
        )
        first, second = axes[self.ends].transpose(1, 0, 2)
        across = np.linalg.norm(np.cross(first, second), axis=1)
        return first.any(axis=1) & second.any(axis=1) & (across < _PARALLEL)

    def has(self, name: str) -> bool:
        """Return True if a data set exists and has non-zero values."""
        return name in self and any(np.any(values) for (values,) in self.blocks(name))

    @property
    def n_spheres(self) -> int:
        """Number of spheres."""
        return len(self.file["spheres/id"])

    def parts(self) -> Iterator[Result]:
        """Iterate over the result in parts of its spheres; a small result is a single part.

        In a part, data sets of ``spheres`` have the rows of the part only; all other data sets are
        complete.
        """
        if self.n_spheres <= self.at_once:
            yield self
            return
        for first in range(0, self.n_spheres, self.at_once):
            yield self._part_of(slice(first, first + self.at_once))

    def _part_of(self, rows: slice) -> Result:
        """Return the result with some of the spheres. It reads the same open file; the memory of
        its arrays is freed with it.
        """
        part = type(self).__new__(type(self))
        part.path = self.path
        part.results = self.results
        part.at_once = self.at_once
        part.file = self.file
        part._assembly = self.assembly
        part._read = {}
        part._part = rows, {}
        return part

    @property
    def in_packing(self) -> NDArray[np.bool_]:
        """True for spheres of the packing, False for strikers: (n_spheres,)."""
        return self["spheres/id"] <= self.assembly.lattice.n_spheres

    @property
    def yield_energy(self) -> NDArray[np.float64]:
        """Energy dissipated by yielding by sphere, with walls, without friction and viscous losses:
        (n_spheres,), J.
        """
        whole = self["spheres/dissipated_energy"]
        others = ("spheres/friction_energy", "spheres/viscous_energy")
        rest = whole - sum(self[name] for name in others if self.has(name))
        return np.where(rest > _ROUNDING * whole, rest, 0.0)

    @property
    def yield_ledger(self) -> NDArray[np.float64]:
        """Energy dissipated by yielding against time, without friction, viscous losses and dampers:
        (n_times,), J.
        """
        others = (
            "friction",
            "rolling",
            "twisting",
            "adhesion",
            "viscous",
            "support_lost",
            "holder",
            "absorbed",
        )
        return self["energy/dissipated"] - sum(
            self[f"energy/{name}"] for name in others if f"energy/{name}" in self
        )

    @property
    def energy_input(self) -> float:
        """Energy input up to the end of the run, J."""
        return float(self["energy/input"][-1])

    @property
    def ledger(self) -> dict[str, NDArray[np.float64]]:
        """Columns of the energy record: (n_times,)."""
        return {name: self[f"energy/{name}"] for name in self.file["energy"]}

    @property
    def largest_input(self) -> float:
        """Largest energy input of the run, J, by which errors of the balance are divided."""
        return float(np.max(work_on_packing(self.ledger, moved_mass(self.assembly))))

    @property
    def n_frames(self) -> int:
        """Number of snapshots."""
        return len(self.file[f"{GROUP}/position/step"])

    @property
    def frame_times(self) -> NDArray[np.float64]:
        """Times of the snapshots: (n_frames,), s."""
        return self[f"{GROUP}/position/time"]

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of the quantities of a snapshot, see `frame`; results of older versions lack
        ``elastic_energy``.
        """
        return tuple(name for name in QUANTITIES if name in self.file[GROUP])

    def frame(self, number: int, quantity: str) -> NDArray[np.float64]:
        """Read one quantity of one snapshot, such as ``displacement``: (n_spheres,) or (n_spheres,
        3), SI units.
        """
        with self._intact(f"{quantity} of snapshot {number}"):
            return self.file[f"{GROUP}/{quantity}/value"][number]
