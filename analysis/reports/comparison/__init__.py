"""Comparison of runs: largest differences, differences between their cases, and curves on shared
axes.

subjects    runs with distinct labels
values      values of their summaries: which differ most
cases       keys of their cases, and grains, that differ
curves      forces, energies, peaks by depth and fronts of a run, as curves
fields      peak forces on a section, side by side
figures     the figures
measured    a measured curve, and its difference from each run
compare     start of a comparison, with checks of the names
comparison  all of it for some runs
blocks      it as a section of a report
page        a page of its own, and lines for the terminal
"""
