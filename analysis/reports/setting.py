"""Setting of the runs of a report: its first line, symbols of its figures, tables of shared
settings, versions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from granwave.analysis.document.model import Block, Group, Note, show, text_table
from granwave.analysis.formatting.numbers import quantity_in, range_in, size_text
from granwave.analysis.formatting.values import grains_called_in, unit_in_cases
from granwave.analysis.reports.inputs import ReportInputs, ReportScan
from granwave.analysis.reports.kinds import ReportRun, Symbol, report_kinds
from granwave.lammps_inputs.case.boundary import SUPPORTS
from granwave.lammps_inputs.case.contact.contact import ALL_LAWS
from granwave.lammps_inputs.case.contact.law_parameters import PARAMETERS
from granwave.lammps_inputs.case.loads.impact import ImpactLoad
from granwave.lammps_inputs.case.loads.load import Wording
from granwave.lammps_inputs.case.loads.registry import load_kinds
from granwave.lammps_inputs.case.precompression import STATIC_LOADS
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.files import read_tables
from granwave.lammps_inputs.lattices import kind_names, kind_of
from granwave.lammps_inputs.load_case import stored_case
from granwave.lammps_inputs.packing.cylinders import in_grains
from granwave.lammps_inputs.packing_kind import PackingKind
from granwave.lammps_inputs.run_directory import CASE_FILE

_MOST_NAMED = 4  # inputs that the first line describes one by one
_TWO = 2  # packings whose values are given by name
_MOST_SYMBOLS = 12  # most runs from which the constants of symbols are read
_LAWS = {"elastoplastic": "", "hertz": "elastic", "line": "elastic"}  # the default needs no word
IDEAL = "ideal"  # packing without imperfections, in the first line of a report
_NOT_IDEAL = {  # keys of cases that are zero or absent in an ideal packing: text and unit
    "contact.friction": ("friction {}", ""),
    "packing.diameter_scatter": ("diameters scattered by {}", "m"),
    "packing.vacancies": ("vacancies {}", ""),
    "contact.loss": ("viscous damping of contacts", ""),
    "contact.rolling": ("resistance to rolling", ""),
    "contact.twisting": ("resistance to twisting", ""),
    "contact.cohesion": ("cohesion", ""),
    "contact.initial_overlap": ("initial plastic indentations", ""),
    "replace": ("some spheres replaced", ""),
}
_NORMALISED = (
    "the normalised velocity, (2/sqrt 3) (2/(1.6 pi))^2 E*^2 sqrt(rho) sigma_y^-2.5 v, with E* of two grains, density "
    "rho and yield strength sigma_y"
)
_OF_LAW = ("material", "contact", "packing.diameter", "packing.shape", "packing.length")
_CONTACT = "contact"
_MATERIAL = "material"
_YIELD_STRENGTH = "yield_strength"
_PAIRS = "pair"  # tables of laws between two materials
_LAW = "law"
KIND_OF_PACKING = "packing.kind"
ORIGIN = "packing.source"
_SIDES = {"periodic": "periodic sides", "wall": "side walls"}
_OF_GRAVITY = ("precompression.acceleration", "precompression.strikers")
_SCATTER = "packing.diameter_scatter"
_OF_SCATTER = ("packing.scatter_distribution",)
_SEED = "packing.seed"
#: Keys of lattices that make a packing, or the position of a striker, depend on the seed.
_RANDOM = (_SCATTER, "packing.vacancies", "replace", "striker")
_REMARKS = ("material.source",)  # keys of the case that do not affect results


def first_line(inputs: ReportInputs) -> str:
    """Describe the runs: few inputs one by one, many by their common values; empty if nothing is
    known.
    """
    if len(inputs.items) == 1:
        return _of_item(inputs.items[0])
    if len(inputs.items) <= _MOST_NAMED:
        told = [(item.label, _of_item(item)) for item in inputs.items]
        return "; ".join(f"{label} ({text})" if text else label for label, text in told)
    return setting_of(_shared(list(inputs.results())))


def setting_of(case: Mapping[str, Any], called: str = "spheres") -> str:
    """Describe a case, by dotted keys, in a line; unknown values are omitted.

    Parameters
    ----------
    called
        Name of its grains.
    """
    diameter = case.get("packing.diameter")
    parts = [
        _body(case),
        _sides(case),
        _materials(case),
        quantity_in(diameter, "m") if isinstance(diameter, float | int) else "",
        load_in_words(case),
        _static(case),
        _bottom(case),
        *_contacts(case),
    ]
    return in_grains(", ".join(filter(None, parts)), called)


_VOWELS = "aeiou"
_MOST_MATERIALS = 3  # these are named, others are counted


def _materials(case: Mapping[str, Any]) -> str:
    """Return the names of the materials in the packing, or their number."""
    names = _names_of_materials(case)
    if len(names) > _MOST_MATERIALS:
        return f"{len(names)} materials"
    return " and ".join(names)


def _names_of_materials(case: Mapping[str, Any]) -> list[str]:
    """Return the names of the materials in the packing: its own material, unless every sphere is
    replaced, and the materials of ``[[replace]]``.
    """
    names = {str(case.get("material.name") or case.get("material") or ""): None}
    replaced: set[int] = set()
    for entry in case.get("replace") or ():
        if isinstance(entry, Mapping) and (other := _name_of(entry.get("material"))):
            names[other] = None
            replaced |= ids_of(entry.get("index"))
    size = case.get("packing.size")
    if len(replaced) == math.prod(size if isinstance(size, list | tuple) else [size or -1]):
        del names[next(iter(names))]
    return [name for name in names if name]


def _name_of(material: Any) -> str:
    """Return the name of a material that is named or a table; empty if there is none."""
    if isinstance(material, Mapping):
        return str(material.get("name") or "")
    return str(material or "")


def ids_of(index: Any) -> set[int]:
    """Return the ids of an index of ``[[replace]]``: one, a list, or first, last and step."""
    if isinstance(index, Mapping):
        return set(range(index["first"], index["last"] + 1, index.get("step", 1)))
    if isinstance(index, list):
        return set(index)
    if isinstance(index, int):
        return {index}
    return set()


def symbols_note(inputs: ReportInputs, uses: Callable[[str], bool] | None = None) -> list[Note]:
    """Define the symbols in which figures and tables of these runs give forces, energies and
    velocities.

    Parameters
    ----------
    uses
        Function that returns True for a symbol that the report uses; by default for all.
    """
    runs = [run for run in inputs.whole() if run.has_balance][:_MOST_SYMBOLS]
    packings = [run for run in runs if run.kind.of_spheres]
    unlike = {
        str([item for item in run.case.items() if item[0].startswith(_OF_LAW)]): run
        for run in packings
    }
    laws = [
        law
        for law in map(_law_of, unlike.values())
        if law is not None and math.isfinite(law.yield_force)
    ]
    largest, given = (
        [run.number(key) or 0.0 for run in packings] for key in ("peak_force_N", "energy_input_J")
    )
    velocities = [run.number("velocity_normalised") for run in packings]
    put_in = "the energy input"
    if any(run.number("dissipated_fraction") for run in packings):
        put_in += ", and e_dis the dissipated energy"
    called = grains_called_in([run.summary for run in packings])
    two = f"two {called}{_of_material([run.case for run in unlike.values()])}"
    rows: list[Symbol] = [
        ("F_y", [law.yield_force for law in laws], "N", f"the force at which a contact of {two} first yields"),
        ("alpha_y", [law.yield_overlap for law in laws], "m", "the overlap at first yield"),
        ("F_y alpha_y", [law.yield_force * law.yield_overlap for law in laws], "J", "the unit of energies"),
        ("F_max", largest if not laws and any(largest) else (), "N", f"the largest force between two {called} in the run"),
        ("e_in", given if all(given) else (), "J", put_in),
        ("v\u0304_0", [one for one in velocities if one is not None], "", _NORMALISED),
    ]  # fmt: skip
    for kind in report_kinds():
        rows += kind.symbols([run for run in runs if run.kind is kind])
    names = [run.label for run in packings]
    said = [
        f"{symbol} = {_values_in(values, unit, names)} is {what}."
        for symbol, values, unit, what in rows
        if values and (uses is None or uses(symbol))
    ]
    return [Note(" ".join(said))] if said else []


def _of_material(cases: Sequence[Mapping[str, Any]]) -> str:
    """Return the material of the contacts whose constants are given, if a packing has several;
    empty otherwise.
    """
    if all(len(_names_of_materials(case)) <= 1 for case in cases):
        return ""
    own = [_name_of(case.get("material.name") or case.get(_MATERIAL)) for case in cases]
    return f" of {' or '.join(dict.fromkeys(filter(None, own)))}".removesuffix(" of ")


def _values_in(values: Sequence[float], unit: str, names: Sequence[str]) -> str:
    """Return the range of a value in words; for two packings that differ, the value of each.

    Parameters
    ----------
    names
        Names of the packings: (n_packings,).
    """
    texts = [range_in([value], unit) for value in values]
    if len(names) != _TWO or len(texts) != _TWO or texts[0] == texts[1]:
        return range_in(values, unit)
    first, second = [f"{text} ({name})" for text, name in zip(texts, names, strict=True)]
    return f"{first} and {second}"


def _of_item(item: ReportRun | ReportScan) -> str:
    if isinstance(item, ReportRun):
        said = item.kind.setting(item)
        return said or setting_of(item.case, grains_called_in([item.summary]))
    runs = [point.run for point in item.points if point.run]
    text = setting_of(_shared(runs), grains_called_in([run.summary for run in runs]))
    varied = f"{', '.join(item.source.varied)} varied" if item.source.varied else ""
    return "; ".join(filter(None, (text, varied)))


def _shared(runs: Sequence[ReportRun]) -> dict[str, Any]:
    if not runs:
        return {}
    return {
        key: value
        for key, value in runs[0].case.items()
        if all(run.case.get(key) == value for run in runs)
    }


def _body(case: Mapping[str, Any]) -> str:
    for report_kind in report_kinds():
        if body := report_kind.body(case):
            return body
    kind = case.get("packing.kind")
    size = case.get("packing.size")
    if kind is None:
        return ""
    rule = packing_rule(case)
    if rule is not None and not rule.is_lattice:
        return _grains_of(case)
    shape = size_text(size) if isinstance(size, list) else "" if size is None else str(size)
    if shape and is_chain(case):
        return f"chain of {shape}"
    return f"{kind} {shape}".rstrip()


def _sides(case: Mapping[str, Any]) -> str:
    """Return the kind of sides; empty for free ones."""
    return _SIDES.get(str(case.get("boundary.sides")), "")


def _grains_of(case: Mapping[str, Any]) -> str:
    """Return the origin and number of grains at user-defined positions: ``poured packing of 200
    spheres``.
    """
    source = origin_of(case)
    table = case.get("packing.grains")
    number = f"{len(table.splitlines()) - 1} spheres" if isinstance(table, str) else "grains"
    if " " in source:
        return source
    if not source or Path(source).suffix:
        return f"packing of {number} of {source or 'a file'}"
    return f"{source} packing of {number}"


def origin_of(case: Mapping[str, Any]) -> str:
    """Return the origin of grains at user-defined positions: the name of a file, or of the way in
    which they were made; empty for a lattice, or if it is not recorded.
    """
    return str(case.get(ORIGIN) or "")


def packing_rule(case: Mapping[str, Any]) -> PackingKind | None:
    """Return the properties of the kind of packing of a case, by dotted keys; None without one."""
    kind = case.get("packing.kind")
    return kind_of(kind) if kind in kind_names() else None


def is_chain(case: Mapping[str, Any]) -> bool:
    """Return True for a case, by dotted keys, whose packing is a chain."""
    rule = packing_rule(case)
    return rule is not None and rule.is_chain


def load_in_words(case: Mapping[str, Any]) -> str:
    """Return the load of a case, by dotted keys: ``5 m/s``, ``struck by steel, 20 mm, 1 m/s``;
    empty if it is unknown.
    """
    load = load_kinds().get(str(case.get("load.kind")), ImpactLoad)
    keys: dict[str, Any] = {}
    for kind in report_kinds():
        keys |= kind.load_keys(case)
    return load.phrase({**keys, **case}, Wording(quantity_in, show))


def _static(case: Mapping[str, Any]) -> str:
    kind = case.get("precompression.kind")
    if kind is None:
        return ""
    for key, unit in (("pressure", "Pa"), ("force", "N")):
        if isinstance(size := case.get(f"precompression.{key}"), float | int):
            return f"under {quantity_in(size, unit)}"
    load = STATIC_LOADS.get(kind)
    return "precompressed" if load is None else load.phrase


def _bottom(case: Mapping[str, Any]) -> str:
    support = target_of(case)
    bottom = case.get("boundary.bottom")
    if not support or not isinstance(bottom, dict):
        return ""
    name = f"{bottom.get('material', {}).get('name', '')} {support.replace('_', '-')}".lstrip()
    mass = bottom[support].get("mass")
    article = "an" if name[:1].lower() in _VOWELS else "a"
    where = f"on {article} {name}"
    return where if mass is None else f"{where} of {show(mass)} kg"


def target_of(case: Mapping[str, Any]) -> str:
    """Return the support of the bottom: plate, half_space, bar or damper; empty for a wall or
    none.
    """
    bottom = case.get("boundary.bottom")
    tables = bottom if isinstance(bottom, dict) else {}
    return next((name for name in SUPPORTS if isinstance(tables.get(name), dict)), "")


def _contacts(case: Mapping[str, Any]) -> list[str]:
    """Return the law, unless it is the default, and the imperfections; empty if
    unknown.
    """
    law = case.get("contact.law")
    there = [
        text.format(quantity_in(value, unit) if unit and isinstance(value, float) else show(value))
        for key, (text, unit) in _NOT_IDEAL.items()
        if (value := case.get(key))
    ]
    known = all(key in case for key in ("contact.friction", "packing.diameter_scatter"))
    return ["" if law is None else _LAWS.get(law, str(law)), *(there or [IDEAL] * known)]


def _law_of(run: ReportRun) -> Any:
    tables = read_tables(run.directory / CASE_FILE)
    try:
        case = None if tables is None else stored_case(tables, run.directory / CASE_FILE)
        return sphere_contact(case) if case is not None and case.contact.yields else None
    except (GranwaveError, TypeError, AttributeError):
        return None


def settings_blocks(inputs: ReportInputs) -> list[Block]:
    """Make tables of the settings that runs share, for each scan and for the runs given directly."""
    groups: list[tuple[str, Sequence[ReportRun | None], Sequence[str]]] = [
        (f"scan {scan.label}", [point.run for point in scan.points], scan.source.varied)
        for scan in inputs.scans
    ]
    if inputs.runs:
        groups.insert(
            0, ("runs" if len(inputs.runs) > 1 else f"run {inputs.runs[0].label}", inputs.runs, ())
        )
    blocks: list[Block] = []
    for title, runs, varied in groups:
        known = [run for run in runs if run and run.case]
        if not known:
            continue
        different = {*differing(known), *varied}
        first = known[0].case
        shared = {
            key: value
            for key, value in first.items()
            if key not in different and _matters(key, known)
        }
        cases = [run.case for run in known]
        rows = [(key, show(one), unit_in_cases(key, cases)) for key, one in _spelt_out(shared)]
        who = f"all points of {title}" if varied else f"all {title}"
        name = f"Settings shared by {who}" if len(known) > 1 else f"Settings of {title}"
        table = text_table(name, ("Key", "Value", "Unit"), rows, captioned=False)
        blocks.append(Group(name, (table,), folded=True))
    return blocks


def differing(runs: Sequence[ReportRun]) -> list[str]:
    """Return the keys of the case that differ between the runs on which they have an effect, in the
    order of the cases.
    """
    keys = list(dict.fromkeys(chain.from_iterable(run.case for run in runs)))
    keys = [key for key in keys if key not in _REMARKS]
    values = {
        key: [run.case.get(key) for run in runs if _has_effect(key, run.case)] for key in keys
    }
    changed = [key for key, of_runs in values.items() if _differ(of_runs)]
    if KIND_OF_PACKING in changed:  # the kind is shown with the origin
        return [key for key in changed if key != ORIGIN]
    return changed


def applied_value(key: str, case: Mapping[str, Any]) -> Any:
    """Return the value of a key of a case; None where it is missing or has no effect."""
    return case.get(key) if _has_effect(key, case) else None


def _has_effect(key: str, case: Mapping[str, Any]) -> bool:
    """Return False for a key that another key of the case makes irrelevant, such as a seed without
    scatter.
    """
    static = STATIC_LOADS.get(str(case.get("precompression.kind")))
    if key in _OF_GRAVITY and static is not None and not static.takes_acceleration:
        return False
    if key in _OF_SCATTER and not case.get(_SCATTER):
        return False
    is_lattice = _SCATTER in case
    if key == _SEED and is_lattice and all(is_nothing(case.get(name)) for name in _RANDOM):
        return False
    return not _is_of_other_laws(key, case)


def _matters(key: str, runs: Sequence[ReportRun]) -> bool:
    """Return True for a key with an effect on any of the runs."""
    return any(_has_effect(key, run.case) for run in runs)


def _is_of_other_laws(key: str, case: Mapping[str, Any]) -> bool:
    """Return True for a key of a contact law, or of the yielding of a material, without effect on
    the laws of a case.
    """
    table, _, name = key.partition(".")
    laws = _laws_of(case)
    if not laws or table not in (_CONTACT, _MATERIAL):
        return False
    if table == _MATERIAL and name == _YIELD_STRENGTH:
        return not any(law.yields for law in laws)
    return name in PARAMETERS and not any(name in law.parameters for law in laws)


def _laws_of(case: Mapping[str, Any]) -> list[Any]:
    """Return the contact laws of a case, of all pairs of materials; empty if one is unknown."""
    pairs = case.get(_PAIRS) or ()
    names = [case.get(f"{_CONTACT}.{_LAW}")]
    names += [pair.get(_LAW) for pair in pairs if isinstance(pair, Mapping)]
    if not all(name in ALL_LAWS for name in names):
        return []
    return [ALL_LAWS[str(name)] for name in names]


def _differ(values: Sequence[Any]) -> bool:
    """Return True if values differ, where a missing value equals one that means nothing."""
    meant = [None if is_nothing(value) else value for value in values]
    return any(value != meant[0] for value in meant)


def is_nothing(value: Any) -> bool:
    """Return True for a value that means that something is absent: none, zero, no or empty."""
    if isinstance(value, list | tuple):
        return all(is_nothing(part) for part in value)
    return value is None or value in (0, "", False)


def _spelt_out(tables: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Iterate over values by full dotted key, including those of nested tables."""
    for name, value in tables.items():
        if isinstance(value, dict) and value:
            yield from _spelt_out(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value
