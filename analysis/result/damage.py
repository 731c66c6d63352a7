"""Check of a ``result.h5`` when it is opened: required content, and columns of equal length."""

from __future__ import annotations

import json
import tomllib

import h5py

from granwave.analysis.result.trajectory import GROUP

#: Columns that every result has, by table.
_COLUMNS = {
    "spheres": ("id", "position", "radius", "mass", "peak_force", "dissipated_energy"),
    "contacts": ("i", "j", "peak_force", "peak_overlap", "dissipated_energy"),
    "energy": ("step", "time", "kinetic", "elastic", "dissipated", "input"),
}
_TEXTS = ("wall",)  # columns of text


def damage_of(file: h5py.File) -> str:
    """Describe the damage of a result; empty if there is none.

    Values of data sets are not read.
    """
    try:
        tomllib.loads(file.attrs["case"])
        for name in ("run", "versions"):
            if not isinstance(json.loads(file.attrs[name]), dict):
                return f"its {name} is no table"
        return _of_tables(file) or _of_trajectory(file)
    except (OSError, RuntimeError, KeyError, AttributeError, TypeError, ValueError) as error:  # of h5py and the parsers
        return " ".join(str(error.args[0] if error.args else error).split())


def _of_tables(file: h5py.File) -> str:
    tables = {name: file[name] for name in (*_COLUMNS, "wall_contacts", "probes") if name in file}
    tables |= {f"walls/{name}": table for name, table in file.get("walls", {}).items()}
    for name, required in _COLUMNS.items():
        if missing := [column for column in required if column not in tables.get(name, ())]:
            return f"it has no {name}/{missing[0]}"
    for name, table in tables.items():
        lengths = {column: values.shape[0] for column, values in table.items()}
        first = next(iter(lengths), "")
        for column, length in lengths.items():
            if length != lengths[first]:
                return f"{name}/{column} has {length} rows, {name}/{first} {lengths[first]}"
            if table[column].dtype.kind not in "biuf" and column not in _TEXTS:
                return f"{name}/{column} does not hold numbers"
    if not len(file["energy/time"]) or not len(file["spheres/id"]):
        return "it holds no instant or no sphere"
    return "" if file["spheres/position"].shape[1:] == (3,) else "spheres/position does not hold vectors"


def _of_trajectory(file: h5py.File) -> str:
    n_spheres, n_frames = len(file["spheres/id"]), len(file[f"{GROUP}/position/time"])
    for name, element in file[GROUP].items():
        shape = element["value"].shape[:2] if isinstance(element, h5py.Group) and "value" in element else None
        if shape not in (None, (n_frames, n_spheres)):
            return f"{GROUP}/{name} holds {shape[0]} snapshots of {shape[1]} spheres, not {n_frames} of {n_spheres}"
    return ""
