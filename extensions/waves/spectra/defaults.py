"""Default numbers of wave vectors, bands and modes."""

POINTS = 61  # wave vectors per stretch of the path
POINTS_OF_LARGE = 16  # the same for a large cell, whose Brillouin zone is small
LARGE = 150  # degrees of freedom above which a cell is large in this sense
MOST_BANDS = 30  # for a large cell
MOST_MODES = 60  # for a large packing
