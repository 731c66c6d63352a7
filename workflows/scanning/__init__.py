"""Scans: many runs of one case with some keys varied, through Snakemake, on this machine or on a cluster.

scan file -> `scan_file.Scan` (points) -> `batches` (cost, jobs) -> `engine` (Snakemake) -> `worker` (one batch of
points) -> `driver` (what is done, what is missing, table, figures and report). `profile` and `queue` know the cluster.
"""
