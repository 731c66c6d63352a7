"""File ``spectra.h5`` with the groups ``/bands``, ``/modes`` and ``/transmission``; each data set
has a ``unit``.
"""

from __future__ import annotations

import contextlib
import json
import tomllib
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.result.hdf5_file import new_hdf5
from granwave.analysis.versions import versions_of
from granwave.extensions.waves.files import SPECTRA_FILE
from granwave.extensions.waves.spectra.band_structure import BandStructure
from granwave.extensions.waves.spectra.bands import Modes
from granwave.extensions.waves.spectra.network import FREEDOMS, Network
from granwave.extensions.waves.spectra.states import State
from granwave.extensions.waves.spectra.transmission import Transmission
from granwave.lammps_inputs.files import regular

Table = Mapping[str, tuple[Any, str]]  # values and unit by name


def write_spectra(path: Path, state: State, tables: Mapping[str, Table]) -> None:
    """Write groups; other groups of an existing file of the same case remain."""
    earlier: dict[str, Table] = {}
    with contextlib.suppress(OSError, KeyError), h5py.File(regular(path), "r") as file:
        if file.attrs["case"] == state.case.to_toml():
            for kind in file.keys() - {name.partition("/")[0] for name in tables}:
                earlier |= _tables(file[kind])
    with new_hdf5(path) as file:
        file.attrs["name"] = state.name
        file.attrs["kind"] = "spectra"
        file.attrs["case"] = state.case.to_toml()
        file.attrs["versions"] = json.dumps(versions_of(()))
        for group, table in (earlier | dict(tables)).items():
            for name, (values, unit) in table.items():
                array = np.asarray(values)
                if array.dtype.kind in "OU":
                    array = array.astype(h5py.string_dtype())
                file.create_dataset(f"{group}/{name}", data=array).attrs["unit"] = unit


def read_spectra(directory: Path, kind: str) -> tuple[dict[str, Any], Mapping[str, Table]]:
    """Read the values and the groups that a command wrote to a directory.

    Parameters
    ----------
    kind
        Name of the command, of `SPECTRA_KINDS`.

    Raises
    ------
    OutputFormatError
        A file is missing or damaged.
    """
    path = directory / SPECTRA_FILE
    try:
        values = json.loads(regular(directory / f"{kind}.json").read_text(encoding="utf-8"))
        with h5py.File(regular(path), "r") as file:
            return values, _tables(file[kind])
    except (OSError, ValueError, KeyError) as error:
        raise OutputFormatError(
            f"{directory}: {kind}.json or {path.name} is missing or damaged ({error}); recompute "
            f"them with  granwave {kind} CASE -o {directory} --force"
        ) from None


