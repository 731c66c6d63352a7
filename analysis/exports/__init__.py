"""Export of results to other programs: tables for pandas, NetCDF for xarray, VTP for ParaView, a
script for OVITO.
"""
