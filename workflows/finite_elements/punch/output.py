"""``result.h5`` of a continuum run, replaced whole or not at all.

    /nodes, /elements              (r, z) of the nodes; the four nodes of each element
    /element_volume                of each element
    /energy/{time, kinetic, elastic, plastic, viscous, hourglass, contact, punch, input}
    /punch/{time, displacement, velocity, force}
    /plastic_zone/{time, volume, volume_ever}
    /fields/{time, von_mises, plastic_strain, plastic_energy, ever_yielded, displacement}

``von_mises`` is (n_frames, n_elements) at ``time``; the other fields are final values. The root has the attributes
``kind``, ``name``, ``case`` (TOML), ``summary`` and ``versions`` (JSON); every data set has a ``unit``.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from granwave.workflows.finite_elements.punch import kernels
from granwave.workflows.finite_elements.punch.case import ContinuumCase
from granwave.workflows.finite_elements.punch.history import History
from granwave.workflows.finite_elements.punch.solver import Solver
from granwave.workflows.finite_elements.result_file import new_result, put_dataset

_ENERGIES = ("kinetic", "elastic", "plastic", "viscous", "hourglass", "contact", "punch")


def write_result(
    directory: Path, case: ContinuumCase, solver: Solver, history: History, summary: dict[str, Any]
) -> None:
    """Write ``result.h5`` into ``directory``."""
    with new_result(directory, "continuum", case, summary) as file:
        _write(file, case, solver, history)


def _write(file: h5py.File, case: ContinuumCase, solver: Solver, history: History) -> None:
    put = partial(put_dataset, file)
    n = solver.mesh.n_elements
    put("nodes", solver.mesh.nodes, "m")
    put("elements", solver.mesh.elements.astype(np.int32), "1")
    put("element_volume", solver.operators.volume.ravel(), "m3")
    time = history.column("time")
    put("energy/time", time, "s")
    for name in _ENERGIES:
        put(f"energy/{name}", history.column(name), "J")
    put("energy/input", np.full(len(time), case.punch.energy), "J")
    put("punch/time", time, "s")
    put("punch/displacement", history.column("punch_displacement"), "m")
    put("punch/velocity", history.column("punch_velocity"), "m s-1")
    put("punch/force", history.column("contact_force"), "N")
    put("plastic_zone/time", time, "s")
    put("plastic_zone/volume", history.column("plastic_volume"), "m3")
    put("plastic_zone/volume_ever", history.column("plastic_volume_ever"), "m3")
    put("fields/time", history.frame_times, "s")
    put("fields/von_mises", np.stack(history.von_mises).reshape(len(history.frame_times), n), "Pa")
    put("fields/plastic_strain", solver.state[:, :, kernels.STRAIN].ravel(), "1")
    put("fields/plastic_energy", solver.state[:, :, kernels.PLASTIC].ravel(), "J m-3")
    put("fields/ever_yielded", solver.ever.ravel().astype(np.uint8), "1")
    put("fields/displacement", np.column_stack([part.ravel() for part in solver.motion[:2]]), "m")
