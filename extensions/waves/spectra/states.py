"""Static states for waves of small amplitude: of a case, by Newton's method, or of a finished run,
at the end of its static stage.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from granwave.analysis.result.reader import Result
from granwave.extensions.waves.spectra.cells import cell_bodies, holds_some, vectors_of_layer
from granwave.extensions.waves.spectra.finite import (
    refuse_moved,
    refuse_parts,
    refuse_pushed,
    whole,
)
from granwave.extensions.waves.spectra.network import Network
from granwave.extensions.waves.spectra.packing_springs import network_of
from granwave.extensions.waves.spectra.runs import as_left, mean_cell
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.statics.bodies import Array, Bodies
from granwave.lammps_inputs.statics.relax import StaticState, relax


@dataclasses.dataclass(frozen=True, eq=False)
class State:
    """Springs of a static state.

    Attributes
    ----------
    name
        Name of the case.
    assembly
        All bodies of the case.
    network
        The springs.
    source
        ``case``, or ``run``.
    residual
        Largest net force on a grain / largest contact force; NaN of a run.
    periods
        Periods under the load: (n_periods, 3), m.
    spread
        Largest difference of overlaps from their means in cells of a run / largest overlap; 0 of a
        case.
    """

    name: str
    assembly: Assembly
    network: Network
    source: str
    residual: float
    periods: Array
    spread: float = 0.0

    @property
    def case(self) -> Case:
        """The case."""
        return self.assembly.case


def cell_state(source: Assembly | Path, *, slab: bool = False) -> State:
    """Return the state of the unit cell of a packing, or the mean state inside a finished run.

    Parameters
    ----------
    slab
        True for a packing with the upper and lower ends of the case, periodic only sideways.

    Raises
    ------
    InputError
        The packing is not periodic, carries no load, or the state of the run is not uniform.
    """
    if slab:
        return _slab_state(source)
    if isinstance(source, Assembly):
        relaxed = relax(cell_bodies(source))
        return _state(source, _network(relaxed), "case", relaxed.residual, relaxed.periods)
    with Result(source) as result:
        mean = mean_cell(result)
        network = mean.network
        return _state(result.assembly, network, "run", np.nan, network.periods, mean.spread)


def packing_state(source: Assembly | Path, *, damped: bool = False) -> State:
    """Return the state of the complete packing of a case, or of a finished run.

    Parameters
    ----------
    damped
        True if a damper at the bottom is included; in the static state it is a wall.

    Raises
    ------
    InputError
        It carries no load, or has parts that are no springs between grains.
    """
    if isinstance(source, Assembly):
        refuse_parts(source, damped=damped)
        return _in_own_cell(source, whole(source))
    with Result(source) as result:
        refuse_parts(result.assembly, damped=damped)
        left = as_left(result)
        periods = left.bodies.periods
        return _state(result.assembly, left.network, "run", np.nan, periods)


def _network(relaxed: StaticState) -> Network:
    """Return the springs of a static state."""
    return network_of(relaxed.bodies, relaxed.position, relaxed.periods)


def _state(
    assembly: Assembly,
    network: Network,
    source: str,
    residual: float,
    periods: Array,
    spread: float = 0.0,
) -> State:
    """Return a state; raise InputError if no contact carries a force."""
    case = assembly.case
    if case.is_viscoelastic:
        raise InputError(
            f'{case.name}: contact.loss: found kind = "prony"; small waves require a stiffness '
            "that does not depend on the frequency: remove contact.loss, or set its time or dashpot"
        )
    if not len(network.contacts):
        raise InputError(
            f"{case.name}: precompression: no contact carries a force, and an unloaded Hertzian "
            "contact has no stiffness; use a static load that closes the contacts"
        )
    if not network.n_freedoms and len(network.left_out):
        raise InputError(
            f"{case.name}: precompression: no movable grain carries a force; use a static load "
            "that closes their contacts"
        )
    return State(case.name, assembly, network, source, residual, periods, spread)


def _in_own_cell(assembly: Assembly, bodies: Bodies) -> State:
    """Return the state of grains that have a cell, in this cell."""
    case = assembly.case
    if case.precompression is None:
        raise InputError(
            f"{case.name}: precompression: missing; contacts without force have no stiffness: add "
            "a static load"
        )
    relaxed = relax(bodies)
    network = _network(relaxed)
    refuse_moved(assembly, bodies, network, relaxed.position)
    refuse_pushed(assembly, network, relaxed.position)
    return _state(assembly, network, "case", relaxed.residual, relaxed.periods)


def _slab_state(source: Assembly | Path) -> State:
    """Return the state of a column of a packing that repeats sideways, or of the complete packing
    if its grains differ.
    """
    state = source if isinstance(source, Assembly) else packing_state(source)
    assembly = state if isinstance(state, Assembly) else state.assembly
    case = assembly.case
    refuse_parts(assembly)
    bodies = whole(assembly)
    if not len(bodies.periods):
        raise InputError(
            f"{case.name}: --slab: found a packing without periodic sides, expected "
            'boundary.sides = "periodic" (of a lattice with layers, or of grains with packing.cell)'
        )
    if isinstance(state, State):
        return state
    lattice = assembly.lattice
    if isinstance(lattice, Lattice) and assembly.sites.uniform and not holds_some(case):
        nx, ny, nz = lattice.shape
        bodies = bodies.part(
            np.arange(nz) * nx * ny, vectors_of_layer(lattice.rule) * lattice.diameter
        )
    return _in_own_cell(assembly, bodies)
