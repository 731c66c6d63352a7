"""Chains and pairs under the elasto-plastic law."""
