"""Results for other programs: tables for pandas, NetCDF for xarray, VTP for ParaView, a scene for OVITO."""
