"""Export of a run or a scan to tables: CSV for pandas and spreadsheets, NetCDF for xarray.

    spheres.csv  contacts.csv  wall_contacts.csv  energy.csv  walls_NAME.csv  probes.csv     tables of result.h5
    prestage.csv                                    of a precompressed run
    snapshots.csv  snapshot_NNNN.csv                times of the snapshots, and the spheres in each
    chain_beads.csv  chain_contacts.csv             initial positions of the beads and contacts of a chain
    chain_displacement.csv  chain_velocity.csv      history of a chain: a row for each instant, a column for each
    chain_contact_force.csv                         bead (by its id) or contact (by the ids of its beads)
    bar_NAME_nodes.csv  bar_NAME_displacement.csv   same for bars, a column for each node or element, from 1
    points.csv                                      a scan: a row for each point

Names of columns end with the unit. Numbers have the fewest digits that reproduce the double exactly, up to 17; missing
values are blank. Reading them without loss::

    pandas.read_csv("spheres.csv")                      # before pandas 3.1 with float_precision="round_trip"
    numpy.genfromtxt("spheres.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")

Export of a run or a scan to NetCDF-4, for xarray: ``result.nc`` or ``points.nc``.

Dimensions of a run: sphere, contact, wall_contact, time (of the energy record), wall_time,
probe_time, frame (of the snapshots) and axis; for a chain also chain_time, bead, chain_contact,
and NAME_node and NAME_element of bars. Names of variables begin with their group:
``sphere_peak_force(sphere)``, ``contact_i(contact)``, ``energy_kinetic(time)``,
``wall_bottom_force(wall_time)``, ``frame_displacement(frame, sphere, axis)``,
``bead_velocity(chain_time, bead)``. Each has ``units`` and ``long_name``; the case (TOML), the run
and the versions (JSON) are attributes of the file. All reals are doubles; positions in a snapshot
are ``sphere_position + frame_displacement``. A scan has the dimension point. Reading them::

    xarray.open_dataset("result.nc")

NetCDF-4 is based on HDF5: h5netcdf writes snapshots one at a time, compressed, through h5py.
scipy's writer of NetCDF-3 would keep the whole file in memory and supports neither 64-bit integers
nor strings of variable length.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable, Container, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.analysis.exports.selection import (
    ALL,
    CHAIN,
    SNAPSHOTS,
    WALLS,
    Rows,
    SelectedRows,
    Selection,
)
from granwave.analysis.result.hdf5_file import unfailing
from granwave.analysis.result.reader import Result
from granwave.analysis.result.trajectory import COMPRESSION, GROUP
from granwave.analysis.scans.table import ScanData
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import write_csv_rows

if TYPE_CHECKING:
    import h5netcdf

OUTDATED_SNAPSHOTS = r"snapshot_\d{4,}\.csv"
OUTDATED_CSV = (
    rf"{OUTDATED_SNAPSHOTS}|walls_(bottom|plate|tube|[xy]lo|[xy]hi|bar|incident_bar)\.csv|(probes|prestage)\.csv"
    r"|chain_\w+\.csv|bar_(bar|incident_bar)_\w+\.csv"
)
CSV_TABLES = ("spheres", "contacts", "wall_contacts", "energy", "probes", "prestage")
CSV_PARTS = (*CSV_TABLES, WALLS, CHAIN, SNAPSHOTS)
#: Columns in this order, followed by the others in the order of their names.
_FIRST = ("id", "i", "j", "wall", "step", "time", "position", "radius", "mass")
_STEP = "step"  # column of whole numbers, which result.h5 may hold as others
_ROWS = 65_536  # formatted at once, as text takes many times the memory of numbers


def write_run_csv(
    result: Result,
    path_of: Callable[[str], Path],
    only: Container[str] = CSV_PARTS,
    selected: Selection = ALL,
) -> None:
    """Write the tables of a run, or their selected rows; ``only``: names among `CSV_PARTS`."""
    rows = SelectedRows(result, selected)
    tables = {name: name for name in CSV_TABLES if name in result and name in only}
    if WALLS in only:
        tables |= {f"walls/{wall}": f"walls_{wall}" for wall in result.names("walls")}
    for group, name in tables.items():
        names = sorted(result.names(group), key=place_of_column)
        columns = {column: result.file[group][column] for column in names}
        _write_csv(
            path_of(f"{name}.csv"),
            columns,
            {column: result.unit(f"{group}/{column}") for column in columns},
            rows.of_table(group),
        )
    if CHAIN in only:
        _write_chain(result, path_of, rows)
    if SNAPSHOTS in only:
        _write_snapshots(result, path_of, rows)


def _write_snapshots(result: Result, path_of: Callable[[str], Path], rows: SelectedRows) -> None:
    """Write the selected spheres in each selected snapshot, and the times of these snapshots."""
    frames = rows.frames
    files = [f"snapshot_{number:04d}.csv" for number in frames]
    units = {"id": "1"} | {name: result.unit(f"{GROUP}/{name}/value") for name in result.quantities}
    for number, name in zip(frames, files, strict=True):
        values = {quantity: result.frame(number, quantity) for quantity in result.quantities}
        columns = {"id": result["spheres/id"], **values}
        _write_csv(path_of(name), columns, units, rows.of_table("spheres"))
    snapshots = {
        "frame": np.array(frames, dtype=np.int64),
        "step": result[f"{GROUP}/position/step"][frames],
        "time": result.frame_times[frames],
        "file_name": np.array(files, dtype=object),
    }
    _write_csv(path_of("snapshots.csv"), snapshots, {"time": "s"})


def _write_chain(result: Result, path_of: Callable[[str], Path], rows: SelectedRows) -> None:
    """Write the history of the selected beads of a chain and of its bars: tables of positions, and
    one table for each quantity.
    """
    if "chain" not in result:
        return
    of_beads = rows.beads
    of_contacts = rows.chain_contacts
    beads = [f"bead_{bead}" for bead in result["chain/id"][of_beads].tolist()]
    places = {"id": result["chain/id"], "position": result["chain/position"]}
    _write_csv(path_of("chain_beads.csv"), places, {"position": "m"}, of_beads)
    places = {name: result[f"chain/contact_{name}"] for name in ("i", "j", "position")}
    _write_csv(path_of("chain_contacts.csv"), places, {"position": "m"}, of_contacts)
    ends = zip(places["i"][of_contacts].tolist(), places["j"][of_contacts].tolist(), strict=True)
    contacts = ["contact_{}_{}".format(*pair) for pair in ends]
    columns_of = {"displacement": of_beads, "velocity": of_beads, "contact_force": of_contacts}
    tables = {
        f"chain/{name}": (f"chain_{name}", contacts if name == "contact_force" else beads)
        for name in columns_of
    }
    for bar in result.names("bars"):
        position = result[f"bars/{bar}/position"]
        nodes = np.arange(1, len(position) + 1)
        _write_csv(
            path_of(f"bar_{bar}_nodes.csv"),
            {"node": nodes, "position": position},
            {"position": "m"},
        )
        of_nodes = [f"node_{node}" for node in nodes]
        tables |= {
            f"bars/{bar}/{name}": (f"bar_{bar}_{name}", of_nodes)
            for name in ("displacement", "velocity")
        }
        tables[f"bars/{bar}/force"] = (
            f"bar_{bar}_force",
            [f"element_{node}" for node in nodes[:-1]],
        )
    for name, (file, columns) in tables.items():
        history = result[name].T
        group, _, quantity = name.partition("/")
        if group == CHAIN:
            history = history[columns_of[quantity]]
        values = {"time": result["chain/time"]} | dict(zip(columns, history, strict=True))
        _write_csv(
            path_of(f"{file}.csv"),
            values,
            {"time": "s"} | dict.fromkeys(columns, result.unit(name)),
            rows.of_table(CHAIN),
        )


def write_scan_csv(scan: ScanData, path_of: Callable[[str], Path]) -> None:
    """Write the table of a scan; names of summary values already contain their units."""
    _write_csv(path_of("points.csv"), scan.columns, {key: scan.unit(key) for key in scan.varied})


def column_name(name: str, unit: str) -> str:
    """Append the unit to a name: ``struck_velocity_m_s``."""
    suffix = unit.replace(" s-1", "_s").replace("/", "_").replace("^", "")
    return name if suffix in ("", "1") or name.endswith(f"_{suffix}") else f"{name}_{suffix}"


def place_of_column(column: str) -> int:
    """Return a sort key with which the columns that identify a row come first."""
    return _FIRST.index(column) if column in _FIRST else len(_FIRST)


def _write_csv(
    path: Path,
    columns: Mapping[str, NDArray | h5py.Dataset],
    units: Mapping[str, str],
    selected: Rows | None = None,
) -> None:
    """Write columns, (n,) or (n, 3), of equal length, or their selected rows."""
    n_rows = max((len(values) for values in columns.values()), default=0)
    with open(path, "w", encoding="utf-8", newline="") as file:
        for start in range(0, max(n_rows, 1), _ROWS):
            table: dict[str, NDArray] = {}
            for name, values in columns.items():
                if isinstance(values, h5py.Dataset) and h5py.check_string_dtype(values.dtype):
                    values = values.asstr()
                part = np.asarray(values[start : start + _ROWS])
                if selected is not None:
                    part = part[selected[start : start + _ROWS]]
                part = part.astype(np.int64) if name == _STEP else part
                parts = (
                    {f"{name}_{axis}": part[:, n] for n, axis in enumerate("xyz")}
                    if part.ndim == 2
                    else {name: part}
                )
                table |= {
                    column_name(own, units.get(name, "1")): column for own, column in parts.items()
                }
            cells = [
                ["" if cell != cell else cell for cell in column.tolist()]
                for column in table.values()
            ]
            write_csv_rows(file, [*([] if start else [table]), *zip(*cells, strict=True)])


_COMPRESSED_FROM = 4096  # values
_ROWS_IN_CHUNK = 32_768
#: Group of result.h5: dimension of its rows, prefix of variable names, end of descriptions, coordinates.
_TABLES = {
    "spheres": ("sphere", "sphere", "of the sphere", ("id",)),
    "contacts": ("contact", "contact", "of the contact", ("i", "j")),
    "wall_contacts": ("wall_contact", "wall_contact", "of the contact with a wall", ("wall", "id")),
    "energy": ("time", "energy", "of the packing", ("time",)),
    "probes": ("probe_time", "probe", "probed", ("time",)),
    "prestage": ("prestage", "prestage", "of the static stage", ()),
}


def write_run_netcdf(
    result: Result, path_of: Callable[[str], Path], selected: Selection = ALL
) -> None:
    """Write ``result.nc``, with the selected rows of its tables."""
    rows = SelectedRows(result, selected)
    with _create(path_of, "result.nc") as file:
        file.attrs["title"] = str(result.file.attrs["name"])
        for name in ("case", "run", "versions"):
            file.attrs[name] = str(result.file.attrs[name])
        _add(
            file,
            "axis",
            ("axis",),
            np.array(["x", "y", "z"], dtype=object),
            long_name="axis; impact goes along +z",
        )
        for group in _TABLES:
            _add_table(file, result, group, rows.of_table(group))
        for n, wall in enumerate(result.names("walls")):
            instants = _every(rows.of_table(f"walls/{wall}"))
            if n == 0:
                times = result[f"walls/{wall}/time"][instants]
                _add(file, "wall_time", ("wall_time",), times, "s", "time")
            for name in result.names(f"walls/{wall}"):
                if name != "time":
                    values = result[f"walls/{wall}/{name}"][instants]
                    unit = result.unit(f"walls/{wall}/{name}")
                    place = "on" if name == "force" else "of"
                    words = f"{name.replace('_', ' ')} {place} the wall {wall}, positive outwards"
                    _add(file, f"wall_{wall}_{name}", ("wall_time",), values, unit, words)
        _add_chain(file, result, rows)
        _add_snapshots(file, result, rows)


def write_scan_netcdf(scan: ScanData, path_of: Callable[[str], Path]) -> None:
    """Write ``points.nc``: the columns of the scan's table, with the varied keys as coordinates."""
    with _create(path_of, "points.nc") as file:
        file.attrs["title"] = scan.name
        file.attrs["case"] = scan.case_name
        file.attrs["varied"] = json.dumps(scan.varied)
        _add(
            file,
            "point",
            ("point",),
            np.arange(1, scan.n_points + 1),
            long_name="number of the point",
        )
        for name in scan:
            coordinates = {} if name in scan.varied else {"coordinates": " ".join(scan.varied)}
            _add(file, name, ("point",), scan[name], scan.unit(name), name, **coordinates)


