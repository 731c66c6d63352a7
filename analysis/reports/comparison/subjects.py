"""Runs of a comparison, with distinct labels."""

from __future__ import annotations

import contextlib
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from granwave.analysis.document.model import named, show
from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.formatting.numbers import quantity_in, size_text
from granwave.analysis.formatting.values import as_label, distinct, unit_in_cases
from granwave.analysis.reports.comparison.grain_ids import short_ids
from granwave.analysis.reports.comparison.replicates import is_of_random_packing, replicate_sets
from granwave.analysis.reports.kinds import ReportRun
from granwave.analysis.reports.setting import (
    KIND_OF_PACKING,
    applied_value,
    differing,
    ids_of,
    is_nothing,
    load_in_words,
    origin_of,
)
from granwave.analysis.result.reader import Result
from granwave.analysis.scans.result import SEED
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.run_directory import RESULT_FILE

MOST_SIDE_BY_SIDE = 6  # runs with a column each in a table
MOST_CURVES = 12  # runs in a figure of curves
_NO_PHYSICS = ("run.", "output.", "figures.", "sensor")  # keys that labels omit
_MATERIAL = "material.name"
_NONE_AT_ZERO = ("contact.initial_overlap",)  # keys whose value 0 means that the feature is absent
_REPLACED = "replace"  # key of replaced grains ...
_DIAMETER = "diameter"
_INDEX = "index"  # ... and of their ids
NONE_REPLACED = "none replaced"  # in the label of a run without replaced grains ...
NONE_FURTHER = "no others replaced"  # ... and of a run with those of all runs only
_LONGEST_REPLACEMENT = 30  # characters of replaced grains that a label lists
_OF_MATERIAL = "material."
_OF_BOUNDARY = "boundary."
_BOTTOM = "boundary.bottom"
_OF_BAR = "bar."
_BAR = "bar.length"  # the key that names a bar in a label
_LOAD = "load"  # in place of the keys of the load, if its kind or its strikers differ
_OF_LOAD = "load."
_KIND_OF_LOAD = "load.kind"
_STRIKERS = "striker"
#: Beginnings of the keys of a label, in their order; other keys follow.
_ORDER = (
    (KIND_OF_PACKING,),
    (_OF_MATERIAL,),
    (_LOAD,),
    ("packing.",),
    (_OF_BOUNDARY, _OF_BAR),
)
_CLEAR = ("packing.size", "packing.diameter", "load.velocity")  # keys known by their units
_PAIR = 2
_MOST_KEYS = 3  # in a label
_LONGEST = 44  # characters of a label
_LONGEST_VALUE = 24  # characters of a value in a label
_EARLY = 0.5  # end time / latest end, below which a label states the end of a run
_BETWEEN_DIFFERENCES = ", "
_BETWEEN_WORDS = r"[-_ /]"  # separators in the name of a run
_PRONOUNS = (("it has ", "they have "), ("it is a ", "each is a "), ("it ", "they "))
_POINT = r"(.+) #\d+"  # name of a point of a scan, which says nothing about its case
_SEED_TEXT = r"seed \d+"  # of a random packing, in a label
_KILO = 1e3
_MOST_LISTED = 4  # runs that a sentence lists; of more the first and the last
_LEAST_RANGE = 3  # runs in a row that are named by the first and the last


class LackingError(GranwaveError, ValueError):
    """Error of a run that has no such curve or field; the message is the reason."""


