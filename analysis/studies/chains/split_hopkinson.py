"""A chain between two elastic bars, struck by a pulse that comes down the first one (thesis 3.2.2)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from granwave.analysis.figures.chain import force_map
from granwave.analysis.figures.style import BLUE, Drawing, new_figure
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.chains.bar import passage
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.study import Picture, Row, Study

_MICRO, _KILO = 1e6, 1e-3


def split_hopkinson(runs: Sequence[ChainRun]) -> Iterator[Study]:
    """Chains between two bars: force and energy ratios, and what the bars saw."""
    for run in runs:
        if run.case.bar is None or run.case.incident_bar is None or not run.recorded:
            continue
        incident, bar = run.assembly.bars
        passed = passage(run, incident), passage(run, bar)
        entered = float(run.summary["energy_input_J"])
        forces = passed[0].peak, float(run.summary["wall_peak_force_N"])
        where = "thesis 3.2.2, Fig. 3.5"
        assumed = "The source prints no signal and no value; this is for the pulse of the case."
        name = run.case.name
        rows = (
            Row(f"Peak force, incident, {name}", "kN", None, forces[0] * _KILO, where),
            Row(f"Peak force, transmitted, {name}", "kN", None, forces[1] * _KILO, where,
                "Fig. 3.5 has an axis to 2.5 kN, for another pulse."),
            Row(f"Force, transmitted over incident, {name}", "", None, forces[1] / forces[0], where, assumed),
            Row(f"Energy, transmitted over incident, {name}", "", None, (run.transmitted or 0.0) / entered, where,
                assumed),
            Row(f"Energy, reflected over incident, {name}", "", None, (run.reflected or 0.0) / entered, where,
                "The source says that nearly all is reflected."),
            Row(f"Energy, dissipated over incident, {name}", "", None,
                float(run.summary["energy_dissipated_J"]) / entered, where),
        )  # fmt: skip
        pictures = [Picture("split_hopkinson", f"{name}: force at a section of each bar", _sections(run))]
        with Result(run.directory) as result:
            drawing = force_map(result)
        if drawing is not None:
            caption = f"{name}: magnitude of the force in place and time, bars and chain (thesis Fig. 3.6)"
            pictures.append(Picture("split_hopkinson_map", caption, drawing))
        yield Study(
            "split-hopkinson",
            "Split-Hopkinson bar",
            f"{run.assembly.lattice.n_spheres} beads between two bars; what comes down the first one is given as a "
            "force on its free end. Incident energy is the work of that force; reflected and transmitted energy are "
            "what the bars hold at the end of the run, before an echo of their ends has reached the chain again.",
            rows,
            tuple(pictures),
        )


def _sections(run: ChainRun) -> Drawing:
    """Force at the middle of the incident bar, and at a quarter of the bar."""
    figure = new_figure(3.6)
    stack = figure.subplots(2, 1, sharex=True)
    columns: dict[str, Any] = {"time_s": run.time}
    places = (("Incident bar", 0.5), ("Bar", 0.25))  # lengths from the end where the pulse enters
    for axes, bar, (label, share) in zip(stack, run.assembly.bars, places, strict=True):
        force = run.array(f"{bar.name}/force")[:, int(share * bar.section.elements)]
        axes.plot(run.time * _MICRO, force * _KILO, color=BLUE)
        axes.axhline(0, color="black", linewidth=0.5)
        axes.set_ylabel(f"{label}\nsection force (kN)")
        columns[f"{bar.name}_N"] = force
    stack[-1].set_xlabel("Time (µs)")
    stack[-1].set_xlim(0, float(run.time[-1]) * _MICRO)
    return Drawing(figure, columns)
