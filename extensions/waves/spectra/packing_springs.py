"""Springs of the loaded contacts of a packing in its static state, for small motions about it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from granwave.extensions.waves.spectra.network import Network, Springs
from granwave.lammps_inputs.statics.bodies import Array, Bodies, NeighbourPairs, joined

_NEGLIGIBLE = 1e-12  # overlap / mean diameter due to rounding
_UNLOADED = 1e-7  # force / largest force of contacts that carry only the residual of the balance


def network_of(
    bodies: Bodies,
    position: Array,
    periods: Array,
    peak: Callable[[NeighbourPairs], Array] | None = None,
) -> Network:
    """Return the springs of the loaded contacts in a state.

    Parameters
    ----------
    position
        Centres in the static state: (n, 3), m.
    periods
        Periods in the static state: (n_periods, 3), m.
    peak
        Function that returns the largest overlaps of contacts so far, m; by default the overlaps of
        the state.
    """
    near = bodies.near(position, periods, -_NEGLIGIBLE * bodies.spacing)
    springs = springs_of(bodies, near, None if peak is None else peak(near))
    least = _UNLOADED * springs.force.max(initial=0.0)
    loaded = (springs.force > least) & (springs.stiffness > 0)
    return network_with(bodies, joined([springs], loaded))


def network_with(bodies: Bodies, springs: Springs) -> Network:
    """Return the network of these contacts, without grains that have no contact."""
    arrays = (
        bodies.ids,
        bodies.position,
        bodies.mass,
        bodies.inertia,
        bodies.moves,
        bodies.periods,
    )
    return Network(*arrays, springs).without_idle()


def springs_of(bodies: Bodies, contacts: NeighbourPairs, peak: Array | None = None) -> Springs:
    """Return the springs of contacts; ``peak`` are the largest overlaps so far, (n,), m, by default
    the present overlaps.
    """
    most = contacts.overlap if peak is None else np.maximum(contacts.overlap, peak)
    force, stiffness, tangential, rolling, twisting = np.zeros((5, len(most)))
    for law, rows, scale in bodies.laws_of(contacts):
        overlap = contacts.overlap[rows]
        force[rows], stiffness[rows], tangential[rows] = law.small(overlap, most[rows], scale)
        if bodies.case.has_resistance:
            rolling[rows], twisting[rows] = law.resisting(overlap, most[rows], scale)
    lever = np.where(
        np.isfinite(contacts.radii), contacts.radii - contacts.overlap[:, None] / 2, 0.0
    )
    return Springs(
        contacts.first, contacts.second, contacts.image, contacts.normal, contacts.distance, force, stiffness,
        tangential, lever, contacts.turns, contacts.wall, rolling, twisting,
    )  # fmt: skip