@contextlib.contextmanager
def _create(path_of: Callable[[str], Path], name: str) -> Iterator[h5netcdf.File]:
    try:
        import h5netcdf
    except ImportError as error:
        raise InputError(
            f'--to netcdf needs h5netcdf ({error}): pip install "granwave[export]"'
        ) from None
    # libver allows attributes longer than 64 kB
    with unfailing(path_of(name)) as stream, h5netcdf.File(stream, "w", libver="v110") as file:
        yield file


def _every(rows: Rows | None) -> Rows | slice:
    """Return an index of the selected rows."""
    return slice(None) if rows is None else rows


def _add_table(file: h5netcdf.File, result: Result, group: str, rows: Rows | None) -> None:
    """Add the selected rows of a table of the result, each column with its dimension, unit and
    description.
    """
    dimension, prefix, owner, coordinates = _TABLES[group]
    names = result.names(group)
    axes = (
        ("sphere", "id"),
        ("time", "time"),
        ("probe_time", "time"),
    )  # coordinates of their dimensions
    own = {name: dimension if (dimension, name) in axes else f"{prefix}_{name}" for name in names}
    others = " ".join(own[name] for name in coordinates if own.get(name, dimension) != dimension)
    for name in names:
        values = result[f"{group}/{name}"][_every(rows)]
        dimensions = (dimension, "axis")[: values.ndim]
        described = name if own[name] == dimension else f"{name.replace('_', ' ')} {owner}"
        extra = {"coordinates": others} if others and name not in coordinates else {}
        _add(
            file, own[name], dimensions, values, result.unit(f"{group}/{name}"), described, **extra
        )


