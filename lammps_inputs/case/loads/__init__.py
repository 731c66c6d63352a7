"""``[load]``: the load on a packing, with a class in a separate file for each kind.

    impact         initial velocity of the impacted spheres
    striker        velocities of the [[striker]]s only
    force          force on the impacted spheres, or on the free end of the incident bar
    displacement   prescribed displacement of the impacted spheres
    plate          a rigid plate on the free top, with a mass and a velocity
    grains         velocities of the grains of packing.file only

The contract of a load is at the top of `load`; the table of all kinds, and the reader of
``[load]``, are in `registry`.
"""
