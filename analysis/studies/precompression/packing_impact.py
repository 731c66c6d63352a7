"""Impacts on precompressed packings: what arrives, and what is dissipated, against the static pressure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.style import BLUE, GREEN, GREY, Drawing, new_figure
from granwave.analysis.studies.precompression import packing_speed
from granwave.analysis.studies.precompression.runs import PastRun, freed_words, groups, rising, values_table
from granwave.analysis.studies.study import Picture, Study
from granwave.analysis.studies.titles import contact_words, load_words, packing_words
from granwave.lammps_inputs.packing.assembly import assemble

_FEWEST = 2  # runs, one of them precompressed
_OF_YIELDING = ("dissipated_share", "contacts_yielded")


def precompressed_impacts(runs: Sequence[PastRun]) -> Iterator[Study]:
    """One study of each impact on a packing that was run at several pressures."""
    chosen = [run for run in runs if _fits(run)]
    kinds = {run.case.precompression.kind for run in chosen if run.case.precompression}
    number = 0
    for kind in sorted(kinds):
        same = [run for run in chosen if run.case.precompression is None or run.case.precompression.kind == kind]
        for group in groups(same, "precompression"):
            series = rising(group, lambda run: run.static_force)
            if len(series) >= _FEWEST:
                number += 1
                yield _study(series, kind, number)


def _fits(run: PastRun) -> bool:
    """A packing of like spheres without dents, of its nominal size, that is not hit by a small wave only."""
    case = run.case
    if case.packing.kind == "chain" or not assemble(case).plain or case.contact.initial_overlap:
        return False
    if case.precompression is not None and case.precompression.kind == "gravity":
        return False
    return not packing_speed.fits(run)


def _study(series: list[PastRun], kind: str, number: int) -> Study:
    first = series[0].case
    columns = {
        "pressure_Pa": [packing_speed.pressure_of(run) for run in series],
        "static_contact_force_N": [run.static_force for run in series],
        "transmitted_force_N": [run.transmitted for run in series],
        "arrival_s": [run.arrival for run in series],
        "dissipated_share": [run.dissipated for run in series],
        "contacts_yielded": [run.summary["n_plastic_contacts"] for run in series],
        "peak_force_N": [run.summary["peak_force_N"] for run in series],
    }
    heads = (
        ("Static pressure", "Pa", 1.0, "pressure_Pa"),
        ("Static force of a contact", "N", 1.0, "static_contact_force_N"),
        ("Largest force added at the bottom", "N", 1.0, "transmitted_force_N"),
        ("Arrival there", "µs", 1e6, "arrival_s"),
        ("Dissipated by the impact", "% of input", 100.0, "dissipated_share"),
        ("Contacts that yielded in it", "", 1.0, "contacts_yielded"),
        ("Largest contact force, the static one in it", "N", 1.0, "peak_force_N"),
    )
    shown = [head for head in heads if head[3] not in _OF_YIELDING or any(columns[head[3]])]
    name = f"precompressed-impact-{number}"
    of_sides = {"free": "free", "periodic": "periodic", "wall": "walled"}[first.boundary.sides]
    text = (
        f"{packing_words(first)}, {of_sides} sides, {contact_words(first)}, struck at {load_words(first)} under {kind} "
        "static pressure, which stays on. What the static load made yield is not counted." + freed_words(series)
    )
    picture = Picture(
        name.replace("-", "_"), "Transmitted force and dissipation against static pressure", _draw(columns)
    )
    return Study(
        name,
        f"Impact on a packing under {kind} pressure, {first.load.velocity:g} m/s",
        text,
        pictures=(picture,),
        tables=(values_table("The impact against static pressure", shown, columns),),
        verdict=(_verdict(series, kind),),
    )


def _verdict(series: list[PastRun], kind: str) -> str:
    first, last = series[0], series[-1]
    loses = any(run.dissipated for run in series)
    start = "without a static load" if not first.static_force else f"at {packing_speed.pressure_of(first):.3g} Pa"
    return (
        f"Under {kind} pressure of {packing_speed.pressure_of(last):.3g} Pa the impact adds {last.transmitted:.4g} N "
        f"at the bottom ({first.transmitted:.4g} N {start})"
        + (f" and dissipates {100 * last.dissipated:.3g} % ({100 * first.dissipated:.3g} %)." if loses else ".")
        + freed_words((first, last))
    )


def _draw(columns: dict[str, list[float]]) -> Drawing:
    shown = [("transmitted_force_N", 1.0, BLUE, "Largest force added at the bottom (N)")]
    if any(columns["dissipated_share"]):
        shown.append(("dissipated_share", 100.0, GREEN, "Dissipated (% of input)"))
    figure = new_figure(2.5, 3.3 * len(shown))
    pressure = np.array(columns["pressure_Pa"])
    loaded = pressure > 0
    panels = figure.subplots(1, len(shown), squeeze=False)[0]
    for axes, (name, scale, colour, label) in zip(panels, shown, strict=True):
        values = scale * np.array(columns[name])
        axes.set_xscale("log")
        axes.set_xlim(pressure[loaded].min() / 2, 2 * pressure[loaded].max())
        axes.plot(pressure[loaded], values[loaded], "o-", color=colour, markersize=4)
        if not loaded.all():
            axes.axhline(values[0], color=GREY, linestyle="--", label="without static load")
            axes.legend()
        axes.set_xlabel("Static pressure (Pa)")
        axes.set_ylabel(label)
        axes.set_ylim(0, 1.25 * np.nanmax(values))
    return Drawing(figure, columns)
