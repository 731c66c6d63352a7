"""A design file: base case, variables, limits, objectives, uncertainty, and the resulting cases."""

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
from granwave.lammps_inputs.case.packing.packing import PackingSection
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
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.packing.disorder import is_random
from granwave.lammps_inputs.planning.plan import plan
from granwave.workflows import library
from granwave.workflows.solvers import GRANULAR, solver_of

_LOG = logging.getLogger("granwave")

_SLOW = 5.0  # expected duration of a run of the base above which a coarse search saves time, s
_COARSE = 3e-5  # run.energy_tolerance of a coarse search: forces differ by 1e-3 from 3e-6
LAYERS = "layers"  # table of [variables]: materials and diameters of each layer or bead
_OF_LAYERS = ("materials", "diameters")  # keys of this table, which may also have ``tied``
# short names of keys in [uncertainty]
_ALIASES = {"velocity": "load.velocity", "tolerance": "packing.diameter_scatter"}
#: Keys by which a packing may become random.
_RANDOM = ("packing.diameter_scatter", "packing.vacancies", "striker.misalignment", "replace.share")
#: Tables of a case that can be a single value.
_WHOLE = {"replace", "replace.material", "striker", "striker.material", "contact.loss"}
#: Values of a summary that need a target.
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
        Number of designs to run, instead of ``search.evaluations``.

    Raises
    ------
    InputError
        The file or its case is invalid; the message has a line for each fault.
    """
    path = Path("design")
    if isinstance(source, Mapping):
        data: dict[str, Any] = copy.deepcopy(dict(source))
    else:
        path = Path(source)
        data = read_toml(path)
    whole_file = copy.deepcopy(data)
    vocabulary = [f"set.{key}" for key in case_keys()]
    vocabulary += [f"variables.{key}" for key in case_keys()]
    table_names = ("set", "variables", "limits", "objective", "uncertainty", "search")
    errors = ErrorList(str(path), vocabulary=[*table_names, *vocabulary])
    tables: dict[str, Any] = {name: data.pop(name, {}) for name in table_names}
    header = read_table(DesignHeader, {"name": path.stem, **data}, "", errors)
    search = read_table(SearchTable, tables["search"], "search", errors)
    objective = read_table(ObjectiveTable, tables["objective"], "objective", errors)
    fixed, base = _base(header, path, tables["set"], errors)
    variables = _variables(tables["variables"], base, errors)
    limits = _limits(tables["limits"], errors)
    objectives = _objectives(objective, base, errors)
    statistic, ranges, replicates = _uncertainty(tables["uncertainty"], errors)
    for key, count in Counter(variable.key for variable in variables).items():
        is_twice = count > 1 or key in ranges or key in fixed
        fault = "is given twice; give it in only one table"
        errors.check((is_twice, f"variables.{key}", fault))
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
    """Return the dotted keys of ``[set]``, and the tables of the base case with their values."""
    if not isinstance(table, Mapping):
        errors.add("set", Mismatch(show(table), "a table of keys and values"))
    if header is None or not isinstance(table, Mapping):
        return {}, {}
    fixed: dict[str, Any] = {}
    try:
        file = library.find_for(header.base, GRANULAR.verb, directory=path.parent)
        base = {"name": file.stem, **read_toml(file)}
        if solver_of(base) is not GRANULAR:
            raise InputError(f"{header.base}: is a continuum case, expected a case of granwave run")
        written = list(_of_set(table, base))
        fixed = dict(written)
        _refuse_twice("set", written, errors)
        outer_first = sorted(fixed, key=lambda key: key.count("."))
        base = apply_overrides(base, {key: fixed[key] for key in outer_first})
        GRANULAR.read(base, file)
    except InputError as error:
        errors.extend(_of_base(item, path) for item in error.items)
        return fixed, {}
    return fixed, base


def _of_base(item: InputFault, path: Path) -> InputFault:
    """Return a fault of the base case as a fault of the design file, with its ``[set]``."""
    key = f"set.{item.key}" if item.changed else item.key
    return dataclasses.replace(item, key=key).inside(f"{path}: base")


def _refuse_twice(name: str, written: Iterable[tuple[str, Any]], errors: ErrorList) -> None:
    for key, count in Counter(key for key, _ in written).items():
        errors.check((count > 1, f"{name}.{key}", "is given twice"))


def _of_set(table: Mapping[str, Any], base: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Return the dotted keys of ``[set]`` with their values.

    A nested table changes the keys of a table of the base one by one, unless it replaces the
    complete table.
    """
    for key, value in table.items():
        current = base.get(key) if isinstance(base, Mapping) else None
        if _replaces(value, current):
            yield f"{prefix}{key}", value
        else:
            yield from _of_set(value, current, f"{prefix}{key}.")


