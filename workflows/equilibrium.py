"""Is a precompressed packing in balance before the impact? The static stage's own record is checked."""

from __future__ import annotations

from pathlib import Path

from granwave.lammps_inputs.case import Case
from granwave.lammps_inputs.deck import DUMPS
from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.prestage import LARGEST_MOVE, PRESTAGE_FILE

LARGEST_RESIDUAL = 1e-6  # of the largest contact force: net force on a sphere

_ADVICE = (
    'the packing is not confined: take boundary.sides = "wall" or "periodic", or precompression.kind = "uniform" '
    "(without friction a pile spreads, and a sphere beside a vacancy may lose its hold)"
)


def check_equilibrium(case: Case, directory: Path) -> dict[str, float]:
    """Read the record of the static stage, and check it.

    Returns
    -------
    dict
        Its columns, see `granwave.lammps_inputs.prestage.RECORD`; SI units.

    Raises
    ------
    RunError
        The packing found no balance, or lost its shape.
    """
    title, values = (directory / DUMPS / PRESTAGE_FILE).read_text(encoding="ascii").splitlines()[:2]
    found = dict(zip(title.lstrip("#").split(), map(float, values.split()), strict=True))
    moved = found["displacement"] / case.packing.diameter
    if not moved <= LARGEST_MOVE:
        raise RunError(
            f"precompression: a sphere moved by {moved:.2g} diameters, expected at most {LARGEST_MOVE}; {_ADVICE}"
        )
    if not found["residual"] <= LARGEST_RESIDUAL:
        raise RunError(
            f"precompression: no balance after {found['iterations']:.0f} iterations: a net force of "
            f"{found['residual']:.1e} of the largest contact force is left, expected at most {LARGEST_RESIDUAL:.0e}; "
            f"{_ADVICE}"
        )
    return found
