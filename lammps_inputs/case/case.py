"""A case: the complete input of one simulation, as read from a TOML file, and the tables of such a
file.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from functools import cache
from typing import Any

import tomli_w

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.added_grains import AddedGrains
from granwave.lammps_inputs.case.bodies import (
    Absorb,
    Bar,
    Guide,
    Hold,
    Line,
    Replace,
    Sensor,
    Striker,
)
from granwave.lammps_inputs.case.boundary import Boundary
from granwave.lammps_inputs.case.contact.contact import RIGID, Contact, Pair
from granwave.lammps_inputs.case.figures import Figures
from granwave.lammps_inputs.case.loads.impact import ImpactLoad
from granwave.lammps_inputs.case.loads.load import Load
from granwave.lammps_inputs.case.loads.registry import load_section
from granwave.lammps_inputs.case.material import (
    MATERIAL,
    MATERIALS,
    SELECTORS,
    Material,
    mass_of,
    presets,
)
from granwave.lammps_inputs.case.output import Output, Probe
from granwave.lammps_inputs.case.packing.contact_ways import DAMPED
from granwave.lammps_inputs.case.packing.packing import PackingSection
from granwave.lammps_inputs.case.precompression import PRECOMPRESSION, Precompression
from granwave.lammps_inputs.case.region_walls import RegionWall
from granwave.lammps_inputs.case.run import (
    AUTO_FRAMES,
    DIVISION_KEYS,
    FRAMES_OF_A_FILM,
    RunSettings,
)
from granwave.lammps_inputs.case.schema import (
    declared_fields,
    info_of,
    keys_of,
    numbered,
    with_inner_tables,
)
from granwave.lammps_inputs.run_directory import FIGURES_TABLE


@dataclasses.dataclass(frozen=True, kw_only=True)
class CaseHead:
    """Keys above all tables: name, material and the tables below."""

    name: str = schema.key_field(
        schema.KeyInfo(
            description="name of the case, and of the directory of its results",
            type=schema.PLAIN_NAME,
            default_form="the name of the file",
        ),
        default="",
    )
    material: Material = schema.typed("material of all bodies without their own material", MATERIAL)


#: Sections of tables by heading, in the order of a case file; the section of ``[load]`` is made
#: when it is needed, because extensions can add to it.
_TABLES: dict[str, type | None] = {
    "[packing]": PackingSection,
    "[material]": Material,
    "[contact]": Contact,
    "[load]": None,
    "[boundary]": Boundary,
    "[run]": RunSettings,
    "[output]": Output,
    f"[{FIGURES_TABLE}]": Figures,
    f"[{PRECOMPRESSION}]": Precompression,
    "[[grains]]": AddedGrains,
    "[[replace]]": Replace,
    "[[striker]]": Striker,
    "[[hold]]": Hold,
    "[[guide]]": Guide,
    "[[wall]]": RegionWall,
    "[[absorb]]": Absorb,
    "[[sensor]]": Sensor,
    "[[line]]": Line,
    "[bar]": Bar,
    "[incident_bar]": Bar,
}
LISTS = {
    heading.strip("[]"): section
    for heading, section in _TABLES.items()
    if section is not None and heading.startswith("[[")
}
_NAMES = [heading.strip("[]") for heading in _TABLES]
_CHOSEN = "chosen"  # field of a case that is no table
#: Keys of which a warning depends on whether the user set them.
MEANT = ("contact.yield_factor",)
OPTIONAL = (PRECOMPRESSION, "bar", "incident_bar")  # sections without defaults
KNOWN = (
    "name",
    "material",
    MATERIALS,
    *(name for name in _NAMES if name not in ("material", *LISTS)),
    "pair",
    *LISTS,
)


@cache
def case_tables() -> dict[str, type]:
    """Return the section of each table of a case file, by heading; tables in a table follow it."""
    return with_inner_tables(
        {heading: section or load_section() for heading, section in _TABLES.items()}
    )


@cache
def case_sections() -> dict[str, type]:
    """Return the section of each table by name, for tables that occur once; without materials."""
    return {
        name: case_tables()[heading]
        for name, heading in zip(_NAMES, _TABLES, strict=True)
        if name not in ("material", *LISTS)
    }


@cache
def case_keys() -> tuple[str, ...]:
    """Return the dotted keys of a case; an array of tables is represented by its entry 1."""
    numbered = {f"{name}.1": section for name, section in LISTS.items()}
    selectors = [f"material.{name}" for name in SELECTORS]
    return (
        *KNOWN,
        *keys_of(case_sections() | {"material": Material}),
        *selectors,
        *keys_of(numbered),
    )


def unit_of(key: str) -> str:
    """Return the unit of a dotted key, such as ``load.velocity``; empty if it has none."""
    table, _, name = re.sub(r"\.\d+", "", key).rpartition(".")
    by_name = {heading.strip("[]"): section for heading, section in case_tables().items()}
    by_name["pair"] = Contact
    section = Material if table.endswith(".material") else by_name.get(table)
    field = declared_fields(section).get(name) if section else None
    return "" if field is None else info_of(field).unit


# table of derived values in the case.toml of an input directory, ignored when read
RECORD = "resolved"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Case:
    """Input of one simulation, as set by the user; see `granwave.lammps_inputs.load_case`.

    Its fields are the tables of a case file, and ``chosen``: dotted keys that the user set, among
    those of `MEANT`. A value that equals a default is then meant.
    """

    name: str
    packing: PackingSection
    material: Material
    contact: Contact = dataclasses.field(default_factory=Contact)
    load: Load = dataclasses.field(default_factory=ImpactLoad)
    boundary: Boundary = dataclasses.field(default_factory=Boundary)
    run: RunSettings = dataclasses.field(default_factory=RunSettings)
    output: Output = dataclasses.field(default_factory=Output)
    figures: Figures = dataclasses.field(default_factory=Figures)
    precompression: Precompression | None = None
    pair: tuple[Pair, ...] = ()
    materials: tuple[Material, ...] = ()
    replace: tuple[Replace, ...] = ()
    striker: tuple[Striker, ...] = ()
    hold: tuple[Hold, ...] = ()
    guide: tuple[Guide, ...] = ()
    wall: tuple[RegionWall, ...] = ()
    absorb: tuple[Absorb, ...] = ()
    sensor: tuple[Sensor, ...] = ()
    line: tuple[Line, ...] = ()
    bar: Bar | None = None
    incident_bar: Bar | None = None
    chosen: frozenset[str] = dataclasses.field(default=frozenset(), compare=False, repr=False)

    @property
    def contact_laws(self) -> tuple[Contact, ...]:
        """Contact laws of the case: of ``[contact]`` and of each ``[[pair]]``."""
        return (self.contact, *(pair.contact for pair in self.pair))

    def contact_between(self, first: Material | None, second: Material | None) -> Contact:
        """Return the law of contacts between two materials, from ``[[pair]]`` or ``[contact]``;
        None: a rigid wall.
        """
        names = [RIGID if material is None else material.name for material in (first, second)]
        return next((pair.contact for pair in self.pair if pair.fits(*names)), self.contact)

    def named_material(self, name: str) -> Material:
        """Return the material of this name: of the case, or a preset; for an empty name the
        material of the packing.

        Raises
        ------
        KeyError
            There is none.
        """
        known = presets() | {str(one.name): one for one in (self.material, *self.materials)}
        return known[name] if name else self.material

    @property
    def has_friction(self) -> bool:
        """True if any contact or wall has friction, of sliding, rolling or twisting."""
        return (
            any(one.friction for one in self.contact_laws)
            or bool(self.boundary.friction)
            or any(wall.friction for wall in self.wall)
            or self.has_resistance
        )

    @property
    def has_partial_slip(self) -> bool:
        """True if any contact with friction has partial slip."""
        return self.has_friction and any(
            one.tangential == "partial_slip" for one in self.contact_laws
        )

    @property
    def has_resistance(self) -> bool:
        """True if any contact resists rolling or twisting."""
        return any(one.resists for one in self.contact_laws)

    @property
    def has_cohesion(self) -> bool:
        """True if any contact coheres."""
        return any(one.coheres for one in self.contact_laws)

    @property
    def has_loss(self) -> bool:
        """True if any contact dissipates energy by a viscous loss."""
        return any(one.loss is not None for one in self.contact_laws)

    @property
    def is_viscoelastic(self) -> bool:
        """True if the modulus of any contact relaxes."""
        return any(one.loss is not None and one.loss.branches for one in self.contact_laws)

    @property
    def bears_along_z(self) -> bool:
        """True if a bottom, or a grain held along z, supports a force along z."""
        return self.boundary.bottom_rule.bears or any(
            "z" in hold.axes for hold in self.holds.values()
        )

    @property
    def has_holder_friction(self) -> bool:
        """True if there is friction between beads and the guide of their chain."""
        return bool(self.boundary.holder_friction)

    @property
    def has_rotation(self) -> bool:
        """True if spheres rotate: with friction, in clumps, or with an initial spin of a sphere or
        striker.
        """
        return (
            self.has_friction
            or self.packing.has_clumps
            or any(self.load.spin)
            or any(any(striker.spin) for striker in self.striker)
        )

    @property
    def moves_otherwise(self) -> bool:
        """True if there is kinetic energy other than the translation of spheres: of rotation, or
        of a plate.
        """
        return self.has_rotation or self.load.plate is not None

    @property
    def has_initial_dents(self) -> bool:
        """True if contacts may have dents before the run, given or left by precompression."""
        return bool(self.contact.initial_overlap) or self.precompression is not None

    @property
    def seeks_balance(self) -> bool:
        """True if a static stage brings the packing to balance, False if
        contacts start unchanged.
        """
        way = self.packing.contact_way
        return way is None or way.balances or not way.presses

    @property
    def settles_damped(self) -> bool:
        """True if a damped run with friction brings the packing to balance."""
        return self.may_rearrange and self.packing.relaxation == DAMPED

    @property
    def strikers_fall(self) -> bool:
        """True if gravity acts on strikers."""
        return self.precompression is not None and self.precompression.strikers

    @property
    def may_rearrange(self) -> bool:
        """True if grains may move far on the way to balance."""
        way = self.packing.contact_way
        return way is not None and way.rearranges

    @property
    def probes(self) -> tuple[Probe, ...]:
        """Probes: ``output.probes``, and in packings other than a chain also the spheres of the
        sensors.
        """
        if self.packing.rule.is_chain:
            return self.output.probes
        return tuple(
            dict.fromkeys(
                [*self.output.probes, *(Probe(sphere=sensor.id) for sensor in self.sensor)]
            )
        )

    @property
    def held(self) -> dict[str, Hold]:
        """Grains and directions held by ``[[hold]]`` and ``[[guide]]``, by key, such as
        ``guide.1``.
        """
        n = self.packing.n_spheres
        return numbered("hold", self.hold) | numbered(
            "guide", (guide.hold(n) for guide in self.guide)
        )

    @property
    def holds(self) -> dict[str, Hold]:
        """Grains and directions held by ``[[hold]]`` and ``[[guide]]``, by the name of its LAMMPS
        group.
        """
        return {key.replace(".", ""): hold for key, hold in self.held.items()}

    @property
    def sphere_mass(self) -> float:
        """Mass of one grain of the packing, kg."""
        return mass_of(self.material, self.packing.diameter / 2, self.packing.of_grain)

    @property
    def n_frames(self) -> int:
        """Number of requested snapshots, including the start and the end."""
        frames = self.run.frames
        if isinstance(frames, int):
            return frames
        if isinstance(frames, tuple):
            return len(frames)
        return self.n_auto_frames

    @property
    def n_auto_frames(self) -> int:
        """Number of snapshots of ``run.frames = "auto"``."""
        return AUTO_FRAMES if self.figures.film == "none" else FRAMES_OF_A_FILM

    def to_dict(self) -> dict[str, Any]:
        """Return the case as nested tables of TOML values, all defaults filled in; [figures] and
        `DIVISION_KEYS` only if they are given.
        """
        tables = _plain(self)
        del tables[_CHOSEN]
        if self.figures == Figures():
            del tables[FIGURES_TABLE]
        if self.contact.line == Contact.line:
            del tables["contact"]["line"]
        for key in DIVISION_KEYS:
            if getattr(self.run, key) == getattr(RunSettings, key):
                del tables["run"][key]
        tables |= {
            name: _plain(getattr(self, name).keys()) for name in ("packing", "load", "boundary")
        }
        if self.materials:
            tables[MATERIALS] = {str(one.name): _plain(one) for one in self.materials}
        if self.pair:
            tables["pair"] = [_plain(pair.to_dict()) for pair in self.pair]
        return {name: table for name, table in tables.items() if table != []}

    def to_toml(self, resolved: Mapping[str, Any] | None = None) -> str:
        """Return the case as the text of a TOML file, with the table ``[resolved]`` if given."""
        return tomli_w.dumps(self.to_dict() | ({RECORD: _plain(resolved)} if resolved else {}))


class WrongTable(Exception):
    """Error of a check that needs an invalid table of a `PartialCase`."""


class PartialCase(Case):
    """A case without its invalid tables; a check that reads one of these ends with `WrongTable`."""

    def __init__(self, parts: Mapping[str, Any]) -> None:
        vars(self).update({name: part for name, part in parts.items() if part is not None})

    def __getattr__(self, name: str) -> Any:
        raise WrongTable(name)


def _plain(value: Any) -> Any:
    """Convert dataclasses and tuples to tables and lists; drop None, which TOML cannot express."""
    if dataclasses.is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items() if item is not None}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value
