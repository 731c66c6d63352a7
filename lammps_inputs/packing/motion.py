"""Impacted grains, grains with an initial velocity, held grains, and grains recorded in time."""

from __future__ import annotations

import dataclasses
import math
from itertools import chain

import numpy as np

from granwave.lammps_inputs.case.bodies import Hold, Line
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.loads.load import LoadedPacking
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.bodies import INCIDENT_BAR
from granwave.lammps_inputs.packing.places import Places, struck_spheres


@dataclasses.dataclass(frozen=True, eq=False)
class LoadedAssembly(LoadedPacking):
    """Bodies of a case, with the properties that its load uses."""

    assembly: Assembly

    @property
    def top_layer(self) -> tuple[int, ...]:
        return tuple(self.assembly.lattice.top_layer.tolist())

    @property
    def n_layers(self) -> int:
        return self.assembly.lattice.n_layers

    @property
    def sphere_mass(self) -> float:
        return self.assembly.case.sphere_mass

    @property
    def masses(self) -> tuple[float, float]:
        masses = self.assembly.sphere_masses()
        return float(masses.min()), float(masses.max())

    @property
    def moving_grains(self) -> tuple[int, ...]:
        return tuple(own_velocities(self.assembly))

    @property
    def moving_strikers(self) -> tuple[int, ...]:
        return tuple(_striker_velocities(self.assembly))

    @property
    def is_at_rest(self) -> bool:
        return not velocities_of(self.assembly)

    @property
    def bar_impedance(self) -> float | None:
        for bar in self.assembly.bars:
            if bar.name == INCIDENT_BAR:
                material = bar.material
                return bar.section.area * math.sqrt(material.youngs_modulus * material.density)
        return None

    def at_centre(self, count: int) -> tuple[int, ...]:
        return struck_spheres(self.assembly.lattice, count)

    def mass_of(self, sphere: int) -> float:
        return self.assembly.mass_of(sphere)


def struck_of(assembly: Assembly) -> tuple[int, ...]:
    """Return the ids of the loaded spheres, the impacted sphere first; for strikers, the moving
    spheres.
    """
    return assembly.case.load.struck(LoadedAssembly(assembly))


def start_velocity(assembly: Assembly) -> tuple[float, float, float] | None:
    """Return the initial velocity of the impacted spheres, m/s; None without a velocity."""
    return assembly.case.load.start_velocity(LoadedAssembly(assembly))


def start_speed(assembly: Assembly) -> float:
    """Return the speed of the impacted spheres at the start, m/s; 0 if the load gives none."""
    return assembly.case.load.start_speed(LoadedAssembly(assembly))


def struck_site(assembly: Assembly) -> int | None:
    """Return the id of the impacted sphere, or of the sphere that the first moving striker hits;
    None without either.
    """
    struck = struck_of(assembly)
    sphere = struck[0] if struck else None
    while sphere is not None and sphere > assembly.lattice.n_spheres:
        sphere = assembly.case.striker[sphere - assembly.lattice.n_spheres - 1].touches[0]
    return sphere


def impacted_of(assembly: Assembly) -> tuple[int, ...]:
    """Return the ids of the loaded spheres of the packing; for strikers, all spheres that moving
    strikers touch.
    """
    n_spheres = assembly.lattice.n_spheres
    pending = list(struck_of(assembly))
    impacted: dict[int, None] = {}
    while pending:
        sphere = pending.pop(0)
        if sphere > n_spheres:
            pending += assembly.case.striker[sphere - n_spheres - 1].touches
        else:
            impacted[sphere] = None
    return tuple(impacted)


def velocities_of(assembly: Assembly) -> dict[int, tuple[float, float, float]]:
    """Return the initial velocities of moving spheres by id, m/s."""
    velocities = own_velocities(assembly)
    velocity = start_velocity(assembly)
    if velocity is not None:
        velocities |= dict.fromkeys(struck_of(assembly), velocity)
    return velocities | _striker_velocities(assembly)


def _striker_velocities(assembly: Assembly) -> dict[int, tuple[float, float, float]]:
    """Return the velocities of the strikers that move, by id, m/s."""
    first = assembly.lattice.n_spheres + 1
    strikers = enumerate(assembly.case.striker, start=first)
    return {number: striker.velocity for number, striker in strikers if striker.moves}


def own_velocities(assembly: Assembly) -> dict[int, tuple[float, float, float]]:
    """Return the velocities of moving grains of a file, by id, the fastest first, m/s."""
    if not isinstance(assembly.lattice, Places):
        return {}
    velocity = assembly.lattice.grains.velocity
    speed = np.linalg.norm(velocity, axis=1)
    moving = np.argsort(-speed, kind="stable")[: np.count_nonzero(speed)]
    return {row + 1: tuple(velocity[row].tolist()) for row in moving.tolist()}


def own_spins(assembly: Assembly) -> dict[int, tuple[float, float, float]]:
    """Return the nonzero initial angular velocities of grains of a file, by id, rad/s.

    Without friction they have no effect. Spins are zero initially for grains that reach equilibrium
    first, grains of clumps, grains whose rotation is held, and cylinders.
    """
    case = assembly.case
    balances = case.precompression is not None and case.seeks_balance
    if not isinstance(assembly.lattice, Places) or not case.has_friction or balances:
        return {}
    grains = assembly.lattice.grains
    spins = grains.spin.any(axis=1) & np.array([shape is None for shape in grains.shape])
    held = [held_ids(case, hold) for hold in case.holds.values() if hold.rotation]
    for ids in (*held, *assembly.clumps.values()):
        spins[np.array(ids, dtype=np.int64) - 1] = False
    return {row + 1: tuple(grains.spin[row].tolist()) for row in np.flatnonzero(spins).tolist()}


