"""Plane crystals of viscoelastic cylinders: equation 7 as damping.

The grains have the instantaneous modulus of equation 7, which relaxes by its Prony series: with the
time constants in ms, with the printed seconds, and without relaxation. The only other dissipation
is friction. The printed attenuation of the hexagonal crystal is compared along its diagonal, since
the source calls the attenuation along the vertical drastically different. The speed and the second
peak are compared with the source. At the contacts of the runs its two force laws are compared: the
viscoelastic law and a linear law with an effective modulus.
"""

from typing import NamedTuple

import numpy as np
from crystal import SOURCE, Crystal
from matplotlib.figure import Figure
from motion import later_peak
from relaxation import INSTANT
from scipy.spatial import cKDTree

import granwave as gw
from granwave.measures import Chain

ELASTIC = "no relaxation"
IN_MS = "time constants in ms"
IN_S = "time constants in s"
SHORTEST = 1e-2  # s, between time constants in ms and in s
WIDE = 24  # grains a row: the sides do not reach the middle line
DECAY = {"BCC": 1.6, "HCP": 1.8}  # 1/m, printed
SPEED = 125.0  # m/s, printed
SECOND = 4.0  # ms, printed
MODULI = (150.0, 740.0)  # MPa, least and largest of the printed effective moduli
IMPULSES = (1.65, 2.2)  # per cent, printed
TOUCHING = 1.01  # diameters
CLOSE_PACKED = np.radians(30)  # of the diagonal of a hexagonal crystal from the vertical
LOADED = 0.1  # of the largest force in the crystal
EVENT = 6e-3  # s, the longest that the source says of its experiment


class Contacts(NamedTuple):
    """Effective moduli, MPa, and differences of impulses, per cent, at the contacts of a
    crystal.
    """

    modulus: np.ndarray
    impulse: np.ndarray


def relaxes(crystal):
    """Return the kind of relaxation of a crystal."""
    branches = crystal.case.contact.loss.branches
    if not branches:
        return ELASTIC
    return IN_MS if max(time for _, time in branches) < SHORTEST else IN_S


def select(runs):
    """Crystals by name, of the size of the reference and wide, each by its kind of relaxation."""
    found = {"here": {}, "wide": {}}
    for crystal in map(Crystal, runs):
        size = "wide" if crystal.count >= WIDE else "here"
        found[size].setdefault(crystal.name, {})[relaxes(crystal)] = crystal
    return [found]


def decay_of(crystal):
    """Rate of the decay of the peak speed by one exponential, 1/m."""
    line = crystal.down
    known = line.fitted
    return -np.polyfit(line.distance[known], np.log(line.peak_speed[known]), 1)[0]


