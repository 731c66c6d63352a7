"""Waves and pulses in chains: records of runs, what they show, and the closed forms beside them."""
