"""The case file: what its tables may hold, and the case that comes of them."""
