"""The study of composite chains: speed and height of the output pulse against the section's length, and reflections."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import SymLogNorm
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing, new_figure
from granwave.analysis.studies.chains.composite import Composite, Decay, composites, decay, is_source
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.study import Picture, Row, Study
from granwave.lammps_inputs.case.material import Material

_MICRO, _MILLI, _MEGA = 1e6, 1e3, 1e6
_WATCHED = 6  # beads in the section whose reflections are shown, as in source Fig. 6
_SHOWN = 4  # lengths of the section whose pulses are shown
_CHANGES = 0.05  # relative: below it a ratio is as good as constant, and its fit tells nothing
_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY)
_LEAST = 3e-3  # of the largest force at a contact: where its axis begins
_MAP = "RdBu"
_FAINT = 0.01  # of the largest force: where the colours of the map begin to be linear
_PLACE = "composite chain, "

#: What the source measured: V (m/s) by the number of beads.
_SPEEDS = {"brass-composite": {3: 469.0, 24: 424.0}, "ptfe": {}}
#: When the pulse from the chain's end comes back (s), and the stress in the section's first and last contact (Pa).
_FROM_END = {"brass-composite": 1.25e-3, "ptfe": 1.85e-3}
_STRESSES = {"brass-composite": (1200e6, 1110e6), "ptfe": (35e6, 20e6)}
_REMARKS_OF_SPEED = {
    True: "Nothing dissipates here. A striker of 0.41 m/s would give the measured V: 0.626 m/s is a free fall of 20 "
    "mm, not the source's slope of 3 degrees. Its finite elements, 2 to 3 % slow, are up to 4.2 % above the measured.",
    False: "Depends on the yield strength, which the source does not give; not fitted.",
}
_REMARKS_OF_CHANGE = {
    True: "The distance of the sensors holds ever less of the fast section: this alone lowers V, without loss.",
    False: "With loss the pulse slows down all along the section; the source's measured V shows little of it.",
}
_REMARKS_OF_STRESS = (
    "The source says compressive stress, for an N2 that it does not give. No material bears more than its yield "
    "strength: the one of the source's model is above this value, or the model is elastic.",
    "Without loss the stress stays as it was; the source's has fallen along the section.",
)
_MEASURED, _FITTED = _PLACE + "section 4, measured", _PLACE + "Fig. 11"

Kinds = dict[str, list[Composite]]


def composite_chain(runs: Sequence[ChainRun]) -> Iterator[Study]:
    """Chains with a section of another material between two sensors, a study for each material."""
    for light, chains in composites(runs):
        known = next((name for name in _SPEEDS if all(is_source(chain, name) for chain in chains)), None)
        yield _study(light, chains, known)


def _study(light: Material, chains: Sequence[Composite], known: str | None) -> Study:
    kinds = _kinds(chains)
    rows: list[Row] = []
    for name, part in kinds.items():
        rows += [*_rows_of_speed(name, part, known), *_rows_of_ratio(name, part)]
    first = next(iter(kinds.values()))
    watched = min(first, key=lambda chain: abs(chain.n - _WATCHED))
    rows += _rows_of_reflections(watched, known)
    rows += _rows_of_stress(watched, known) if math.isinf(watched.strength) else []
    slug = (light.name or "section").replace("-", "_")
    at_sensor = f"{light.name}: pulse at the second sensor (source Figs. 7, 10)"
    waves = f"{light.name}, {watched.n} beads: waves in the chain, and at one contact of the section (source Fig. 6)"
    pictures = [
        Picture(f"composite_{slug}_pulses", at_sensor, _pulses(kinds)),
        Picture(f"composite_{slug}_reflections", waves, _reflections(watched)),
    ]
    if len({chain.n for chain in chains}) > 1:
        caption = f"{light.name}: speed and height of the output pulse against the section's length (source Fig. 11)"
        drawing = _against_length(kinds, _SPEEDS.get(known or "", {}))
        pictures.append(Picture(f"composite_{slug}_length", caption, drawing))
    return Study(
        f"composite-{slug.replace('_', '-')}",
        f"Composite chain with {light.name}",
        f"{len(chains)} chains of {chains[0].run.case.packing.size[0]} beads, {min(c.n for c in chains)} to "
        f"{max(c.n for c in chains)} of them {light.name} ({', '.join(kinds)}). A sensor reads the mean of its bead's "
        "two contact forces. V: distance of the sensors over the time between the first peaks there; lambda: the "
        "ratio of these peaks, output over incident.",
        tuple(rows),
        tuple(pictures),
    )


def _kinds(chains: Sequence[Composite]) -> Kinds:
    """Elastic ones first, then by falling yield strength; one chain of each length."""
    kinds: Kinds = {}
    for strength in sorted({chain.strength for chain in chains}, reverse=True):
        name = "elastic" if math.isinf(strength) else f"yielding at {strength / _MEGA:g} MPa"
        lengths = {chain.n: chain for chain in reversed(chains) if chain.strength == strength}
        kinds[name] = [lengths[n] for n in sorted(lengths)]
    return kinds


# ---------------------------------------------------------------------- rows


def _arrays(chains: Sequence[Composite]) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Beads in the section, V and lambda."""
    columns = np.array([(chain.n, chain.speed, chain.ratio) for chain in chains], dtype=float)
    return columns[:, 0], columns[:, 1], columns[:, 2]


