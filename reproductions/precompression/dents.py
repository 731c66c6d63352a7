"""Effect of keeping the plastic indentation.

Each packing is run twice. Indentations are kept (boundary.forget_gap of 0.1 diameters), or
forgotten as soon as the undeformed spheres separate (1e-9 diameters). The second choice corresponds
to the plastic laws of LIGGGHTS, YADE and MercuryDPM that we read, and to the contact history of
LAMMPS's own granular styles, which ends when the distance exceeds the sum of the radii.
Indentations in rigid walls are kept in both runs. Chains that rattle move chaotically: there the
sign and the order of magnitude of a change are meaningful, but not its digits.
"""

import math

import numpy as np

from granwave.measures import Chain

LITTLE = 0.01  # relative
SAME = 5e-4  # relative change below the digits shown
VALUES = {
    "Dissipated": ("J", "energy_dissipated_J"),
    "Largest contact force": ("N", "peak_force_N"),
    "Largest force at the bottom": ("N", "wall_peak_force_N"),
}


def pairs(runs):
    """Runs with indentations kept and forgotten, by their description."""
    found = {}
    for run in sorted(runs, key=lambda run: -run.case.boundary.forget_gap):
        found.setdefault(words(run), []).append(run)
    return found


def words(run):
    """``Chain of 5 spheres with gaps of 0.1 mm; impact on 5 at 5 m/s``."""
    case = run.case
    load = run.case.load
    packing = run.case.packing
    count = run["n_spheres"]
    if packing.kind == "fcc":
        parts = [f"FCC packing of {' × '.join(map(str, packing.size))} spheres"]
    else:
        gap = np.diff(np.sort(run.spheres.position_z)).max() - packing.diameter
        parts = [
            f"Chain of {count} spheres"
            + (f" with gaps of {1e3 * gap:.3g} mm" if gap > 1e-6 else "")
        ]
    if packing.diameter_scatter:
        parts.append(f"diameter scatter {1e6 * packing.diameter_scatter:.3g} µm")
    if case.has_initial_dents:
        parts.append("preconditioned contacts")
    if load.kind == "displacement":
        return f"{', '.join(parts)}; shaken by ± {1e6 * load.amplitude:.3g} µm at {load.frequency:.4g} Hz"
    return (
        f"{', '.join(parts)}; impact on {len(load.index) if load.index else load.spheres} at {load.velocity:g} "
        "m/s"
    )


def change(pair, key):
    """Relative change by forgetting; infinite if the value was 0."""
    before, after = (run[key] for run in pair)
    return after / before - 1 if before else math.inf if after else 0.0


def shown(size):
    if not math.isfinite(size):
        return "from none"
    return f"{100 * size:+.2g} %" if abs(size) >= SAME else "0 %"


def tables(runs):
    found = pairs(runs)
    columns = {"Packing of 10 mm brass spheres, and load": list(found)}
    for heading, (unit, key) in VALUES.items():
        for word, place in (("kept", 0), ("forgotten", 1)):
            columns[f"{heading}: {word} ({unit})"] = [pair[place][key] for pair in found.values()]
        columns[f"{heading}: change"] = [shown(change(pair, key)) for pair in found.values()]
    yield "Indentations kept, and forgotten where the undeformed spheres separate", columns
    run = next(kept for kept, _ in found.values() if kept.case.load.kind == "impact")
    velocity = run.case.load.velocity
    kept, forgotten = restitution_at_zero_force(Chain(run).law, run.case.sphere_mass / 2, velocity)
    yield (
        "If indentations were forgotten at zero force, where spheres still overlap by the "
        f"indentation, energy would be created. Two such spheres that collide at {velocity:g} "
        f"m/s separate with {kept:.3f} of this speed, and would separate with {forgotten:.3f} "
        "(by the law alone). No run can show this, and we know no program with such a law."
    )


def verdict(runs):
    changes = [(name, change(pair, "energy_dissipated_J")) for name, pair in pairs(runs).items()]
    small = [name for name, size in changes if abs(size) < LITTLE]
    large = [f"{name} ({shown(size)})" for name, size in changes if abs(size) >= LITTLE]
    yield (
        f"Forgetting changes the dissipated energy by less than 1 % in these cases: {'. '.join(small)}."
    )
    yield f"It changes the dissipated energy by more in these cases: {'. '.join(large)}."


def restitution_at_zero_force(law, mass, velocity):
    """Restitution if the indentation is kept, and if it is forgotten when the force falls to zero.

    A new contact that overlaps by the indentation releases the energy that loading to this overlap
    would have stored; it leaves a smaller indentation, which is forgotten too, and so on.
    """
    energy = 0.5 * mass * velocity**2
    overlap = np.geomspace(1e-3, 1, 4000) * law.valid_overlap
    peak = float(np.interp(energy, law.loading_work(overlap), overlap))
    kept = returned = energy - float(law.dissipated_energy(peak))
    while (peak := float(law.residual_overlap(peak))) > 0:
        returned += float(law.loading_work(peak)) - float(law.dissipated_energy(peak))
    return math.sqrt(kept / energy), math.sqrt(returned / energy)
