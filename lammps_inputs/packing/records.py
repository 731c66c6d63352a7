"""Times at which chains and lines of a case are recorded, and the ranks that record them."""

from __future__ import annotations

from granwave.lammps_inputs.packing.assembly import Assembly

_HISTORY, _LEAST_HISTORY = 1000, 5  # instants; beads of a chain from which on they are recorded by themselves
_LINE_HISTORY = 2000  # instants
_PARTS_FROM = 10_000_000  # spheres: one rank alone writes a snapshot of them, 1.4 GB, for seconds while all others wait
_IN_A_PERIOD, _MOST_HISTORY_VALUES = 10, 1e7  # instants in the shortest period of a load; instants times particles
_HISTORY_VALUES, _LEAST_ROWS = 1e6, 250  # instants times particles, nodes of bars among them; fewest instants


def chain_history(assembly: Assembly) -> int:
    """Return the number of instants at which velocities and forces of a chain are recorded; 0: none."""
    case, output, packing = assembly.case, assembly.case.output, assembly.case.packing
    if output.history != "auto":
        return output.history
    if packing.kind != "chain" or packing.size[0] < _LEAST_HISTORY:
        return 0
    instants = min(_HISTORY, max(_LEAST_ROWS, _HISTORY_VALUES / assembly.n_particles))
    if case.load.driven and case.load.oscillates:
        instants = max(instants, _IN_A_PERIOD * case.load.frequencies[1] * case.run.longest)
    return int(min(instants, _MOST_HISTORY_VALUES / assembly.n_particles))


def line_history(assembly: Assembly) -> int:
    """Return the number of instants at which the grains of the lines of a case are recorded."""
    history = assembly.case.output.history
    return history if not isinstance(history, str) and history else _LINE_HISTORY


def written_in_parts(assembly: Assembly) -> bool:
    """Return True if each rank writes its own snapshots and contacts."""
    parts = assembly.case.output.parts
    return assembly.n_spheres >= _PARTS_FROM if parts == "auto" else bool(parts)
