"""Static states of grains, by Newton's method on the energy of contacts and loads."""
