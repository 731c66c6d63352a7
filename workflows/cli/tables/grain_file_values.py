"""Rows and values of ``granwave check`` for a packing from a file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from granwave.lammps_inputs.message_words import counted
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.places import Places
from granwave.lammps_inputs.packing.touching import rounding_of

_MOST_SHOWN = 6  # materials or types in a row
_UNNAMED = "of the case"  # material without a name
_SAME = 1e-9  # relative tolerance of equal sizes


def grain_file_values(assembly: Assembly) -> dict[str, Any] | None:
    """Return the content of ``packing.file``; None without a file.

    Units are part of the names.
    """
    grains = assembly.case.packing.grains
    lattice = assembly.lattice
    if grains is None or grains.reading is None or not isinstance(lattice, Places):
        return None
    reading = grains.reading
    overlaps = lattice.overlapping()[1]
    speed = np.linalg.norm(grains.velocity, axis=1)
    of_case = assembly.case.material.name or _UNNAMED
    names = [name or of_case for name in grains.material]
    return {
        "file": grains.file,
        "format": reading.format,
        "n_grains": len(grains),
        "types": reading.types,
        "materials": dict(Counter(names)),
        "smallest_diameter_m": float(grains.diameter.min()),
        "mean_diameter_m": float(grains.diameter.mean()),
        "largest_diameter_m": float(grains.diameter.max()),
        "box_m": None if reading.bounds is None else reading.bounds.tolist(),
        "periodic": "".join(
            axis for axis, is_periodic in zip("xyz", reading.periodic, strict=True) if is_periodic
        ),
        "last_place_m": rounding_of(grains) if len(grains.half_unit) else None,
        "density_kg_m3": reading.density,
        "largest_speed_m_s": float(speed.max()),
        "n_touching": lattice.n_contacts,
        "n_overlapping": len(overlaps),
        "largest_overlap_m": float(overlaps.max()) if len(overlaps) else 0.0,
    }


def grain_file_rows(values: Mapping[str, Any] | None) -> Iterator[tuple[str, str]]:
    """Yield the rows of `grain_file_values` for the table of a plan."""
    if values is None:
        return
    yield "read", f"{counted(values['n_grains'], 'grain')} of {values['file']} ({values['format']})"
    yield "diameters", _sizes(values)
    yield "materials", _counts(values["materials"])
    if len(values["types"]) > 1:
        yield "types in the file", _counts(values["types"], "of type ")
    if values["box_m"] is not None:
        edges = " × ".join(f"{high - low:.4g}" for low, high in values["box_m"])
        axes = " and ".join(values["periodic"])
        yield "box of the file", f"{edges} m" + (f", periodic along {axes}" if axes else "")
    if values["density_kg_m3"] is not None:
        low, high = values["density_kg_m3"]
        shown = f"{low:.4g}" if high - low <= _SAME * high else f"{low:.4g} to {high:.4g}"
        yield "density in the file", f"{shown} kg/m^3; the densities of the materials are used"
    if values["largest_speed_m_s"]:
        yield "velocities", f"up to {values['largest_speed_m_s']:.4g} m/s in the file"
    n_overlapping = values["n_overlapping"]
    deepest = f"{n_overlapping}, the largest by {values['largest_overlap_m']:.4g} m"
    yield "overlaps in the file", deepest if n_overlapping else "none"


def _sizes(values: Mapping[str, Any]) -> str:
    """Return smallest, mean and largest diameter in words."""
    low = values["smallest_diameter_m"]
    high = values["largest_diameter_m"]
    if high - low <= _SAME * high:
        return f"{high:.6g} m"
    mean = values["mean_diameter_m"]
    return f"{low:.6g} m to {high:.6g} m, {mean:.6g} m on average"


def _counts(counts: Mapping[str, int], before: str = "") -> str:
    """Return names with their numbers of grains, the first ones of many."""
    shown = [f"{n} {before}{name}" for name, n in list(counts.items())[:_MOST_SHOWN]]
    more = len(counts) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more else "")
