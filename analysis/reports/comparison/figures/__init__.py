"""Figures of a comparison, a file each: curves of several runs on shared axes.

figure      definition of a figure, and the data of the runs for it
axes        lines, legends and axes that figures share
registry    the figures by name
"""
