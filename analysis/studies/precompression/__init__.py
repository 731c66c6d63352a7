"""Chains and packings with a past: precompressed, settled, preconditioned, hit before."""
