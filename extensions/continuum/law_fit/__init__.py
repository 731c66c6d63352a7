"""Fit of the contact law to a measured or computed curve."""
