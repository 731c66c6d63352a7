"""Problem of a search: keys of a design file, a base case with its variables, and the cases of its
designs.
"""

from __future__ import annotations

import contextlib
import copy
import dataclasses
import itertools
import math
import re
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from granwave.analysis.quantities import entries
from granwave.extensions.design.search.variables import Space, Values
from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.ids import INDEX
from granwave.lammps_inputs.case.run import ENERGY_TOLERANCE
from granwave.lammps_inputs.case.schema import ValidationError, show
from granwave.lammps_inputs.errors import InputError, fault_of
from granwave.lammps_inputs.load_case import assembly_from_dict
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.workflows.scanning.header import TABLE_OF_KEYS

_REPLACE = "replace"
_ROUNDING = 1e-9  # relative difference between a value and a limit that it meets exactly
_MOST_IDS = 1_000_000  # most ids of grains that one key changes
#: Values of a packing that limits may concern and that are known before a run.
KNOWN_BEFORE = ("mass_kg", "height_m", "width_m", "n_spheres", "smallest_diameter_m")
_DERIVED = (
    "yielded_share",
    "kinetic_share",
    "overlap_over_radius",
)  # values that are computed from the summary
_NO_NUMBERS = (
    "name",
    "end_reason",
    "zone_cut",
    "versions",
)  # values that are words, lists or tables


def value_names() -> list[str]:
    return [
        *KNOWN_BEFORE,
        *_DERIVED,
        *(entry.name for entry in entries() if entry.name not in _NO_NUMBERS),
    ]


def is_value(name: str) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in value_names())


@dataclasses.dataclass(frozen=True, kw_only=True)
class DesignHeader:
    """Top-level keys of a design file."""

    name: str = schema.typed("name of the search", schema.PLAIN_NAME, default="")
    base: str = schema.text("base case of the search: a built-in case or a case file")

    FURTHER_KEYS: ClassVar[dict[str, Any]] = {
        "set": schema.typed("values for all designs", TABLE_OF_KEYS, default=None),
        "variables": schema.typed(
            "variables: keys of the case, with positions in lists counted from 0; replace.ID.KEY "
            "for grains; layers",
            schema.OtherType(
                expected="for each key a list of choices, or {low = ..., high = ...} with log, "
                "integer or step",
                kinds=("object",),
            ),
        ),
        "limits": schema.typed(
            "limits of a design: mass_kg, height_m, width_m, n_spheres, smallest_diameter_m, "
            "yielded_share, kinetic_share, overlap_over_radius, or a value of summary.json",
            schema.OtherType(
                expected="for each value its upper limit, or {low = ..., high = ...}",
                kinds=("object",),
            ),
            default=None,
        ),
    }


_NAMES_FORM = 'the name of a value of summary.json, such as "target_peak_force_N", or a list of two'


def _value_name(name: str) -> str:
    near = schema.did_you_mean(name, value_names())
    schema.refuse_if(not is_value(name), f"the name of a number of summary.json{near}")
    return name


