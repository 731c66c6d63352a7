"""First yield of two spheres of the chain, calculated by hand.

The rows give the overlap and the force at which the contact of two brass spheres of R = 4.76 mm
begins to yield.
"""

import granwave as gw

REMARK = "R = 4.76 mm; in one place the thesis calls 4.763 mm a diameter"


def rows(runs):
    sphere = {"shape": "sphere", "diameter": runs[0].case.packing.diameter, "material": "brass"}
    overlap, force = gw.contact_yield("elastoplastic", [sphere, sphere])
    for what, unit, ours, theory in (
        ("Overlap", "m", overlap, 1.139e-6),
        ("Force", "N", force, 4.996),
    ):
        yield gw.Row(f"{what} at first yield", unit, ours=ours, theory=theory, where="thesis 2.4, 2.5, by hand",
                     remark=REMARK, verification=True)  # fmt: skip
