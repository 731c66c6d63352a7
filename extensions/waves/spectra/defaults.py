"""Default numbers of wave vectors, bands and modes."""

POINTS = 61  # wave vectors of a stretch of the path
MOST_BANDS = 30  # of a large cell
MOST_MODES = 60  # of a large packing