@dataclass(frozen=True, eq=False)
class ComparedRun:
    """A run of a comparison.

    Attributes
    ----------
    run
        The run, as a report reads it.
    label
        Its label in figures: its name and the differences of its case.
    number
        Its position among the runs, from 0.
    look
        Number of its colour and line, from 0, which are the same in all figures.
    set_number
        Position of the first run of its replicates; its own position without replicates.
    is_random
        True if its packing depends on the seed.
    is_repeated
        True for a replicate that figures leave out, since they show another one of its set.
    """

    run: ReportRun
    label: str
    number: int
    look: int
    set_number: int = 0
    is_random: bool = False
    is_repeated: bool = False

    @property
    def name(self) -> str:
        """Its name in tables and sentences."""
        return self.run.label

    @property
    def has_spheres(self) -> bool:
        """True for a run of spheres."""
        return self.run.kind.of_spheres

    @contextlib.contextmanager
    def opened(self) -> Iterator[Result]:
        """Open the result of a run of spheres within a ``with`` block.

        Raises
        ------
        LackingError
            It is no run of spheres, its result.h5 is missing or damaged, or lacks a data set.
        """
        if not self.has_spheres:
            raise LackingError(f"it is a {self.run.kind.noun}, without grains")
        try:
            with Result(self.run.results) as result:
                yield result
        except MissingOutputError:
            raise LackingError(f"it has no {RESULT_FILE}") from None
        except OutputFormatError:
            raise LackingError(f"its {RESULT_FILE} does not contain it, or is damaged") from None
        except GranwaveError as error:
            if isinstance(error, LackingError):
                raise
            raise LackingError(f"its case cannot be read: {error}") from None
        except KeyError as error:  # an id
            raise LackingError(f"its {RESULT_FILE} lacks grains of its case: {error}") from None

    @property
    def unfinished(self) -> str:
        """Reason why its results end early; empty for a finished run."""
        return self.run.stopped


def compared_runs(runs: Sequence[ReportRun]) -> list[ComparedRun]:
    """Return the runs with their labels, each of which is used once."""
    texts = _texts(runs)
    names = _names(runs, texts)
    labels: list[str] = []
    for name, text in zip(names, texts, strict=True):
        is_said = text == name or not text
        label = _shortened(name if is_said else _with_differences(name, text))
        labels.append(distinct(label, labels))
    random = list(map(is_of_random_packing, runs))
    sets = replicate_sets(runs, random)
    leaders: dict[int, int] = {}
    for members in sets:
        leaders |= dict.fromkeys(members, members[0])
    is_reduced = len(runs) > MOST_SIDE_BY_SIDE and len(sets) > 1
    repeated = [is_reduced and leaders[place] != place for place in range(len(runs))]
    drawn_first = sorted(drawn_places(repeated, MOST_CURVES))
    others = [place for place in range(len(runs)) if place not in drawn_first]
    looks = {place: look for look, place in enumerate([*drawn_first, *others])}
    return [
        ComparedRun(
            run,
            labels[place],
            place,
            looks[place],
            leaders[place],
            random[place],
            repeated[place],
        )
        for place, run in enumerate(runs)
    ]


def _names(runs: Sequence[ReportRun], texts: Sequence[str]) -> list[str]:
    """Return the names of the runs in their labels: their numbers, if they are points of one scan
    and their labels are too long with its name.
    """
    names = [run.label for run in runs]
    points = [re.fullmatch(_POINT, name) for name in names]
    scans = {point.group(1) if point else "" for point in points}
    whole = [f"{name}: {text}" for name, text in zip(names, texts, strict=True)]
    if len(scans) > 1 or "" in scans or max(map(len, whole), default=0) <= _LONGEST:
        return names
    scan = scans.pop()
    return [name.removeprefix(f"{scan} ") for name in names]


def _with_differences(name: str, text: str) -> str:
    """Return a label of the name and of as many differences of the case as it has room for; the
    seed, which is the last one, is left out without an ellipsis.
    """
    parts = text.removesuffix(f"{_BETWEEN_DIFFERENCES}…").split(_BETWEEN_DIFFERENCES)
    label = f"{name}: {text}"
    if len(label) > _LONGEST and len(parts) > 1 and re.fullmatch(_SEED_TEXT, parts[-1]):
        parts.pop()
        label = f"{name}: {_BETWEEN_DIFFERENCES.join(parts)}"
    while len(label) > _LONGEST and len(parts) > 1:
        parts.pop()
        label = f"{name}: {_BETWEEN_DIFFERENCES.join(parts)}, …"
    return label


def drawn_places(repeated: Sequence[bool], most: int) -> list[int]:
    """Return the positions of the runs that a figure shows, if all have data; without replicates
    of others.

    Parameters
    ----------
    repeated
        True for runs that are left out, since others of their replicates are drawn: (n_runs,).
    most
        Largest number of runs that a figure shows.
    """
    return places_in_order(repeated, most)[:most]


def places_in_order(repeated: Sequence[bool], most: int) -> list[int]:
    """Return the positions of the runs without replicates of others, in the order of
    `spread_first`; parameters as of `drawn_places`.
    """
    places = [place for place, is_repeated in enumerate(repeated) if not is_repeated]
    return [places[n] for n in spread_first(len(places), most)]


