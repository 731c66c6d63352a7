"""Packings at high energy inputs, and dissipating volumes of packings and blocks.

The axes of Figs 5.5 and 5.7 end at a normalised input of 1e10. At this input, overlaps of brass
spheres would exceed the range of the contact law by far. At a given normalised velocity, the
overlap relative to the radius is proportional to the square of the ratio of yield strength to
modulus. Spheres with a tenth of the yield strength of brass therefore reach 9.5e9 within the range
of the law, on the same curve (5.6 to 5.13). Blocks of brass are hit by a punch of 0.1 kg. Volumes
are normalised by pi D^3/6, with D = 10 mm. Packings have 24 × 24 × 12 spheres; their boundaries
raise the dissipated fraction by less than 1 %.
"""

import math
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

import granwave as gw

BRASS = 5.5e8  # Pa, yield strength
SAME = 1e-4  # relative difference of inputs that are meant to be equal
FASTEST = 1e4  # end of the axis of Fig. 5.6a, normalised velocity
UNIT = 16 / 15  # F_y alpha_y / unit of energy of thesis 5.15
AXIS = 100.0  # end of Fig. 5.13
VOLUME = math.pi * 0.01**3 / 6
STRIKES = (1, 3, 7)  # impacted spheres


class Impacts(NamedTuple):
    """Impacts, each group by rising input: packings that yield early by the number of impacted
    spheres; packings and blocks of brass.
    """

    early: dict
    brass: list
    blocks: list


def select(runs):
    """The impacts; empty for a single scan."""
    runs = sorted(runs, key=lambda run: run["energy_input_J"])
    blocks = [run for run in runs if "punch.velocity" in run.labels]
    packings = [run for run in runs if "load.spheres" in run.labels]
    if not (blocks and packings):
        return []
    brass = [run for run in packings if run.labels.get("material.yield_strength", BRASS) == BRASS]
    early = {}
    for run in packings:
        if run not in brass:
            early.setdefault(run.case.load.spheres, []).append(run)
    return [Impacts(early, brass, blocks)]


def volumes(run):
    """Cumulative dissipated fraction and normalised volume of the spheres of a packing in
    descending order of dissipation, from zero.
    """
    spheres = gw.measures.spheres_involved(run.result, run["energy_input_J"])
    return np.append(0.0, spheres.fraction), np.append(0.0, spheres.volume / VOLUME)


def of_blocks(blocks):
    """Dissipated fractions and normalised plastic volumes of blocks: (n_blocks,) each."""
    share = np.array([run["dissipated_fraction"] for run in blocks])
    volume = np.array([run["plastic_zone_volume_m3"] for run in blocks]) / VOLUME
    return share, volume


def rows(impacts):
    single = impacts.early[1]
    yield from loading_areas(impacts.early)
    most = single[-1]
    overlap = max(run["peak_overlap_m"] / (run.case.packing.diameter / 4) for run in single)
    yield gw.Row(
        "Dissipated fraction of a packing, input "
        f"{most['energy_input_normalised']:.2g} F_y alpha_y",
        ours=most["dissipated_fraction"], where="thesis Figs 5.5 to 5.7", digits=4,
        remark=f"Overlaps reach {overlap:.2g} R*; the contact law is valid up to 0.2 R*. The axes "
        "of the source end at 1e10 × 15/16 F_y alpha_y.",
    )  # fmt: skip
    yield from constants(single)
    yield from shares_on_axis(impacts)
    share, volume = of_blocks(impacts.blocks)
    energies = [run["energy_input_J"] for run in impacts.blocks]
    for run in impacts.brass:
        of_packing = np.interp(share, *volumes(run))
        yield gw.Row(
            "Largest difference of the volumes with the same dissipated fraction, spheres at "
            f"{run['energy_input_J']:.3g} J and blocks at {energies[0]:.3g} to "
            f"{energies[-1]:.3g} J",
            source=0.0, ours=np.abs(of_packing - volume).max(), where="thesis 5.5, Fig. 5.14",
            digits=2,
            remark="According to the source the volumes are very close, on an axis that ends at "
            f"20. Fractions from {share[0]:.2f} to {share[-1]:.2f} are compared. Whole spheres are "
            "counted, although only their contacts yield.",
        )  # fmt: skip


def loading_areas(early):
    """Row that compares impacts on 3 and 7 spheres with impacts on one sphere at equal input."""
    single = {run["energy_input_J"]: run["dissipated_fraction"] for run in early[1]}
    differences = []
    inputs = []
    for run in [*early[3], *early[7]]:
        energy = run["energy_input_J"]
        of_one = next(share for known, share in single.items() if abs(energy / known - 1) < SAME)
        differences.append(abs(run["dissipated_fraction"] - of_one))
        inputs.append(run["energy_input_normalised"])
    yield gw.Row(
        "Largest difference of the dissipated fraction between 1, 3 and 7 impacted spheres, inputs "
        f"of {min(inputs):.2g} to {max(inputs):.2g} F_y alpha_y",
        source=0.0, ours=max(differences), where="thesis Fig. 5.7", digits=2,
        remark="According to the source the curves overlap.",
    )  # fmt: skip


