"""Numbers, units and values of a case, as people read them."""
