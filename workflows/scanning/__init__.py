"""Scans: many runs of one case with some keys varied, on this machine or on a cluster.

scan file -> `scan_file.Scan` (points) -> `batches` (cost, jobs) -> `engine` (jobs) -> `worker` (one
batch of points) -> `driver` (state of the points, table, figures and report). `slurm` describes the
cluster.
"""
