"""Checks of the installation: ``granwave doctor`` and ``granwave selftest``."""
