"""Tables of a case file: their sections, the dotted keys in them, and the units of these."""

from __future__ import annotations

import dataclasses
from functools import cache

from granwave.lammps_inputs.case.absorb import Absorb
from granwave.lammps_inputs.case.added_grains import AddedGrains
from granwave.lammps_inputs.case.bodies import Bar, Guide, Hold, Line, Replace, Sensor, Striker
from granwave.lammps_inputs.case.boundary import Boundary, Tube
from granwave.lammps_inputs.case.contact import Contact
from granwave.lammps_inputs.case.figures import Figures
from granwave.lammps_inputs.case.load import Load
from granwave.lammps_inputs.case.material import MATERIALS, SELECTORS, Material
from granwave.lammps_inputs.case.output import Output
from granwave.lammps_inputs.case.packing import PackingSection
from granwave.lammps_inputs.case.precompression import Precompression
from granwave.lammps_inputs.case.run import Run
from granwave.lammps_inputs.case.schema import keys_of
from granwave.lammps_inputs.case.supports import SUPPORTS
from granwave.lammps_inputs.run_directory import FIGURES_TABLE

SECTIONS: dict[str, type] = {
    "packing": PackingSection,
    "contact": Contact,
    "load": Load,
    "boundary": Boundary,
    "run": Run,
    "output": Output,
    FIGURES_TABLE: Figures,
}
LISTS: dict[str, type] = {
    "replace": Replace, "striker": Striker, "hold": Hold, "guide": Guide, "absorb": Absorb, "sensor": Sensor,
    "line": Line,
}  # fmt: skip
BARS = ("bar", "incident_bar")
GRAINS = "grains"
PRECOMPRESSION = "precompression"

WALL_KEYS = ("bottom", "sides")  # keys of [boundary] that take a material
KNOWN = ("name", "material", MATERIALS, *SECTIONS, PRECOMPRESSION, "pair", GRAINS, *LISTS, *BARS)


@cache
def case_keys() -> tuple[str, ...]:
    """Return the dotted keys of a case; an array of tables is represented by its entry 1."""
    tables = {**SECTIONS, PRECOMPRESSION: Precompression, "material": Material, **dict.fromkeys(BARS, Bar)}
    numbered = {f"{name}.1": section for name, section in ({GRAINS: AddedGrains} | LISTS).items()}
    return (*KNOWN, *keys_of(tables), *(f"material.{name}" for name in SELECTORS), *keys_of(numbered))


def case_tables() -> dict[str, type]:
    """Return the section of each table of a case file whose keys are fields of a section, by heading."""
    first = {"[packing]": PackingSection, "[material]": Material}
    supports = {f"[boundary.bottom.{name}]": section for name, section in SUPPORTS.items()}
    return {
        **first,
        **{f"[{name}]": section for name, section in SECTIONS.items()},
        "[boundary.sides.tube]": Tube,
        **supports,
        f"[{PRECOMPRESSION}]": Precompression,
        f"[[{GRAINS}]]": AddedGrains,
        **{f"[[{name}]]": section for name, section in LISTS.items()},
        **{f"[{name}]": Bar for name in BARS},
    }


def unit_of(key: str) -> str:
    """Return the unit of a dotted key, such as ``load.velocity``; empty if it has none."""
    table, *between, name = [*key.split("."), ""] if "." not in key else key.split(".")
    sections = {**SECTIONS, **LISTS, **dict.fromkeys(BARS, Bar), "material": Material, "pair": Contact}
    sections[PRECOMPRESSION] = Precompression
    section = Material if "material" in between else sections.get(table)
    fields = {field.name: field for field in dataclasses.fields(section)} if section else {}
    return (fields[name].metadata.get("unit") or "") if name in fields else ""