def spread_first(n_runs: int, most: int) -> list[int]:
    """Return the positions of runs, starting with ``most`` evenly spaced ones from first to last.

    Parameters
    ----------
    n_runs
        Number of runs.
    most
        Largest number of runs that a figure shows.
    """
    if n_runs <= most:
        return list(range(n_runs))
    places = np.linspace(0, n_runs - 1, most).round().astype(int).tolist()
    others = [place for place in range(n_runs) if place not in places]
    return [*places, *others]


def names_with_cases(runs: Sequence[ComparedRun]) -> list[str]:
    """Return the names of runs; with their cases if there are more runs than a table shows side by
    side.
    """
    if len(runs) > MOST_SIDE_BY_SIDE:
        return [run.label for run in runs]
    return [run.name for run in runs]


def names_in_words(names: Sequence[str]) -> str:
    """Return names in a sentence; for many names the first and the last."""
    if len(names) > _MOST_LISTED:
        return f"{names[0]} to {names[-1]} ({len(names)} runs)"
    if len(names) == 1:
        return names[0]
    return f"{', '.join(names[:-1])} and {names[-1]}"


def joined_texts(texts: Sequence[tuple[str, str]], between: str) -> str:
    """Return texts with the names of the runs that have them, each text once: ``2 mm in a and b,
    3 mm in c``.

    Parameters
    ----------
    texts
        Name and text of each run.
    between
        Word between a text and the names.
    """
    names: dict[str, list[str]] = {}
    for name, text in texts:
        names.setdefault(text, []).append(name)
    return ", ".join(f"{text} {between} {names_in_words(runs)}" for text, runs in names.items())


def by_reason(lacking: Mapping[ComparedRun, str]) -> str:
    """Return runs with the reasons for which they lack a curve, each reason once.

    Runs that follow one another are a range: ``a, b #3 to b #9 (only 12 runs are drawn)``.
    """
    groups: dict[str, list[ComparedRun]] = {}
    for run, why in lacking.items():
        groups.setdefault(why, []).append(run)
    texts = [
        f"{ranges_of(runs)} ({why if len(runs) == 1 else _of_several(why)})"
        for why, runs in groups.items()
    ]
    return "; ".join(texts)


def _of_several(reason: str) -> str:
    """Return the reason of several runs, which is in words for one run: ``they have no ...``."""
    for one, several in _PRONOUNS:
        if reason.startswith(one):
            reason = f"{several}{reason.removeprefix(one)}"
            break
    return re.sub(r"\bits\b", "their", reason)


def ranges_of(runs: Sequence[ComparedRun]) -> str:
    """Return the names of runs; for three or more consecutive runs, the first and the last."""
    groups: list[list[ComparedRun]] = []
    for run in sorted(runs, key=lambda run: run.number):
        if groups and run.number == groups[-1][-1].number + 1:
            groups[-1].append(run)
        else:
            groups.append([run])
    parts: list[str] = []
    for group in groups:
        names = [run.name for run in group]
        is_range = len(names) >= _LEAST_RANGE
        parts += [f"{names[0]} to {names[-1]}"] if is_range else names
    return named(parts, len(parts))


def physical_keys(runs: Sequence[ReportRun]) -> list[str]:
    """Return the keys that differ and change the physics; for different materials their name."""
    keys = [key for key in differing(runs) if is_physical(key)]
    if _MATERIAL not in keys:
        return keys
    return [key for key in keys if not key.startswith(_OF_MATERIAL) or key == _MATERIAL]


def comparable_keys(keys: Sequence[str], runs: Sequence[ReportRun]) -> list[str]:
    """Return the keys that every case has, and those that differ between runs of one kind."""
    shown = set(keys).intersection(*(run.case for run in runs))
    for kind in {run.kind for run in runs}:
        shown |= set(differing([run for run in runs if run.kind is kind]))
    return [key for key in keys if key in shown]


def is_physical(key: str) -> bool:
    """Return False for keys of output and run control."""
    return not key.startswith(_NO_PHYSICS)


