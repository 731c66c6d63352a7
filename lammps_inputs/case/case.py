"""A case: the complete input of one simulation, as read from a TOML file."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Collection, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import tomli_w

from granwave.lammps_inputs.case.absorb import Absorb
from granwave.lammps_inputs.case.added_grains import AddedGrains, with_added_grains
from granwave.lammps_inputs.case.bodies import (
    Bar,
    Guide,
    Hold,
    Line,
    Replace,
    Sensor,
    Striker,
    read_body,
    read_list,
)
from granwave.lammps_inputs.case.boundary import Boundary, Tube
from granwave.lammps_inputs.case.contact import Contact
from granwave.lammps_inputs.case.contact_pairs import RIGID, Pair, read_pairs
from granwave.lammps_inputs.case.figures import FRAMES_OF_A_FILM, Figures
from granwave.lammps_inputs.case.load import Load, read_load
from granwave.lammps_inputs.case.material import (
    MATERIALS,
    SELECTORS,
    Material,
    presets,
    read_material,
    read_materials,
    with_named_materials,
)
from granwave.lammps_inputs.case.output import Output, Probe
from granwave.lammps_inputs.case.packing import PackingSection, check_cell, read_packing
from granwave.lammps_inputs.case.precompression import Precompression
from granwave.lammps_inputs.case.run import Run
from granwave.lammps_inputs.case.schema import ErrorList, keys_of, read_name, read_table, refuse_unknown, show
from granwave.lammps_inputs.case.shape import mass_of
from granwave.lammps_inputs.case.supports import SUPPORTS, read_bottom
from granwave.lammps_inputs.named_files import with_absolute_paths
from granwave.lammps_inputs.plane_lattices import is_plane_crystal
from granwave.lammps_inputs.run_directory import FIGURES_TABLE

_SECTIONS: dict[str, type] = {
    "packing": PackingSection,
    "contact": Contact,
    "load": Load,
    "boundary": Boundary,
    "run": Run,
    "output": Output,
    FIGURES_TABLE: Figures,
}
_LISTS: dict[str, type] = {
    "replace": Replace, "striker": Striker, "hold": Hold, "guide": Guide, "absorb": Absorb, "sensor": Sensor,
    "line": Line,
}  # fmt: skip
_BARS = ("bar", "incident_bar")
_GRAINS = "grains"
_PRECOMPRESSION = "precompression"
_WALLS = ("bottom", "sides")  # keys of [boundary] that take a material
_REQUIRED = ("packing", "material")
KNOWN = ("name", "material", MATERIALS, *_SECTIONS, _PRECOMPRESSION, "pair", _GRAINS, *_LISTS, *_BARS)
RECORD = "resolved"  # table of derived values in the case.toml beside a deck, ignored when read
_OF_CONTINUUM = ("block", "punch", "sphere", "partner")
_OF_SCAN = ("replicates", "ranks", "case", "set", "grid", "zip", "points")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Case:
    """Input of one simulation, as the user gave it; see `granwave.lammps_inputs.load_case`."""

    name: str
    packing: PackingSection
    material: Material
    contact: Contact = dataclasses.field(default_factory=Contact)
    load: Load = dataclasses.field(default_factory=Load)
    boundary: Boundary = dataclasses.field(default_factory=Boundary)
    run: Run = dataclasses.field(default_factory=Run)
    output: Output = dataclasses.field(default_factory=Output)
    figures: Figures = dataclasses.field(default_factory=Figures)
    precompression: Precompression | None = None
    pair: tuple[Pair, ...] = ()
    materials: tuple[Material, ...] = ()
    replace: tuple[Replace, ...] = ()
    striker: tuple[Striker, ...] = ()
    hold: tuple[Hold, ...] = ()
    guide: tuple[Guide, ...] = ()
    absorb: tuple[Absorb, ...] = ()
    sensor: tuple[Sensor, ...] = ()
    line: tuple[Line, ...] = ()
    bar: Bar | None = None
    incident_bar: Bar | None = None

    def contact_between(self, first: Material | None, second: Material | None) -> Contact:
        """Return the law of contacts between two materials, from ``[[pair]]`` or ``[contact]``; None: a rigid wall."""
        names = [RIGID if material is None else material.name for material in (first, second)]
        return next((pair.contact for pair in self.pair if pair.fits(*names)), self.contact)

    def named_material(self, name: str) -> Material:
        """Return the material of this name: of the case, or a preset; that of the packing for an empty name.

        Raises
        ------
        KeyError
            There is none.
        """
        known = presets() | {str(one.name): one for one in (self.material, *self.materials)}
        return known[name] if name else self.material

    @property
    def has_friction(self) -> bool:
        """True if any contact or wall has friction."""
        contacts = [self.contact.friction, self.boundary.friction or 0.0, *(one.contact.friction for one in self.pair)]
        return any(contacts)

    @property
    def has_loss(self) -> bool:
        """True if any contact loses energy by the rate of its overlap."""
        return any(one.loss is not None for one in (self.contact, *(pair.contact for pair in self.pair)))

    @property
    def bears_along_z(self) -> bool:
        """True if something bears a force along z: a bottom, or a grain that is held along z."""
        return self.boundary.bottom != "free" or any("z" in hold.axes for hold in self.holds.values())

    @property
    def has_holder_friction(self) -> bool:
        """True if beads rub against the holder of their chain."""
        return bool(self.boundary.holder_friction)

    @property
    def has_rotation(self) -> bool:
        """True if spheres rotate: with friction, or with an initial spin of a sphere or striker."""
        return self.has_friction or any(self.load.spin) or any(any(striker.spin) for striker in self.striker)

    @property
    def moves_otherwise(self) -> bool:
        """True if there is kinetic energy besides that of the spheres' translation: of rotation, or of a plate."""
        return self.has_rotation or self.load.plate is not None

    @property
    def has_initial_dents(self) -> bool:
        """True if contacts may have dents before the run, given or left by precompression."""
        return bool(self.contact.initial_overlap) or self.precompression is not None

    @property
    def probes(self) -> tuple[Probe, ...]:
        """Probes: ``output.probes``, and in packings other than a chain also the spheres of the sensors."""
        if self.packing.kind == "chain":
            return self.output.probes
        return tuple(dict.fromkeys([*self.output.probes, *(Probe(sphere=sensor.id) for sensor in self.sensor)]))

    @property
    def holds(self) -> dict[str, Hold]:
        """Grains and directions held by ``[[hold]]`` and ``[[guide]]``, by the name of its LAMMPS group."""
        n = math.prod(self.packing.size)
        held = {f"hold{number}": hold for number, hold in enumerate(self.hold, start=1)}
        return held | {f"guide{number}": guide.hold(n) for number, guide in enumerate(self.guide, start=1)}

    @property
    def sphere_mass(self) -> float:
        """Mass of one grain of the packing, kg."""
        return mass_of(self.material, self.packing.diameter / 2, self.packing.of_grain)

    def to_dict(self) -> dict[str, Any]:
        """Return the case as nested tables of TOML values, all defaults filled in; [figures] only if it is given."""
        tables = _plain(self)
        if self.figures == Figures():
            del tables[FIGURES_TABLE]
        if self.contact.line == Contact.line:
            del tables["contact"]["line"]
        tables["packing"] = _plain(self.packing.keys())
        tables["load"] = _plain(self.load.keys())
        for key in _WALLS:
            wall = tables["boundary"].pop(f"{key}_material", None)
            others = tables["boundary"].pop(f"{key}_support", None) or {}
            if (radius := tables["boundary"].pop(f"{key}_tube", None)) is not None:
                others = {"tube": {"radius": radius}}
            if wall is not None or others:
                tables["boundary"][key] = others | ({} if wall is None else {"material": wall})
        if self.materials:
            tables[MATERIALS] = {str(one.name): _plain(one) for one in self.materials}
        if self.pair:
            tables["pair"] = [_plain(pair.to_dict()) for pair in self.pair]
        return {name: table for name, table in tables.items() if table != []}

    def to_toml(self, resolved: Mapping[str, Any] | None = None) -> str:
        """Return the case as the text of a TOML file, with the table ``[resolved]`` if given."""
        return tomli_w.dumps(self.to_dict() | ({RECORD: _plain(resolved)} if resolved else {}))


