"""Finished runs with their cases, in the form for studies; titles of packing, load and bottom."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np

from granwave.analysis.result.writer import BALANCE_REFUSED
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.load_case import read_stored_case
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.packing.motion import velocities_of
from granwave.lammps_inputs.run_directory import CASE_FILE

AnyCase = TypeVar("AnyCase")
Kind = TypeVar("Kind", bound="AnyRun[Any]")

_NOT_OF_THE_CASE = (
    "name",
    "run",
    "output",
    "sensor",
)  # tables with duration and resolution of the records


@dataclasses.dataclass(frozen=True, eq=False)
class AnyRun(Generic[AnyCase]):
    """A finished run.

    Attributes
    ----------
    label
        Name in a report.
    summary
        Its ``summary.json``.
    """

    label: str
    directory: Path
    case: AnyCase
    summary: Mapping[str, Any]

    def seen_as(self, kind: type[Kind]) -> Kind:
        """The run as a `Run` object; the same object at each call, so that files are read once."""
        if isinstance(self, kind):
            return self
        if kind not in self._views:
            self._views[kind] = kind(self.label, self.directory, self.case, self.summary)
        return self._views[kind]

    @cached_property
    def _views(self) -> dict[type, Any]:
        return {}

    def value(self, name: str) -> float:
        """A number of the summary; NaN if it does not apply."""
        found = self.summary.get(name)
        return (
            float(found)
            if isinstance(found, int | float) and not isinstance(found, bool)
            else math.nan
        )


class FinishedRun(AnyRun[Case]):
    """A finished run of spheres."""

    @cached_property
    def assembly(self) -> Assembly:
        """All bodies of the case."""
        return assemble(self.case)


def read_run(label: str, directory: Path, summary: Mapping[str, Any]) -> FinishedRun | None:
    """Read a finished run of spheres; None if its case cannot be read."""
    try:
        return FinishedRun(label, directory, read_stored_case(directory / CASE_FILE), summary)
    except GranwaveError:
        return None  # reported elsewhere


def finished_runs(found: Iterable[tuple[str, Path, Mapping[str, Any]]]) -> list[FinishedRun]:
    """Read runs of spheres, except runs whose energy balance was rejected or whose case cannot be
    read.

    Parameters
    ----------
    found
        Label, directory and summary of finished runs.
    """
    runs = (read_run(*one) for one in found if one[2].get("end_reason") != BALANCE_REFUSED)
    return [run for run in runs if run is not None]


def all_but(case: Case, *left_out: str) -> str:
    """Text of a case without some tables or keys: equal for cases without other differences.

    Duration and resolution of the records do not count.

    Parameters
    ----------
    left_out
        Such as ``precompression`` or ``load.velocity``.
    """
    tables = case.to_dict()
    for name in (*_NOT_OF_THE_CASE, *left_out):
        table, _, key = name.partition(".")
        if key:
            tables.get(table, {}).pop(key, None)
        else:
            tables.pop(table, None)
    return json.dumps(tables, sort_keys=True)


_LAWS = {"hertz": "elastic", "elastoplastic": "elasto-plastic"}


def impact_title(assembly: Assembly, *, height: bool = True) -> str:
    """``FCC packing of 12 x 12 x 8 brass spheres of 10 mm, elasto-plastic contacts, 5 m/s``.

    Parameters
    ----------
    height
        False: of packings that differ in it.
    """
    name = assembly.case.contact.law
    law = _LAWS.get(name, name)
    return f"{packing_title(assembly, height=height)}, {law} contacts, {load_label(assembly)}"


def packing_title(assembly: Assembly, *, height: bool = True) -> str:
    """``FCC packing of 12 x 12 x 8 brass spheres of 10 mm``; of a single sphere ``Brass sphere of
    10 mm``.
    """
    packing = assembly.case.packing
    own = _materials(assembly)
    diameter = f"of {1e3 * packing.diameter:.4g} mm"
    if height and assembly.lattice.n_spheres == 1:
        words = f"{own} sphere {diameter}".lstrip()
        return words[:1].upper() + words[1:]
    whole = height or packing.rule.is_layer  # the layer is across the height
    size = " × ".join(map(str, packing.size if whole else packing.size[:-1]))
    spheres = " ".join(filter(None, (size, own, "spheres", diameter)))
    return f"{packing.rule.title} of {spheres}" + ("" if whole or not size else " a layer")


_MOST_MATERIALS = 3  # these are named, others are counted


def _materials(assembly: Assembly) -> str:
    """Return the names of the materials of the spheres, ``steel and ptfe``."""
    sites = assembly.sites
    present = np.unique(np.broadcast_to(sites.body, sites.present.shape)[sites.present])
    names = dict.fromkeys(sites.bodies[number][0].name or "" for number in present.tolist())
    if len(names) > _MOST_MATERIALS:
        return f"{len(names)} materials:"
    return " and ".join(filter(None, names))


def load_label(assembly: Assembly) -> str:
    """Velocity of the fastest sphere, ``5 m/s``; for a force or a prescribed motion, the label of
    the load.
    """
    if assembly.case.load.label:
        return assembly.case.load.label
    speeds = [math.hypot(*velocity) for velocity in velocities_of(assembly).values()]
    return f"{max(speeds, default=0.0):g} m/s"


def bottom_label(case: Case) -> str:
    """``rigid wall``, ``concrete half-space``, ``plate of 0.5 kg, 314 µs``."""
    boundary = case.boundary
    support = boundary.bottom_support
    material = boundary.bottom_material
    name = (material.name or "elastic") if material else "rigid"
    if support is None:
        return boundary.bottom_rule.label.format(material=name)
    return support.label(name)
