"""Tables of text with any separator, decimal sign, header and comments.

layout      rows of a text, their separator and decimal sign
text_table  columns of a table, read by pandas
encoding    encodings of the text
units       units in the names of columns
digits      digits with which numbers were written
"""