def parse_case(data: Mapping[str, Any], source: str | Path, errors: ErrorList) -> dict[str, Any]:
    """Read the nested mapping of a case file, table by table; faults are added to ``errors``.

    Parameters
    ----------
    source
        File that the case comes from; its stem is the default name of the case.

    Returns
    -------
    dict
        Fields of `Case` by name; None for those that are wrong.
    """
    _refuse_others(data, errors)
    data = _with_implied(with_absolute_paths(data, Path()))
    materials = read_materials(data.get(MATERIALS, {}), errors)
    data = with_named_materials(data, materials)
    parts = read_parts(data, source, errors, sections=_SECTIONS, required=_REQUIRED, read=_read_section)
    if _PRECOMPRESSION in data:
        parts[_PRECOMPRESSION] = read_table(Precompression, data[_PRECOMPRESSION], _PRECOMPRESSION, errors)
    parts[_PRECOMPRESSION] = _pressed(parts, errors)
    parts["pair"] = read_pairs(data.get("pair", ()), data.get("contact", {}), errors)
    parts[MATERIALS] = tuple(materials.values())
    for name, section in _LISTS.items():
        parts[name] = read_list(section, data.get(name, ()), name, errors)
    for name in _BARS:
        parts[name] = read_body(Bar, data[name], name, errors) if name in data else None
    packing: PackingSection | None = parts["packing"] if "packing" in data else None
    added = read_list(AddedGrains, data.get(_GRAINS, ()), _GRAINS, errors)
    if packing is not None and (added or packing.gaps):
        boundary: Boundary | None = parts["boundary"]
        periodic = boundary is not None and boundary.sides == "periodic"
        packing = parts["packing"] = with_added_grains(packing, added, materials, errors, periodic=periodic)
        parts[MATERIALS] = tuple(materials.values())
    if packing is not None:
        check_cell(packing, errors)
    if "load" not in data and packing is not None and packing.grains is not None and packing.grains.velocity.any():
        parts["load"] = Load(kind="grains")
    return parts


