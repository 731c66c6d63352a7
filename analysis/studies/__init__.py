"""Studies: results of several runs, compared with sources and theory."""
