"""Results for scripts and notebooks: runs and scans with pandas tables, xarray fields and
matplotlib axes.
"""