def _replaces(value: Any, current: Any) -> bool:
    """Return True if a value of ``[set]`` replaces the complete value of the base.

    A table does so if it is of another kind, such as ``{plate = ...}`` for ``{half_space = ...}``,
    or has a preset.
    """
    if not isinstance(value, Mapping) or not isinstance(current, Mapping) or "preset" in value:
        return True
    kinds = _inner_tables(value)
    current_kinds = _inner_tables(current)
    return bool(kinds and current_kinds) and kinds.isdisjoint(current_kinds)


def _inner_tables(table: Mapping[str, Any]) -> set[str]:
    """Return the names of the tables inside a table."""
    return {name for name, entry in table.items() if isinstance(entry, Mapping)}


def _variables(tables: Any, base: dict[str, Any], errors: ErrorList) -> list[Variable]:
    """Read ``[variables]``; faults go into ``errors``."""
    if not isinstance(tables, Mapping) or not tables:
        errors.add(
            "variables",
            Mismatch("none", "a table of keys of the case, each with choices or a range"),
        )
        return []
    keys = dict(tables)
    layers = keys.pop(LAYERS, None)
    written = list(_dotted(keys))
    variables = read_variables(dict(written), "variables", errors)
    _refuse_twice("variables", written, errors)
    if layers is not None and base:
        variables += _layers(layers, base, [variable.key for variable in variables], errors)
    for variable in variables:
        if _is_key("variables", variable.key, errors) and base:
            _check_place(variable, base, errors)
    if base and not errors.items:
        _warn_of_refused_values(variables, base, errors.source)
    return variables


def _check_place(variable: Variable, base: dict[str, Any], errors: ErrorList) -> None:
    """Check that the base has a place for the key of a variable."""
    try:
        with_values(base, {variable.key: variable.value(0.0)})
    except InputError as error:
        errors.extend(
            dataclasses.replace(item, source=errors.source, key=f"variables.{item.key}")
            for item in error.items
        )


def _warn_of_refused_values(
    variables: Iterable[Variable], base: dict[str, Any], source: str
) -> None:
    """Warn of words and ends of ranges that alone make the base invalid.

    Variables with the same fault share a warning.
    """
    refused: dict[tuple[str, str], list[str]] = defaultdict(list)
    for variable in variables:
        values = list(variable.choices)
        if variable.ordered:
            values = list(dict.fromkeys((variable.value(0.0), variable.value(1.0))))
        for value in values:
            try:
                GRANULAR.read(with_values(base, {variable.key: value}), source)
            except InputError as error:
                fault = str(error.items[0].outside(source))
                refused[show(value), fault].append(variable.key)
    text = "%s: variables.%s%s: %s is rejected even without other changes: %s"
    for (shown, fault), keys in refused.items():
        others = f" and {len(keys) - 1} more" if len(keys) > 1 else ""
        _LOG.warning(text, source, keys[0], others, shown, fault)


