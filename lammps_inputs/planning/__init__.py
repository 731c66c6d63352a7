"""Timestep, schedule and cost of a run, before it is run."""
