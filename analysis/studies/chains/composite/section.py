"""The study of composite chains: speed and height of the output pulse against the section's length, and its waves."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from granwave.analysis.document.model import Table
from granwave.analysis.figures.chains import composite as composite_figures
from granwave.analysis.figures.chains.composite import Kinds
from granwave.analysis.measures.chains.composite_section import Composite, composite_of
from granwave.analysis.measures.chains.groups import columns
from granwave.analysis.measures.signals import decay
from granwave.analysis.studies.chains.composite.waves import (
    rows_of_energy,
    rows_of_output,
    rows_of_pressure,
    rows_of_reflections,
    table_of_waves,
)
from granwave.analysis.studies.chains.runs import chain_runs, elastic_constants
from granwave.analysis.studies.runs import FinishedRun, rising
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.case.material import material

_MILLI, _MEGA = 1e3, 1e6
_WATCHED = 6  # beads in the section whose reflections are shown, as in source Fig. 6
_CHANGES = 0.05  # relative: below it a ratio is as good as constant, and its fit tells nothing
_PLACE = "composite chain, "

_REMARKS_OF_SPEED = {
    True: "Nothing dissipates here. A striker of 0.41 m/s would give the measured V: 0.626 m/s is a free fall of 20 "
    "mm, not the source's slope of 3 degrees. Its finite elements, 2 to 3 % slow, are up to 4.2 % above the measured.",
    False: "The yield strength is our choice: the source gives none.",
}
_REMARKS_OF_CHANGE = {
    True: "the distance of the sensors holds ever less of the fast section, and this alone lowers V, without loss.",
    False: "the yield strength, which is our choice, does not fit them: V falls far more.",
}
_MEASURED, _FITTED = _PLACE + "section 4, measured", _PLACE + "Fig. 11"


@dataclasses.dataclass(frozen=True)
class Source:
    """Values of the source for a section of one material.

    Attributes
    ----------
    speeds
        Measured V by the number of beads, m/s.
    from_end
        When the pulse from the chain's end comes back, ms.
    stresses
        In the section's first and last contact, MPa.
    """

    speeds: Mapping[int, float] = dataclasses.field(default_factory=dict)
    from_end: float | None = None
    stresses: tuple[float | None, float | None] = (None, None)


#: Values of the source by the section's material.
SOURCES = {
    "brass-composite": Source({3: 469.0, 24: 424.0}, 1.25, (1200.0, 1110.0)),
    "ptfe": Source({}, 1.85, (35.0, 20.0)),
}
_LARGEST_SPEED_ERROR = 4.2  # per cent, of the source's finite elements against its measurements, brass
_STRIKER_SPEED = 0.626  # m/s
_ROLLED, _SLOPE, _GRAVITY = 0.010, math.radians(3), 9.81  # m, between surfaces; slope of the holder; m/s^2


@dataclasses.dataclass(frozen=True)
class Group:
    """Chains with a section of one material.

    Attributes
    ----------
    kinds
        Elastic ones first, then by falling yield strength; one chain of each length.
    source
        Values for these chains, if they are the source's.
    """

    chains: list[Composite]
    kinds: Kinds
    source: Source

    @property
    def light(self) -> str | None:
        """Material of the section."""
        return self.chains[0].light.name

    @property
    def slug(self) -> str:
        """Slug for names of files."""
        return (self.light or "section").replace("-", "_")

    @property
    def watched(self) -> Composite:
        """Chain whose reflections are shown."""
        return min(next(iter(self.kinds.values())), key=lambda chain: abs(chain.n - _WATCHED))


def select(runs: Sequence[FinishedRun]) -> list[Group]:
    """Chains with a section of another material between two sensors, a group for each material."""
    smooth = [
        run for run in chain_runs(runs) if not (run.case.has_holder_friction or run.case.has_loss)
    ]  # `holder`, `loss`
    found = [chain for run in smooth if (chain := composite_of(run)) is not None]
    groups = []
    for light in dict.fromkeys(chain.light.name for chain in found):
        one_each = {(chain.n, -chain.strength): chain for chain in reversed(found) if chain.light.name == light}
        alike = [one_each[key] for key in sorted(one_each)]
        kinds: Kinds = {}
        for strength in sorted({chain.strength for chain in alike}, reverse=True):
            kind = "elastic" if math.isinf(strength) else f"yielding at {strength / _MEGA:g} MPa"
            kinds[kind] = rising((chain for chain in alike if chain.strength == strength), lambda chain: chain.n)
        known = (source for name, source in SOURCES.items() if all(is_source(chain, name) for chain in alike))
        groups.append(Group(alike, kinds, next(known, Source())))
    return groups


def name(group: Group) -> str:
    """For links."""
    return f"composite-{group.slug.replace('_', '-')}"


def title(group: Group) -> str:
    """With the section's material."""
    return f"Composite chain with {group.light}"


def text(group: Group) -> str:
    """Describe the runs."""
    chains = group.chains
    many = f"{len(chains)} chain{'s' * (len(chains) > 1)} of {chains[0].run.case.packing.size[0]} beads"
    return (
        f"{many}, {chains[0].n} to {chains[-1].n} of them {group.light} ({', '.join(group.kinds)}). A sensor reads the "
        "mean of its bead's two contact forces. V: distance of the sensors over the time between the first peaks "
        "there; lambda: the ratio of these peaks, output over incident."
    )


