"""Speed of the styles, of packings, and of the reference study, measured on this machine."""

PARTS = ("styles", "sizes", "ranks", "study")
