"""Search for the best packing: variables, limits, objective, evaluations, guards."""
