"""Forces of the spheres on walls and bars in time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from granwave.lammps_inputs.deck.columns import MOVING_WALL, sources
from granwave.lammps_inputs.deck.commands import time_series
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import PLATE, Wall, moving_fix, wall_fixes, walls
from granwave.lammps_inputs.run_directory import WALLS_FILE

if TYPE_CHECKING:
    from granwave.lammps_inputs.planning.schedule import Schedule


def wall_forces(assembly: Assembly, schedule: Schedule, *, resumed: bool = False) -> list[str]:
    """Return the commands for the forces on walls, positive outwards."""
    case, found, bars = assembly.case, walls(assembly), assembly.bars
    if not found and not bars:
        return []
    columns = {wall.name: f"v_{wall.name}" for wall in found} | {bar.name: f"c_on_{bar.name}[2]" for bar in bars}
    if support := moving_fix(assembly):
        columns |= {f"bottom_{name}": source for name, source in sources(MOVING_WALL, of=support).items()}
    if case.load.plate is not None:
        columns |= {f"{PLATE}_{name}": source for name, source in sources(MOVING_WALL, of=PLATE).items()}
    return [
        "# Force of the spheres on each wall and bar, N, positive outwards.",
        *(f"variable        {wall.name} equal {outward_force(assembly, wall)}" for wall in found),
        *time_series("walls", schedule.wall_every, WALLS_FILE, "wall forces, N", {"time": "v_time"} | columns, resumed),
    ]


def outward_force(assembly: Assembly, wall: Wall, prefix: str = "") -> str:
    """Return the formula of the force of the spheres on a wall, positive outwards; ``prefix``: of its fixes."""
    sources = ["held"] if wall.held_layer else [prefix + name for name, _, _ in wall_fixes(assembly, wall)]
    sign = "-" if wall.outward < 0 else "+"
    return "".join(f"{sign}f_{source}[{wall.axis + 1}]" for source in sources).removeprefix("+")
