"""Checks of the static state of a packing, with the positions and forces that LAMMPS has."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.workflows.run import checks
from granwave.workflows.run.lammps_engine import Engine

if TYPE_CHECKING:
    from mpi4py.MPI import Intracomm


def look_at_strikers(engine: Engine, assembly: Assembly, comm: Intracomm) -> None:
    """Warn of strikers that no longer touch their spheres after the static stage."""
    chosen = set(chain.from_iterable(assembly.striker_contacts))
    if not chosen:
        return
    centres = _gathered(engine, comm, "x", chosen.__contains__)
    if centres is not None:
        checks.warn_of_strikers(assembly, centres)


def look_at_rolling(
    engine: Engine, assembly: Assembly, comm: Intracomm, found: Mapping[str, float]
) -> None:
    """Warn of grains that still roll after the static stage of a bed.

    Parameters
    ----------
    found
        Result of `checks.check_equilibrium`.
    """
    n = assembly.lattice.n_spheres
    forces = _gathered(engine, comm, "f", lambda number: number <= n)
    if forces is not None:
        checks.warn_of_rolling(assembly, found, forces)


def _gathered(
    engine: Engine, comm: Intracomm, name: str, chosen: Callable[[int], bool]
) -> dict[int, NDArray[np.float64]] | None:
    """Return a vector of the chosen grains by their number, on the first rank; otherwise None."""
    rows = zip(engine.per_atom("id").tolist(), engine.per_atom(name).tolist(), strict=True)
    parts: list[list[Any]] | None = comm.gather([row for row in rows if chosen(row[0])])
    if parts is None:
        return None
    return {number: np.array(vector) for number, vector in chain.from_iterable(parts)}
