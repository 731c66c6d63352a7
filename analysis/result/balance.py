"""Error of the energy balance over the energy that the load puts in, of rows of the ledger or of all of it.

The error is |kinetic + elastic + dissipated - input|. It is divided by the largest |input| up to then. A prescribed
displacement also gives the moved grains their kinetic energy, and takes it back when they stop: it is left out of that
input, or the error of a grain that is pushed in fast and then held would be compared with an energy that no other grain
ever had.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import struck_of


def moved_mass(assembly: Assembly) -> float:
    """Return the mass of the grains whose displacement is prescribed, kg; 0 for other loads."""
    if assembly.case.load.kind != "displacement":
        return 0.0
    return sum(assembly.mass_of(sphere) for sphere in struck_of(assembly))


def misfit(ledger: Mapping[str, Any]) -> Any:
    """Return |kinetic + elastic + dissipated - input| of a row, or of columns, of the ledger, J."""
    return abs(ledger["kinetic"] + ledger["elastic"] + ledger["dissipated"] - ledger["input"])


def work_on_packing(ledger: Mapping[str, Any], moved: float) -> Any:
    """Return the magnitude of the input without the kinetic energy of the moved grains, of mass ``moved`` (kg), J."""
    return abs(ledger["input"] - moved * ledger["struck_velocity"] ** 2 / 2) if moved else abs(ledger["input"])
