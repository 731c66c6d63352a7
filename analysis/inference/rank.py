"""Rank of the equations: forces that they leave undetermined are refused, or made small by a ridge."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from granwave.analysis.inference.equations import Equations, unknown_columns
from granwave.analysis.inference.grains import Array
from granwave.lammps_inputs.errors import InputError

_DENSE = 4000  # unknowns up to which singular values are computed
_SINGULAR = 1e-10  # ratio of singular values below which forces are undetermined


def refuse_undetermined(equations: Equations, friction: Array, ridge: float) -> float | None:
    """Raise InputError if the equations leave forces undetermined, unless there is a ridge.

    Returns
    -------
    float or None
        Ratio of the extreme singular values; None for problems too large to compute them.
    """
    n_contacts = len(friction)
    keep = unknown_columns(friction, equations.motion.shape[1] // n_contacts)
    unknown, given = len(keep), equations.n_equations
    if unknown > _DENSE:
        rank, condition = min(unknown, given), None
    else:
        values = np.linalg.svd(equations.matrix[:, keep].toarray(), compute_uv=False) if given else np.zeros(1)
        rank = int(np.count_nonzero(values > _SINGULAR * values[0])) if values[0] > 0 else 0
        condition = float(values[0] / values[-1]) if rank == unknown else None
    if rank < unknown and not ridge:
        few = "fewer equations than unknowns: " if given < unknown else "equations that do not determine the forces: "
        raise InputError(
            f"{few}{given} equations of rank {rank} for {unknown} components of the forces of {n_contacts} contacts; "
            "measure strains and accelerations of more grains, lower infer.contact_tolerance, take infer.friction = 0 "
            "where it may be neglected, or give infer.ridge, which takes the smallest forces that fit"
        )
    return condition


def add_ridge(matrix: sparse.csr_array, data: Array, ridge: float) -> tuple[sparse.csr_array, Array]:
    """Add rows that keep all forces small, with ``ridge`` times the mean weight of the other rows."""
    if not ridge:
        return sparse.csr_array(matrix), data
    n = matrix.shape[1]
    size = float(np.sqrt((matrix**2).sum() / n))
    rows = sparse.diags_array(np.full(n, ridge * size))
    return sparse.csr_array(sparse.vstack([matrix, rows])), np.concatenate([data, np.zeros(n)])
