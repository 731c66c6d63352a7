"""Packings: forces and energies of single spheres.

The impact is on one sphere of an FCC packing of 36 × 36 × 18 spheres, along [111]. Peak forces are
divided by F_y, the force at first yield.
"""

import math

import numpy as np
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure

import granwave as gw

LARGEST_FORCE = 700.0  # F_y: end of the colours of Fig. 5.3, whose velocity is not printed
# along a preferred direction; with a point below the struck sphere
CONTACTS = 7
LAYER = 3
ON = 0.25  # largest distance of a sphere from its site, diameters
SHOWN = (4, 10, 40)  # m/s
# of Fig. 5.3: m/s, nearest to the velocity with its largest force; deepest layers shown, diameters;
# distance of spheres from a plane, diameters
MAPPED = 25
SHALLOW = 8.0
IN_PLANE = 0.1


def directions(run):
    """Number of layers, from the first, whose largest force is on a preferred direction; and the
    force straight below divided by the force in that direction.
    """
    result = run.result
    ways = gw.measures.rays(run.result).directions
    offset = (result["spheres/position"] - result.origin) / run.case.packing.diameter
    force = result["spheres/peak_force"]
    layer = np.rint(offset[:, 2] / ways[0, 2]).astype(int)

    def distance(n):
        return np.linalg.norm(offset[:, None] - n * ways, axis=2).min(axis=1)

    for n in range(1, layer.max() + 1):
        there = np.flatnonzero(layer == n)
        if distance(n)[there[force[there].argmax()]] > ON:
            break
    below = force[(layer == LAYER) & (np.hypot(*offset[:, :2].T) < ON)].max()
    return n - 1, below / force[distance(LAYER) < ON].max()


def struck_once(runs):
    """Runs with one impacted sphere by velocity."""
    return {run.case.load.velocity: run for run in sorted(runs, key=lambda run: run.case.load.velocity)
            if run.case.load.spheres == 1}  # fmt: skip


def plane_spheres(run, across, along):
    """Positions of the spheres whose centres are in the plane of two unit vectors through the
    impact point, diameters, and their largest contact forces, N: (n_spheres, 2) and (n_spheres,).
    """
    result = run.result
    offset = (result["spheres/position"] - result.origin) / run.case.packing.diameter
    place = np.stack([offset @ across, offset @ along], axis=1)
    off = np.abs(offset @ np.cross(across, along))
    chosen = (off < IN_PLANE) & (place[:, 1] < SHALLOW) & (np.abs(place[:, 0]) < SHALLOW)
    return place[chosen], result["spheres/peak_force"][chosen]


def principal_planes(run):
    """Unit vectors across and along the planes OAB and OCD of thesis Fig. 5.2, by their names."""
    first, second, third = gw.measures.rays(run.result).directions
    depth = np.array([0.0, 0.0, 1.0])
    aside = third * (1 - depth)
    return {
        "OAB": (first - second, (first + second) / np.linalg.norm(first + second)),
        "OCD": (aside / np.linalg.norm(aside), depth),
    }