def _rows_of_speed(name: str, chains: Sequence[Composite], known: str | None) -> Iterator[Row]:
    n, speed, _ = _arrays(chains)
    measured = _SPEEDS.get(known or "", {})
    elastic = math.isinf(chains[0].strength)
    ends = [int(n[k]) for k in sorted({0, len(n) - 1})]
    sources = [measured.get(beads) for beads in ends]
    for beads, source, value in zip(ends, sources, (speed[0], speed[-1]), strict=False):
        remark = _REMARKS_OF_SPEED[elastic] if source else ""
        yield Row(f"V, N2 = {beads}, {name}", "m/s", source, float(value), _MEASURED if source else _FITTED, remark)
    if len(ends) > 1:
        both = 100 * (sources[1] / sources[0] - 1) if sources[0] and sources[1] else None
        remark = _REMARKS_OF_CHANGE[elastic] if both else ""
        change = float(100 * (speed[-1] / speed[0] - 1))
        yield Row(
            f"Change of V from N2 = {ends[0]} to {ends[1]}, {name}", "%", both, change,
            _MEASURED if both else _FITTED, remark,
        )  # fmt: skip
    fit = decay(n, speed)
    if fit:
        formula = f"V = {fit.end:.1f} + {fit.span:.1f} exp(-N2/{fit.length:.2f}) m/s, to {fit.residual:.2g} rms."
        yield Row(f"N2 within which V nears its end by 1/e, {name}", "", None, fit.length, _FITTED, formula)


def _rows_of_ratio(name: str, chains: Sequence[Composite]) -> Iterator[Row]:
    n, _, ratio = _arrays(chains)
    for k in sorted({0, len(n) - 1}):
        yield Row(f"lambda, N2 = {n[k]:.0f}, {name}", "", None, float(ratio[k]), _FITTED)
    difference = float(np.ptp(ratio) / ratio.max())
    if len(n) > 1 and difference < _CHANGES:
        remark = "Without loss it does not depend on the length: the source's decay is loss."
        yield Row(f"Largest difference of lambda over all N2, {name}", "%", None, 100 * difference, _FITTED, remark)
        return
    fit = decay(n, ratio)
    if fit:
        formula = f"lambda = {fit.end:.3f} + {fit.span:.3f} exp(-N2/{fit.length:.2f}), to {fit.residual:.2g} rms."
        yield Row(f"N2 within which lambda nears its end by 1/e, {name}", "", None, fit.length, _FITTED, formula)


def _rows_of_reflections(chain: Composite, known: str | None) -> Iterator[Row]:
    words = {
        "incident": "Incident pulse",
        "BRW": "Back reflection (BRW)",
        "FRW": "Forth reflection (FRW)",
        "DFRW": "Delayed forth reflection (DFRW)",
    }
    at = f"between beads {chain.middle} and {chain.middle + 1}, N2 = {chain.n}"
    found = chain.reflections
    for key, text in words.items():
        if key not in found:
            continue
        remark = f"{found[key].force:.3g} N."
        if key == "BRW" and "FRW" not in found:
            remark += " No forth reflection above 0.5 % of the largest force follows it."
        if key == "FRW" and not found[key].forth:
            remark += " It meets a second wave back here, and their forces add up."
        yield Row(f"{text} {at}", "ms", None, _MILLI * found[key].time, _PLACE + "Fig. 6", remark)
    if "end" in found:
        source = _FROM_END.get(known or "")
        yield Row(
            f"Pulse back from the chain's end {at}", "ms", None if source is None else _MILLI * source,
            _MILLI * found["end"].time, _PLACE + "3.3", f"{found['end'].force:.3g} N; time from the impact on.",
        )  # fmt: skip


def _rows_of_stress(chain: Composite, known: str | None) -> Iterator[Row]:
    sources = _STRESSES.get(known or "", (None, None))
    ends = zip(sources, (chain.first, chain.last - 1), ("first", "last"), _REMARKS_OF_STRESS, strict=True)
    for source, bead, place, remark in ends:
        yield Row(
            f"Largest von Mises stress, {place} contact of the section, N2 = {chain.n}, elastic", "MPa",
            None if source is None else source / _MEGA, chain.stress(bead) / _MEGA, _PLACE + "3.3",
            remark if source else "",
        )  # fmt: skip


# ---------------------------------------------------------------------- figures


