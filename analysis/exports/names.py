"""Names of the formats of ``granwave export``, which need no drawing and no reading of results."""

from __future__ import annotations

from granwave.lammps_inputs.extensions import added_by_name

CSV = "csv"
NETCDF = "netcdf"


def export_names() -> tuple[str, ...]:
    """Return the names of all formats, those of extensions too, in alphabetical order."""
    return tuple(sorted((CSV, NETCDF, *added_by_name("exports"))))