def rows(runs):
    found = struck_once(runs)
    ten = found[10]
    fast = found[40]
    sphere = {"shape": "sphere", "diameter": 0.01, "material": "brass"}
    _, yield_force = gw.contact_yield("elastoplastic", [sphere, sphere])
    force = [run["peak_force_N"] / yield_force for run in found.values()]
    along = np.nanmean(gw.measures.rays(ten.result).peak_force, axis=1)[:CONTACTS]
    count, below = directions(ten)
    volume = math.pi * 0.01**3 / 6
    involved = gw.measures.spheres_involved(fast.result, fast["energy_input_J"])
    name = f"normalised velocity {fast['velocity_normalised']:.3g}"
    unit = fast["energy_input_J"] / fast["energy_input_normalised"]
    # fmt: off
    yield gw.Row("Velocity with the largest force of Fig. 5.3, 700 F_y", "m/s", where="thesis Fig. "
                                                                                      "5.3",
                                                                                          digits=3,
                 ours=np.interp(LARGEST_FORCE, force, list(found)),
                 remark="The source prints no velocity; its Fig. 5.8 has 4, 10 and 40 m/s.")
    for what, ours, remark, digits in (
        (f"Decay of the peak force per contact along a preferred direction, contacts 1 to "
         f"{len(along)}, 10 m/s",
         -np.polyfit(np.arange(len(along)), np.log(along), 1)[0],
             "The source describes a rapid decay, as in its chains.", 3),
        ("Layers whose largest force lies on a preferred direction, 10 m/s", count,
            "The source states that these are the first few layers.", 5),
        ("Force straight below the impacted sphere / force on a preferred direction, layer "
         f"{LAYER}, "
         "10 m/s", below,
         "In the source the force is highest in the preferred directions.", 3),
    ):
        yield gw.Row(what, ours=ours, where="thesis 5.2, Fig. 5.3", remark=remark, digits=digits)
    yield gw.Row(f"Largest dissipation of a sphere (thesis 5.15), {name}, at most", source=1e6, bound=True, digits=3,
                 ours=2 * 16 / 15 * fast.result["spheres/dissipated_energy"].max() / unit, where="thesis Fig. 5.8",
                 remark="The bound is the end of the axis; the source counts each contact at both "
                        "of its spheres.")
    yield gw.Row(f"Spheres with half of the dissipation, {name}",
        ours=involved.part(0.5)[1] / volume,
                 where="thesis Fig. 5.8", remark=("According to the source the first few spheres "
                                                  "have most of the dissipation."))
    yield gw.Row(f"Dissipated fraction of a packing, {fast['energy_input_J']:.3g} J, at most",
        source=0.9, bound=True,
                 ours=fast["dissipated_fraction"], where="thesis Fig. 5.13",
                 remark="The bound is the end of the axis; the axes of Figs 5.5 to 5.7, for the "
                        "same packings, end at 1.")
    # fmt: on


def pictures(runs):
    found = struck_once(runs)
    data = {}
    axes = Figure((3.4, 2.6), layout="constrained").subplots()
    for velocity, style in zip(SHOWN, ("C0", "C1--", "k-."), strict=True):
        run = found[velocity]
        unit = run["energy_input_J"] / run["energy_input_normalised"]
        values = 2 * 16 / 15 * np.sort(run.result["spheres/dissipated_energy"])[::-1] / unit
        values = values[values > 0]
        axes.loglog(1 + np.arange(len(values)), values, style, label=f"{velocity} m/s")
        data[f"dissipation_at_{velocity}_m_s"] = values
    axes.set(
        xlabel="Sphere, in order of decreasing dissipation", ylabel="Dissipation (thesis 5.15)"
    )
    axes.legend()
    caption = (
        "Dissipation of the spheres in descending order, with each contact counted at both of its "
        "spheres (thesis Fig. 5.8). The steeper the curve, the fewer spheres dissipate most of "
        "the energy; at higher velocities the curve extends further"
    )
    yield gw.Picture("dissipation_of_spheres", caption, axes.figure, data)
    if MAPPED in found:
        yield peak_force_map(found[MAPPED])


def peak_force_map(run):
    """Peak contact forces in the two planes of thesis Fig. 5.3."""
    diameter = run.case.packing.diameter
    sphere = {"shape": "sphere", "diameter": diameter, "material": run.case.material.name}
    _, yield_force = gw.contact_yield("elastoplastic", [sphere, sphere])
    figure = Figure((5, 5.6), layout="constrained")
    panels = figure.subplots(2, 1)
    data = {}
    for axes, (name, vectors) in zip(panels, principal_planes(run).items(), strict=True):
        place, force = plane_spheres(run, *vectors)
        reduced = force / yield_force
        circles = EllipseCollection(
            1, 1, 0, units="xy", offsets=place, offset_transform=axes.transData, array=reduced,
            cmap="viridis_r",
        )  # fmt: skip
        circles.set_norm("log")
        circles.set_clim(1.0, LARGEST_FORCE)
        axes.add_collection(circles)
        axes.set(title=f"Plane {name}", xlabel="Across (diameters)", ylabel="Down (diameters)")
        axes.set(xlim=(-SHALLOW, SHALLOW), ylim=(SHALLOW, -1), aspect="equal")
        data |= {
            f"{name}_across_diameters": place[:, 0],
            f"{name}_down_diameters": place[:, 1],
            f"{name}_force_over_yield_force": reduced,
        }
    figure.colorbar(circles, ax=panels, label="Largest contact force of a sphere / $F_y$")
    caption = (
        f"Largest contact forces of the spheres in two planes through the impact point, {MAPPED} "
        "m/s (thesis Fig. 5.3, whose velocity is not printed). The principal plane OAB contains "
        "two preferred directions; OCD contains the third and the direction of the impact. Colours "
        "end at the end of the scale of the source"
    )
    return gw.Picture("peak_forces_in_planes", caption, figure, data)