def constants(single):
    """Rows of the quadratic law, fitted over the velocities of Fig. 5.6a."""
    chosen = [run for run in single if run["velocity_normalised"] <= FASTEST]
    velocity = np.array([run["velocity_normalised"] for run in chosen])
    share = np.array([run["dissipated_fraction"] for run in chosen])
    law = gw.measures.quadratic_law(velocity, share * 0.5 * velocity**2)
    for name, ours, deviation in zip(
        ("D0", "D1", "D2"), law.constants, law.deviations, strict=True
    ):
        yield gw.Row(
            f"{name} of the quadratic law, where the input is v0²/2, normalised velocities from "
            f"{velocity[0]:.3g} to {velocity[-1]:.3g}",
            ours=ours, where="thesis 5.17, Fig. 5.6a", digits=3,
            remark=f"The standard deviation is {deviation:.2g}. The axis of the source goes from 1 "
            "to 1e4.",
        )  # fmt: skip


def on_axis(impacts):
    """Inputs of brass divided by sigma_y^2 D^3/E, and dissipated fractions, of packings and
    blocks."""
    unit = unit_of(impacts.brass[0]) / unit_of(impacts.blocks[0])
    packing = [unit * run["energy_input_normalised"] for run in impacts.early[1]]
    block = [run["energy_input_normalised"] for run in impacts.blocks]
    shares = [run["dissipated_fraction"] for run in impacts.early[1]]
    return np.array(packing), np.array(shares), np.array(block), of_blocks(impacts.blocks)[0]


def unit_of(run):
    """Unit of the input of a run, J."""
    return run["energy_input_J"] / run["energy_input_normalised"]


def shares_on_axis(impacts):
    """Rows of packing and block on one axis of the input."""
    packing, of_packing, block, of_block = on_axis(impacts)
    yield gw.Row(
        "Dissipated fraction of a packing, input 100 sigma_y^2 D^3/E, at most",
        source=0.9, bound=True, digits=3,
        ours=np.interp(np.log(AXIS), np.log(packing), of_packing), where="thesis Fig. 5.13",
        remark="The bounds are the ends of both axes. The normalised inputs are equal; brass "
        "spheres would exceed the range of the contact law.",
    )  # fmt: skip
    yield gw.Row(
        "Dissipated fraction of a packing divided by the fraction of a block, input "
        f"{block[-1]:.3g} sigma_y^2 D^3/E", digits=3,
        ours=np.interp(np.log(block[-1]), np.log(packing), of_packing) / of_block[-1],
        where="thesis Fig. 5.13", remark=("According to the source the fraction is much larger "
                                          "in a packing."),
    )  # fmt: skip


def pictures(impacts):
    yield master_curve(impacts.early)
    yield packing_and_block(impacts)


def master_curve(early):
    """Dissipated fraction against the input, by the number of impacted spheres."""
    data = {}
    axes = Figure((3.6, 2.7), layout="constrained").subplots()
    for count, style in zip(STRIKES, ("C0o-", "C1s", "k^"), strict=True):
        energy = np.array([UNIT * run["energy_input_normalised"] for run in early[count]])
        share = np.array([run["dissipated_fraction"] for run in early[count]])
        axes.semilogx(energy, share, style, markersize=3.5, label=f"{count} impacted")
        data |= {f"input_{count}": energy, f"share_{count}": share}
    axes.set(xlabel="Energy input (thesis 5.15)", ylabel="Dissipated fraction", ylim=(0.8, 1))
    axes.legend()
    caption = "Dissipated fraction of packings with 1, 3 or 7 impacted spheres against the energy "
    caption += "input of thesis Figs 5.5b and 5.7, from 6e3. The spheres have a tenth of the yield "
    caption += "strength of brass, which keeps them within the range of the contact law"
    return gw.Picture("packings_master_curve", caption, axes.figure, data)


def packing_and_block(impacts):
    """Dissipated fractions on one axis, and volumes that dissipate a fraction."""
    packing, of_packing, block, of_block = on_axis(impacts)
    figure = Figure((7, 2.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.semilogx(packing, of_packing, "C0o-", markersize=3.5, label="packing, 10 mm")
    left.semilogx(8 * packing, of_packing, "C1^-", markersize=3.5, label="packing, 20 mm")
    left.semilogx(block, of_block, "ks", markersize=4, label="block")
    left.axvline(AXIS, color="0.7", linewidth=0.8)
    left.set(
        xlabel=r"Input / ($\sigma_y^2 D^3/E$), $D$ = 10 mm",
        ylabel="Dissipated fraction",
        ylim=(0, 1),
    )
    share, volume = of_blocks(impacts.blocks)
    right.plot(share, volume, "ks", markersize=4, label="blocks, 1.8 to 28.8 J")
    data = {"input_packing": packing, "share_packing": of_packing, "input_block": block}
    data |= {"share_block": share, "volume_block": volume}
    for run in impacts.brass:
        name = f"{run['energy_input_J']:.3g}"
        fraction, of_spheres = volumes(run)
        right.plot(fraction, of_spheres, label=f"packing, {name} J")
        data |= {f"share_at_{name}_J": fraction, f"volume_at_{name}_J": of_spheres}
    right.set(
        xlabel="Dissipated fraction", ylabel=r"Volume / ($\pi D^3/6$)", xlim=(0, 0.9), ylim=(0, 20)
    )
    for axes in (left, right):
        axes.legend(fontsize=7)
    caption = "Left: dissipated fraction of packings and of blocks of brass against the normalised "
    caption += (
        "input; the axis of thesis Fig. 5.13 ends at the line. Right: volume that dissipates "
    )
    caption += "a fraction of the input, for spheres in descending order and for blocks (Fig. 5.14)"
    return gw.Picture("packing_and_block", caption, figure, data)
