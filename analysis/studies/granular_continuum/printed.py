"""Printed values of impacts beside ours: peak forces, energies, shares and volumes (thesis 5.2 to 5.5)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.measures.geometry.planes import preferred_directions
from granwave.analysis.measures.impact.dissipation import rays
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.granular_continuum.blocks import collapse, masses
from granwave.analysis.studies.granular_continuum.impacts import SAME, Continuum, Granular, Impacts, constants
from granwave.analysis.studies.granular_continuum.sides import involved
from granwave.analysis.studies.study import Row
from granwave.lammps_inputs.case.material import material
from granwave.lammps_inputs.run_directory import RESULT_FILE

_SPHERE = 0.01  # m, diameter of the spheres and of the punch
_LARGEST_FORCE = 700.0  # F_y: end of the colours of Fig. 5.3, whose velocity is not printed
_ENERGIES = {16.0: 0.576, 40.0: 3.60}  # J by velocity, m/s (Fig. 5.14)
_DIRECTIONS_OF, _FIRST_DECAY = 10.0, 7  # m/s; contacts along a preferred direction
_MOST_OF_A_SPHERE = 1e6  # end of the axis of Fig. 5.8, in the units of thesis 5.15
_SHARE, _VOLUME, _GRANULAR_SHARE = 0.7, 4.0, 0.9  # ends of the axes of Figs 5.10 and 5.11, 5.12, 5.13
_FEW, _ON = 3, 0.25  # layers: a point below the struck sphere; diameters: on a preferred direction
_OF_AXIS = "By the end of the axis."


def rows(impacts: Impacts) -> Iterator[Row]:
    """Rows of packings, of blocks, and of both."""
    packings = [run for run in impacts.reference if _is_source(run) and run.case.packing.kind == "fcc"]
    blocks = [run for run in impacts.continuum_reference if _is_source(run)]
    yield from _of_forces(packings)
    yield from _of_spheres(packings)
    if blocks:
        yield from _of_blocks(impacts, blocks[-1])
    if packings and blocks:
        yield from _of_volumes(packings[-1], blocks[-1])


def _is_source(run: Granular | Continuum) -> bool:
    """The source's spheres, with all values of the run."""
    alike = constants(run.case.material) == constants(material("brass")) and math.isclose(run.diameter, _SPHERE)
    return alike and (run.directory / RESULT_FILE).is_file()


def _of_forces(runs: Sequence[Granular]) -> Iterator[Row]:
    """Largest peak force, and how it falls and where it lies on the way down."""
    if len(runs) > 1:
        force = [run.value("peak_force_N") / run.law.yield_force for run in runs]
        velocity = float(np.interp(_LARGEST_FORCE, force, [run.case.load.velocity for run in runs]))
        if force[0] < _LARGEST_FORCE < force[-1]:
            yield Row("Velocity of the largest force of Fig. 5.3, 700 F_y", "m/s", None, velocity, "thesis Fig. 5.3",
                      "The source prints none; its Fig. 5.8 has 4, 10 and 40 m/s.", digits=3)  # fmt: skip
    for run in _at(runs, _DIRECTIONS_OF):
        with Result(run.directory) as result:
            if len(result["spheres/id"]) < run.value("n_spheres"):
                continue  # some were taken out of the file
            along = np.nanmean(rays(result).peak_force, axis=1)[:_FIRST_DECAY]
            on, beside = directions_of(result)
        what, where = f"{_DIRECTIONS_OF:g} m/s", "thesis 5.2, Fig. 5.3"
        decay = float(-np.polyfit(np.arange(len(along)), np.log(along), 1)[0])
        quantity = (
            f"Decay of the peak force per contact along a preferred direction, contacts 1 to {len(along)}, {what}"
        )
        yield Row(quantity, "", None, decay, where, "The source: rapid, and as in its chains.", digits=3)
        yield Row(f"Layers whose largest force lies on a preferred direction, {what}", "", None, on, where,
                  "The source: the first few.")  # fmt: skip
        yield Row(f"Force straight below the struck sphere over that on a preferred direction, layer {_FEW}, {what}",
                  "", None, beside, where, "The source: highest in the preferred directions.", digits=3)  # fmt: skip


def directions_of(result: Result) -> tuple[int, float]:
    """Layers, from the first on, whose largest force lies on a preferred direction; force below over that there."""
    offset = (result["spheres/position"] - result.origin) / result.case.packing.diameter
    force, directions = result["spheres/peak_force"], preferred_directions(result.case.packing.kind)
    layer = np.rint(offset[:, 2] / directions[0, 2]).astype(int)

    def distance(n: int) -> Array:
        return np.linalg.norm(offset[:, None] - n * directions, axis=2).min(axis=1)

    count = 0
    while count < layer.max():
        there = np.flatnonzero(layer == count + 1)
        if distance(count + 1)[there[force[there].argmax()]] > _ON:
            break
        count += 1
    below = force[(layer == _FEW) & (np.hypot(*offset[:, :2].T) < _ON)].max(initial=0.0)
    return count, float(below / force[distance(_FEW) < _ON].max())


