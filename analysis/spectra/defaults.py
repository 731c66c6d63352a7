"""How many wave vectors, bands and modes are found unless a user says so."""

POINTS = 61  # wave vectors of a stretch of the path
MOST_BANDS = 30  # of a large cell
MOST_MODES = 60  # of a large packing
