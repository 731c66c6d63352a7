"""The functions of ``import granwave as gw``."""
