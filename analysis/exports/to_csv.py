"""Export of a run or a scan to CSV tables, for pandas and spreadsheets.

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
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.analysis.exports.staging import Staging
from granwave.analysis.result.reader import Result
from granwave.analysis.result.trajectory import GROUP
from granwave.analysis.scans.table import ScanData
from granwave.lammps_inputs.files import write_csv_rows

OUTDATED = (
    r"snapshot_\d{4,}\.csv|walls_(bottom|plate|tube|[xy]lo|[xy]hi|bar|incident_bar)\.csv|(probes|prestage)\.csv"
    r"|chain_\w+\.csv|bar_(bar|incident_bar)_\w+\.csv"
)
TABLES = ("spheres", "contacts", "wall_contacts", "energy", "probes", "prestage")
#: Columns in this order, followed by the others in the order of their names.
_FIRST = ("id", "i", "j", "wall", "step", "time", "position", "radius", "mass")
_STEP = "step"  # column of whole numbers, which result.h5 may hold as others
_ROWS = 65_536  # formatted at once, as text takes many times the memory of numbers


def export_run(result: Result, staging: Staging) -> None:
    """Write the tables of a run."""
    tables = {name: name for name in TABLES if name in result}
    tables |= {f"walls/{wall}": f"walls_{wall}" for wall in result.names("walls")}
    for group, name in tables.items():
        names = sorted(result.names(group), key=place_of_column)
        columns = {column: result.file[group][column] for column in names}
        _write(staging.path(f"{name}.csv"), columns, {column: result.unit(f"{group}/{column}") for column in columns})
    _write_chain(result, staging)
    files = [f"snapshot_{number:04d}.csv" for number in range(result.n_frames)]
    units = {"id": "1"} | {name: result.unit(f"{GROUP}/{name}/value") for name in result.quantities}
    for number, name in enumerate(files):
        values = {quantity: result.frame(number, quantity) for quantity in result.quantities}
        _write(staging.path(name), {"id": result["spheres/id"], **values}, units)
    snapshots = {
        "frame": np.arange(result.n_frames),
        "step": result[f"{GROUP}/position/step"],
        "time": result.frame_times,
        "file_name": np.array(files, dtype=object),
    }
    _write(staging.path("snapshots.csv"), snapshots, {"time": "s"})


def _write_chain(result: Result, staging: Staging) -> None:
    """Write the history of a chain and its bars: tables of positions, and one table for each quantity."""
    if "chain" not in result:
        return
    beads = [f"bead_{bead}" for bead in result["chain/id"].tolist()]
    ends = zip(result["chain/contact_i"].tolist(), result["chain/contact_j"].tolist(), strict=True)
    contacts = ["contact_{}_{}".format(*pair) for pair in ends]
    places = {"id": result["chain/id"], "position": result["chain/position"]}
    _write(staging.path("chain_beads.csv"), places, {"position": "m"})
    places = {name: result[f"chain/contact_{name}"] for name in ("i", "j", "position")}
    _write(staging.path("chain_contacts.csv"), places, {"position": "m"})
    tables = {f"chain/{name}": (f"chain_{name}", beads) for name in ("displacement", "velocity")}
    tables["chain/contact_force"] = ("chain_contact_force", contacts)
    for bar in result.names("bars"):
        position = result[f"bars/{bar}/position"]
        nodes = np.arange(1, len(position) + 1)
        _write(staging.path(f"bar_{bar}_nodes.csv"), {"node": nodes, "position": position}, {"position": "m"})
        of_nodes = [f"node_{node}" for node in nodes]
        tables |= {f"bars/{bar}/{name}": (f"bar_{bar}_{name}", of_nodes) for name in ("displacement", "velocity")}
        tables[f"bars/{bar}/force"] = (f"bar_{bar}_force", [f"element_{node}" for node in nodes[:-1]])
    for name, (file, columns) in tables.items():
        values = {"time": result["chain/time"]} | dict(zip(columns, result[name].T, strict=True))
        _write(staging.path(f"{file}.csv"), values, {"time": "s"} | dict.fromkeys(columns, result.unit(name)))


def export_scan(scan: ScanData, staging: Staging) -> None:
    """Write the table of a scan; names of summary values already contain their units."""
    _write(staging.path("points.csv"), scan.columns, {key: scan.unit(key) for key in scan.varied})


def column_name(name: str, unit: str) -> str:
    """Append the unit to a name: ``struck_velocity_m_s``."""
    suffix = unit.replace(" s-1", "_s").replace("/", "_").replace("^", "")
    return name if suffix in ("", "1") or name.endswith(f"_{suffix}") else f"{name}_{suffix}"


def place_of_column(column: str) -> int:
    """Sort key that puts the columns that name a row first."""
    return _FIRST.index(column) if column in _FIRST else len(_FIRST)


def _write(path: Path, columns: Mapping[str, NDArray | h5py.Dataset], units: Mapping[str, str]) -> None:
    """Write columns, (n,) or (n, 3), of equal length."""
    header: list[str] = []
    for name, values in columns.items():
        parts = [f"{name}_{axis}" for axis in "xyz"] if values.ndim == 2 else [name]
        header += [column_name(part, units.get(name, "1")) for part in parts]
    n_rows = max((len(values) for values in columns.values()), default=0)
    with open(path, "w", encoding="utf-8", newline="") as file:
        write_csv_rows(file, [header])
        for start in range(0, n_rows, _ROWS):
            rows = slice(start, start + _ROWS)
            cells = [text for name, values in columns.items() for text in _cells(values, rows, whole=name == _STEP)]
            write_csv_rows(file, zip(*cells, strict=True))


def _cells(values: NDArray | h5py.Dataset, rows: slice, *, whole: bool) -> Sequence[list[object]]:
    """Return one list of cells for each component, of whole numbers if all are."""
    if isinstance(values, h5py.Dataset) and h5py.check_string_dtype(values.dtype):
        values = values.asstr()
    part = np.asarray(values[rows])
    part = part.astype(np.int64) if whole else part
    return [["" if cell != cell else cell for cell in column] for column in np.atleast_2d(part.T).tolist()]
