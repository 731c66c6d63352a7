"""Small waves on a chain under a static force, as ``granwave check`` tells them: speed, travel time, cut-off, gaps."""

from __future__ import annotations

import numpy as np

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import assemble

_MOST_GAPS = 3
_KILO = 1e-3  # kHz in a Hz


def small_waves(case: Case) -> list[tuple[str, str]]:
    """Return rows for the table of a plan; none but for chains that repeat and bear a static force.

    The bands of the endless chain tell them (`granwave.analysis.spectra`); a finite one, with other spheres in it, has
    none of its own.
    """
    if case.precompression is None or case.packing.kind != "chain" or case.packing.grains is not None:
        return []
    from granwave.analysis.spectra.band_structure import band_structure  # takes longer to load than a plan to make

    try:
        found = band_structure(case)
    except InputError:  # no chain that repeats, or nothing bears the load
        return []
    highest = float(np.nanmax(found.bands.frequency))
    inside = [gap for gap in found.gaps if gap.below and np.isfinite(gap.high)]
    bounds = ", ".join(f"{_KILO * gap.low:.4g} to {_KILO * gap.high:.4g}" for gap in inside[:_MOST_GAPS])
    but = f", but for gaps: {bounds} kHz" if bounds else ""
    rows = [("small waves", f"up to {_KILO * highest:.4g} kHz{but}")]
    if len(found.speeds):
        speed = float(found.speeds[-1])
        low, high = assemble(case).lattice_bounds()
        length = float(high[2] - low[2])
        rows.append(("", f"long ones {speed:.4g} m/s: from end to end ({length:.3g} m) in {length / speed:.3g} s"))
    frequencies = [one for one in (case.load.frequency, case.load.last_frequency) if one is not None]
    for frequency in frequencies:
        stopped = frequency > highest or any(gap.low < frequency < gap.high for gap in inside)
        rows.append(("load's frequency", f"{_KILO * frequency:.4g} kHz {'is stopped' if stopped else 'passes'}"))
    return rows