def value_text(key: str, case: Mapping[str, Any], *, missing: str = "none") -> str:
    """Return the value of a key of a case in words: ``10 m/s``, ``12 x 12 x 8``, ``steel``."""
    value = applied_value(key, case)
    if key == KIND_OF_PACKING:
        value = origin_of(case) or value
    is_none = value == 0 and key in _NONE_AT_ZERO
    if value is None or value == "" or is_none:
        return missing
    if isinstance(value, str) and "\n" in value:
        return f"table of {len(value.splitlines()) - 1} rows"
    if key == _REPLACED and isinstance(value, list):
        return ", ".join(_replacement(table) for table in value)
    if isinstance(value, list) and any(isinstance(part, Mapping) for part in value):
        value = [_without_nothing(part) for part in value]
    if isinstance(value, list | tuple) and all(isinstance(part, int) for part in value):
        return size_text(value)
    unit = unit_in_cases(key, [case])
    if isinstance(value, bool):
        return show(value)
    if isinstance(value, float | int) and unit:
        return _with_unit(value, unit)
    return as_label(value)


def _replacement(table: Mapping[str, Any]) -> str:
    """Return an entry of ``[[replace]]`` in words: ``aluminium at 3 to 4``."""
    changes = [
        quantity_in(value, "m") if name == _DIAMETER else as_label(value)
        for name, value in table.items()
        if name != _INDEX
    ]
    return f"{', '.join(changes)} {short_ids(ids_of(table.get(_INDEX)))}"


def _without_nothing(entry: Any) -> Any:
    """Return an entry of a list of tables without zeros and empty values."""
    if not isinstance(entry, Mapping):
        return entry
    return {name: value for name, value in entry.items() if not is_nothing(value)}


def _with_unit(value: float, unit: str) -> str:
    """Return a number with its unit, which has a prefix if it is a simple unit."""
    if unit.isalpha() and unit != "kg":
        return quantity_in(value, unit)
    if unit == "m/s" or 1 / _KILO <= abs(value) < _KILO:
        return f"{value:g} {unit}"
    return f"{show(float(value))} {unit}"


def _texts(runs: Sequence[ReportRun]) -> list[str]:
    """Return the differences of the case of each run, in a few words that are not in its name; an
    ellipsis stands for further differences.
    """
    with_case = [run for run in runs if run.case]
    keys = physical_keys(with_case) if len(with_case) > 1 else []
    if len({run.kind for run in runs}) > 1:
        keys = comparable_keys(keys, with_case)
    keys = [key for key in keys if not _has_table(key, runs)]
    keys = _with_one_key_of_bar(keys)
    keys = _with_one_key_of_load(keys)
    keys.sort(key=_order_in_label)
    values = {key: _value_texts(key, runs) for key in keys}
    usual = {key: _usual(of_runs) for key, of_runs in values.items()}
    ends = [_end_of(run) for run in runs]
    texts: list[str] = []
    for place, run in enumerate(runs):
        parts = {
            key: _fitting(key, of[place], run.case)
            for key, of in values.items()
            if of[place] != usual[key]
        }
        in_name = re.split(_BETWEEN_WORDS, run.label)
        said = [
            _with_name(key, part) for key, part in parts.items() if part and part not in in_name
        ]
        if not said and re.fullmatch(_POINT, run.label):
            said = [_with_name(key, "0") for key in parts if _is_zero(run.case.get(key))]
        if not said and 0 < ends[place] < _EARLY * max(ends):
            said = [f"until {quantity_in(ends[place], 's')}"]
        if not said and not parts and len(runs) > _PAIR:  # it has the usual values
            said = _usual_in_words(values, place, run)
        more = ["…"] if len(said) > _MOST_KEYS else []
        texts.append(_BETWEEN_DIFFERENCES.join([*said[:_MOST_KEYS], *more]))
    return texts


def _usual_in_words(values: Mapping[str, Sequence[str]], place: int, run: ReportRun) -> list[str]:
    """Return the values of the differing keys of a run with the usual ones; none if its name has
    one of them, and of a point of a scan.

    Parameters
    ----------
    values
        Values of the differing keys in words, by run.
    place
        Position of the run.
    """
    parts = {key: _fitting(key, of_runs[place], run.case) for key, of_runs in values.items()}
    in_name = set(re.split(_BETWEEN_WORDS, run.label))
    if in_name.intersection(parts.values()) or re.fullmatch(_POINT, run.label):
        return []
    return [_with_name(key, part) for key, part in parts.items() if part]


def _end_of(run: ReportRun) -> float:
    """Return the end time of the case of a run, s; 0 without a number."""
    end = run.case.get("run.end_time")
    return float(end) if isinstance(end, int | float) else 0.0


