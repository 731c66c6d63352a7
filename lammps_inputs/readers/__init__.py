"""Readers of packings that other programs wrote, found by the content of the file.

grain_table   result of a reader
source        a file that is read: its bytes, its text, and the options of the user
packed        files that are packed, or of kinds that hold no grains
columns       columns of a file as quantities of grains, by usual names and units
registry      readers by the name of their format; reading of any file

A format each: table, lammps_dump, lammps_data, yade, mercury, xyz, vtk_files, h5md, ase_files;
``recognises`` returns True for a file of it, ``read`` returns the grains.
"""
