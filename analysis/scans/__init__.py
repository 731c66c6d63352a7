"""Results of scans: points, table and figures."""
