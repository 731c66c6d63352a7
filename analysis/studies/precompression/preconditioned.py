"""Spheres that were pressed before: dents that keep contacts elastic up to the force they were pressed with.

A contact that once bore F_p unloads and reloads on one curve and loses nothing up to F_p (thesis 1.1, 2.1). Dents leave
gaps between spheres at nominal places; a small static load closes them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing, new_figure
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.precompression.runs import PastRun, freed_words, groups, rising, values_table
from granwave.analysis.studies.study import Picture, Row, Study
from granwave.analysis.studies.titles import packing_words
from granwave.lammps_inputs.case.sections import Dents

_VARYING = ("contact.initial_overlap", "load.velocity")
_ELASTIC = 1e-9  # share of the input: nothing is dissipated
_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY)
_WHERE = "thesis 1.1"
_REACHED = 1e-3  # of the largest force along the chain: the pulse has come to a contact


def preconditioned(runs: Sequence[PastRun]) -> Iterator[Study]:
    """One study of each chain and packing that was struck with dents of one size everywhere, and without."""
    chosen = [run for run in runs if run.case.contact.yields and np.isfinite(level_of(run))]
    number = 0
    for group in groups(chosen, *_VARYING):
        if any(level_of(run) for run in group):
            number += 1
            yield _study(sorted(group, key=lambda run: (level_of(run), run.case.load.velocity)), number)


def level_of(run: PastRun) -> float:
    """Force up to which the contacts were pressed before, N; 0: never; NaN where it is not the same for all."""
    given = run.case.contact.initial_overlap
    if isinstance(given, str):
        return np.nan
    if not isinstance(given, tuple):
        given = (Dents(overlap=given),)
    if len(given) != 1 or given[0].low is not None or given[0].high is not None:
        return np.nan
    if given[0].force is not None:
        return given[0].force
    return float(run.law.loading_force(np.array([given[0].overlap or 0.0]))[0])


def _study(runs: Sequence[PastRun], number: int) -> Study:
    case = runs[0].case
    name = "preconditioned" + (f"-{number}" if number > 1 else "")
    slug = name.replace("-", "_")
    pictures = [
        Picture(f"{slug}_dissipation", "Dissipation against the largest force, by preconditioning", _draw(runs))
    ]
    if case.packing.kind == "chain":
        fastest = _one_velocity(runs)
        if len(fastest) > 1:
            caption = f"Largest force along the chain, impact at {fastest[0].case.load.velocity:g} m/s"
            pictures.append(Picture(f"{slug}_pulse", caption, _draw_pulses(fastest)))
    columns = {
        "level_N": [level_of(run) for run in runs],
        "velocity_m_s": [run.case.load.velocity for run in runs],
        "peak_force_N": [float(run.summary["peak_force_N"]) for run in runs],
        "dissipated_share": [run.dissipated for run in runs],
        "contacts_yielded": [run.summary["n_plastic_contacts"] for run in runs],
        "transmitted_force_N": [run.transmitted for run in runs],
    }
    heads = (
        ("Preconditioned to", "N", 1.0, "level_N"),
        ("Impact", "m/s", 1.0, "velocity_m_s"),
        ("Largest force", "N", 1.0, "peak_force_N"),
        ("Dissipated", "% of input", 100.0, "dissipated_share"),
        ("Contacts whose dents grew", "", 1.0, "contacts_yielded"),
        ("Largest force added at the bottom", "N", 1.0, "transmitted_force_N"),
    )
    reached = heads if any(columns["transmitted_force_N"]) else heads[:-1]  # the bottom
    gaps = "The gaps that dents leave between spheres at their nominal places "
    gaps += "are closed by a static load, which stays on." if case.precompression else "are there at the impact."
    return Study(
        name,
        f"Preconditioned: {packing_words(case)}",
        "Contacts that have dents from the start, of one force everywhere: they shall stay elastic up to that force. "
        f"{gaps}{freed_words(runs)}",
        tuple(_rows(runs)),
        tuple(pictures),
        (values_table("Impacts with and without preconditioning", reached, columns),),
        tuple(_verdict(runs)),
    )


def _rows(runs: Sequence[PastRun]) -> Iterator[Row]:
    """How far the contacts stay elastic, and what is dissipated just beyond."""
    for level in sorted({level_of(run) for run in runs} - {0.0}):
        series = [run for run in runs if level_of(run) == level]
        elastic = [run for run in series if run.dissipated < _ELASTIC]
        losing = [run for run in series if run.dissipated >= _ELASTIC]
        for found, which, choose in ((elastic, "Largest force without", max), (losing, "Smallest force with", min)):
            if found:
                force = choose(float(run.summary["peak_force_N"]) for run in found)
                quantity = f"{which} dissipation over that of the preconditioning, {level:g} N"
                remark = f"Theory: the two are on either side of 1; of {len(series)} impacts."
                yield Row(quantity, "", None, force / level, _WHERE, remark, 1.0)


def _one_velocity(runs: Sequence[PastRun]) -> list[PastRun]:
    """Runs by level at the velocity that most levels have, the largest of such."""
    by_velocity: dict[float, list[PastRun]] = {}
    for run in runs:
        by_velocity.setdefault(run.case.load.velocity, []).append(run)
    found = max(by_velocity.values(), key=lambda same: (len(same), same[0].case.load.velocity))
    return rising(found, level_of)


def _verdict(runs: Sequence[PastRun]) -> Iterator[str]:
    series = _one_velocity(runs)
    fresh, best = series[0], series[-1]
    if level_of(fresh) == 0 and best is not fresh:
        yield (
            f"Impact at {fresh.case.load.velocity:g} m/s: fresh contacts dissipate {100 * fresh.dissipated:.3g} %, "
            f"those preconditioned to {level_of(best):g} N {100 * best.dissipated:.3g} %." + freed_words((fresh, best))
        )


def _draw(runs: Sequence[PastRun]) -> Drawing:
    figure = new_figure(2.7)
    axes = figure.subplots()
    columns: dict[str, np.ndarray] = {}
    for place, level in enumerate(sorted({level_of(run) for run in runs})):
        series = [run for run in runs if level_of(run) == level]
        force = np.array([float(run.summary["peak_force_N"]) for run in series])
        share = 100 * np.array([run.dissipated for run in series])
        colour = _COLOURS[place % len(_COLOURS)] if level else GREY
        axes.semilogx(force, share, "o-", color=colour, markersize=3, label=f"{level:g} N" if level else "fresh")
        if level:
            axes.axvline(level, color=colour, linestyle=":", linewidth=0.8)
        columns |= {f"level_{level:g}_N_peak_force_N": force, f"level_{level:g}_N_dissipated_percent": share}
    axes.set_xlabel("Largest contact force (N)")
    axes.set_ylabel("Dissipated (% of input)")
    axes.set_ylim(-2, max(105.0, 105 * max(run.dissipated for run in runs)))
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 3)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    _legend(figure)
    return Drawing(figure, columns)


def _draw_pulses(runs: Sequence[PastRun]) -> Drawing:
    figure = new_figure(2.5)
    axes = figure.subplots()
    columns: dict[str, np.ndarray] = {}
    for place, run in enumerate(runs):
        chain, level = ChainRun(run.label, run.directory, run.case, run.summary), level_of(run)
        peaks = chain.of_contacts("peak_force")
        contact = np.arange(1, len(peaks) + 1)
        colour = _COLOURS[place % len(_COLOURS)] if level else GREY
        reached = np.where(peaks > _REACHED * peaks.max(), peaks, np.nan)
        axes.semilogy(contact, reached, color=colour, label=f"{level:g} N" if level else "fresh")
        columns |= {"contact": contact, f"level_{level:g}_N_peak_force_N": peaks}
    axes.set_xlabel("Contact")
    axes.set_ylabel("Largest force (N)")
    axes.set_xlim(left=0)
    _legend(figure)
    return Drawing(figure, columns)


def _legend(figure: Figure) -> None:
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, title="Preconditioned to", loc="outside upper center", ncols=len(labels))
