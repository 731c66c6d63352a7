"""LAMMPS decks from case files: case -> packing -> input script and data file. Needs no LAMMPS.

Names are imported on first use.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from granwave.lammps_inputs.load_case import load_case  # at once: on first use it would be the module of that name

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case
    from granwave.lammps_inputs.case.material import Material, load_materials, material, presets
    from granwave.lammps_inputs.case.yield_factor import hertz_von_mises_yield_factor
    from granwave.lammps_inputs.contact.law import flat_contact, pair_contact, sphere_contact
    from granwave.lammps_inputs.deck.deck import Deck, write_deck
    from granwave.lammps_inputs.errors import GranwaveError, InputError, RunError
    from granwave.lammps_inputs.lattices import Lattice
    from granwave.lammps_inputs.packing.packing import Packing, build_packing
    from granwave.lammps_inputs.packing.struck_spheres import struck_spheres
    from granwave.lammps_inputs.packing.walls import Wall, walls
    from granwave.lammps_inputs.planning.plan import Plan, check_memory, plan
    from granwave.lammps_inputs.planning.schedule import Schedule, make_schedule
    from granwave.lammps_inputs.planning.timestep import auto_timestep, expected_peak_overlap

_HOME = {
    "Case": "case.case",
    "Deck": "deck.deck",
    "GranwaveError": "errors",
    "InputError": "errors",
    "Lattice": "lattices",
    "Material": "case.material",
    "Packing": "packing.packing",
    "Plan": "planning.plan",
    "RunError": "errors",
    "Schedule": "planning.schedule",
    "Wall": "packing.walls",
    "auto_timestep": "planning.timestep",
    "build_packing": "packing.packing",
    "check_memory": "planning.plan",
    "expected_peak_overlap": "planning.timestep",
    "flat_contact": "contact.law",
    "hertz_von_mises_yield_factor": "case.yield_factor",
    "load_materials": "case.material",
    "make_schedule": "planning.schedule",
    "material": "case.material",
    "pair_contact": "contact.law",
    "plan": "planning.plan",
    "presets": "case.material",
    "sphere_contact": "contact.law",
    "struck_spheres": "packing.struck_spheres",
    "walls": "packing.walls",
    "write_deck": "deck.deck",
}

__all__ = [
    "Case",
    "Deck",
    "GranwaveError",
    "InputError",
    "Lattice",
    "Material",
    "Packing",
    "Plan",
    "RunError",
    "Schedule",
    "Wall",
    "auto_timestep",
    "build_packing",
    "check_memory",
    "expected_peak_overlap",
    "flat_contact",
    "hertz_von_mises_yield_factor",
    "load_case",
    "load_materials",
    "make_schedule",
    "material",
    "pair_contact",
    "plan",
    "presets",
    "sphere_contact",
    "struck_spheres",
    "walls",
    "write_deck",
]


def __getattr__(name: str) -> object:
    """Import a public name from its module."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
