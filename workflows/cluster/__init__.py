"""Clusters: schedulers by pysqa, profiles of clusters, and jobs of single commands.

`schedulers` knows the scripts and commands of each scheduler -> `profile` describes a cluster ->
`job` submits one command, as ``granwave run --submit``. Jobs of scans are in
`granwave.workflows.scanning`.
"""
