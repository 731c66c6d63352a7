"""Dampers of the grains that a case lets absorb waves, ``[[absorb]]``."""

from __future__ import annotations

import numpy as np

from granwave.analysis.spectra.network import Array, Network
from granwave.lammps_inputs.contact.static_load import absorbing_ids, impedance_of, rise_of
from granwave.lammps_inputs.packing.assembly import Assembly

_FREEDOMS, _Z = 6, 2


def dampers_of(assembly: Assembly, network: Network) -> Array:
    """Return force over velocity, and moment over angular velocity, of each grain: (n_grains, 6), N s/m and N m s."""
    found = np.zeros((network.n_grains, _FREEDOMS))
    for entry in assembly.case.absorb:
        rows = np.flatnonzero(np.isin(network.ids, absorbing_ids(assembly, entry)))
        if entry.rate is None:
            found[rows, _Z] = impedance_of(assembly, entry)
            continue
        rate = np.full(len(rows), entry.rate)
        if (rise := rise_of(assembly, entry)) is not None:
            place = network.position[rows, "xyz".index(entry.towards[1])]
            rate *= np.clip((place - rise[0]) / (rise[1] - rise[0]), 0.0, 1.0) ** 2
        found[rows, :3] = (rate * network.mass[rows])[:, None]
        found[rows, 3:] = (rate * network.inertia[rows])[:, None]
    return found
