"""LAMMPS decks from case files: case -> packing -> input script and data file. Needs no LAMMPS."""

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact import hertz_von_mises_yield_factor
from granwave.lammps_inputs.case.material import Material, load_materials, material, presets
from granwave.lammps_inputs.contact.law import flat_contact, pair_contact, sphere_contact
from granwave.lammps_inputs.deck.deck import Deck, write_deck
from granwave.lammps_inputs.errors import GranwaveError, InputError, RunError
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.packing.packing import Packing, build_packing
from granwave.lammps_inputs.packing.places import struck_spheres
from granwave.lammps_inputs.packing.walls import Wall, walls
from granwave.lammps_inputs.planning.plan import Plan, check_memory, plan
from granwave.lammps_inputs.planning.schedule import Schedule, make_schedule
from granwave.lammps_inputs.planning.timestep import auto_timestep, expected_peak_overlap

__all__ = [
    "Case", "Deck", "GranwaveError", "InputError", "Lattice", "Material", "Packing", "Plan", "RunError", "Schedule",
    "Wall", "auto_timestep", "build_packing", "check_memory", "expected_peak_overlap", "flat_contact",
    "hertz_von_mises_yield_factor", "load_case", "load_materials", "make_schedule", "material", "pair_contact",
    "plan", "presets", "sphere_contact", "struck_spheres", "walls", "write_deck",
]  # fmt: skip