def _pressed(parts: Mapping[str, Any], errors: ErrorList) -> Precompression | None:
    """Return the precompression, which a negative gap at the sides implies."""
    given: Precompression | None = parts.get(_PRECOMPRESSION)
    boundary: Boundary | None = parts.get("boundary")
    if boundary is None or boundary.gap >= 0:
        return given
    axes = [axis for axis in "xy" if boundary.has_planes(axis)]
    if (packing := parts.get("packing")) is not None and is_plane_crystal(packing.kind) and boundary.y is None:
        axes = [axis for axis in axes if axis != "y"]
    moves = {axis: -boundary.gap for axis in axes}
    implied = Precompression(kind="walls", x=moves.get("x"), y=moves.get("y"))
    if given is not None and given != implied:
        errors.add(
            "boundary.side_gap",
            f"found {boundary.gap:g} m, which presses, beside [{_PRECOMPRESSION}]; take one of them out",
        )
    return implied if axes else given


def read_parts(
    data: Mapping[str, Any],
    source: str | Path,
    errors: ErrorList,
    *,
    sections: Mapping[str, type],
    required: Collection[str] = ("material",),
    read: Callable[[type, Any, str, ErrorList], Any] = read_table,
) -> dict[str, Any]:
    """Read name, material and sections of a case of any kind; faults are added to ``errors``.

    Parameters
    ----------
    source
        As in `parse_case`.
    sections
        Dataclass of each table. A table that ``data`` lacks takes its defaults, unless it is required.
    required
        Names of the tables that must be there.
    read
        Function that reads one section.

    Returns
    -------
    dict
        Parts by name; None for those that are wrong.
    """
    parts: dict[str, Any] = {"name": read_name(data, source, errors)}
    for name in required:
        if name not in data:
            errors.add(name, f"missing; a case needs [{name}]")
    if "material" in data:
        parts["material"] = read_material(data["material"], errors)
    for name, section in sections.items():
        if name in data or name not in required:
            parts[name] = read(section, data.get(name, {}), name, errors)
    return parts


@cache
def case_keys() -> tuple[str, ...]:
    """Return the dotted keys of a case; an array of tables is represented by its entry 1."""
    tables = {**_SECTIONS, _PRECOMPRESSION: Precompression, "material": Material, **dict.fromkeys(_BARS, Bar)}
    numbered = {f"{name}.1": section for name, section in ({_GRAINS: AddedGrains} | _LISTS).items()}
    return (*KNOWN, *keys_of(tables), *(f"material.{name}" for name in SELECTORS), *keys_of(numbered))


