"""Keys of a scan file: top-level keys, and the varied values, by point."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

from granwave.analysis.studies.registry import STUDIES, find_studies, is_study_file
from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.schema import ErrorList, ValidationError, count, show
from granwave.lammps_inputs.errors import Mismatch

_MOST_POINTS = 100_000
_SHAPES = ("log", "linear")


@dataclasses.dataclass(frozen=True, kw_only=True)
class RanksBySize:
    """``ranks = {...}``: MPI ranks of a point by the number of its spheres."""

    spheres_per_rank: float = schema.number("spheres for each rank", at_least=1, default=100_000)
    most: int = count("largest number of ranks", default=1)

    def of(self, n_spheres: int) -> int:
        """Return the number of ranks for a packing."""
        return max(1, min(self.most, math.ceil(n_spheres / self.spheres_per_rank)))


_ONE_RANK = RanksBySize()
_RANKS_FORM = "a whole number from 1 up, or {spheres_per_rank = 100000, most = 8}"


def _ranks(n: int) -> RanksBySize:
    return RanksBySize(spheres_per_rank=1, most=n)


_RANKS = schema.EitherType(
    types=(
        schema.TableType(section=RanksBySize, expected=_RANKS_FORM),
        schema.CountType(form=_RANKS_FORM, finish=_ranks),
    ),
    form=_RANKS_FORM,
)
_STUDIES_FORM = f"a Python file, a study, or a list of them; studies are: {', '.join(STUDIES)}"


def _study(name: str) -> str:
    schema.refuse_if(name not in STUDIES and not is_study_file(name), _STUDIES_FORM)
    return name


#: Type of the name or path of a study, or a list of them.
STUDIES_TYPE = schema.ListType(
    item=schema.TextType(expected=_STUDIES_FORM, finish=_study), expected=_STUDIES_FORM, alone=True
)


def studies_beside(names: tuple[str, ...], path: Path, errors: ErrorList) -> tuple[str, ...]:
    """Return studies with the absolute paths of their files, which are relative to a scan or suite
    file.
    """
    found, faults = find_studies(names, path.parent)
    for fault in faults:
        errors.add("study", fault)
    return tuple(found)


TABLE_OF_KEYS = schema.OtherType(expected="a table of dotted keys of the case", kinds=("object",))
_LISTS = (
    "a list of values, {linear = [first, last, how many]} or {log = [first, last, how many]} for "
    "each key"
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class ScanHeader:
    """Top-level keys of a scan file."""

    name: str = schema.typed("name of the scan", schema.PLAIN_NAME, default="")
    case: str = schema.text("a built-in case or a case file")
    ranks: RanksBySize = schema.typed("MPI ranks of a point", _RANKS, default=_ONE_RANK)
    replicates: int = count(
        "number of runs of each point with random quantities, with seeds 1 to n", default=1
    )
    figures: bool = schema.choice(
        "also make the figures of every point", (False, True), default=False
    )
    study: tuple[str, ...] = schema.typed(
        "study, or list of studies, in the report of the scan", STUDIES_TYPE, default=()
    )

    FURTHER_KEYS: ClassVar[dict[str, Any]] = {
        "set": schema.typed("values for all points", TABLE_OF_KEYS, default=None),
        "grid": schema.typed(
            "lists of values; every combination is a point",
            schema.OtherType(expected=_LISTS, kinds=("object",)),
            default=None,
        ),
        "zip": schema.typed(
            "tables [[zip]] of values that vary together, in addition to the grid",
            schema.OtherType(expected=f"{_LISTS}, equally long", kinds=("array", "object")),
            default=None,
        ),
        "points": schema.typed(
            "tables [[points]], each a single point",
            schema.OtherType(expected=TABLE_OF_KEYS.expected, kinds=("array", "object")),
            default=None,
        ),
    }


def _values_of(value: Any) -> list[Any]:
    """Return the values of a key, from a list or a range.

    Raises
    ------
    ValidationError
        It is neither, or the list is empty.
    """
    expected = (
        "a list of values such as [1, 2, 5], or {log = [1, 100, 9]} or {linear = [0, 10, 11]}"
    )
    if isinstance(value, list):
        if not value:
            raise ValidationError("at least one value")
        return value
    if not isinstance(value, Mapping):
        raise ValidationError(f"{expected}; a value for all points belongs in [set]")
    if len(value) != 1 or not set(value) <= set(_SHAPES):
        raise ValidationError(expected)
    ((shape, limits),) = value.items()
    expected = f"{{{shape} = [first, last, how many]}}"
    numbers = limits if isinstance(limits, list) else []
    if len(numbers) != 3 or not all(
        isinstance(n, int | float) and not isinstance(n, bool) for n in numbers
    ):
        raise ValidationError(expected)
    first, last, count = numbers
    first = schema.finite(first, expected)
    last = schema.finite(last, expected)
    if not isinstance(count, int) or not 2 <= count <= _MOST_POINTS:
        raise ValidationError(f"{expected} with 2 to {_MOST_POINTS} values")
    if shape == "log" and (first <= 0 or last <= 0):
        raise ValidationError(f"{expected} with positive numbers")
    span = last - first if shape == "linear" else last / first
    if not math.isfinite(span) or (shape == "log" and not span):
        raise ValidationError(f"{expected} with a smaller range of numbers")
    shares = [k / (count - 1) for k in range(1, count - 1)]
    inner = [first + share * span if shape == "linear" else first * span**share for share in shares]
    # 14 digits, so that 0.3 in a range equals 0.3 in a list, and gives the same point
    return [first, *(float(f"{value:.14g}") for value in inner), last]


def variations_of(
    tables: Mapping[str, Any], header: ScanHeader | None, errors: ErrorList
) -> list[dict[str, Any]]:
    """Make the values of each point, by dotted key, out of [grid], [[zip]] and [[points]]; a
    product of the first two.

    Faults are added to ``errors``.
    """
    axes = [
        [{key: value} for value in values]
        for key, values in _lists(tables.get("grid", {}), "grid", errors).items()
        if values
    ]
    for n, table in enumerate(_tables(tables.get("zip", []), "zip", errors), start=1):
        zipped = _lists(table, f"zip {n}", errors)
        lengths = {key: len(values) for key, values in zipped.items()}
        if len(set(lengths.values())) > 1:
            found = ", ".join(f"{key} has {length}" for key, length in lengths.items())
            errors.add(f"zip {n}", Mismatch(f"lists of different lengths ({found})", "one length"))
        elif zipped:
            axes.append(
                [
                    dict(zip(zipped, values, strict=True))
                    for values in zip(*zipped.values(), strict=True)
                ]
            )
    single = [
        flat(table, f"points {n}", errors)
        for n, table in enumerate(_tables(tables.get("points", []), "points", errors), start=1)
    ]
    if not axes and not single and not errors.items:
        errors.add("grid", "nothing varies: expected [grid], [[zip]] or [[points]] with values")
    keys = [*itertools.chain.from_iterable(axis[0] for axis in axes)]
    for key in dict.fromkeys(key for key in keys if keys.count(key) > 1):
        errors.add(key, "varies twice; keep it in only one of [grid] and [[zip]]")
    count = ((math.prod(map(len, axes)) if axes else 0) + len(single)) * (
        header.replicates if header else 1
    )
    if count > _MOST_POINTS:
        errors.add("grid", Mismatch(f"{count} points", f"at most {_MOST_POINTS}"))
    if errors.items:
        return []
    points = list[dict[str, Any]]()
    for parts in itertools.product(*axes) if axes else ():
        point = dict[str, Any]()
        for part in parts:
            point |= part
        points.append(point)
    return points + single


def _tables(value: Any, name: str, errors: ErrorList) -> list[Mapping[str, Any]]:
    if isinstance(value, Mapping):
        value = [value]
    if not isinstance(value, list) or not all(isinstance(table, Mapping) for table in value):
        errors.add(name, Mismatch(show(value), f"tables [[{name}]]"))
        return []
    for n, table in enumerate(value, start=1):
        if not table:
            errors.add(f"{name} {n}", Mismatch("an empty table", "keys and values"))
    return value


def flat(table: Any, name: str, errors: ErrorList) -> dict[str, Any]:
    """Keys and values with dotted keys, whether they were written with quotes or without."""
    if not isinstance(table, Mapping):
        errors.add(name, Mismatch(show(table), "a table of keys and values"))
        return {}
    flat: dict[str, Any] = {}
    for key, value in table.items():
        if not all(part.isidentifier() or part.isdigit() for part in key.split(".")):
            errors.add(name, Mismatch(f"the key {show(key)}", "one such as load.velocity"))
            continue
        whole_table = "." in key or (
            key == "material" and isinstance(value, Mapping) and "preset" in value
        )
        if isinstance(value, Mapping) and not whole_table and not set(value) & {*_SHAPES}:
            flat |= {f"{key}.{inner}": held for inner, held in value.items()}
        else:
            flat[key] = value
    return flat


def _lists(table: Any, name: str, errors: ErrorList) -> dict[str, list[Any]]:
    lists = {}
    for key, value in flat(table, name, errors).items():
        try:
            lists[key] = _values_of(value)
        except ValidationError as error:
            errors.add_wrong(f"{name}: {key}", value, error)
    return lists