def _add_chain(file: h5netcdf.File, result: Result, rows: SelectedRows) -> None:
    """Add the history of the selected beads of a chain and of its bars."""
    if CHAIN not in result:
        return
    instants = _every(rows.of_table(CHAIN))
    for name in result.names("chain"):
        contact = name.startswith("contact_")
        own = "chain_contact" if contact else "bead"
        column = name.removeprefix("contact_")
        unit = result.unit(f"chain/{name}")
        if name == "time":
            values = result[f"chain/{name}"][instants]
            _add(file, "chain_time", ("chain_time",), values, unit, "time")
            continue
        values = result[f"chain/{name}"][..., rows.chain_contacts if contact else rows.beads]
        values = values[instants] if values.ndim == 2 else values
        dimensions = ("chain_time", own) if values.ndim == 2 else (own,)
        variable = own if (own, column) == ("bead", "id") else f"{own}_{column}"
        _add(
            file,
            variable,
            dimensions,
            values,
            unit,
            f"{column} of the {own.replace('_', ' ')}, along the chain",
        )
    for bar in result.names("bars"):
        for name in result.names(f"bars/{bar}"):
            values = result[f"bars/{bar}/{name}"]
            values = values[instants] if values.ndim == 2 else values
            unit = result.unit(f"bars/{bar}/{name}")
            own = f"{bar}_element" if name == "force" else f"{bar}_node"
            dimensions = ("chain_time", own) if values.ndim == 2 else (own,)
            _add(
                file,
                f"{own}_{name}",
                dimensions,
                values,
                unit,
                f"{name} along the {bar.replace('_', ' ')}",
            )


