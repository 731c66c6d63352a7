"""Studies: what runs that belong together say, beside sources and theory."""
