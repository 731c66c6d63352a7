"""Page of a run for a browser: the packing in three dimensions, which can be turned, cut and
followed in time.
"""
