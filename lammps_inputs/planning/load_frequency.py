"""Frequencies of a load against those that contacts pass on.

No wave runs above the cut-off; grains then move by a share that falls with the square of the frequency, and the
timestep follows the load. Far above, a run takes long, and shows rounding.
"""

from __future__ import annotations

import logging
import math

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.planning.timestep import shortest_time

_LOG = logging.getLogger("granwave")
_OF_CUTOFF = 2.0  # cut-off of a row over 1/(2 pi shortest time): 2/sqrt(1.2) for Hertz's law by its mean stiffness
_FAR, _TOO_FAR = 5.0, 100.0  # times the cut-off: a warning, and an error


def check_load_frequency(assembly: Assembly) -> None:
    """Warn about a load that oscillates far above the cut-off, and refuse it where that is beyond all sense.

    Raises
    ------
    InputError
        The frequency is more than a hundred times what the contacts under the static load pass on.
    """
    case, load = assembly.case, assembly.case.load
    if not load.driven or not load.oscillates or assembly.bars or case.precompression is None:
        return
    try:
        cutoff = _OF_CUTOFF / (2 * math.pi * shortest_time(assembly))
    except (ArithmeticError, ValueError):  # no contact takes up energy
        return
    highest = load.frequencies[1]
    if highest <= _FAR * cutoff:
        return
    key = "last_frequency" if load.last_frequency and load.last_frequency > (load.frequency or 0.0) else "frequency"
    found = (
        f"{case.name}: load.{key}: found {highest:g} Hz, {highest / cutoff:.3g} times the highest frequency that the "
        f"stiffest contact passes on, about {cutoff:.3g} Hz"
    )
    if highest > _TOO_FAR * cutoff:
        raise InputError(f"{found}; expected at most {_TOO_FAR:g} times as much")
    _LOG.warning("%s: hardly anything moves, the steps follow the load, and the energy balance may suffer", found)