def _pulses(kinds: Kinds) -> Drawing:
    """Force at both sensors for some lengths of the section."""
    figure = new_figure(2.6, 3.4 * len(kinds))
    row = figure.subplots(1, len(kinds), squeeze=False, sharey=True)[0]
    columns: dict[str, NDArray[np.float64]] = {}
    for axes, (name, chains) in zip(row, kinds.items(), strict=True):
        slug, latest = name.replace(" ", "_"), 0.0
        for chain, colour in zip(_some(chains), _COLOURS, strict=False):
            time, force = chain.run.time, chain.run.sensors[chain.behind]
            axes.plot(_MICRO * time, force, color=colour, linewidth=0.9, label=rf"$N_2$ = {chain.n}")
            columns |= {f"{slug}_{chain.n}_time_s": time, f"{slug}_{chain.n}_output_N": force}
            latest = max(latest, chain.output[0])
        time, incident = chains[0].run.time, chains[0].run.sensors[chains[0].before]
        until = time < chains[0].output[0]
        axes.plot(_MICRO * time[until], incident[until], color="black", linewidth=0.9, label="incident")
        columns |= {f"{slug}_incident_time_s": time, f"{slug}_incident_N": incident}
        axes.set_xlim(0, 1.25 * _MICRO * latest)
        axes.set_ylim(bottom=0)
        axes.set_xlabel("Time (µs)")
        axes.set_title(name)
    row[0].set_ylabel("Sensor force (N)")
    row[-1].legend(fontsize=7)
    return Drawing(figure, columns)


def _some(chains: Sequence[Composite]) -> list[Composite]:
    """A few, at about equal ratios of length."""
    wanted = np.geomspace(chains[0].n, chains[-1].n, _SHOWN)
    chosen = {min(range(len(chains)), key=lambda k: abs(chains[k].n - n)) for n in wanted}
    return [chains[k] for k in sorted(chosen)]


def _reflections(chain: Composite) -> Drawing:
    """Waves forth and back in place and time; beside it, on the same scale of time, the force at one contact."""
    time, flow = chain.run.time, chain.flow()
    k = chain.contact(chain.middle)
    place = chain.run.place[: flow.shape[1]]
    largest = float(np.abs(flow).max())
    norm = SymLogNorm(_FAINT * largest, vmin=-largest, vmax=largest)
    figure = new_figure(4.2, 7.0)
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=(1.5, 1))
    mesh = left.pcolormesh(
        _MILLI * place, _MICRO * time, flow, norm=norm, cmap=_MAP, rasterized=True, shading="nearest"
    )
    for bead in (chain.first - 1, chain.last):
        left.axvline(_MILLI * place[chain.contact(bead)], color="black", linewidth=0.6, linestyle="--")
    left.axvline(_MILLI * place[k], color=GREY, linewidth=0.6, linestyle=":")
    left.set_xlabel("Place (mm)")
    left.set_ylabel("Time (µs)")
    bar = figure.colorbar(mesh, ax=left, location="top", label="Contact force (N), negative while the beads move back")
    bar.ax.tick_params(labelsize=7)
    force = chain.run.force[:, k]
    right.plot(np.maximum(force, 1e-9 * force.max()), _MICRO * time, color=BLUE, linewidth=0.9)
    for name, wave in chain.reflections.items():
        right.annotate(
            {"end": "from the end"}.get(name, name), (wave.force, _MICRO * wave.time), (6, 0),
            textcoords="offset points", va="center", fontsize=7,
        )  # fmt: skip
    right.set_xscale("log")
    right.set_xlim(_LEAST * float(force.max()), 20 * float(force.max()))
    right.set_xlabel(f"Force (N) between beads {chain.middle} and {chain.middle + 1}")
    right.set_ylim(0, _MICRO * float(time[-1]))
    return Drawing(
        figure, {"time_s": time, f"contact_{chain.middle}_{chain.middle + 1}_N": force, "flow_N": flow[:, k]}
    )


def _against_length(kinds: Kinds, measured: dict[int, float]) -> Drawing:
    figure = new_figure(2.6, 7.0)
    left, right = figure.subplots(1, 2)
    columns: dict[str, NDArray[np.float64]] = {}
    for (name, chains), colour, marker in zip(kinds.items(), _COLOURS, "os^Dv", strict=False):
        n, speed, ratio = _arrays(chains)
        slug = name.replace(" ", "_")
        columns |= {f"{slug}_n": n, f"{slug}_speed_m_s": speed, f"{slug}_ratio": ratio}
        for axes, values in ((left, speed), (right, ratio)):
            axes.plot(n, values, marker, color=colour, markersize=4, label=name)
            _draw_fit(axes, decay(n, values), n, colour)
    if measured:
        left.plot(list(measured), list(measured.values()), "*", color="black", markersize=7, label="source, measured")
    for axes, title in ((left, r"Speed $V$ (m/s)"), (right, r"$\lambda$, output over incident peak")):
        axes.set_xlabel(r"Beads in the section $N_2$")
        axes.set_ylabel(title)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    right.set_ylim(bottom=0)
    left.legend()
    return Drawing(figure, columns)


def _draw_fit(axes: Axes, fit: Decay | None, n: NDArray[np.float64], colour: str) -> None:
    if fit is not None:
        fine = np.linspace(n[0], n[-1], 200)
        axes.plot(fine, fit(fine), color=colour, linewidth=0.8)
