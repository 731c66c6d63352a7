"""Small waves of a chain, for ``granwave check``: their speed, and the frequencies that are
blocked.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.workflows.check_part import CheckPart, Rows

_KILO = 1e-3  # kHz in a Hz
_MOST_GAPS = 3


def check(assembly: Assembly) -> CheckPart:
    """Return the output of ``granwave check`` on small waves."""
    waves = small_waves(assembly)
    return CheckPart(rows=tuple(wave_rows(waves)), values={"small_waves": waves})


def small_waves(assembly: Assembly) -> dict[str, Any] | None:
    """Return the small waves of a periodic chain under a static force; None for other
    packings.

    They follow from the bands of the infinite
    chain. Values are the cut-off, the lowest gaps below it, the speed of long waves, their travel
    time from end to end, and whether each frequency of the load passes; units are part of the
    names.
    """
    case = assembly.case
    if case.precompression is None or not case.packing.rule.is_chain:
        return None
    # imported on demand: slow to load
    from granwave.extensions.waves.spectra.band_structure import band_structure

    try:
        found = band_structure(assembly)
    except InputError:  # no repeating chain, or nothing carries the load
        return None
    highest = float(np.nanmax(found.bands.frequency))
    inside = [(gap.low, gap.high) for gap in found.gaps if gap.below and np.isfinite(gap.high)]
    low, high = assembly.lattice_bounds()
    keys = case.load.keys()
    frequencies = [keys[name] for name in ("frequency", "last_frequency") if keys.get(name)]
    speed = float(found.speeds[-1]) if len(found.speeds) else None
    length = float(high[2] - low[2])
    return {
        "highest_Hz": highest,
        "gaps_Hz": [list(gap) for gap in inside[:_MOST_GAPS]],
        "speed_m_s": speed,
        "length_m": length,
        "travel_time_s": None if speed is None else length / speed,
        "load": [
            {"frequency_Hz": one, "passes": _passes(one, highest, inside)} for one in frequencies
        ],
    }


def _passes(frequency: float, highest: float, gaps: Sequence[Sequence[float]]) -> bool:
    """Return True for a frequency up to the highest, and in none of the gaps."""
    return not (frequency > highest or any(low < frequency < high for low, high in gaps))


def wave_rows(waves: Mapping[str, Any] | None) -> Rows:
    """Return rows on `small_waves` for the table of a plan."""
    if waves is None:
        return
    bounds = ", ".join(f"{_KILO * low:.4g} to {_KILO * high:.4g}" for low, high in waves["gaps_Hz"])
    but = f", except for gaps: {bounds} kHz" if bounds else ""
    yield "small waves", f"up to {_KILO * waves['highest_Hz']:.4g} kHz{but}"
    if waves["speed_m_s"] is not None:
        long = f"long waves {waves['speed_m_s']:.4g} m/s"
        way = f"from end to end ({waves['length_m']:.3g} m)"
        yield "", f"{long}: {way} in {waves['travel_time_s']:.3g} s"
    for load in waves["load"]:
        fate = "passes" if load["passes"] else "is stopped"
        yield "load frequency", f"{_KILO * load['frequency_Hz']:.4g} kHz {fate}"