def rows(group: Group) -> Iterator[Row]:
    """Speed and height of the output pulse, waves in and behind the section, energy and pressure."""
    for kind, chains in group.kinds.items():
        yield from _rows_of_speed(kind, chains, group.source.speeds)
        yield from _rows_of_ratio(kind, chains)
    yield from _rows_of_striker(group.source)
    yield from rows_of_reflections(group.watched, group.source.from_end)
    for kind, chains in group.kinds.items():
        watched = min(chains, key=lambda chain: abs(chain.n - _WATCHED))
        yield from rows_of_output(watched, chains[-1], kind)
        yield from rows_of_energy(watched, kind)
    if math.isinf(group.watched.strength):
        yield from rows_of_pressure(group.watched, group.source.stresses)


def tables(group: Group) -> Iterator[Table]:
    """All waves at the watched contact."""
    yield table_of_waves(group.watched)


def pictures(group: Group) -> Iterator[Picture]:
    """Pulses, reflections, and both quantities against the section's length."""
    light, slug, watched = group.light, group.slug, group.watched
    caption = f"{light}: pulse at the second sensor (source Figs. 7, 10)"
    yield Picture(f"composite_{slug}_pulses", caption, composite_figures.pulses(group.kinds))
    caption = f"{light}, {watched.n} beads: waves in the chain, and at one contact of the section (source Fig. 6)"
    yield Picture(f"composite_{slug}_reflections", caption, composite_figures.reflections(watched))
    caption = (
        f"{light}, {watched.n} beads: energy by section (dips: in the contact with the end), and its largest density "
        "along the chain (source Fig. 8)"
    )
    alike = {kind: min(chains, key=lambda one: abs(one.n - _WATCHED)) for kind, chains in group.kinds.items()}
    yield Picture(f"composite_{slug}_energy", caption, composite_figures.energies(alike))
    if group.chains[0].n != group.chains[-1].n:
        caption = f"{light}: speed and height of the output pulse against the section's length (source Fig. 11)"
        drawing = composite_figures.against_length(group.kinds, group.source.speeds)
        yield Picture(f"composite_{slug}_length", caption, drawing)


def is_source(chain: Composite, light: str) -> bool:
    """The chain of the composite-chain source with this material of the section."""
    case, assembly = chain.run.case, chain.run.assembly
    return (
        elastic_constants(case.material) == elastic_constants(material("stainless-steel"))
        and elastic_constants(chain.light) == elastic_constants(material(light))
        and (case.packing.size[0], chain.first, case.packing.diameter) == (40, 8, 0.01)
        and [striker.velocity[2] for striker in case.striker] == [0.626]
        and assembly.strikers[0][0].material in (None, case.material)
    )


def _rows_of_speed(kind: str, chains: Sequence[Composite], measured: Mapping[int, float]) -> Iterator[Row]:
    n, speed = columns(chains, "n", "speed")
    elastic, ends = math.isinf(chains[0].strength), sorted({0, len(n) - 1})
    for k in ends:
        source = measured.get(int(n[k]))
        remark = _REMARKS_OF_SPEED[elastic] if source else ""
        where = _MEASURED if source else _FITTED
        yield Row(f"V, N2 = {n[k]}, {kind}", "m/s", source, float(speed[k]), where, remark)
    if len(ends) > 1:
        known = n[0] in measured and n[-1] in measured
        printed = 100 * (measured[n[-1]] / measured[n[0]] - 1) if known else 0.0
        remark = f"From the source's two values of V: {printed:.1f} %; {_REMARKS_OF_CHANGE[elastic]}" if known else ""
        yield Row(f"Change of V from N2 = {n[0]} to {n[-1]}, {kind}", "%", None,
                  float(100 * (speed[-1] / speed[0] - 1)), _MEASURED if known else _FITTED, remark)  # fmt: skip
    errors = [abs(float(v) / measured[int(one)] - 1) for one, v in zip(n, speed, strict=True) if int(one) in measured]
    if errors:
        yield Row(f"Largest error of V against the measured, {kind}", "%", _LARGEST_SPEED_ERROR, 100 * max(errors),
                  _PLACE + "section 4", "The source's: over all N2, of its finite elements. Ours: over the N2 whose "
                  "measured V it prints.")  # fmt: skip
    if fit := decay(n, speed):
        formula = f"V = {fit.end:.1f} + {fit.span:.1f} exp(-N2/{fit.length:.2f}) m/s, to {fit.residual:.2g} rms."
        yield Row(f"N2 within which V nears its end by 1/e, {kind}", "", None, fit.length, _FITTED, formula)


def _rows_of_ratio(kind: str, chains: Sequence[Composite]) -> Iterator[Row]:
    n, ratio = columns(chains, "n", "ratio")
    for k in sorted({0, len(n) - 1}):
        yield Row(f"lambda, N2 = {n[k]}, {kind}", "", None, float(ratio[k]), _FITTED)
    difference = float(np.ptp(ratio) / ratio.max())
    if len(n) > 1 and difference < _CHANGES:
        remark = "Without loss it does not depend on the length: the source's decay is loss."
        yield Row(f"Largest difference of lambda over all N2, {kind}", "%", None, 100 * difference, _FITTED, remark)
    elif fit := decay(n, ratio):
        formula = f"lambda = {fit.end:.3f} + {fit.span:.3f} exp(-N2/{fit.length:.2f}), to {fit.residual:.2g} rms."
        yield Row(f"N2 within which lambda nears its end by 1/e, {kind}", "", None, fit.length, _FITTED, formula)


def _rows_of_striker(source: Source) -> Iterator[Row]:
    """The striker's speed in the source, which cannot be that of its slope."""
    if source.from_end is not None:
        slid = math.sqrt(2 * _GRAVITY * math.sin(_SLOPE) * _ROLLED)
        yield Row("Speed of the striker", "m/s", _STRIKER_SPEED, None, _PLACE + "section 4",
                  "The source's is that of a free fall of 20 mm. Released with its centre 20 mm before that of the "
                  "first bead it slides 10 mm down a slope of 3 degrees.", slid)  # fmt: skip
