"""First yield of two spheres of the chain, by hand.

Brass of R = 4.76 mm: the overlap and the force at which the contact of two begins to yield.
"""

import granwave as gw

REMARK = "R = 4.76 mm; the thesis calls 4.763 mm a diameter once"


def rows(runs):
    sphere = {"shape": "sphere", "diameter": runs[0].case.packing.diameter, "material": "brass"}
    overlap, force = gw.contact_yield("elastoplastic", [sphere, sphere])
    for what, unit, ours, theory in (
        ("Overlap", "m", overlap, 1.139e-6),
        ("Force", "N", force, 4.996),
    ):
        yield gw.Row(f"{what} at first yield", unit, ours=ours, theory=theory, where="thesis 2.4, 2.5, by hand",
                     remark=REMARK, verification=True)  # fmt: skip
