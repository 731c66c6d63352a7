"""What yielding does to the waves in a square packing: a scan of the striker's velocity with both laws."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.style import BLUE, GREEN, ORANGE, PURPLE, Drawing, new_figure
from granwave.analysis.studies.square.regions import groups, settled
from granwave.analysis.studies.square.runs import PackingRun, squares
from granwave.analysis.studies.study import Picture, Row, Study
from granwave.lammps_inputs.case.material import Material

_PLACES = (2, 6)  # spheres of the chain, from the struck one as 1
_LAW = "elastoplastic"


def yielding(runs: Sequence[PackingRun]) -> Iterator[Study]:
    """One study for each way of impact with yielding runs."""
    for way in ("in-plane", "out-of-plane"):
        series = squares(runs, way, _LAW)
        if series:
            yield _study(series, way)


def _study(series: list[PackingRun], way: str) -> Study:
    material = series[0].case.material
    rows = []
    for run in series:
        shares = settled(run)
        largest = groups(run)["central chains"][0].speeds(run).max(axis=0)
        rows.append(_row(f"Dissipated at {run.speed:g} m/s, {way}", "% of input", 100 * shares["dissipated"]))
        rows.append(
            _row(f"Most in central chains at {run.speed:g} m/s, {way}", "% of input", 100 * shares["central chains"])
        )
        if len(largest) >= max(_PLACES):
            first, second = _PLACES
            quantity = f"Peak velocity at sphere {second} over that at sphere {first}, {run.speed:g} m/s, {way}"
            rows.append(_row(quantity, "", float(largest[second - 1] / largest[first - 1])))
    return Study(
        f"square-yielding-{way}",
        f"Square packing with yielding, {way} impact",
        f"The same impacts with the elasto-plastic law and {_yield_strength(material)}, which the source did not do. "
        "Harder spheres lose less. In the chains: the most they ever held.",
        tuple(rows),
        (Picture(f"square_yielding_{way.replace('-', '_')}", f"Where the energy goes, {way} impact", _draw(series)),),
    )


def _yield_strength(material: Material) -> str:
    size = f"a yield strength of {(material.yield_strength or 0) / 1e6:g} MPa"
    return f"{size} ({material.name}: {material.source})" if material.name and material.source else size


def _row(quantity: str, unit: str, ours: float) -> Row:
    return Row(quantity, unit, None, ours, "ours alone")


def _draw(series: list[PackingRun]) -> Drawing:
    figure = new_figure(2.4)
    axes = figure.subplots()
    speed = np.array([run.speed for run in series])
    found = [settled(run) for run in series]
    columns = {"striker_velocity_m_s": speed}
    names = ["dissipated", *groups(series[0]), "struck spheres", "strikers"]
    colours = {"dissipated": GREEN, "central chains": BLUE, "struck spheres": ORANGE, "strikers": PURPLE}
    for name in names:
        share = np.array([one[name] for one in found])
        axes.semilogx(speed, 100 * share, "o-", markersize=3, color=colours.get(name, "black"), label=name)
        columns[f"{name.replace(' ', '_')}_over_input"] = share
    axes.set_xlabel("Velocity of the striker (m/s)")
    axes.set_ylabel("Energy (% of input)")
    axes.set_ylim(0, 105)
    axes.legend(loc="center right")
    return Drawing(figure, columns)
