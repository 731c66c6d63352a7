"""A design file: a case, what may vary, limits, objectives, uncertainty, and the cases that follow
from it.
"""

from __future__ import annotations

import copy
import dataclasses
import logging
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from granwave.analysis.document.model import is_number
from granwave.analysis.scans.result import SEED
from granwave.extensions.design.search.problem import (
    KNOWN_BEFORE,
    DesignHeader,
    DesignLimit,
    DesignProblem,
    Objective,
    ObjectiveTable,
    SearchTable,
    UncertaintyTable,
    ids_of,
    is_value,
    value_names,
    with_values,
)
from granwave.extensions.design.search.variables import Space, Variable, read_variables
from granwave.lammps_inputs.case.bounds import is_target
from granwave.lammps_inputs.case.case import case_keys
from granwave.lammps_inputs.case.parse import apply_overrides
from granwave.lammps_inputs.case.schema import (
    ErrorList,
    ValidationError,
    did_you_mean,
    finite,
    read_table,
    show,
)
from granwave.lammps_inputs.errors import InputError, InputFault, Mismatch
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.packing.disorder import is_random
from granwave.lammps_inputs.planning.plan import plan
from granwave.workflows import library
from granwave.workflows.solvers import GRANULAR, solver_of

_LOG = logging.getLogger("granwave")

# s, expected of a run of the base: from there on a coarse search saves more than it costs
_SLOW = 5.0
_COARSE = 3e-5  # run.energy_tolerance of a coarse search: forces within 1e-3 of those with 3e-6
LAYERS = "layers"  # of [variables]: materials and diameters of each layer or bead
_ALIASES = {
    "velocity": "load.velocity",
    "tolerance": "packing.diameter_scatter",
}  # of [uncertainty]
#: Keys by which a packing may become random.
_RANDOM = ("packing.diameter_scatter", "packing.vacancies", "striker.misalignment", "replace.share")
_WHOLE = {
    "replace",
    "replace.material",
    "striker",
    "striker.material",
    "contact.loss",
}  # tables, as one value
_OF_TARGET = (
    "target_*",
    "wall_peak_force_N",
    "wall_impulse_Ns",
    "ground_*",
    "peak_reduction*",
    "unprotected_*",
)


def load_problem(
    source: str | Path | Mapping[str, Any], budget: int | None = None
) -> DesignProblem:
    """Read a design file.

    Parameters
    ----------
    source
        Path of the file, or its tables.
    budget
        Number of designs to run, in place of that of the file.

    Raises
    ------
    InputError
        The file or its case is wrong; the message has a line for each fault.
    """
    path = Path("design") if isinstance(source, Mapping) else Path(source)
    data: dict[str, Any] = (
        copy.deepcopy(dict(source)) if isinstance(source, Mapping) else read_toml(path)
    )
    whole_file = copy.deepcopy(data)
    vocabulary = [f"{table}.{key}" for table in ("set", "variables") for key in case_keys()]
    known = ("set", "variables", "limits", "objective", "uncertainty", "search")
    errors = ErrorList(str(path), vocabulary=[*known, *vocabulary])
    tables: dict[str, Any] = {name: data.pop(name, {}) for name in known}
    header = read_table(DesignHeader, {"name": path.stem, **data}, "", errors)
    search = read_table(SearchTable, tables["search"], "search", errors)
    objective = read_table(ObjectiveTable, tables["objective"], "objective", errors)
    fixed, base = _base(header, path, tables["set"], errors)
    variables = _variables(tables["variables"], base, errors)
    limits = _limits(tables["limits"], errors)
    objectives = _objectives(objective, base, errors)
    statistic, ranges, replicates = _uncertainty(tables["uncertainty"], errors)
    keys = [one.key for one in variables]
    twice = dict.fromkeys(
        key for key in keys if key in ranges or key in fixed or keys.count(key) > 1
    )
    errors.check(
        *(
            (True, f"variables.{key}", "is given twice, expected it in one table alone")
            for key in twice
        )
    )
    if errors.items or header is None or search is None:
        raise InputError(errors.items)
    if budget is not None:
        search = dataclasses.replace(search, evaluations=budget)
    problem = DesignProblem(
        name=header.name,
        base=base,
        path=path,
        tables=whole_file,
        space=Space(tuple(variables)),
        limits=limits,
        objectives=objectives,
        search=search,
        statistic=statistic,
    )
    samples = tuple(_samples(problem, ranges, replicates)) if tables["uncertainty"] else ({},)
    tolerance = search.tolerance
    if isinstance(tolerance, str):
        slow = plan(problem.assembly(with_values(base, samples[0]))).wall_time > _SLOW
        tolerance = _COARSE if slow else 0.0
    return dataclasses.replace(problem, samples=samples, tolerance=tolerance)