def held_ids(case: Case, hold: Hold) -> tuple[int, ...]:
    """Return the ids of the grains that an entry ``[[hold]]`` holds, in rising order."""
    if hold.index is not None:
        return tuple(sorted(set(hold.index)))
    return case.packing.grains.of_group(hold.group or "") if case.packing.grains is not None else ()


def held_against_load(assembly: Assembly) -> tuple[int, ...]:
    """Return the ids of the grains held along a direction in which the load moves other grains: a
    last layer held in place, and the grains of ``[[hold]]`` and ``[[guide]]``.
    """
    case = assembly.case
    moving = {axis for axis, part in zip("xyz", case.load.way, strict=True) if part}
    for velocity in velocities_of(assembly).values():
        moving |= {axis for axis, part in zip("xyz", velocity, strict=True) if part}
    ids = set[int]()
    for hold in case.holds.values():
        if moving & set(hold.axes):
            ids.update(held_ids(case, hold))
    if case.boundary.bottom_rule.holds_layer:
        ids.update(assembly.lattice.last_layer.tolist())
    return tuple(sorted(ids))


_BESIDE = 0.25  # diameters; grains of a line are no further from it
# diameters above a fixed floor: grains there cannot reach the speed of the wave
_HELD = 3.0


def line_ids(assembly: Assembly, line: Line) -> tuple[int, ...]:
    """Return the ids of the grains of a line in their order: the given grains, or the grains along
    a direction.
    """
    ids = assembly.ids
    own = ids <= assembly.lattice.n_spheres
    if isinstance(line.index, str):
        return tuple(ids[own].tolist())
    if line.index is not None:
        return line.index
    ids = ids[own]
    positions = assembly.positions()[own]
    start = line.start or struck_site(assembly) or int(ids[0])
    row = int(np.searchsorted(ids, start))
    if row == len(ids) or ids[row] != start:
        return ()
    way = np.array(line.direction) / np.linalg.norm(line.direction)
    offset = positions - positions[row]
    along = offset @ way
    beside = np.linalg.norm(offset - along[:, None] * way, axis=1)
    diameter = assembly.case.packing.diameter
    on = np.flatnonzero((beside <= _BESIDE * diameter) & (along >= -1e-6 * diameter))
    return tuple(ids[on[np.argsort(along[on], kind="stable")]].tolist())


def all_line_ids(assembly: Assembly) -> tuple[int, ...]:
    """Return the ids of the grains of all lines, each once, in rising order."""
    lines = (line_ids(assembly, line) for line in assembly.case.line)
    return tuple(sorted(set(chain.from_iterable(lines))))


def left_out(assembly: Assembly, line: Line) -> int:
    """Return the number of grains at the end of a line that are held by the floor and excluded from
    the fit of the decay.
    """
    if not isinstance(line.leave_out, str):
        return line.leave_out
    boundary = assembly.case.boundary
    if not boundary.bottom_rule.bears or boundary.bottom_support is not None:
        return 0
    lowest = assembly.bottom() - _HELD * assembly.case.packing.diameter
    near = [float(assembly.centre_of(one)[2]) > lowest for one in line_ids(assembly, line)]
    return next((n for n, held in enumerate(reversed(near)) if not held), len(near))


# instants; largest number of beads of a chain that are recorded together
_HISTORY = 1000
_LEAST_HISTORY = 5
_LINE_HISTORY = 2000  # instants
# spheres: one rank alone writes a snapshot of them, 1.4 GB, for seconds while all others wait
_PARTS_FROM = 10_000_000
# instants in the shortest period of a load; instants times particles
_IN_A_PERIOD = 10
_MOST_HISTORY_VALUES = 1e7
# instants times particles, nodes of bars among them; fewest instants
_HISTORY_VALUES = 1e6
_LEAST_ROWS = 250


def chain_history(assembly: Assembly) -> int:
    """Return the number of instants at which velocities and forces of a chain are recorded; 0:
    none.
    """
    case = assembly.case
    output = assembly.case.output
    packing = assembly.case.packing
    if output.history != "auto":
        return output.history
    if not packing.rule.is_chain or packing.size[0] < _LEAST_HISTORY:
        return 0
    instants = min(_HISTORY, max(_LEAST_ROWS, _HISTORY_VALUES / assembly.n_particles))
    if case.load.oscillates:
        instants = max(instants, _IN_A_PERIOD * case.load.highest_frequency * case.run.longest)
    return int(min(instants, _MOST_HISTORY_VALUES / assembly.n_particles))


def line_history(assembly: Assembly) -> int:
    """Return the number of instants at which the grains of the lines of a case are recorded."""
    history = assembly.case.output.history
    return history if not isinstance(history, str) and history else _LINE_HISTORY


def written_in_parts(assembly: Assembly) -> bool:
    """Return True if snapshots and contacts are written to several files."""
    parts = assembly.case.output.parts
    return assembly.n_spheres >= _PARTS_FROM if parts == "auto" else bool(parts)