def _tables(parent: h5py.Group) -> dict[str, Table]:
    """Return values and units of all data sets of a group, by group and name."""
    found: dict[str, dict[str, tuple[Any, str]]] = defaultdict(dict)

    def add(_: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            group, _, own = item.name[1:].rpartition("/")
            values = item.asstr()[()] if h5py.check_string_dtype(item.dtype) else item[()]
            found[group][own] = values, str(item.attrs["unit"])

    parent.visititems(add)
    return dict(found)


def case_in(path: Path) -> str:
    """Return the text of the case of a file of spectra; empty if there is none."""
    with contextlib.suppress(OSError, KeyError), h5py.File(regular(path), "r") as file:
        return str(file.attrs["case"])
    return ""


def recorded(directory: Path) -> tuple[dict[str, Any], dict[str, str]]:
    """Return the tables of the case, and versions of the programs, of spectra.h5; empty if the file
    cannot be read.
    """
    try:
        with h5py.File(regular(directory / SPECTRA_FILE), "r") as file:
            return tomllib.loads(str(file.attrs["case"])), json.loads(str(file.attrs["versions"]))
    except (OSError, KeyError, ValueError):
        return {}, {}


def tables_of_network(group: str, state: State) -> dict[str, Table]:
    """Return the grains and springs of a state."""
    network: Network = state.network
    springs = network.springs
    walls = network.supports
    return {
        f"{group}/grains": {
            "id": (network.ids, "1"),
            "position": (network.position, "m"),
            "mass": (network.mass, "kg"),
            "periods": (network.periods, "m"),
            "periods_under_load": (state.periods, "m"),
            "left_out": (network.left_out, "1"),
        },
        f"{group}/springs": {
            "i": (network.ids[springs.first], "1"),
            "j": (network.ids[springs.second], "1"),
            "image": (springs.image, "1"),
            "normal": (springs.normal, "1"),
            "distance": (springs.distance, "m"),
            "force": (springs.force, "N"),
            "stiffness": (springs.stiffness, "N m-1"),
            "tangential_stiffness": (springs.tangential, "N m-1"),
        },
        f"{group}/wall_springs": {
            "id": (network.ids[walls.first], "1"),
            "wall": (np.array([] if walls.wall is None else walls.wall, dtype=str), "1"),
            "force": (walls.force, "N"),
            "stiffness": (walls.stiffness, "N m-1"),
        },
    }


def tables_of_bands(found: BandStructure) -> dict[str, Table]:
    """Return the groups of bands."""
    bands = found.bands
    path = found.bands.path
    grain, direction = found.state.network.freedoms
    share = {} if bands.share is None else {"surface_share": (bands.share, "1")}
    tables: dict[str, Table] = {
        "bands": {
            "k": (path.k, "rad m-1"),
            "distance": (path.distance, "rad m-1"),
            "frequency": (bands.frequency, "Hz"),
            "group_velocity": (bands.velocity, "m s-1"),
            "corner": ([row for row, _ in path.corners], "1"),
            "corner_name": ([name for _, name in path.corners], "1"),
            "edges": (found.edges, "Hz"),
            "gaps": (np.array([[gap.low, gap.high] for gap in found.gaps]).reshape(-1, 2), "Hz"),
            "speed": (found.speeds, "m s-1"),
            "unit_frequency": (found.unit_frequency, "Hz"),
            **share,
        },
        "bands/shapes": {
            "amplitude": (
                bands.shape / np.sqrt(found.state.network.masses)[None, :, None],
                "kg-1/2",
            ),
            "id": (found.state.network.ids[grain], "1"),
            "freedom": ([FREEDOMS[one] for one in direction], "1"),
        },
    }
    if found.complex_bands is not None:
        one = found.complex_bands
        tables["bands/complex"] = {
            "frequency": (one.frequency, "Hz"),
            "attenuation": (one.attenuation, "1"),
            "phase": (one.phase, "rad"),
            "direction": (one.direction, "1"),
            "spacing": (one.spacing, "m"),
        }
    if found.surface is not None:
        tables["bands/plane"] = {
            "name": (np.array(found.surface.plane, dtype=object), "1"),
            "angle": (found.surface.angle, "rad"),
            "speed": (found.surface.speed, "m s-1"),
            "slowness": (found.surface.slowness, "s m-1"),
            "k": (found.surface.k, "rad m-1"),
            "frequency": (found.surface.frequency, "Hz"),
        }
    return tables | tables_of_network("bands", found.state)


def tables_of_modes(state: State, modes: Modes) -> dict[str, Table]:
    """Return the groups of modes."""
    grain, direction = state.network.freedoms
    return {
        "modes": {
            "frequency": (modes.frequency, "Hz"),
            "participation_ratio": (modes.participation, "1"),
            "shape": (modes.shape, "kg-1/2"),
            "id": (state.network.ids[grain], "1"),
            "freedom": ([FREEDOMS[one] for one in direction], "1"),
            "density_frequency": (modes.density_frequency, "Hz"),
            "density_of_states": (modes.density, "Hz-1"),
        }
    } | tables_of_network("modes", state)


def tables_of_transmission(state: State, found: Transmission) -> dict[str, Table]:
    """Return the groups of a transmission."""
    return {
        "transmission": {
            "frequency": (found.frequency, "Hz"),
            "drive": (found.drive, "1"),
            "driven_together": (np.array(found.together, dtype=np.int64), "1"),
            "sensor": (list(found.sensors), "1"),
            "amplitude_ratio": (found.amplitude, "1"),
            "phase": (found.phase, "rad"),
        }
    } | tables_of_network("transmission", state)