def _base(
    header: DesignHeader | None, path: Path, table: Any, errors: ErrorList
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the keys of ``[set]``, dotted, and the tables of the case that they are set in."""
    if not isinstance(table, Mapping):
        errors.add("set", Mismatch(show(table), "a table of keys and values"))
    if header is None or not isinstance(table, Mapping):
        return {}, {}
    fixed: dict[str, Any] = {}
    try:
        file = library.find_for(header.base, GRANULAR.verb, directory=path.parent)
        base = {"name": file.stem, **read_toml(file)}
        if solver_of(base) is not GRANULAR:
            raise InputError(
                f"{header.base}: is a continuum case, expected one that granwave run takes"
            )
        written = list(_of_set(table, base))
        fixed = dict(written)
        _refuse_twice("set", written, errors)
        base = apply_overrides(
            base, {key: fixed[key] for key in sorted(fixed, key=lambda key: key.count("."))}
        )
        GRANULAR.read(base, file)
    except InputError as error:
        errors.extend(_of_base(item, path) for item in error.items)
        return fixed, {}
    return fixed, base


def _of_base(item: InputFault, path: Path) -> InputFault:
    """Return a fault of the base case as one of the design file, with its ``[set]``."""
    key = f"set.{item.key}" if item.changed else item.key
    return dataclasses.replace(item, key=key).inside(f"{path}: base")


def _refuse_twice(name: str, written: Iterable[tuple[str, Any]], errors: ErrorList) -> None:
    for key, count in Counter(key for key, _ in written).items():
        errors.check((count > 1, f"{name}.{key}", "is given twice"))


def _of_set(table: Mapping[str, Any], base: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Give the keys of ``[set]`` with dots; tables without quotes change keys of the case's tables
    one by one.

    A table of another kind, such as ``{plate = ...}`` for ``{half_space = ...}``, or of a preset,
    takes the other's place.
    """
    for key, value in table.items():
        there = base.get(key) if isinstance(base, Mapping) else None
        kinds = [{name for name, held in one.items() if isinstance(held, Mapping)} if isinstance(one, Mapping) else None
                 for one in (value, there)]  # fmt: skip
        whole = (
            None in kinds
            or "preset" in value
            or (all(kinds) and set(kinds[0] or ()).isdisjoint(kinds[1] or ()))
        )
        if whole:
            yield f"{prefix}{key}", value
        else:
            yield from _of_set(value, there, f"{prefix}{key}.")


def _variables(tables: Any, base: dict[str, Any], errors: ErrorList) -> list[Variable]:
    if not isinstance(tables, Mapping) or not tables:
        errors.add(
            "variables",
            Mismatch("none", "a table of keys of the case, each with choices or a range"),
        )
        return []
    keys = dict(tables)
    layers = keys.pop(LAYERS, None)
    written = list(_dotted(keys))
    found = read_variables(dict(written), "variables", errors)
    _refuse_twice("variables", written, errors)
    if layers is not None and base:
        found += _layers(layers, base, [one.key for one in found], errors)
    for one in found:
        if _is_key("variables", one.key, errors) and base:
            try:
                with_values(base, {one.key: one.value(0.0)})
            except InputError as error:
                errors.extend(
                    dataclasses.replace(item, source=errors.source, key=f"variables.{item.key}")
                    for item in error.items
                )
    if not base or errors.items:
        return found
    # words, and ends of ranges, that alone make the base wrong; one warning for variables of equal
    # fault
    refused: dict[tuple[str, str], list[str]] = defaultdict(list)
    for one in found:
        for value in (
            one.choices if not one.ordered else dict.fromkeys(one.value(end) for end in (0.0, 1.0))
        ):
            try:
                GRANULAR.read(with_values(base, {one.key: value}), errors.source)
            except InputError as error:
                fault = str(error.items[0].outside(errors.source))
                refused[show(value), fault].append(one.key)
    for (value, fault), same in refused.items():
        more = f" and {len(same) - 1} more" * (len(same) > 1)
        _LOG.warning(
            "%s: variables.%s%s: %s alone is refused: %s",
            errors.source,
            same[0],
            more,
            value,
            fault,
        )
    return found


def _dotted(tables: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Give variables by dotted key, whether their keys were written with quotes or as nested
    tables.
    """
    for key, value in tables.items():
        if isinstance(value, Mapping) and value and not {"low", "high"} & set(value):
            yield from _dotted(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _is_key(table: str, key: str, errors: ErrorList) -> bool:
    """Return True for a key of a case, or one inside the table that a key holds; else add the
    error.
    """
    names = {_generic(one) for one in case_keys()} | _WHOLE
    generic = _generic(key)
    known = generic in names or any(
        "." in name and generic.startswith(f"{name}.") for name in names
    )
    fault = f"is no key of a case{did_you_mean(generic, names)}; granwave keys lists them"
    return errors.check_first((not known, f"{table}.{key}", fault))


def _generic(key: str) -> str:
    """Return a key without places in lists."""
    return ".".join(part for part in key.split(".") if not ids_of(part))


def _layers(
    value: Any, base: Mapping[str, Any], others: Collection[str], errors: ErrorList
) -> list[Variable]:
    """Return the variables of each layer, or bead of a chain: its material, and its diameter over
    that of the packing.

    Tied layers are alike: with ``{period = 2}`` every other one, with ``{groups = 3}`` those of
    each third.
    """
    key = f"variables.{LAYERS}"
    packing = GRANULAR.read(base, errors.source).packing
    table = value if isinstance(value, Mapping) else {}
    lattice = packing.lattice() if packing.grains is None else None
    ends = table.get("diameters")
    tied = table.get("tied", {"groups": lattice.n_layers if lattice else 1})
    way, count = (
        next(iter(tied.items())) if isinstance(tied, Mapping) and len(tied) == 1 else ("", 0)
    )
    fits = errors.check_first(
        (
            {"packing.size", "packing.diameter"} & {other.removesuffix(".2") for other in others},
            key,
            Mismatch("beside packing.size or packing.diameter", "these in the base"),
        ),
        (
            lattice is None,
            key,
            Mismatch(f'with packing.kind = "{packing.kind}"', "a base with layers"),
        ),
        (
            not {"materials", "diameters"} & set(table)
            or set(table) - {"materials", "diameters", "tied"},
            key,
            Mismatch(
                show(value),
                '{materials = ["steel", "ptfe"]} or {diameters = [0.4, 1.0]} (over '
                "packing.diameter), or both",
            ),
        ),
        (
            way not in ("period", "groups") or not isinstance(count, int) or count < 1,
            f"{key}.tied",
            Mismatch(
                show(tied),
                "{period = 2}, every other layer alike, or {groups = 3}, three "
                "blocks of layers; free if left out",
            ),
        ),
        (
            ends is not None and not packing.rule.is_chain,
            f"{key}.diameters",
            Mismatch(
                f'with packing.kind = "{packing.kind}"',
                '"chain": smaller spheres leave gaps in a lattice',
            ),
        ),
        (
            ends is not None
            and not (isinstance(ends, list) and len(ends) == 2 and all(map(is_number, ends))),
            f"{key}.diameters",
            Mismatch(show(ends), "[smallest, largest]"),
        ),
    )
    if not fits or lattice is None:
        return []
    alike = defaultdict(list)
    for layer in range(lattice.n_layers):
        alike[layer % count if way == "period" else layer * count // lattice.n_layers].append(layer)
    written: dict[str, Any] = {}
    for layers in alike.values():
        blocks = (
            [(layers[0], layers[-1])] if way == "groups" else [(layer, layer) for layer in layers]
        )
        spans = [(lattice.layer(top)[0], lattice.layer(bottom)[-1]) for top, bottom in blocks]
        ids = ",".join(f"{first}" if first == last else f"{first}-{last}" for first, last in spans)
        if "materials" in table:
            written[f"replace.{ids}.material"] = table["materials"]
        if ends is not None:
            low, high = (end * packing.diameter for end in ends)
            written[f"replace.{ids}.diameter"] = {"low": low, "high": high}
    return read_variables(written, "variables", errors)


def _limits(tables: Any, errors: ErrorList) -> tuple[DesignLimit, ...]:
    found = []
    if not isinstance(tables, Mapping):
        errors.add(
            "limits",
            Mismatch(show(tables), "a table of values and their largest allowed ones"),
        )
        return ()
    for name, value in tables.items():
        expected = "the largest allowed value, or {low = ..., high = ...}"
        if not is_value(name):
            near = did_you_mean(name, value_names())
            errors.add(
                f"limits.{name}",
                f"is no value of summary.json, and none of {', '.join(KNOWN_BEFORE)}{near}",
            )
            continue
        try:
            ends = value if isinstance(value, Mapping) else {"high": value}
            if not ends or set(ends) - {"low", "high"}:
                raise ValidationError(expected)
            low, high = (
                finite(ends[end], expected) if end in ends else None for end in ("low", "high")
            )
            if low is not None and high is not None and high < low:
                raise ValidationError("a high that is not below the low")
        except ValidationError as error:
            errors.add_wrong(f"limits.{name}", value, error)
        else:
            found.append(DesignLimit(name, low, high))
    return tuple(found)


def _objectives(
    table: ObjectiveTable | None, base: Mapping[str, Any], errors: ErrorList
) -> tuple[Objective, ...]:
    if table is None:
        return ()
    found = [Objective(name, 1) for name in table.minimise] + [
        Objective(name, -1) for name in table.maximise
    ]
    if not 1 <= len(found) <= 2 or len({one.name for one in found}) < len(found):
        errors.add(
            "objective",
            Mismatch(
                f"{len(found)} values", "one, or two different ones, under minimise or maximise"
            ),
        )
    bottom = base.get("boundary", {}).get("bottom", "wall") if base else "wall"
    without_target = "bar" not in base and not is_target(bottom)
    for one in found:
        of_target = any(fnmatchcase(one.name, pattern) for pattern in _OF_TARGET)
        errors.check((
            without_target and of_target, "objective",
            f"{one.name}: is null without a target: found boundary.bottom = {show(bottom)} in the base, "
            'expected "wall", {plate = ...}, {half_space = ...} or {bar = ...}',
        ))  # fmt: skip
    return tuple(found)


def _uncertainty(
    table: Any, errors: ErrorList
) -> tuple[str | float, dict[str, tuple[float, float]], int]:
    if not isinstance(table, Mapping):
        errors.add("uncertainty", Mismatch(show(table), "a table"))
        return "mean", {}, 1
    names = {field.name for field in dataclasses.fields(UncertaintyTable)}
    own = read_table(
        UncertaintyTable, {key: table[key] for key in table if key in names}, "uncertainty", errors
    )
    ranges: dict[str, tuple[float, float]] = {}
    for key, value in _dotted({key: table[key] for key in table if key not in names}):
        expected = "a range [smallest, largest], or one number"
        name = _ALIASES.get(key, key)
        try:
            if isinstance(value, Mapping) and set(value) == {"low", "high"}:
                value = [value["low"], value["high"]]
            ends = value if isinstance(value, list) else [value, value]
            if len(ends) != 2:
                raise ValidationError(expected)
            low, high = (finite(end, expected) for end in ends)
            if high < low:
                raise ValidationError(f"{expected}, the largest not below the smallest")
        except ValidationError as error:
            errors.add_wrong(f"uncertainty.{key}", value, error)
            continue
        if _is_key("uncertainty", name, errors):
            errors.check((name in ranges, f"uncertainty.{key}", "is given twice"))
        ranges[name] = (low, high)
    return (own.statistic, ranges, own.replicates) if own else ("mean", ranges, 1)


def _samples(
    problem: DesignProblem, ranges: Mapping[str, tuple[float, float]], replicates: int
) -> Iterator[dict[str, Any]]:
    """Give the changes of the case for each run of a design: evenly spread over the ranges, and the
    seeds.
    """
    varied = [key for key, (low, high) in ranges.items() if high > low]
    middle = {key: (low + high) / 2 for key, (low, high) in ranges.items()}
    try:
        random = is_random(problem.case(with_values(problem.base, middle)))
    except InputError as error:
        path = str(problem.path)
        raise InputError(
            item.outside(path).inside(f"{path}: uncertainty") for item in error.items
        ) from None
    random = random or any(_generic(one.key) in _RANDOM for one in problem.space.variables)
    if not random and not varied:
        _LOG.warning(
            "%s: uncertainty: nothing is random in these packings, so that each is run once",
            problem.path,
        )
        replicates = 1
    rng = np.random.default_rng(problem.search.seed)
    shares = {key: (rng.permutation(replicates) + 0.5) / replicates for key in varied}
    for n in range(replicates):
        drawn = {key: float(share[n]) for key, share in shares.items()}
        found = {
            key: low + drawn.get(key, 0.0) * (high - low) for key, (low, high) in ranges.items()
        }
        yield {**found, SEED: n + 1} if random else found
