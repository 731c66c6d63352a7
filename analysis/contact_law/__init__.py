"""Curves of the contact law, and its fit to measured curves."""
