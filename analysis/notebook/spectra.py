"""Bands, modes and transmission as datasets of xarray; each variable has its unit in ``attrs["units"]``."""

from __future__ import annotations

import numpy as np
from xarray import Dataset, Variable

from granwave.analysis.spectra.band_structure import BandStructure
from granwave.analysis.spectra.modes import Modes
from granwave.analysis.spectra.network import FREEDOMS
from granwave.analysis.spectra.states import State
from granwave.analysis.spectra.transmission import Transmission


def bands(found: BandStructure) -> Dataset:
    """Return bands along a path.

    Returns
    -------
    Dataset
        ``frequency`` Hz, ``group_velocity`` m/s (point, band, axis), ``edges`` Hz (band, edge), ``gaps`` Hz
        (gap, edge), ``speed`` of long waves m/s (wave); where known ``attenuation`` from plane to plane
        and ``phase`` rad (complex_frequency, root), ``slowness`` s/m (angle, wave), ``plane_frequency`` Hz over a
        plane of wave vectors (plane_k2, plane_k1, band), and of a slab ``surface_share`` (point, band), the part of
        the energy in its upper quarter. Coordinates ``distance`` and ``k`` rad/m, ``corner``. The values of
        bands.json are in ``attrs``.
    """
    path = found.bands.path
    corner = np.full(len(path.k), "", dtype=object)
    for row, name in path.corners:
        corner[row] = name
    gaps = np.array([[gap.low, gap.high] for gap in found.gaps]).reshape(-1, 2)
    variables = {
        "frequency": Variable(("point", "band"), found.bands.frequency, {"units": "Hz"}),
        "group_velocity": Variable(("point", "band", "axis"), found.bands.velocity, {"units": "m s-1"}),
        "edges": Variable(("band", "edge"), found.edges, {"units": "Hz"}),
        "gaps": Variable(("gap", "edge"), gaps, {"units": "Hz"}),
        "speed": Variable("wave", found.speeds, {"units": "m s-1"}),
    }
    coordinates = {
        "distance": Variable("point", path.distance, {"units": "rad m-1"}),
        "k": Variable(("point", "axis"), path.k, {"units": "rad m-1"}),
        "corner": Variable("point", corner.astype(str), {"units": "1"}),
        "axis": Variable("axis", list("xyz"), {"units": "1"}),
        "edge": Variable("edge", ["low", "high"], {"units": "1"}),
    }
    if (decaying := found.complex_bands) is not None:
        variables["attenuation"] = Variable(("complex_frequency", "root"), decaying.attenuation, {"units": "1"})
        variables["phase"] = Variable(("complex_frequency", "root"), decaying.phase, {"units": "rad"})
        coordinates["complex_frequency"] = Variable("complex_frequency", decaying.frequency, {"units": "Hz"})
    if found.bands.share is not None:
        variables["surface_share"] = Variable(("point", "band"), found.bands.share, {"units": "1"})
    if (plane := found.surface) is not None:
        shape = ("plane_k2", "plane_k1", "plane_band")
        variables["plane_frequency"] = Variable(shape, plane.frequency, {"units": "Hz", "plane": plane.plane})
        coordinates["plane_k1"] = Variable("plane_k1", plane.k, {"units": "rad m-1"})
        coordinates["plane_k2"] = Variable("plane_k2", plane.k, {"units": "rad m-1"})
        variables["slowness"] = Variable(("angle", "plane_wave"), plane.slowness, {"units": "s m-1"})
        coordinates["angle"] = Variable("angle", plane.angle, {"units": "rad", "plane": plane.plane})
    return Dataset(variables, coordinates, found.summary())


def modes(state: State, found: Modes) -> Dataset:
    """Return modes of a finite packing.

    Returns
    -------
    Dataset
        ``frequency`` Hz, ``participation_ratio`` (mode), ``shape`` (freedom, mode), ``density_of_states`` 1/Hz
        (density_frequency). Coordinates ``id`` and ``direction`` of each freedom.
    """
    grain, direction = state.network.freedoms
    return Dataset(
        {
            "frequency": Variable("mode", found.frequency, {"units": "Hz"}),
            "participation_ratio": Variable("mode", found.participation, {"units": "1"}),
            "shape": Variable(("freedom", "mode"), found.shape, {"units": "kg-1/2"}),
            "density_of_states": Variable("density_frequency", found.density, {"units": "Hz-1"}),
        },
        {
            "id": Variable("freedom", state.network.ids[grain], {"units": "1"}),
            "direction": Variable("freedom", [FREEDOMS[one] for one in direction], {"units": "1"}),
            "density_frequency": Variable("density_frequency", found.density_frequency, {"units": "Hz"}),
        },
        {"name": state.name},
    )


def transmission(state: State, found: Transmission) -> Dataset:
    """Return the transmission between grains.

    Returns
    -------
    Dataset
        ``amplitude_ratio``, ``phase`` rad (frequency, sensor).
    """
    return Dataset(
        {
            "amplitude_ratio": Variable(("frequency", "sensor"), found.amplitude, {"units": "1"}),
            "phase": Variable(("frequency", "sensor"), found.phase, {"units": "rad"}),
        },
        {
            "frequency": Variable("frequency", found.frequency, {"units": "Hz"}),
            "sensor": Variable("sensor", list(found.sensors), {"units": "1"}),
        },
        {"name": state.name, "drive": found.drive, "axis": found.axis, "end": found.end},
    )
