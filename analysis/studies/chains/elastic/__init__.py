"""Elastic chains of like beads: waves, trains and steady loads."""
