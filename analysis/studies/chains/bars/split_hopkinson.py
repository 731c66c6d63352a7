"""A chain between two elastic bars, struck by a pulse that comes down the first one (thesis 3.2.2)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from granwave.analysis.figures.run.chain import force_map
from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, Drawing
from granwave.analysis.measures.chains.bar_pulse import passage
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.chains.runs import ChainRun, chain_runs
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.packing.bars import BAR, INCIDENT_BAR

TITLE = "Split-Hopkinson bar"
_MICRO, _KILO = 1e6, 1e-3
_WHERE = "thesis 3.2.2, Fig. 3.5"
_ASSUMED = "The source prints no incident signal and no value: the pulse is ours, and nothing is tested by this number."
_SECTIONS = (("Incident bar", 0.5), ("Bar", 0.25))  # shown; lengths from the end where the pulse enters


def select(runs: Sequence[FinishedRun]) -> list[ChainRun]:
    """Recorded chains between two bars."""
    return [run for run in chain_runs(runs) if run.case.bar and run.case.incident_bar and run.recorded]


def text(run: ChainRun) -> str:
    """Describe the runs."""
    return (
        f"{run.assembly.lattice.n_spheres} beads between two bars; what comes down the first one is given as a "
        "force on its free end. Incident energy is the work of that force; reflected and transmitted energy are what "
        "the bars hold at the end of the run, before an echo of their ends has reached the chain again."
    )


def rows(run: ChainRun) -> Iterator[Row]:
    """Force and energy ratios."""
    incident, transmitted = passage(run, run.assembly.bars[0]).peak, run.value("wall_peak_force_N")
    entered = run.value("energy_input_J")
    for what, unit, ours, remark in (
        ("Peak force, incident", "kN", incident * _KILO, ""),
        ("Peak force, transmitted", "kN", transmitted * _KILO, _ASSUMED),
        ("Force, transmitted over incident", "", transmitted / incident, _ASSUMED),
        ("Energy, transmitted over incident", "", run.value(f"energy_{BAR}_J") / entered, _ASSUMED),
        ("Energy, reflected over incident", "", run.value(f"energy_{INCIDENT_BAR}_J") / entered,
         "The source says that most of the energy is reflected."),
        ("Energy, dissipated over incident", "", run.value("energy_dissipated_J") / entered, ""),
    ):  # fmt: skip
        yield Row(f"{what}, {run.case.name}", unit, None, ours, _WHERE, remark)


def pictures(run: ChainRun) -> Iterator[Picture]:
    """Force at a section of each bar, and everywhere."""
    figure, *stack = panels(3.6, rows=2, sharex=True)
    data = {"time_s": run.time}
    for axes, bar, (name, share) in zip(stack, run.assembly.bars, _SECTIONS, strict=True):
        force = run.array(f"bars/{bar.name}/force")[:, int(share * bar.section.elements)]
        axes.plot(run.time * _MICRO, force * _KILO, color=BLUE)
        axes.axhline(0, color="black", linewidth=0.5)
        label(axes, y=f"{name}\nsection force (kN)")
        data[f"{bar.name}_N"] = force
    label(stack[-1], "Time (µs)", xlim=(0, float(run.time[-1]) * _MICRO))
    yield Picture("split_hopkinson", f"{run.case.name}: force at a section of each bar", Drawing(figure, data))
    with Result(run.directory) as result:
        drawing = force_map(result)
    if drawing is not None:
        caption = f"{run.case.name}: magnitude of the force in place and time, bars and chain (thesis Fig. 3.6)"
        yield Picture("split_hopkinson_map", caption, drawing)
