"""Scans: points, table and figures."""
