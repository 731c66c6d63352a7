"""Check of the static equilibrium of a precompressed packing, from the record of the static stage."""

from __future__ import annotations

from pathlib import Path

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.deck.static_stage import largest_move
from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.run_directory import DUMPS, STATIC_STAGE_FILE

LARGEST_RESIDUAL = 1e-6  # largest net force on a sphere over the largest contact force

FORCE_TOLERANCE = 1e-4  # of the force of walls that are moved to a force

_ADVICE = (
    'the packing is not confined: take boundary.sides = "periodic", or precompression.kind = "uniform" (without '
    "friction a pile spreads, also between walls, and a sphere beside a vacancy may lose its hold)"
)
_SUPPORT = "; or the bottom gave way: take a stiffer boundary.bottom"


def check_equilibrium(case: Case, directory: Path) -> dict[str, float]:
    """Read and check the record of the static stage.

    Returns
    -------
    dict
        Values by column, see `granwave.lammps_inputs.deck.static_stage.RECORD`; SI units.

    Raises
    ------
    RunError
        The packing is not in equilibrium, or has rearranged.
    """
    title, values = (directory / DUMPS / STATIC_STAGE_FILE).read_text(encoding="ascii").splitlines()[:2]
    found = dict(zip(title.lstrip("#").split(), map(float, values.split()), strict=True))
    advice = _ADVICE + (_SUPPORT if case.boundary.bottom_support is not None else "")
    moved, limit = (length / case.packing.diameter for length in (found["displacement"], largest_move(assemble(case))))
    if not moved <= limit:
        raise RunError(
            f"precompression: a sphere moved by {moved:.2g} diameters, expected at most {limit:.2g}; {advice}"
        )
    if not found["residual"] <= LARGEST_RESIDUAL:
        raise RunError(
            f"precompression: no balance after {found['iterations']:.0f} iterations: a net force of "
            f"{found['residual']:.1e} of the largest contact force is left, expected at most {LARGEST_RESIDUAL:.0e}; "
            f"{advice}"
        )
    for name, asked in (case.precompression.presses if case.precompression else {}).items():
        force = found[f"force_{name}"]
        if not abs(force / asked - 1) <= FORCE_TOLERANCE:
            raise RunError(
                f"precompression: the {name} walls bear {force:.6g} N after the static stage, expected {asked:.6g} N: "
                "their distance is found with elastic contacts, and under this force some yield, or the walls press "
                f"on nothing; take a smaller {name}_force, or give the distance {name}"
            )
    return found