def case_tables() -> dict[str, type]:
    """Return the section of each table of a case file whose keys are fields of a section, by heading."""
    first = {"[packing]": PackingSection, "[material]": Material}
    supports = {f"[boundary.bottom.{name}]": section for name, section in SUPPORTS.items()}
    return {
        **first,
        **{f"[{name}]": section for name, section in _SECTIONS.items()},
        "[boundary.sides.tube]": Tube,
        **supports,
        f"[{_PRECOMPRESSION}]": Precompression,
        f"[[{_GRAINS}]]": AddedGrains,
        **{f"[[{name}]]": section for name, section in _LISTS.items()},
        **{f"[{name}]": Bar for name in _BARS},
    }


def unit_of(key: str) -> str:
    """Return the unit of a dotted key, such as ``load.velocity``; empty if it has none."""
    table, *between, name = [*key.split("."), ""] if "." not in key else key.split(".")
    sections = {**_SECTIONS, **_LISTS, **dict.fromkeys(_BARS, Bar), "material": Material, "pair": Contact}
    sections[_PRECOMPRESSION] = Precompression
    section = Material if "material" in between else sections.get(table)
    fields = {field.name: field for field in dataclasses.fields(section)} if section else {}
    return (fields[name].metadata.get("unit") or "") if name in fields else ""


def _read_section(section: type, table: Any, name: str, errors: ErrorList) -> Any:
    if section is Load:
        return read_load(table, errors)
    if section is PackingSection:
        return read_packing(table, errors)
    if section is not Boundary or not isinstance(table, Mapping):
        return read_table(section, table, name, errors)
    before, plain = len(errors.lines), dict(table)
    read: dict[str, Any] = {}
    for key in _WALLS:
        if not isinstance(table.get(key), Mapping):
            continue
        plain[key] = "wall"
        if key == "bottom":
            read["bottom_material"], read["bottom_support"] = read_bottom(table[key], f"boundary.{key}", errors)
        else:
            read[f"{key}_material"], read[f"{key}_tube"] = _read_sides(table[key], f"boundary.{key}", errors)
    boundary = read_table(Boundary, plain, name, errors)
    if boundary is None or len(errors.lines) > before:
        return None
    return dataclasses.replace(boundary, **read)


def _read_sides(table: Mapping[str, Any], key: str, errors: ErrorList) -> tuple[Material | None, float | None]:
    """Read the material of the sides, and the radius of a tube."""
    refuse_unknown(table, ("material", "tube"), key, errors)
    if not table:
        errors.add(key, f'found {show(table)}, expected a word, or {{material = "..."}} for a wall')
    material = read_material(table["material"], errors, f"{key}.material") if "material" in table else None
    tube = read_table(Tube, table["tube"], f"{key}.tube", errors) if "tube" in table else None
    return material, None if tube is None else tube.radius


def _with_implied(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a case with implied values.

    These are strikers as the load, the axis of strikers, a bar for a bottom, and frames of a film.
    """
    data = dict(data)
    if "striker" in data and "load" not in data:
        data["load"] = {"kind": "striker"}
    packing, strikers = data.get("packing"), data.get("striker")
    if isinstance(packing, Mapping) and isinstance(strikers, list | tuple) and packing.get("shape") == "cylinder":
        axis = packing.get("axis", "z" if packing.get("kind") == "square" else None)  # rows of a square are along y
        data["striker"] = [
            {**one, "axis": axis}
            if axis is not None and isinstance(one, Mapping) and one.get("shape") == "cylinder" and "axis" not in one
            else one
            for one in strikers
        ]
    boundary = data.get("boundary", {})
    if "bar" in data and isinstance(boundary, Mapping) and "bottom" not in boundary:
        data["boundary"] = {**boundary, "bottom": "free"}
    figures, run = data.get(FIGURES_TABLE, {}), data.get("run", {})
    if isinstance(figures, Mapping) and isinstance(run, Mapping) and figures.get("film", "none") != "none":
        data["run"] = {"frames": FRAMES_OF_A_FILM, **run}
    return data


def _refuse_others(data: Mapping[str, Any], errors: ErrorList) -> None:
    for name in _OF_CONTINUUM:
        if name in data:
            errors.add_unknown(name, "belongs to a continuum case: granwave continuum runs it")
    for name in _OF_SCAN:
        if name in data:
            errors.add_unknown(name, "belongs in a scan file: granwave scan runs it")
    others = (*_OF_CONTINUUM, *_OF_SCAN, RECORD)
    rest = {name: value for name, value in data.items() if name not in others}
    refuse_unknown(rest, KNOWN, "", errors)


def _plain(value: Any) -> Any:
    """Convert dataclasses and tuples to tables and lists; drop None, which TOML cannot express."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items() if item is not None}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value
