"""Page of a run for a browser: the packing in three dimensions, to be turned, cut and followed in
time.
"""
