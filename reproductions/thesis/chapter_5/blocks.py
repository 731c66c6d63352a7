"""Blocks, and a packing compared with a block.

A rigid punch of 10 mm hits a block of brass or another material; the reference is a punch of 0.1 kg
on brass. Energies are normalised by sigma_y² D³/E (thesis 5.30), volumes by pi D³/6.
"""

import math

import numpy as np

import granwave as gw

SAME = 1e-4  # relative difference of normalised energies that are meant to be equal
BRASS = {"youngs_modulus": 115e9, "yield_strength": 550e6}
VOLUME = math.pi * 0.01**3 / 6
OF_AXIS = "The bound is the end of the axis."


def measured(runs):
    """Blocks of brass by the mass of the punch, in order of rising energy; other blocks; and the
    fastest impact on a packing.
    """
    brass = {}
    others = []
    packings = []
    for run in sorted(runs, key=lambda run: run["energy_input_J"]):
        labels = run.labels
        if "punch.velocity" in labels:
            alike = all(
                labels.get(f"material.{key}", value) == value for key, value in BRASS.items()
            )
            (brass.setdefault(labels.get("punch.mass", 0.1), []) if alike else others).append(run)
        elif labels.get("load.spheres") == 1:
            packings.append(run)
    return dict(sorted(brass.items())), others, packings[-1]


def equal(runs, run):
    """Dissipated fractions of runs at the normalised energy of another run."""
    energy = run["energy_input_normalised"]
    return [
        one["dissipated_fraction"]
        for one in runs
        if abs(one["energy_input_normalised"] / energy - 1) < SAME
    ]


def rows(runs):
    brass, others, packing = measured(runs)
    block = brass[0.1][-1]
    energy = block["energy_input_J"]
    share = block["dissipated_fraction"]
    volume = block["plastic_zone_volume_m3"] / VOLUME
    name = f"{energy:.3g} J"
    of_materials = [abs(run["dissipated_fraction"] / twin - 1) for run in others if run["energy_input_normalised"] > 1
                    for twin in equal(brass[0.1], run)]  # fmt: skip
    together = [run for group in brass.values() for run in group]
    of_masses = {True: [], False: []}
    for run in next(iter(brass.values())):
        of_masses[run["energy_input_normalised"] > 1].append(np.ptp(equal(together, run)))
    spheres = gw.measures.spheres_involved(packing.result, packing["energy_input_J"])
    between = "Largest difference in the dissipated fraction of a block between"
    # fmt: off
    yield gw.Row("Energy input / energy input, normalised", ours=energy / block["energy_input_normalised"],
                 theory=2.630, verification=True, where="thesis 5.30, by hand",
                 remark="The unit of energy is sigma_y^2 D^3 / E.")
    yield gw.Row(f"Dissipated fraction of a block, {name}, at most", source=0.7, ours=share,
        bound=True,
                 where="thesis Figs 5.10, 5.11", remark=OF_AXIS)
    yield gw.Row(f"Plastic volume of a block / (pi D^3/6), {name}, at most", source=4.0, ours=volume, bound=True,
                 where="thesis Fig. 5.12", remark=OF_AXIS)
    yield gw.Row(f"{between} materials, inputs above sigma_y^2 D^3/E", "%", source=0.0, ours=100 * max(of_materials),
                 where="thesis Fig. 5.10b", remark="The source has one curve.", digits=2)
    for word, above in (("up to", False), ("above", True)):
        yield gw.Row(f"{between} punches of different mass, inputs {word} sigma_y^2 D^3/E",
            source=0.0,
                     ours=max(of_masses[above]), where="thesis Fig. 5.11", remark=(
                         "The source states a small difference."), digits=2)
    yield gw.Row(f"Volume that dissipates {share:.2g} of the input, spheres at {packing['energy_input_J']:.3g} J / "
                 f"plastic volume of a block at {name}", source=1.0, digits=2, where="thesis 5.5, Fig. 5.14",
                 ours=np.interp(share, spheres.fraction, spheres.volume) / VOLUME / volume,
                 remark="The source calls the volumes very close. Whole spheres are counted "
                        "here, although only their contacts yield.")
    # fmt: on
