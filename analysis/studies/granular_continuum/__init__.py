"""Granular packings against each other and against the continuum: what many runs say together (thesis chapter 5).

`collect` reads the runs, `granular`, `forces`, `continuum` and `both` draw and measure; a report shows it all.
"""
