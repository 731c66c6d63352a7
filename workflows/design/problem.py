"""Problem of a search: a base case with variables, limits and objectives, and the cases of its designs."""

from __future__ import annotations

import contextlib
import copy
import dataclasses
import itertools
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from granwave.lammps_inputs.case.bodies import parse_index
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.run import ENERGY_TOLERANCE
from granwave.lammps_inputs.case.schema import ValidationError, show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.places import layout_of
from granwave.workflows.design.keys import SearchTable
from granwave.workflows.design.variables import Space, Values
from granwave.workflows.solvers import GRANULAR

_REPLACE = "replace"
_MOST_IDS = 1_000_000  # of grains that one key changes


@dataclasses.dataclass(frozen=True)
class Limit:
    """Bounds of a value; None where there is none."""

    name: str
    low: float | None
    high: float | None

    def margin(self, value: float) -> float:
        """Return how far a value is beyond its bounds, over the bound; 0 or negative where it is within."""
        return max(
            (float(sign * (value - bound) / (abs(bound) or 1.0)) for sign, bound in ((1, self.high), (-1, self.low))
             if bound is not None),
            default=0.0,
        )  # fmt: skip

    def fault(self, value: float) -> str:
        """Say how a value is beyond its bounds; empty if it is within."""
        if self.high is not None and value > self.high:
            return f"{self.name} {value:.4g}, at most {self.high:g}"
        if self.low is not None and value < self.low:
            return f"{self.name} {value:.4g}, at least {self.low:g}"
        return ""


@dataclasses.dataclass(frozen=True)
class Objective:
    """A value of a summary; ``sign`` is 1 if it is to be small, -1 if it is to be large."""

    name: str
    sign: int

    def loss(self, value: float) -> float:
        """Return the number that is to be small."""
        return self.sign * value


