"""Names of the files that LAMMPS writes to dumps/."""

from __future__ import annotations

from typing import TYPE_CHECKING

from granwave.lammps_inputs.deck.final_contacts import contacts_file
from granwave.lammps_inputs.deck.snapshots import frames_file
from granwave.lammps_inputs.deck.wall_forces import wall_forces
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.records import written_in_parts
from granwave.lammps_inputs.packing.walls import wall_fixes, walls
from granwave.lammps_inputs.run_directory import (
    COUNT_FILE,
    ENERGY_FILE,
    FORCES_FILE,
    FRAME_FORCES_FILE,
    HISTORY_FILE,
    INITIAL_COUNT_FILE,
    INITIAL_FORCES_FILE,
    INITIAL_WALL_FORCES_FILE,
    LINES_FILE,
    MOVED_WALLS_FILE,
    PROBES_FILE,
    STATIC_FILE,
    STATIC_STAGE_FILE,
    WALL_CONTACTS_FILE,
    WALLS_FILE,
)

if TYPE_CHECKING:
    from granwave.lammps_inputs.planning.schedule import Schedule


def output_files(assembly: Assembly, schedule: Schedule) -> list[str]:
    """Return the names of the files that LAMMPS writes to dumps/."""
    case = assembly.case
    planes = [fix for wall in walls(assembly) if not wall.held_layer for fix, _, _ in wall_fixes(assembly, wall)]
    files = [
        ENERGY_FILE,
        frames_file(assembly),
        contacts_file(assembly),
        *(WALL_CONTACTS_FILE.format(fix) for fix in planes),
    ]
    files += [COUNT_FILE] if written_in_parts(assembly) else []
    files += [WALLS_FILE] if wall_forces(assembly, schedule) else []
    files += [PROBES_FILE] if case.probes else []
    files += [HISTORY_FILE, FORCES_FILE] if schedule.history_every else []
    files += [FRAME_FORCES_FILE] if case.output.contact_forces else []
    files += [LINES_FILE] if case.line else []
    if case.precompression is None:
        return files
    files += [MOVED_WALLS_FILE] if case.precompression.presses else []
    files += [contacts_file(assembly, INITIAL_FORCES_FILE), *(INITIAL_WALL_FORCES_FILE.format(fix) for fix in planes)]
    files += [INITIAL_COUNT_FILE] if written_in_parts(assembly) else []
    return [*files, STATIC_STAGE_FILE, STATIC_FILE]
