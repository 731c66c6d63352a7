"""Grains of a finite packing with its static loads, and checks of their static states."""

from __future__ import annotations

import numpy as np

from granwave.extensions.waves.spectra.cells import refuse_resistance
from granwave.extensions.waves.spectra.network import Network
from granwave.lammps_inputs.deck.static_stage import largest_move
from granwave.lammps_inputs.errors import InputError, RunError
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.clumps import refuse_clumps
from granwave.lammps_inputs.packing.cylinders import distances
from granwave.lammps_inputs.packing.places import Places
from granwave.lammps_inputs.packing.walls import PLATE, refuse_region_walls
from granwave.lammps_inputs.statics.bodies import Array, Bodies
from granwave.lammps_inputs.statics.packing_bodies import loaded_bodies

_PUSHED = 1e-4  # overlap with a striker / largest one in the packing


def whole(assembly: Assembly) -> Bodies:
    """Return all grains of a finite packing with their dead loads; grains of a held layer do not
    move.

    Raises
    ------
    InputError
        They do not act as springs between grains, see `refuse_resistance`.
    """
    refuse_resistance(assembly)
    return loaded_bodies(assembly)


def refuse_parts(assembly: Assembly, *, damped: bool = False) -> None:
    case = assembly.case
    support = case.boundary.bottom_support
    refuse_clumps(assembly)
    refuse_region_walls(case)
    if assembly.bars:
        raise InputError(
            f"{case.name}: {assembly.bars[0].name}: found an elastic bar, expected only grains "
            "and walls"
        )
    if support is not None and not (damped and support.absorbs):
        raise InputError(
            f"{case.name}: boundary.bottom: found a {support.kind} that moves; expected a fixed "
            "bottom, or --end matched; granwave transmission also accepts a damper"
        )
    if case.boundary.bottom_rule.repeats:
        raise InputError(
            f'{case.name}: boundary.bottom: found "periodic", expected an end ("wall", "fixed" or '
            '"free"); '
            "granwave bands without --slab accepts infinite packings"
        )
    _refuse_loads(assembly)


def _refuse_loads(assembly: Assembly) -> None:
    """Reject loads of an infinite packing for a finite packing."""
    case = assembly.case
    stage = case.precompression
    if stage is None or not isinstance(assembly.lattice, Places):
        return
    if stage.pressure is not None:
        raise InputError(
            f"{case.name}: precompression.pressure: found for grains at user-defined positions, "
            "which have no face; set a force, or compute the bands of the infinite packing"
        )
    if stage.force is not None and not case.bears_along_z:
        raise InputError(
            f"{case.name}: precompression.force: found a force on the top without a support; hold "
            "a grain along z, set boundary.bottom, or compute the bands of the infinite packing"
        )


def refuse_moved(assembly: Assembly, bodies: Bodies, network: Network, position: Array) -> None:
    """Reject a state that a static stage would not accept, since grains rearrange on the way.

    Parameters
    ----------
    bodies, position
        Grains before the load, and their centres under it: (n, 3), m.
    """
    case = assembly.case
    inside = np.isin(bodies.ids, network.ids)
    displacement = (position - bodies.position)[inside]
    moved = float(np.linalg.norm(displacement, axis=1).max(initial=0.0))
    most = largest_move(assembly)
    if moved > most:
        raise RunError(
            f"{case.name}: precompression: a grain moves by {moved / case.packing.diameter:.2g} "
            f"diameters, expected at most {most / case.packing.diameter:.2g}: the packing "
            "rearranges; confine it, or use a smaller load"
        )


def refuse_pushed(assembly: Assembly, network: Network, position: Array) -> None:
    """Reject a state in which grains press on a plate or on a striker, which nothing holds.

    Parameters
    ----------
    position
        Centres of the grains in the static state, of all or of a column: (n, 3), m.
    """
    case = assembly.case
    on_plate = np.asarray(network.supports.wall, dtype=str) == PLATE
    if on_plate.any():
        force = float(network.supports.force[on_plate].sum())
        raise InputError(
            f"{case.name}: load.kind: found a plate without support, on which the packing exerts "
            f"{force:.3g} N before the impact; use another load"
        )
    column = len(position) < np.count_nonzero(assembly.sites.present)
    if column or not assembly.strikers:
        return  # a column stands for a packing that repeats sideways, without strikers
    centres = np.concatenate([position, [centre for _, centre in assembly.strikers]])
    diameter = assembly.sphere_diameters()
    grains = np.arange(len(position))
    shapes = assembly.grain_shapes()
    lattice = assembly.lattice
    period = lattice.lengths if lattice.periodic else None
    contacts = network.contacts
    deepest = float((contacts.force / contacts.stiffness).max(initial=0.0))
    for number in range(len(assembly.strikers)):
        row = len(position) + number
        striker = np.full(len(grains), row)
        apart = distances(centres, diameter, shapes, grains, striker, period)
        overlap = (diameter[grains] + diameter[row]) / 2 - apart
        if overlap.max() > _PUSHED * deepest:
            raise InputError(
                f"{case.name}: striker.{number + 1}: found a striker on which grain "
                f"{assembly.ids[np.argmax(overlap)]} exerts a force before the impact, without "
                "support; place it elsewhere, or use another load"
            )