_NAMES = schema.ListType(
    item=schema.TextType(expected=_NAMES_FORM, may_be_empty=True, finish=_value_name),
    expected=_NAMES_FORM,
    at_most=2,
    alone=True,
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class ObjectiveTable:
    """``[objective]``: values to minimise and maximise; two values in all make a Pareto front."""

    minimise: tuple[str, ...] = schema.typed("values to minimise", _NAMES, default=())
    maximise: tuple[str, ...] = schema.typed("values to maximise", _NAMES, default=())


_STATISTIC_FORM = '"mean", "worst", or a fraction of runs that are at least as good, such as 0.9'
_STATISTIC = schema.EitherType(
    types=(
        schema.ChoiceType(("mean", "worst")),
        schema.NumberType(above=0, below=1, form=_STATISTIC_FORM),
    ),
    form=_STATISTIC_FORM,
)
_RANGE = schema.OtherType(expected="[smallest, largest], or one number", kinds=("array", "number"))


@dataclasses.dataclass(frozen=True, kw_only=True)
class UncertaintyTable:
    """``[uncertainty]``: several runs of each design, with different seeds, and with keys of the
    case drawn from ranges.
    """

    replicates: int = schema.count("number of runs of each design", default=3, at_most=1000)
    statistic: str | float = schema.typed(
        "combination of the runs into the objective", _STATISTIC, default="mean"
    )

    FURTHER_KEYS: ClassVar[dict[str, Any]] = {
        "velocity": schema.typed(
            "range of load.velocity; ranges of other keys of the case are given in the same way",
            _RANGE,
            default=None,
        ),
        "tolerance": schema.typed("range of packing.diameter_scatter, m", _RANGE, default=None),
    }


@dataclasses.dataclass(frozen=True, kw_only=True)
class SearchTable:
    """``[search]``: extent and method of the search."""

    evaluations: int = schema.count(
        "number of designs to run; rejected designs do not count", default=60, at_most=100_000
    )
    seed: int = schema.count("seed of the search", at_least=0, default=1)
    sampler: str = schema.choice(
        "method of the search: model (a Gaussian process of the objective) or random (for "
        "comparison)",
        ("model", "random"),
        default="model",
    )
    guards: bool = schema.choice(
        "check the best design by further runs, and move to better neighbouring designs",
        (True, False),
        default=True,
    )
    neighbours: int = schema.count(
        "largest number of neighbours of the best design that are run after the evaluations",
        default=40,
        at_least=0,
        at_most=100_000,
    )
    tolerance: float | str = schema.number(
        "value of run.energy_tolerance in the search; the best tenth of the designs is run "
        "again with the tolerance of the case; auto: 3e-5 if a run takes seconds, otherwise the "
        "tolerance of the case",
        above=0,
        at_most=1e-3,
        word="auto",
        default="auto",
    )


#: Tables of a design file: class and description.
DESIGN_TABLES: dict[str, tuple[type, str]] = {
    "": (DesignHeader, "top-level keys, variables and limits"),
    "[objective]": (
        ObjectiveTable,
        "objective of the search; two values give a Pareto front",
    ),
    "[uncertainty]": (
        UncertaintyTable,
        "several runs of each design, with other seeds and keys drawn from ranges",
    ),
    "[search]": (SearchTable, "length and method of the search"),
}


@dataclasses.dataclass(frozen=True)
class DesignLimit:
    """Bounds of a value; None where there is none."""

    name: str
    low: float | None
    high: float | None

    def margin(self, value: float) -> float:
        """Return how far a value is beyond a bound, divided by the bound; 0 or negative within the
        bounds, and 0 for a value that differs from a bound by rounding only.
        """
        margins = [_beyond(value, self.high, 1), _beyond(value, self.low, -1)]
        known = [margin for margin in margins if margin is not None]
        return max(known, default=0.0)

    def fault(self, value: float) -> str:
        """Return a value beyond its bounds in words, with the bound; empty within the bounds."""
        if (_beyond(value, self.high, 1) or 0.0) > 0:
            return f"{self.name} {value:.4g}, at most {self.high:g}"
        if (_beyond(value, self.low, -1) or 0.0) > 0:
            return f"{self.name} {value:.4g}, at least {self.low:g}"
        return ""


def _beyond(value: float, bound: float | None, sign: int) -> float | None:
    """Return how far a value is beyond a bound, divided by the bound; None without a bound.

    Parameters
    ----------
    sign
        1 for an upper bound, -1 for a lower bound.
    """
    if bound is None:
        return None
    margin = float(sign * (value - bound) / (abs(bound) or 1.0))
    return 0.0 if abs(margin) <= _ROUNDING else margin


@dataclasses.dataclass(frozen=True)
class Objective:
    """A value of a summary; ``sign`` is 1 if it is to be small, -1 if it is to be large."""

    name: str
    sign: int


@dataclasses.dataclass(frozen=True)
class DesignProblem:
    """A checked design file.

    Attributes
    ----------
    base
        Tables of the case, with the values of ``[set]``.
    path
        Design file; relative paths start from its folder.
    tables
        Tables of the file, for comparison when a search is resumed.
    samples
        Changes of the case by dotted key for each run of a design; a single empty mapping without
        uncertainty.
    tolerance
        ``run.energy_tolerance`` of the search; the best designs are run again with the tolerance
        of the case. 0: the tolerance of the case throughout.
    """

    name: str
    base: dict[str, Any]
    path: Path
    tables: dict[str, Any]
    space: Space
    limits: tuple[DesignLimit, ...]
    objectives: tuple[Objective, ...]
    search: SearchTable
    statistic: str | float = "mean"
    samples: tuple[dict[str, Any], ...] = ({},)
    tolerance: float = 0.0

    @property
    def record(self) -> dict[str, Any]:
        """Tables of the file and of its case, which identify a search."""
        return {**self.tables, "base": self.base}

    def tables_of(
        self, values: Values, sample: Mapping[str, Any] | None = None, *, longer: float = 1.0
    ) -> dict[str, Any]:
        """Return the tables of the case of a design.

        ``longer``: duration of the run divided by the duration in the design file.
        """
        tables = with_values(with_values(self.base, values), sample or {})
        if longer == 1:
            return tables
        return with_values(tables, {"run.end_time": longer * tables["run"]["end_time"]})

    def cheaply(self, tables: Mapping[str, Any]) -> dict[str, Any]:
        """Return the tables of a case with the tolerance of the search.

        They are unchanged if the tolerance of the case is larger, or if its timestep is fixed.
        """
        run = tables.get("run", {})
        is_larger = self.tolerance > run.get("energy_tolerance", ENERGY_TOLERANCE)
        if is_larger and run.get("timestep", "auto") == "auto":
            return with_values(tables, {"run.energy_tolerance": self.tolerance})
        return dict(tables)

    def assembly(self, tables: Mapping[str, Any]) -> Assembly:
        """Read a case, and place its bodies; raise InputError if the case is invalid."""
        return assembly_from_dict(tables, self.path)

    def case(self, tables: Mapping[str, Any]) -> Case:
        """Read a case; raise InputError if it is invalid."""
        return self.assembly(tables).case

    def statistic_of(self, objective: Objective, values: Sequence[float]) -> float:
        """Return the mean, the worst or a quantile of the values of the runs of a design."""
        if self.statistic == "mean":
            return float(np.mean(values))
        if self.statistic == "worst":
            return max(values) if objective.sign > 0 else min(values)
        share = float(self.statistic)
        return float(np.quantile(values, share if objective.sign > 0 else 1 - share))


def examined(
    problem: DesignProblem, values: Values
) -> tuple[dict[str, float], dict[str, float], str]:
    """Examine a design before a run.

    Returns
    -------
    values, margins, fault
        Values of the packing by name; margins of their limits by name; reason why the design is
        rejected, empty if it is not.
    """
    limits = {limit.name: limit for limit in problem.limits}
    try:
        assembly = problem.assembly(problem.tables_of(values, problem.samples[0]))
        values_before = _values_before(assembly, limits.get("n_spheres"))
    except InputError as error:
        return {}, {}, "; ".join(error.errors)
    margins = {}
    faults = []
    for name, limit in limits.items():
        if name in values_before:
            margins[name] = limit.margin(values_before[name])
            faults.append(limit.fault(values_before[name]))
    return values_before, margins, "; ".join(filter(None, faults))


def _values_before(assembly: Assembly, limit: DesignLimit | None) -> dict[str, float]:
    """Return `known_before`; only the number of spheres if it exceeds its limit, to save the memory
    of the positions.
    """
    n_spheres = assembly.lattice.n_spheres
    if limit is not None and n_spheres and limit.fault(n_spheres):
        return {"n_spheres": n_spheres}
    return known_before(assembly)


def known_before(assembly: Assembly) -> dict[str, float]:
    """Return the values of a packing that are known before a run, by the names of
    `KNOWN_BEFORE`.
    """
    n = assembly.lattice.n_spheres
    diameters = assembly.sphere_diameters()[:n]
    positions = assembly.positions()[:n]
    radii = diameters[:, None] / 2
    spans = (positions + radii).max(axis=0) - (positions - radii).min(axis=0)
    return {
        "mass_kg": float(assembly.sphere_masses()[:n].sum()),
        "height_m": float(spans[2]),
        "width_m": float(spans[:2].max()),
        "n_spheres": n,
        "smallest_diameter_m": float(diameters.min()),
    }


def with_derived(summary: Mapping[str, Any], smallest_diameter: float) -> dict[str, Any]:
    """Return a summary with the derived values for limits and objectives.

    ``overlap_over_radius`` is the largest overlap divided by the effective radius of two of the
    smallest spheres, a quarter of their diameter. ``kinetic_share`` is the kinetic energy at the
    end divided by the energy input.
    """
    overlap = summary.get("peak_overlap_m", math.nan)
    if overlap is None:
        overlap = 0.0  # no two spheres are in contact
    kinetic = summary.get("energy_kinetic_J")
    yielded = summary.get("n_plastic_spheres")
    return {
        **summary,
        "mass_kg": summary.get("packing_mass_kg"),
        "height_m": summary.get("packing_height_m"),
        "overlap_over_radius": None if math.isnan(overlap) else 4 * overlap / smallest_diameter,
        "kinetic_share": _ratio(kinetic, summary.get("energy_input_J")),
        "yielded_share": _ratio(yielded, summary.get("n_spheres")),
    }


def _ratio(part: float | None, total: float | None) -> float | None:
    """Return the ratio of two values; None if one is missing, or if the total is 0."""
    return part / total if part is not None and total else None


def with_values(tables: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a case with the values of a design.

    A number in a key is a position in a list, from 0. After ``replace`` it is an id of a grain, or
    several such as ``1-16,33-48``, whose entry of ``[[replace]]`` is changed or added.

    Raises
    ------
    InputError
        Part of a key is not a table or list, or there is no such position.
    """
    changed = copy.deepcopy(dict(tables))
    errors = []
    # complete tables before keys inside them; the new position of a grain after its other keys
    for key in sorted(values, key=lambda key: (key.count("."), key.endswith(".index"))):
        try:
            _set(changed, key.split("."), values[key])
        except ValidationError as error:
            errors.append(fault_of(str(error), key=key))
    if errors:
        raise InputError(errors)
    return changed


def _set(table: Any, path: Sequence[str], value: Any) -> None:
    """Set the value at the parts of a key, in a table or list; missing tables are added."""
    name = path[0]
    rest = path[1:]
    if name == _REPLACE and len(rest) > 1 and (ids := ids_of(rest[0])):
        for entry in _entries_of(ids, table.setdefault(_REPLACE, [])):
            _set(entry, rest[1:], value)
        return
    place: Any = name
    if isinstance(table, list):
        if not ids_of(name, single=True) or int(name) >= len(table):
            raise ValidationError(
                f"found a list of {len(table)} in the case, expected a position from 0 to "
                f"{len(table) - 1}"
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
    """Return the ids in a part of a key, such as ``5`` or, unless single, ``1-16,33-48``; empty if
    the part is a name.
    """
    if not re.fullmatch(r"\d+" if single else r"\d+(-\d+)?(,\d+(-\d+)?)*", text, re.ASCII):
        return []
    spans = []
    for part in text.split(","):
        first, _, last = part.partition("-")
        spans.append(range(int(first), int(last or first) + 1))
    if sum(map(len, spans)) > _MOST_IDS:
        return []
    return list(itertools.chain.from_iterable(spans))


def _entries_of(grains: Sequence[int], entries: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the entries of ``[[replace]]`` of some grains; missing entries are added.

    An added entry has the values of the last entry that covers its grains.
    """
    covering: dict[int, int | None] = dict.fromkeys(grains, None)  # position of the entry by grain
    for place, entry in enumerate(entries):
        with contextlib.suppress(ValidationError):
            covering |= dict.fromkeys(covering.keys() & INDEX.read(entry.get("index", [])), place)
    entries_of_grains = []
    for last in dict.fromkeys(covering.values()):
        ids = [grain for grain, place_of_grain in covering.items() if place_of_grain == last]
        entry = {} if last is None else entries[last]
        if not entry or sorted(INDEX.read(entry["index"])) != sorted(ids):
            entry = {**copy.deepcopy(entry), "index": _index_of(ids)}
            entries.append(entry)
        entries_of_grains.append(entry)
    return entries_of_grains


def _index_of(ids: Sequence[int]) -> Any:
    """Return the key ``index`` of some grains: an id, a range, or a list."""
    steps = {second - first for first, second in itertools.pairwise(ids)}
    if not steps:
        return ids[0]
    if len(steps) > 1 or min(steps) <= 0:
        return list(ids)
    index = {"first": ids[0], "last": ids[-1]}
    step = steps.pop()
    if step != 1:
        index["step"] = step
    return index