def _dotted(tables: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Give variables by dotted key; keys may be in quotes, or nested tables."""
    for key, value in tables.items():
        if isinstance(value, Mapping) and value and not {"low", "high"} & set(value):
            yield from _dotted(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _is_key(table: str, key: str, errors: ErrorList) -> bool:
    """Return True for a key of a case, or a key inside its tables; else add the error."""
    names = {_generic(name) for name in case_keys()} | _WHOLE
    generic = _generic(key)
    is_known = generic in names or any(
        "." in name and generic.startswith(f"{name}.") for name in names
    )
    fault = f"is not a key of a case{did_you_mean(generic, names)}; granwave keys lists them"
    return errors.check_first((not is_known, f"{table}.{key}", fault))


def _generic(key: str) -> str:
    """Return a key without positions in lists."""
    return ".".join(part for part in key.split(".") if not ids_of(part))


def _layers(
    value: Any, base: Mapping[str, Any], others: Collection[str], errors: ErrorList
) -> list[Variable]:
    """Return the variables of each layer, or bead of a chain: its material, and its diameter
    divided by the diameter of the packing.

    Tied layers are identical: with ``{period = 2}`` every other layer, with ``{groups = 3}`` the
    layers of each third.
    """
    packing = GRANULAR.read(base, errors.source).packing
    table = value if isinstance(value, Mapping) else {}
    lattice = packing.lattice() if packing.grains is None else None
    ends = table.get("diameters")
    tied = table.get("tied", {"groups": lattice.n_layers if lattice else 1})
    if not _layers_fit(value, tied, packing, others, errors) or lattice is None:
        return []
    ((rule, count),) = tied.items()
    identical = defaultdict(list)
    for layer in range(lattice.n_layers):
        group = layer % count if rule == "period" else layer * count // lattice.n_layers
        identical[group].append(layer)
    written: dict[str, Any] = {}
    for layers in identical.values():
        blocks = [(layer, layer) for layer in layers]
        if rule == "groups":
            blocks = [(layers[0], layers[-1])]
        ids = ",".join(_ids_of_block(lattice, top, bottom) for top, bottom in blocks)
        if "materials" in table:
            written[f"replace.{ids}.material"] = table["materials"]
        if ends is not None:
            low, high = (end * packing.diameter for end in ends)
            written[f"replace.{ids}.diameter"] = {"low": low, "high": high}
    return read_variables(written, "variables", errors)


def _layers_fit(
    value: Any, tied: Any, packing: PackingSection, others: Collection[str], errors: ErrorList
) -> bool:
    """Return True if the table ``layers`` is valid; else add its first fault."""
    key = f"variables.{LAYERS}"
    kind = f'with packing.kind = "{packing.kind}"'
    table = value if isinstance(value, Mapping) else {}
    ends = table.get("diameters")
    unknown = set(table) - {*_OF_LAYERS, "tied"}
    resized = {"packing.size", "packing.diameter"} & {name.removesuffix(".2") for name in others}
    is_range = isinstance(ends, list) and len(ends) == 2 and all(map(is_number, ends))
    return errors.check_first(
        (
            resized,
            key,
            Mismatch("together with packing.size or packing.diameter", "these keys in the base"),
        ),
        (packing.grains is not None, key, Mismatch(kind, "a base with layers")),
        (
            unknown or table.keys().isdisjoint(_OF_LAYERS),
            key,
            Mismatch(
                show(value),
                '{materials = ["steel", "ptfe"]} or {diameters = [0.4, 1.0]} (relative to '
                "packing.diameter), or both",
            ),
        ),
        (
            not _is_tie(tied),
            f"{key}.tied",
            Mismatch(
                show(tied),
                "{period = 2}, alternating layers, or {groups = 3}, three blocks of layers; "
                "default: all layers independent",
            ),
        ),
        (
            ends is not None and not packing.rule.is_chain,
            f"{key}.diameters",
            Mismatch(kind, '"chain": smaller spheres leave gaps in a lattice'),
        ),
        (
            ends is not None and not is_range,
            f"{key}.diameters",
            Mismatch(show(ends), "[smallest, largest]"),
        ),
    )


def _is_tie(tied: Any) -> bool:
    """Return True for ``{period = N}`` and ``{groups = N}``."""
    if not isinstance(tied, Mapping) or len(tied) != 1:
        return False
    ((rule, count),) = tied.items()
    return rule in ("period", "groups") and isinstance(count, int) and count >= 1


def _ids_of_block(lattice: Lattice, top: int, bottom: int) -> str:
    """Return the ids of the spheres from one layer to another, such as ``1-16``."""
    first = lattice.layer(top)[0]
    last = lattice.layer(bottom)[-1]
    return f"{first}" if first == last else f"{first}-{last}"


def _limits(tables: Any, errors: ErrorList) -> tuple[DesignLimit, ...]:
    """Read ``[limits]``; faults go into ``errors``."""
    limits = []
    if not isinstance(tables, Mapping):
        errors.add(
            "limits",
            Mismatch(show(tables), "a table of values and their upper limits"),
        )
        return ()
    for name, value in tables.items():
        if not is_value(name):
            near = did_you_mean(name, value_names())
            errors.add(
                f"limits.{name}",
                f"is not a value of summary.json, nor one of {', '.join(KNOWN_BEFORE)}{near}",
            )
            continue
        try:
            limits.append(_limit(name, value))
        except ValidationError as error:
            errors.add_wrong(f"limits.{name}", value, error)
    return tuple(limits)


def _limit(name: str, value: Any) -> DesignLimit:
    """Read a limit; raise `ValidationError` if it is invalid."""
    expected = "the largest allowed value, or {low = ..., high = ...}"
    ends = value if isinstance(value, Mapping) else {"high": value}
    if not ends or set(ends) - {"low", "high"}:
        raise ValidationError(expected)
    low = finite(ends["low"], expected) if "low" in ends else None
    high = finite(ends["high"], expected) if "high" in ends else None
    if low is not None and high is not None and high < low:
        raise ValidationError("a high that is not below the low")
    return DesignLimit(name, low, high)


def _objectives(
    table: ObjectiveTable | None, base: Mapping[str, Any], errors: ErrorList
) -> tuple[Objective, ...]:
    """Return the objectives of ``[objective]``; faults go into ``errors``."""
    if table is None:
        return ()
    names = [*table.minimise, *table.maximise]
    if not 1 <= len(names) <= 2 or len(set(names)) < len(names):
        expected = "one value, or two different values, in minimise or maximise"
        errors.add("objective", Mismatch(f"{len(names)} values", expected))
    objectives = [Objective(name, 1) for name in table.minimise]
    objectives += [Objective(name, -1) for name in table.maximise]
    bottom = base.get("boundary", {}).get("bottom", "wall") if base else "wall"
    without_target = "bar" not in base and not is_target(bottom)
    for objective in objectives:
        of_target = any(fnmatchcase(objective.name, pattern) for pattern in _OF_TARGET)
        fault = (
            f"{objective.name}: is null without a target: found boundary.bottom = {show(bottom)} "
            'in the base, expected "wall", {plate = ...}, {half_space = ...} or {bar = ...}'
        )
        errors.check((without_target and of_target, "objective", fault))
    return tuple(objectives)


def _uncertainty(
    table: Any, errors: ErrorList
) -> tuple[str | float, dict[str, tuple[float, float]], int]:
    """Return statistic, ranges by key, and replicates of ``[uncertainty]``; faults go into
    ``errors``.
    """
    if not isinstance(table, Mapping):
        errors.add("uncertainty", Mismatch(show(table), "a table"))
        return "mean", {}, 1
    names = {field.name for field in dataclasses.fields(UncertaintyTable)}
    own = read_table(
        UncertaintyTable, {key: table[key] for key in table if key in names}, "uncertainty", errors
    )
    ranges: dict[str, tuple[float, float]] = {}
    for key, written in _dotted({key: table[key] for key in table if key not in names}):
        name = _ALIASES.get(key, key)
        value = written
        if isinstance(value, Mapping) and set(value) == {"low", "high"}:
            value = [value["low"], value["high"]]
        try:
            span = _range(value)
        except ValidationError as error:
            errors.add_wrong(f"uncertainty.{key}", value, error)
            continue
        if _is_key("uncertainty", name, errors):
            errors.check((name in ranges, f"uncertainty.{key}", "is given twice"))
        ranges[name] = span
    return (own.statistic, ranges, own.replicates) if own else ("mean", ranges, 1)


def _range(value: Any) -> tuple[float, float]:
    """Read a range, or a number as a range without width; raise `ValidationError` if invalid."""
    expected = "a range [smallest, largest], or one number"
    ends = value if isinstance(value, list) else [value, value]
    if len(ends) != 2:
        raise ValidationError(expected)
    low, high = (finite(end, expected) for end in ends)
    if high < low:
        raise ValidationError(f"{expected}, the largest not below the smallest")
    return low, high


def _samples(
    problem: DesignProblem, ranges: Mapping[str, tuple[float, float]], replicates: int
) -> Iterator[dict[str, Any]]:
    """Return the changes of the case for each run of a design: values that cover the ranges evenly,
    and a seed.
    """
    varied = [key for key, (low, high) in ranges.items() if high > low]
    random = _may_be_random(problem, ranges)
    if not random and not varied:
        _LOG.warning(
            "%s: uncertainty: these packings have no random quantities, so each is run once",
            problem.path,
        )
        replicates = 1
    rng = np.random.default_rng(problem.search.seed)
    shares = {key: (rng.permutation(replicates) + 0.5) / replicates for key in varied}
    for n in range(replicates):
        drawn = {key: float(share[n]) for key, share in shares.items()}
        changes: dict[str, Any] = {
            key: low + drawn.get(key, 0.0) * (high - low) for key, (low, high) in ranges.items()
        }
        if random:
            changes[SEED] = n + 1
        yield changes


def _may_be_random(problem: DesignProblem, ranges: Mapping[str, tuple[float, float]]) -> bool:
    """Return True if the packing of the base or of a design is random."""
    middle = {key: (low + high) / 2 for key, (low, high) in ranges.items()}
    try:
        random = is_random(problem.case(with_values(problem.base, middle)))
    except InputError as error:
        path = str(problem.path)
        raise InputError(
            item.outside(path).inside(f"{path}: uncertainty") for item in error.items
        ) from None
    keys = [_generic(variable.key) for variable in problem.space.variables]
    return random or not set(keys).isdisjoint(_RANDOM)
