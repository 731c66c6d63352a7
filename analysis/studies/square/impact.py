"""The square packing at the source's two impacts: energies by region, maps of speed, and lengths of the pulses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.packings.maps import speed_maps
from granwave.analysis.figures.packings.regions import energies_by_region, pulse_lengths
from granwave.analysis.measures.chains.hertz_chain import discrete_width
from granwave.analysis.measures.impact.regions import Array, chains, groups, regions
from granwave.analysis.measures.waves.pulses import MEASURES, last_length, lengths, settled_from, theory
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.square.runs import WAYS, PackingRun, squares
from granwave.analysis.studies.square.signals import accelerations, signal_rows
from granwave.analysis.studies.study import Picture, Row

Lengths = dict[str, Array]  # by name of `MEASURES`

_SHOWN = (0.15e-3, 0.30e-3)  # s, of the maps of speed
_LEAST_PASSED = 6  # spheres for a length of the pulse
_WHERE = "square packing, Wave Propagation Path"
_PULSE = "square packing, Pulse Length"
_LENGTH = 5.0  # diameters: of the fitted waves (equation 2, Fig. 11a, b)
_MAPS = "square packing, Figs 3 and 6"
_CARRIES = 0.01  # of the input, in a chain that carries a wave
_CHAINS = {"in-plane": 4.0, "out-of-plane": 8.0}  # with a wave, of the source
_REBOUND = "strikers and struck spheres"
_OF_REBOUND = "The source: the remaining energy, which is 4.0 % of its numbers."
_OF_LENGTH = (
    "The source's 13 % are those of Chatterjee's asymptotic wave against Nesterenko's; it calls the decrease of its "
    "simulations similar."
)
#: Per cent of the input that the source found; None where it prints no number.
_ENERGIES: dict[str, dict[str, float | None]] = {
    "in-plane": {"central chains": 71.5, "edge chains": 24.5, _REBOUND: None},
    "out-of-plane": {"central chains": 44.3, "strikers": 8.0, "struck spheres": 47.7},
}


def select(runs: Sequence[FinishedRun]) -> list[PackingRun]:
    """One for each way of impact: the source's own run if it is there, else the slowest elastic one."""
    series = [squares(runs, way, "hertz") for way in WAYS]
    return [next((run for run in one if run.is_source_impact), one[0]) for one in series if one]


def name(run: PackingRun) -> str:
    """``square-in-plane``."""
    return f"square-{run.way}"


def title(run: PackingRun) -> str:
    """By way of impact."""
    return f"Square packing, {run.way} impact"


def text(run: PackingRun) -> str:
    """Describe the impact and the energies."""
    nx, ny = run.case.packing.size
    through = "through a sphere at rest" if any(not one.moves for one in run.case.striker) else "directly"
    return (
        f"{nx} x {ny} elastic spheres of {1e3 * run.case.packing.diameter:.4g} mm, {len(run.snapshots.struck)} of them "
        f"struck {through} at {run.speed:g} m/s. Energies are kinetic and elastic, over the input: in chains the most "
        "they ever held, without the struck spheres; in strikers and struck spheres what they hold when they have "
        "rebounded."
    )


def rows(run: PackingRun) -> Iterator[Row]:
    """Energies by region, paths and places of the waves, lengths of the pulses, and signals of the sensors."""
    ours = {region: 100 * share for region, share in run.settled.items()}
    ours[_REBOUND] = ours["strikers"] + ours["struck spheres"]
    for region, printed in _ENERGIES[run.way].items():
        source = printed if run.is_source_impact else None
        remark = _OF_REBOUND if region == _REBOUND and run.is_source_impact else ""
        yield Row(f"Energy in {region}, {run.way}", "% of input", source, ours[region], _WHERE, remark)
    yield from _paths(run)
    yield from _maps(run)
    for group, found in _measured(run).items():
        if last_length(found) >= _LEAST_PASSED:
            yield from _length_rows(run, group, found)
    if run.is_source_impact:
        yield from signal_rows(run)


