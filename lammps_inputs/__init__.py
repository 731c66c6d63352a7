"""LAMMPS input from case files: case -> packing -> input script and data file. Needs no LAMMPS."""

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact.contact import hertz_von_mises_yield_factor
from granwave.lammps_inputs.case.material import Material, load_materials, material, presets
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.deck.deck import Deck
from granwave.lammps_inputs.errors import GranwaveError, InputError, RunError
from granwave.lammps_inputs.functions_of_case import (
    auto_timestep,
    build_packing,
    expected_peak_overlap,
    flat_contact,
    make_schedule,
    pair_contact,
    plan,
    walls,
    write_deck,
)
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.packing.packing import Packing
from granwave.lammps_inputs.packing.places import struck_spheres
from granwave.lammps_inputs.packing.walls import Wall
from granwave.lammps_inputs.planning.plan import Plan, check_memory
from granwave.lammps_inputs.planning.schedule import Schedule

__all__ = [
    "Case", "Deck", "GranwaveError", "InputError", "Lattice", "Material", "Packing", "Plan", "RunError", "Schedule",
    "Wall", "auto_timestep", "build_packing", "check_memory", "expected_peak_overlap", "flat_contact",
    "hertz_von_mises_yield_factor", "load_case", "load_materials", "make_schedule", "material", "pair_contact",
    "plan", "presets", "sphere_contact", "struck_spheres", "walls", "write_deck",
]  # fmt: skip
