"""Chains of spheres: what a run of one shows, and the studies of the sources beside ours."""