def pictures(run: PackingRun) -> Iterator[Picture]:
    """Energies, maps of speed, accelerations of sensors, and lengths where a pulse passed."""
    impact = f"{run.way} impact"
    yield Picture("_energies", f"Energy by region, {impact}", energies_by_region(run.snapshots))
    speeds = speed_maps(run.snapshots, run.case.packing.diameter, _SHOWN)
    yield Picture("_speeds", f"Speed of the spheres, {impact} (source Figs 3 and 6)", speeds)
    if signals := accelerations(run):
        yield Picture("_accelerations", f"Accelerations of the sensors, {impact} (source Figs 4, 5 and 7)", signals)
    if measured := _measured(run):
        yield Picture("_pulses", f"Length of the pulse, {impact} (source Fig. 11)", pulse_lengths(measured))


def _paths(run: PackingRun) -> Iterator[Row]:
    """Number of chains that carry a wave, and the energy outside of them."""
    seen = run.snapshots
    carrying = sum(float(seen.energy[:, one.rows[1:]].sum(axis=1).max()) > _CARRIES for one in chains(seen))
    source = _CHAINS[run.way] if run.is_source_impact else None
    yield Row(f"Chains with a wave, {run.way}", "", source, carrying, _WHERE)
    ours = 100 * float(regions(seen)["other spheres"].max())
    yield Row(f"Most energy in other spheres, {run.way}", "% of input", None, ours, _WHERE, "Theory: symmetry.", 0.0)


def _maps(run: PackingRun) -> Iterator[Row]:
    """Place of the crest in the central chains, and the largest speed, at the times of the maps."""
    seen = run.snapshots
    for time in _SHOWN:
        if time <= seen.time[-1]:
            frame = int(np.abs(seen.time - time).argmin())
            speeds = groups(seen)["central chains"][0].speeds(seen)[frame]
            crest, when = int(speeds[1:].argmax()) + 2, f"{1e3 * time:.2f} ms, {run.way}"
            yield Row(f"Fastest sphere of a central chain at {when}", "", None, crest, _MAPS)
            yield Row(f"Speed of it at {when}", "m/s", None, float(speeds[crest - 1]), _MAPS)


def _measured(run: PackingRun) -> dict[str, Lengths]:
    """Lengths in the first chain of each group that a pulse passed; all of a group are alike by symmetry."""
    seen, diameter = run.snapshots, run.case.packing.diameter
    found = {
        group: lengths(seen.time, members[0].speeds(seen), diameter)
        for group, members in groups(seen).items()
        if members
    }
    return {group: one for group, one in found.items() if last_length(one) > 1}


def _length_rows(run: PackingRun, group: str, found: Lengths) -> Iterator[Row]:
    printed = (13.0, 5.0) if run.is_source_impact else (None, None)
    where, last, expected = f"{group}, {run.way}", last_length(found), theory()
    for measure in MEASURES:
        source = _LENGTH if run.is_source_impact and measure in MEASURES[:2] else None
        remark = "The source: about 5, which is Nesterenko's." if source else "Theory: Nesterenko's wave."
        ours = float(found[measure][last])
        yield Row(f"Pulse length, {measure}, {where}", "diameters", source, ours, _PULSE, remark, expected[measure])
    half = MEASURES[3]
    below = float(100 * (1 - found[half][last] / expected[half]))
    remark = "Theory: the travelling wave of the chain of beads itself."
    exact = 100 * (1 - discrete_width() / expected[half])
    remark = f"{_OF_LENGTH} {remark}" if printed[0] else remark
    yield Row(f"Half-maximum length below Nesterenko's, {where}", "%", printed[0], below, _PULSE, remark, exact)
    remark = "Printed: roughly five or six. Ours is within 2 % of its last length from there on."
    passed = float(settled_from(found))
    yield Row(f"Sphere from which on the pulse is settled, {where}", "", printed[1], passed, _PULSE, remark)