def _add_snapshots(file: h5netcdf.File, result: Result, rows: SelectedRows) -> None:
    frames = rows.frames
    numbers = np.array(frames, dtype=np.int64)
    _add(file, "frame", ("frame",), numbers, long_name="number of the snapshot")
    _add(file, "frame_time", ("frame",), result.frame_times[frames], "s", "time of the snapshot")
    _add(
        file,
        "frame_step",
        ("frame",),
        result[f"{GROUP}/position/step"][frames],
        long_name="time step of the snapshot",
    )
    spheres = _every(rows.of_table("spheres"))
    n_spheres = file.dimensions["sphere"].size
    for name in result.quantities:
        if name == "position":
            continue  # given by initial position and displacement
        source = result.file[f"{GROUP}/{name}/value"]
        variable = file.create_variable(
            f"frame_{name}",
            ("frame", "sphere", "axis")[: source.ndim],
            np.float64,
            chunks=(1, min(max(n_spheres, 1), _ROWS_IN_CHUNK), *source.shape[2:]),
            **COMPRESSION,
        )
        description = f"{name.replace('_', ' ')} at the snapshot"
        variable.attrs.update(
            _attributes(result.unit(f"{GROUP}/{name}/value"), description, coordinates="frame_time")
        )
        for place, number in enumerate(frames):
            variable[place] = result.frame(number, name)[spheres]


def _add(
    file: h5netcdf.File,
    name: str,
    dimensions: tuple[str, ...],
    values: NDArray,
    unit: str = "1",
    long_name: str = "",
    **attributes: str,
) -> None:
    for dimension, length in zip(dimensions, values.shape, strict=True):
        if dimension not in file.dimensions:
            file.dimensions[dimension] = length
    extra: dict[str, Any] = dict(attributes)
    kind: Any = values.dtype
    if values.dtype == bool:
        values = values.astype(np.int8)
        kind = np.int8
        extra["dtype"] = "bool"  # xarray converts it back
    elif values.dtype.kind in "OU":
        values = values.astype(object)
        kind = h5py.string_dtype()
    options = COMPRESSION if values.size >= _COMPRESSED_FROM and kind is values.dtype else {}
    variable = file.create_variable(name, dimensions, kind, **options)
    if values.size:
        variable[...] = values
    variable.attrs.update(_attributes("" if values.dtype == object else unit, long_name, **extra))


def _attributes(unit: str, long_name: str, **others: str) -> Mapping[str, str]:
    return {"long_name": long_name} | ({"units": unit.replace("^", "")} if unit else {}) | others
