"""The file result.h5: writer, reader, and the tables in it."""