def _of_spheres(runs: Sequence[Granular]) -> Iterator[Row]:
    """Energies of the struck sphere, and how dissipation is shared among spheres."""
    for velocity, energy in _ENERGIES.items():
        for run in _at(runs, velocity):
            yield Row(f"Energy of a sphere at {velocity:g} m/s", "J", energy, run.energy, "thesis Fig. 5.14",
                      "The source's is that of 4.5 g; a sphere has 4.45 g.")  # fmt: skip
    for run in _at(runs, max(_ENERGIES)):
        with Result(run.directory) as result:
            most = float(result["spheres/dissipated_energy"].max())
        name, unit = f"normalised velocity {run.velocity_normalised:.3g}", run.law.yield_force * run.law.yield_overlap
        remark = "By the end of the axis; the source counts each contact at both of its spheres."
        yield Row(f"Largest dissipation of a sphere (thesis 5.15), {name}, at most", "", _MOST_OF_A_SPHERE,
                  2 * 16 / 15 * most / unit, "thesis Fig. 5.8", remark, digits=3, bound=True)  # fmt: skip
        if found := involved(run):
            count = found.volume / (math.pi * _SPHERE**3 / 6)
            yield Row(f"Spheres that do half of the dissipation, {name}", "", None, float(count[found.enough(0.5)]),
                      "thesis Fig. 5.8", "The source: the bulk in the first few.")  # fmt: skip
        yield Row(f"Dissipated share of a packing, {run.energy:.3g} J, at most", "", _GRANULAR_SHARE, run.fraction,
                  "thesis Fig. 5.13", "By the end of the axis; those of its Figs 5.5 to 5.7 end at 1.",
                  bound=True)  # fmt: skip


def _of_blocks(impacts: Impacts, run: Continuum) -> Iterator[Row]:
    """Share and volume at the largest energy, and what material and mass of the punch change."""
    name = f"{run.energy:.3g} J"
    yield Row(f"Dissipated share of a block, {name}, at most", "", _SHARE, run.fraction, "thesis Figs 5.10, 5.11",
              _OF_AXIS, bound=True)  # fmt: skip
    yield Row(f"Plastic volume of a block over pi D^3/6, {name}, at most", "", _VOLUME, run.volume, "thesis Fig. 5.12",
              _OF_AXIS, bound=True)  # fmt: skip
    if found := [one for one in collapse(impacts) if one.energy > 1]:
        yield Row("Largest difference in a block's share between materials, inputs above sigma_y^2 D^3/E", "%", 0.0,
                  100 * max(abs(one.fraction) for one in found), "thesis Fig. 5.10b", "The source: one curve.",
                  digits=2)  # fmt: skip
    curves = [runs for _, runs in masses(impacts)]
    gaps = [(one.energy_normalised, np.ptp(_at_energy(curves, one.energy_normalised))) for one in curves[0]]
    for word, chosen in (("up to", [gap for energy, gap in gaps if energy <= 1]),
                         ("above", [gap for energy, gap in gaps if energy > 1])):  # fmt: skip
        if len(curves) > 1 and chosen:
            quantity = f"Largest difference in a block's share between punches of unlike mass, inputs {word}"
            yield Row(f"{quantity} sigma_y^2 D^3/E", "", 0.0, float(max(chosen)), "thesis Fig. 5.11",
                      "The source: little.", digits=2)  # fmt: skip


def _of_volumes(packing: Granular, block: Continuum) -> Iterator[Row]:
    """Spheres that dissipate what a block does, over the plastic volume of that."""
    found = involved(packing)
    if found and found.fraction[-1] > block.fraction:
        spheres = np.interp(block.fraction, found.fraction, found.volume) / (math.pi * block.diameter**3 / 6)
        yield Row(f"Volume that dissipates {block.fraction:.2g} of the input, spheres at {packing.energy:.3g} J over "
                  f"the plastic volume of a block at {block.energy:.3g} J", "", 1.0, float(spheres / block.volume),
                  "thesis 5.5, Fig. 5.14", "The source: very close. Whole spheres count, though contacts alone yield.",
                  digits=2)  # fmt: skip


def _at(runs: Sequence[Granular], velocity: float) -> list[Granular]:
    return [run for run in runs if math.isclose(run.case.load.velocity, velocity)][:1]


def _at_energy(curves: Sequence[Sequence[Continuum]], energy: float) -> list[float]:
    """Dissipated shares at one energy."""
    return [run.fraction for runs in curves for run in runs if abs(run.energy_normalised / energy - 1) < SAME]