def decay_along_diagonal(crystal):
    """Decay rate of the peak speed along a close-packed line of a hexagonal crystal, 1/m, over the
    grains whose peak precedes any signal from the sides.
    """
    result = crystal.run.result
    position, velocity = (result[f"lines/all/{name}"] for name in ("position", "velocity"))
    peak = np.linalg.norm(velocity, axis=2).max(axis=0)
    diameter = crystal.case.packing.diameter
    down = result["lines/down/position"]
    way = np.array([np.sin(CLOSE_PACKED), 0.0, np.cos(CLOSE_PACKED)])
    way[2] *= np.sign(down[-1, 2] - down[0, 2])
    # the grain below the plate is left out
    distance = diameter * np.arange(1, crystal.count // 2 + 1)
    apart, grain = cKDTree(position).query(down[0] + distance[:, None] * way)
    if apart.max() > (TOUCHING - 1) * diameter:
        raise ValueError(f"{crystal.name}: no grains along the diagonal")
    return -np.polyfit(distance, np.log(peak[grain]), 1)[0]


def contacts_of(crystal):
    """Effective moduli and impulses at the contacts of a run with relaxation.

    At the overlaps of the run the viscoelastic force is compared with that of a linear law, whose
    modulus fits it best by least squares, as long as the source's experiment lasts.
    """
    result = crystal.run.result
    time, position, displacement = (
        result[f"lines/all/{name}"] for name in ("time", "position", "displacement")
    )
    until = time <= EVENT
    time = time[until]
    displacement = displacement[until]
    diameter = crystal.case.packing.diameter
    pairs = cKDTree(position).query_pairs(TOUCHING * diameter, output_type="ndarray")
    first, second = pairs.T
    apart = position[second] - position[first] + displacement[:, second] - displacement[:, first]
    overlap = np.maximum(diameter - np.linalg.norm(apart, axis=2), 0.0)
    law = Chain(crystal.run).law_between(1, 2)
    branches = crystal.case.contact.loss.branches
    relaxed = np.array([law.relax(one, time, branches)["force"] for one in overlap.T])
    instant = law.force(overlap.T, overlap.T)
    loaded = relaxed.max(axis=1) > LOADED * relaxed.max()
    relaxed = relaxed[loaded]
    instant = instant[loaded]
    fraction = (relaxed * instant).sum(axis=1) / (instant**2).sum(axis=1)
    gained = np.trapezoid(relaxed, time) / (fraction * np.trapezoid(instant, time)) - 1
    return Contacts(INSTANT * fraction, 100 * gained)


def rows(crystals):
    here = crystals["here"]
    wide = crystals["wide"]
    for name in here:
        yield from of_decay(name, wide[name])
    for name, by_law in here.items():
        yield from of_waves(name, by_law)
    for name, by_law in here.items():
        yield from of_contacts(name, contacts_of(by_law[IN_MS]))


def of_decay(name, by_law):
    """Rows of the attenuation along the middle line of a wide crystal, where the sides have no
    effect.
    """
    rates = {law: decay_of(one) for law, one in by_law.items()}
    along_middle = name == "BCC"  # the printed one
    source = None
    words = "The source prints the rate along the diagonal (next row)."
    if along_middle:
        source = DECAY[name]
        words = "In the source the rate is higher in HCP; in our runs it is higher in BCC. "
        words += "This is not explained."
    yield gw.Row(
        f"Decay of the peak speed in region 1, {IN_MS}, {name}", "1/m", source, rates[IN_MS],
        f"{SOURCE}, Fig. 7", digits=3,
        remark="The decay is fitted by one exponential in a crystal of 24 grains per row; plate "
               f"and friction are not printed. Without relaxation it is {rates[ELASTIC]:.2g}. "
               f"{words}",
    )  # fmt: skip
    if not along_middle:
        diagonal = {law: decay_along_diagonal(one) for law, one in by_law.items()}
        yield gw.Row(
            f"Decay of the peak speed in region 1, {IN_MS}, {name}, along the diagonal", "1/m",
            DECAY[name], diagonal[IN_MS], f"{SOURCE}, Fig. 7", digits=3,
            remark="According to the source the rate along the vertical is drastically "
                   f"different. Without relaxation it is {diagonal[ELASTIC]:.2g}. In the source "
                   "the rate is higher than in BCC; in our runs it is lower. This is not "
                   "explained.",
        )  # fmt: skip
    yield gw.Row(
        f"Decay of the peak speed in region 1, {ELASTIC}, {name}", "1/m", ours=rates[ELASTIC],
        where=f"{SOURCE}, 7", digits=3, remark="Only friction and the plate cause this decay.",
    )  # fmt: skip
    yield gw.Row(
        f"Decay by relaxation, {IN_MS} less none, {name}", "1/m",
        ours=rates[IN_MS] - rates[ELASTIC], where=f"{SOURCE}, 7", digits=2,
    )  # fmt: skip


def of_waves(name, by_law):
    """Rows of the speed, the second peak and the dissipation in a crystal of the size of the
    reference.
    """
    relaxing = by_law[IN_MS]
    elastic = by_law[ELASTIC]
    speed = relaxing.down.front_speed
    ratio = speed / elastic.down.front_speed
    yield gw.Row(
        f"Front speed, {IN_MS}, {name}", "m/s", SPEED, speed, f"{SOURCE}, Fig. 9", digits=3,
        remark=f"Elastic grains of {INSTANT * ratio**2:.0f} MPa have the same speed, as speeds "
               "vary as the square root of the modulus: the front passes before the modulus "
               "relaxes. The printed speed requires 25 to 76 MPa; this is not explained.",
    )  # fmt: skip
    yield gw.Row(
        f"Second, small peak of the speed in deep grains, {IN_MS}, {name}", "ms", SECOND,
        1e3 * later_peak(relaxing), f"{SOURCE}, Fig. 9", digits=2,
        remark=f"Waves are {speed / SPEED:.1f} times as fast as printed, and return sooner.",
    )  # fmt: skip
    for law in (IN_MS, IN_S):
        yield gw.Row(
            f"Dissipated by relaxation / input, {law}, {name}",
            ours=by_law[law].run["viscous_fraction"], where=f"{SOURCE}, 7", digits=2,
        )  # fmt: skip


def of_contacts(name, contacts):
    """Effective moduli and differences of impulses at the contacts of a crystal."""
    for word, printed, found in zip(
        ("smallest", "largest"), MODULI, np.percentile(contacts.modulus, (0, 100)), strict=True
    ):
        yield gw.Row(
            f"Effective modulus at the contacts of the run, {word}, {name}", "MPa", printed, found,
            f"{SOURCE}, 3", digits=3,
            remark="The source values are of four contacts, whose positions are shown only in a "
                   "picture. Our value is the modulus of the linear law that fits the "
                   "viscoelastic force of the first 6 ms best, at all contacts with at least a "
                   f"tenth of the largest force; the median is {np.median(contacts.modulus):.0f} "
                   "MPa.",
        )  # fmt: skip
    for word, printed, found in zip(
        ("smallest", "median"),
        IMPULSES,
        np.percentile(np.abs(contacts.impulse), (0, 50)),
        strict=True,
    ):
        yield gw.Row(
            f"Difference of impulses at the contacts of the run, {word}, {name}", "%", printed,
            found, f"{SOURCE}, Fig. 3", digits=3,
            remark="The viscoelastic law is compared with this linear law. The source uses "
                   "measured strains, which are not printed. Half-sine pulses with the printed "
                   "moduli give differences of the printed size.",
        )  # fmt: skip


def pictures(crystals):
    figure = Figure((7, 2.8), layout="constrained")
    panels = figure.subplots(1, 2)
    data = {}
    for axes, (name, by_law) in zip(panels, crystals["wide"].items(), strict=True):
        for law, line in ((ELASTIC, "o-"), (IN_MS, "s--")):
            one = by_law[law]
            axes.semilogy(one.depth, one.peak, line, markersize=3, label=law)
            data |= {f"{name}_{law}_depth_diameters": one.depth, f"{name}_{law}_peak_m_s": one.peak}
        axes.set(title=name, xlabel="Depth (diameters)", ylabel="Peak speed (m/s)")
    panels[0].legend(fontsize=7)
    caption = (
        "Peak speed of the grains on the middle line of crystals of 24 a row, with and without "
    )
    caption += "the relaxation of equation 7"
    yield gw.Picture("lateral_viscoelastic", caption, figure, data)
