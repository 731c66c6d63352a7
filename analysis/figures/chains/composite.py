"""Figures of composite chains: pulses behind the section, reflections in it, and both against its length."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from granwave.analysis.figures.series import MARKS, label, map_of_forces, panels
from granwave.analysis.figures.style import BLANK, BLUE, GREY, ORANGE, WIDTH, Drawing, legend_above
from granwave.analysis.measures.chains.composite_section import Composite
from granwave.analysis.measures.chains.groups import columns
from granwave.analysis.measures.chains.section_energy import SectionEnergy
from granwave.analysis.measures.signals import decay

_MICRO, _MILLI = 1e6, 1e3
_SECTIONS, _STYLES = ("first steel", "light", "second steel"), ("-", "--", ":")
_SHOWN = 4  # lengths of the section whose pulses are shown
_LEAST = 3e-3  # of the largest force at a contact: where its axis begins
_FAINT = 0.01  # of the largest force: where the colours of the map begin to be linear

Kinds = dict[str, list[Composite]]  # chains by the kind of section, in the order of its length


def pulses(kinds: Kinds) -> Drawing:
    """Force at both sensors for some lengths of the section."""
    figure, *row = panels(2.6, len(kinds), width=WIDTH * len(kinds), sharey=True)
    data: dict[str, ArrayLike] = {}
    for axes, (name, chains) in zip(row, kinds.items(), strict=True):
        slug, some, shortest = name.replace(" ", "_"), _spread_lengths(chains), chains[0]
        for chain in some:
            time, force = chain.run.time, chain.run.sensors[chain.behind]
            axes.plot(_MICRO * time, force, label=rf"$N_2$ = {chain.n}")
            data |= {f"{slug}_{chain.n}_time_s": time, f"{slug}_{chain.n}_output_N": force}
        time, incident = shortest.run.time, shortest.run.sensors[shortest.before]
        until = time < shortest.output[0]
        axes.plot(_MICRO * time[until], incident[until], color="black", label="incident")
        data |= {f"{slug}_incident_time_s": time, f"{slug}_incident_N": incident}
        latest = max(chain.output[0] for chain in some)
        label(axes, "Time (µs)", title=name, xlim=(0, 1.25 * _MICRO * latest), ylim=(0, None))
    label(row[0], y="Sensor force (N)")
    row[-1].legend(fontsize=7)
    return Drawing(figure, data)


def _spread_lengths(chains: Sequence[Composite]) -> list[Composite]:
    """Select a few chains, at about equal ratios of length."""
    wanted = np.geomspace(chains[0].n, chains[-1].n, _SHOWN)
    found = {chain.n: chain for chain in (min(chains, key=lambda chain: abs(chain.n - n)) for n in wanted)}
    return [found[n] for n in sorted(found)]


def reflections(chain: Composite) -> Drawing:
    """Waves forth and back in place and time; beside it, on the same scale of time, the force at one contact."""
    run, flow, k = chain.run, chain.flow(), chain.run.contact_between(chain.middle)
    time, force, place = _MICRO * run.time, run.force[:, k], _MILLI * run.place[: flow.shape[1]]
    highest = float(force.max())
    figure, left, right = panels(4.2, 2, sharey=True, width_ratios=(1.5, 1))
    mesh = map_of_forces(left, place, time, flow, _FAINT)
    for bead in (chain.first - 1, chain.last):
        left.axvline(place[run.contact_between(bead)], color="black", linewidth=0.6, linestyle="--")
    left.axvline(place[k], color=GREY, linewidth=0.6, linestyle=":")
    label(left, "Place (mm)", "Time (µs)")
    figure.colorbar(mesh, ax=left, location="top", label="Contact force (N), negative while the beads move back")
    right.plot(np.maximum(force, 1e-9 * highest), time, color=BLUE)
    for name, wave in chain.reflections.items():
        right.annotate("from the end" if name == "end" else name, (wave.force, _MICRO * wave.time), (6, 0),
                       textcoords="offset points", va="center", fontsize=7)  # fmt: skip
    label(right, f"Force (N) between beads {chain.middle} and {chain.middle + 1}", log="x",
          xlim=(_LEAST * highest, 20 * highest), ylim=(0, time[-1]))  # fmt: skip
    watched = f"contact_{chain.middle}_{chain.middle + 1}_N"
    return Drawing(figure, {"time_s": run.time, watched: force, "flow_N": flow[:, k]})


def energies(kinds: Mapping[str, Composite]) -> Drawing:
    """Energy of the three sections in time, and the largest energy density of every bead, for chains by kind."""
    figure, left, right = panels(2.8, 2)
    data: dict[str, ArrayLike] = {}
    for (kind, chain), style in zip(kinds.items(), _STYLES, strict=False):
        energy, slug = SectionEnergy(chain), kind.replace(" ", "_")
        data |= {f"{slug}_time_s": energy.time}
        for share, name, colour in zip(energy.sections.T, _SECTIONS, (GREY, ORANGE, BLUE), strict=True):
            left.plot(_MICRO * energy.time, share, style, color=colour, label=name if style == "-" else None)
            data[f"{slug}_{name}_over_input".replace(" ", "_")] = share
        ids = chain.run.array("chain/id")
        place = np.where(ids <= chain.run.assembly.lattice.n_spheres, ids, 0)  # the striker before bead 1
        right.plot(place, energy.highest_densities, "o" + style, markersize=2.5, label=kind)
        data |= {f"{slug}_bead": place, f"{slug}_density_J_m3": energy.highest_densities}
    chain = next(iter(kinds.values()))
    right.axvspan(chain.first - 0.5, chain.last + 0.5, color=BLANK, alpha=0.6, linewidth=0)
    label(left, "Time (µs)", "Energy over the input", xlim=(0, None), ylim=(0, None))
    label(right, "Bead (0: striker; shaded: section)", "Largest energy density (J/m³)", ylim=(0, None))
    legend_above(left, 3, fontsize=7)
    legend_above(right, 2, fontsize=7)
    return Drawing(figure, data)


def against_length(kinds: Kinds, measured: Mapping[int, float]) -> Drawing:
    """Speed and height of the output pulse with their exponential laws."""
    figure, left, right = panels(2.6, 2)
    data: dict[str, ArrayLike] = {}
    for (name, chains), marker in zip(kinds.items(), MARKS, strict=False):
        n, speed, ratio = columns(chains, "n", "speed", "ratio")
        slug = name.replace(" ", "_")
        data |= {f"{slug}_n": n.astype(float), f"{slug}_speed_m_s": speed, f"{slug}_ratio": ratio}
        for axes, values in ((left, speed), (right, ratio)):
            (marks,) = axes.plot(n, values, marker, markersize=4, label=name)
            if fit := decay(n, values):
                fine = np.linspace(n[0], n[-1], 200)
                axes.plot(fine, fit(fine), color=marks.get_color())
    if measured:
        left.plot(list(measured), list(measured.values()), "k*", label="source, measured")
    label(left, r"Beads in the section $N_2$", r"Speed $V$ (m/s)")
    label(right, r"Beads in the section $N_2$", r"$\lambda$, output over incident peak", ylim=(0, None))
    left.legend()
    return Drawing(figure, data)