def _fitting(key: str, text: str, case: Mapping[str, Any]) -> str:
    """Return the value of a key, of a long table its first name, ``plate``; empty if it does not
    fit into a label.
    """
    longest = _LONGEST if key in (_REPLACED, _LOAD) else _LONGEST_VALUE
    if len(text) <= longest:
        return text
    first = re.split(r"[ ,]", text)[0]
    return first if isinstance(case.get(key), Mapping) and len(first) <= longest else ""


def _is_zero(value: Any) -> bool:
    """Return True for a number 0, such as the diameter scatter of a regular packing."""
    return isinstance(value, int | float) and not isinstance(value, bool) and value == 0


def _has_table(key: str, runs: Sequence[ReportRun]) -> bool:
    """Return True if the value of a key of any run is a table of several lines."""
    return any("\n" in str(run.case.get(key)) for run in runs)


def _value_texts(key: str, runs: Sequence[ReportRun]) -> list[str]:
    """Return the value of a key of each run in words; empty where it is missing or zero.

    Of replaced grains these are the entries that some runs lack.
    """
    if key == _REPLACED:
        return _replacement_texts(runs)
    if key == _LOAD:
        return [load_in_words(run.case) for run in runs]
    return [
        "" if _is_left_out(key, run.case) else value_text(key, run.case, missing="") for run in runs
    ]


def _is_left_out(key: str, case: Mapping[str, Any]) -> bool:
    """Return True for a value that is missing or zero, and for the bottom of a chain on a bar."""
    return is_nothing(case.get(key)) or (key == _BOTTOM and _BAR in case)


def _with_one_key_of_bar(keys: Sequence[str]) -> list[str]:
    """Return the keys without the other keys of a bar next to its length."""
    if _BAR not in keys:
        return list(keys)
    return [key for key in keys if key == _BAR or not key.startswith(_OF_BAR)]


def _with_one_key_of_load(keys: Sequence[str]) -> list[str]:
    """Return the keys with one key for the load, if its kind or its strikers differ."""
    if not {_KIND_OF_LOAD, _STRIKERS}.intersection(keys):
        return list(keys)
    return [*(key for key in keys if key != _STRIKERS and not key.startswith(_OF_LOAD)), _LOAD]


def _order_in_label(key: str) -> int:
    """Return the order of a key in a label: kind of packing, material and load before the size,
    then the support and the law, and the seed last, so that short labels omit it first.
    """
    if key == SEED:
        return len(_ORDER) + 1
    for order, beginnings in enumerate(_ORDER):
        if key.startswith(beginnings):
            return order
    return len(_ORDER)


def _replacement_texts(runs: Sequence[ReportRun]) -> list[str]:
    """Return the replaced grains of each run that some other run does not have."""
    tables = [run.case.get(_REPLACED) or () for run in runs]
    entries = [list(map(_replacement, of_run)) for of_run in tables]
    shared = set(entries[0]).intersection(*entries)
    texts: list[str] = []
    for of_run in entries:
        own = [text for text in of_run if text not in shared]
        nothing = NONE_FURTHER if of_run else NONE_REPLACED
        text = " and ".join(own) or nothing
        if len(text) > _LONGEST_REPLACEMENT:
            text = f"{own[0]} and {len(own) - 1} more"
        texts.append(text)
    return texts


def _with_name(key: str, text: str) -> str:
    """Return the value of a key in a label: with the name of the key for a boundary, for a number
    without a unit, and for a unit that does not identify the key.
    """
    if key in (_REPLACED, _LOAD):
        return text
    if key == _BAR:
        return f"bar of {text}"
    is_bare = re.fullmatch(r"[-+.\de]+", text) is not None
    is_unclear = text[:1].isdigit() and key not in _CLEAR
    if is_bare or is_unclear or key.startswith(_OF_BOUNDARY):
        return f"{key.rpartition('.')[2].replace('_', ' ')} {text}"
    return text


def _usual(values: Sequence[str]) -> str | None:
    """Return the value of most runs, which labels omit; None if there is none."""
    text, count = Counter(values).most_common(1)[0]
    return text if 2 * count > len(values) else None


def _shortened(label: str) -> str:
    """Return a label, shortened in the middle if it is long."""
    if len(label) <= _LONGEST:
        return label
    half = _LONGEST // 2 - 1
    return f"{label[:half]}…{label[-half:]}"
