"""Energy of a packing by region."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.waves.directions import energy_of_spheres
from granwave.analysis.result.reader import Result


def energy_by_region(result: Result, regions: Mapping[str, ArrayLike]) -> dict[str, Array]:
    """Share of the input that each region of a packing holds: kinetic energy, and half the elastic one of contacts.

    Parameters
    ----------
    result
        ``run.result`` of a run as `granwave.load` gives it.
    regions
        Ids of the spheres of each region, by name; strikers are spheres too.

    Returns
    -------
    dict
        At each snapshot, (n_frames,), by the name of the region. Beside them ``other spheres``, those of no region;
        ``walls``, the elastic energy of contacts with walls; and ``dissipated``, what is lost. Of an impact on regions
        that share no sphere, all together are the input.
    """
    energy = np.stack([energy_of_spheres(result, frame) for frame in range(result.n_frames)]) / result.energy_input
    rows = {name: result.rows(np.asarray(ids)) for name, ids in regions.items()}
    rest = np.setdiff1d(np.arange(energy.shape[1]), np.concatenate([*rows.values()]))
    found = {name: energy[:, chosen].sum(axis=1) for name, chosen in (rows | {"other spheres": rest}).items()}
    time, given = result["energy/time"], result["energy/input"][-1]
    for name, term in (("walls", "elastic_wall"), ("dissipated", "dissipated")):
        found[name] = np.interp(result.frame_times, time, result[f"energy/{term}"] / given)
    return found
