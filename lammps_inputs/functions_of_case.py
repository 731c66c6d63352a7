"""Functions of a case, as `granwave.lammps_inputs` provides them to users: each function assembles
the case and passes the assembly on.

The packages themselves read and assemble a case once, and call the functions of an assembly.
"""

from __future__ import annotations

from granwave.lammps_inputs.contact import law
from granwave.lammps_inputs.deck import deck
from granwave.lammps_inputs.packing import packing
from granwave.lammps_inputs.packing import walls as of_packing
from granwave.lammps_inputs.packing.assembly import of_case
from granwave.lammps_inputs.planning import plan as planning
from granwave.lammps_inputs.planning import schedule, timestep

auto_timestep = of_case(timestep.auto_timestep)
build_packing = of_case(packing.build_packing)
expected_peak_overlap = of_case(timestep.expected_peak_overlap)
flat_contact = of_case(law.flat_contact)
make_schedule = of_case(schedule.make_schedule)
pair_contact = of_case(law.pair_contact)
plan = of_case(planning.plan)
walls = of_case(of_packing.walls)
write_deck = of_case(deck.write_deck)
