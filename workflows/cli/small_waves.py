"""Small waves on a chain under a static force, as ``granwave check`` tells them: speed, travel time, cut-off, gaps."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import assemble

_MOST_GAPS = 3
_KILO = 1e-3  # kHz in a Hz


@dataclasses.dataclass(frozen=True)
class SmallWaves:
    """Small waves on the endless chain; see `granwave.analysis.spectra`.

    Attributes
    ----------
    highest
        Cut-off frequency, Hz.
    gaps
        Lower and upper ends of the gaps below it, Hz; of the lowest ones.
    speed
        Speed of long waves, m/s; None if there are none.
    length
        Distance of the ends of the chain, m.
    load
        Frequencies of the load, Hz, and True for those that pass.
    """

    highest: float
    gaps: tuple[tuple[float, float], ...]
    speed: float | None
    length: float
    load: tuple[tuple[float, bool], ...]


def small_waves(case: Case) -> SmallWaves | None:
    """Return the small waves of a chain that repeats and bears a static force; None for other packings.

    The bands of the endless chain tell them; a finite one, with other spheres in it, has none of its own.
    """
    if case.precompression is None or case.packing.kind != "chain" or case.packing.grains is not None:
        return None
    from granwave.analysis.spectra.band_structure import band_structure  # takes longer to load than a plan to make

    try:
        found = band_structure(case)
    except InputError:  # no chain that repeats, or nothing bears the load
        return None
    highest = float(np.nanmax(found.bands.frequency))
    inside = [(gap.low, gap.high) for gap in found.gaps if gap.below and np.isfinite(gap.high)]
    low, high = assemble(case).lattice_bounds()
    frequencies = [one for one in (case.load.frequency, case.load.last_frequency) if one is not None]
    return SmallWaves(
        highest,
        tuple(inside[:_MOST_GAPS]),
        float(found.speeds[-1]) if len(found.speeds) else None,
        float(high[2] - low[2]),
        tuple((one, not (one > highest or any(a < one < b for a, b in inside))) for one in frequencies),
    )


def wave_rows(waves: SmallWaves | None) -> list[tuple[str, str]]:
    """Return rows for the table of a plan."""
    if waves is None:
        return []
    bounds = ", ".join(f"{_KILO * low:.4g} to {_KILO * high:.4g}" for low, high in waves.gaps)
    but = f", but for gaps: {bounds} kHz" if bounds else ""
    rows = [("small waves", f"up to {_KILO * waves.highest:.4g} kHz{but}")]
    if waves.speed is not None:
        time = waves.length / waves.speed
        rows.append(("", f"long ones {waves.speed:.4g} m/s: from end to end ({waves.length:.3g} m) in {time:.3g} s"))
    for frequency, passes in waves.load:
        rows.append(("load's frequency", f"{_KILO * frequency:.4g} kHz {'passes' if passes else 'is stopped'}"))
    return rows


def wave_values(waves: SmallWaves | None) -> dict[str, Any] | None:
    """Return the values of the rows; units are part of the names."""
    if waves is None:
        return None
    return {
        "highest_Hz": waves.highest,
        "gaps_Hz": [list(gap) for gap in waves.gaps],
        "speed_m_s": waves.speed,
        "length_m": waves.length,
        "travel_time_s": None if waves.speed is None else waves.length / waves.speed,
        "load": [{"frequency_Hz": frequency, "passes": passes} for frequency, passes in waves.load],
    }
