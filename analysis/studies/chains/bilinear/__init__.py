"""Chains under the bilinear law."""
