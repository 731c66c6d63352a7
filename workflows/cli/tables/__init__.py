"""Tables and values that commands print."""
