"""The case file: keys of its tables, and the case that is read from them."""
