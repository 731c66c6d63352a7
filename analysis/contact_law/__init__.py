"""Curves of contact laws, and fits to measured curves."""
