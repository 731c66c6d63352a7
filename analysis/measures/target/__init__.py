"""Protected targets: what reaches them, with and without a packing."""