@dataclasses.dataclass(frozen=True)
class Problem:
    """A checked design file.

    Attributes
    ----------
    base
        Tables of the case, with those of ``[set]``.
    path
        Design file; its folder is that of relative paths.
    tables
        Tables of the file, for comparison on a resumed search.
    samples
        Changes of the case by dotted key for each run of a design; one empty mapping without uncertainty.
    tolerance
        Of the energy balance, until the best designs are run again with that of the case; 0: that of the case.
    """

    name: str
    base: dict[str, Any]
    path: Path
    tables: dict[str, Any]
    space: Space
    limits: tuple[Limit, ...]
    objectives: tuple[Objective, ...]
    search: SearchTable
    statistic: str | float = "mean"
    samples: tuple[dict[str, Any], ...] = ({},)
    tolerance: float = 0.0

    @property
    def record(self) -> dict[str, Any]:
        """Tables of the file and of its case, by which a search is known again."""
        return {**self.tables, "base": self.base}

    def tables_of(self, values: Values, sample: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """Return the tables of the case of a design."""
        return with_values(with_values(self.base, values), sample or {})

    def cheaply(self, tables: Mapping[str, Any]) -> dict[str, Any]:
        """Return the tables of a case with the tolerance of the search; the same where it is not larger."""
        run = tables.get("run", {})
        if self.tolerance <= run.get("energy_tolerance", ENERGY_TOLERANCE) or run.get("timestep", "auto") != "auto":
            return dict(tables)
        return with_values(tables, {"run.energy_tolerance": self.tolerance})

    def case(self, tables: Mapping[str, Any]) -> Case:
        """Read a case; raise InputError if it is wrong."""
        case: Case = GRANULAR.read(tables, self.path)
        return case

    def statistic_of(self, objective: Objective, values: Sequence[float]) -> float:
        """Return the mean, the worst or a quantile of the values of the runs of a design."""
        if self.statistic == "mean":
            return float(np.mean(values))
        if self.statistic == "worst":
            return max(values) if objective.sign > 0 else min(values)
        share = float(self.statistic)
        return float(np.quantile(values, share if objective.sign > 0 else 1 - share))


def examined(problem: Problem, values: Values) -> tuple[dict[str, float], dict[str, float], str]:
    """Return what is known of a design before a run: values, margins of limits, and why it is refused; empty if not."""
    try:
        case = problem.case(problem.tables_of(values, problem.samples[0]))
        most = next((limit for limit in problem.limits if limit.name == "n_spheres"), None)
        if (
            most is not None
            and (count := layout_of(case.packing, case.boundary).n_spheres)
            and (fault := most.fault(count))
        ):
            return {"n_spheres": count}, {most.name: most.margin(count)}, fault  # before it takes memory
        known = known_before(case)
    except InputError as error:
        return {}, {}, "; ".join(error.errors)
    limits = [limit for limit in problem.limits if limit.name in known]
    margins = {limit.name: limit.margin(known[limit.name]) for limit in limits}
    return known, margins, "; ".join(filter(None, (limit.fault(known[limit.name]) for limit in limits)))


def known_before(case: Case) -> dict[str, float]:
    """Return the values of a packing that are known before a run, by the names of `KNOWN_BEFORE`."""
    assembly = assemble(case)
    n = assembly.lattice.n_spheres
    diameters, positions = assembly.sphere_diameters()[:n], assembly.positions()[:n]
    spans = (positions + diameters[:, None] / 2).max(axis=0) - (positions - diameters[:, None] / 2).min(axis=0)
    return {
        "mass_kg": float(assembly.sphere_masses()[:n].sum()),
        "height_m": float(spans[2]),
        "width_m": float(spans[:2].max()),
        "n_spheres": n,
        "smallest_diameter_m": float(diameters.min()),
    }


def with_values(tables: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a case with the values of a design.

    Parts of a key that are numbers are places in a list, from 0; after ``replace`` ids of grains, such as ``5`` or
    ``1-16,33-48``, whose entry of ``[[replace]]`` is changed or added.

    Raises
    ------
    InputError
        Part of a key is no table or list, or there is no such place.
    """
    found = copy.deepcopy(dict(tables))
    errors = []
    # whole tables first, then keys inside them; a grain's new place after what is said of its old one
    for key in sorted(values, key=lambda key: (key.count("."), key.endswith(".index"))):
        try:
            _set(found, key.split("."), values[key])
        except ValidationError as error:
            errors.append(f"{key}: {error}")
    if errors:
        raise InputError(errors)
    return found


def _set(table: Any, path: Sequence[str], value: Any) -> None:
    name, rest = path[0], path[1:]
    if name == _REPLACE and len(rest) > 1 and (ids := ids_of(rest[0])):
        for entry in _entries_of(ids, table.setdefault(_REPLACE, [])):
            _set(entry, rest[1:], value)
        return
    place: Any = name
    if isinstance(table, list):
        if not ids_of(name, single=True) or int(name) >= len(table):
            raise ValidationError(
                f"found a list of {len(table)} in the case, expected a place from 0 to {len(table) - 1}"
            )
        place = int(name)
    elif not isinstance(table, dict):
        raise ValidationError(f"found {show(table)} in the case, expected a table or a list")
    if not rest:
        table[place] = copy.deepcopy(value)
        return
    if isinstance(table, dict):
        inner = table.setdefault(name, {})
        if name == "material" and isinstance(inner, str):
            table[name] = {"preset": inner}
    _set(table[place], rest, value)


def ids_of(text: str, *, single: bool = False) -> list[int]:
    """Return the numbers of a part of a key, such as ``5`` or, unless single, ``1-16,33-48``; empty if it is none."""
    if not re.fullmatch(r"\d+" if single else r"\d+(-\d+)?(,\d+(-\d+)?)*", text, re.ASCII):
        return []
    ends = [part.split("-") for part in text.split(",")]
    spans = [range(int(first), int(last[0] if last else first) + 1) for first, *last in ends]
    return [n for span in spans for n in span] if sum(map(len, spans)) <= _MOST_IDS else []


def _entries_of(grains: Sequence[int], entries: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the entries of ``[[replace]]`` of some grains; a new one has the values of the last that covers them."""
    covering: dict[int, int | None] = dict.fromkeys(grains, None)
    for place, entry in enumerate(entries):
        with contextlib.suppress(ValidationError):
            covering |= dict.fromkeys(covering.keys() & parse_index(entry.get("index", [])), place)
    found = []
    for one in dict.fromkeys(covering.values()):
        ids = [grain for grain in covering if covering[grain] == one]
        before = {} if one is None else entries[one]
        if before and sorted(parse_index(before["index"])) == sorted(ids):
            found.append(before)
        else:
            found.append({**copy.deepcopy(before), "index": _index_of(ids)})
            entries.append(found[-1])
    return found


def _index_of(ids: Sequence[int]) -> Any:
    """Return ids as an ``index`` of a case is written."""
    if len(ids) == 1:
        return ids[0]
    steps = {second - first for first, second in itertools.pairwise(ids)}
    if len(steps) > 1 or min(steps) < 1:
        return list(ids)
    return {"first": ids[0], "last": ids[-1], **({"step": steps.pop()} if steps != {1} else {})}
