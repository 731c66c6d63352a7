"""Directions of the waves.

The rows give the fraction of the energy of the spheres, before the wave reaches an end, and the
fraction of all dissipation, within 15 degrees of the directions of contacts from the impacted
spheres. The remarks give the fraction of an isotropic distribution, which is no prediction for a
crystal. Square packings have the fastest impact. The figure
`directions` of each run is its own map.
"""

import granwave as gw
from granwave.measures import directional_spread, sphere_energies, travelling_frame

LAWS = {"hertz": "elastic", "elastoplastic": "elasto-plastic"}
FASTEST = 5.0  # m/s


def rows(runs):
    found = []
    for run in runs:
        case = run.case
        result = run.result
        velocity = run.case.striker[1].velocity
        label = f"{case.packing.kind}, {LAWS[case.contact.law]}, {max(velocity):g} m/s"
        if case.packing.kind == "square":
            if max(velocity) < FASTEST:
                continue
            label += ", out-of-plane" if velocity[2] else ", in-plane"
        energy = sphere_energies(result, travelling_frame(result))
        for what, values in (
            ("Energy", energy),
            ("Dissipation", result["spheres/dissipated_energy"]),
        ):
            if spread := directional_spread(result, values):
                found.append(
                    gw.Row(
                        f"{what} along contacts: {label}", "%", ours=100 * spread.along,
                        where="ours",
                        remark=f"Isotropic distribution: {100 * spread.even:.3g} %.",
                    )
                )  # fmt: skip
    return sorted(found, key=lambda row: row.quantity)
