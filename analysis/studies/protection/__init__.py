"""Protection of the target below a packing: force, impulse and energy that arrive, by bottom and by
height.
"""
