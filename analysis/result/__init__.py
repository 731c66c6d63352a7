"""The file result.h5: writer, reader and tables."""
