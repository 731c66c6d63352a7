"""Losses in the contacts of composite chains: what a restitution below 1 makes of the output pulse.

The source (section 4) measures a V that falls with the section's length, and a lambda that falls ever more below that
of its elastic finite elements. Here all contacts have Tsuji's dashpot, whose restitution is the same at any speed.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence

from granwave.analysis.figures.chains import losses as figures
from granwave.analysis.measures.chains.composite_section import Composite, composite_of
from granwave.analysis.measures.chains.record import ChainRecord
from granwave.analysis.studies.chains.composite.section import SOURCES, Source, is_source
from granwave.analysis.studies.chains.runs import chain_runs
from granwave.analysis.studies.runs import FinishedRun, rising
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.case.loss import DashpotRestitution

TITLE = "Losses in the contacts of composite chains"
TEXT = (
    "Composite chains with Hertz's law and Tsuji's dashpot in every contact, given by the restitution of a collision, "
    "which does not depend on the speed. V and lambda as in the study of composite chains. The source gives no "
    "restitution: that here is a value of polished metal spheres."
)
_PLACE = "composite chain, "
_WATCHED = 6  # beads in the section, of the source's pressures


@dataclasses.dataclass(frozen=True)
class Series:
    """Chains of one section's material, by falling restitution, then by rising length of the section."""

    light: str
    chains: dict[float, list[Composite]]
    source: Source


def select(runs: Sequence[FinishedRun]) -> list[list[Series]]:
    """Composite chains whose dashpot is given by its restitution, by the section's material."""
    lossy = [run for run in chain_runs(runs) if not math.isnan(_restitution_of(run)) and not run.case.contact.yields]
    found = [chain for run in lossy if (chain := composite_of(run)) is not None]
    series = []
    for light in dict.fromkeys(chain.light.name or "section" for chain in found):
        alike = [chain for chain in found if (chain.light.name or "section") == light]
        values = sorted({restitution(chain) for chain in alike}, reverse=True)
        chains = {
            value: rising((one for one in alike if restitution(one) == value), lambda one: one.n) for value in values
        }
        known = (source for name, source in SOURCES.items() if all(is_source(chain, name) for chain in alike))
        series.append(Series(light, chains, next(known, Source())))
    return [series] if series else []


def restitution(chain: Composite) -> float:
    """Restitution of the contacts."""
    return _restitution_of(chain.run)


def rows(found: list[Series]) -> Iterator[Row]:
    """Speed, lambda and pressures beside the source's measurements, for each restitution."""
    for series in found:
        for value, chains in series.chains.items():
            yield from _rows(series, f"{series.light}, restitution {value:g}", chains)


_STRIKER, _SLOWER = 0.626, 0.41  # m/s, as printed, and what gives the measured speeds


def _rows(series: Series, kind: str, chains: Sequence[Composite]) -> Iterator[Row]:
    first, last, source = chains[0], chains[-1], series.source
    for chain in (first, last)[: len(chains)]:
        known, remark = source.speeds.get(chain.n), ""
        if known is not None:
            slower = chain.speed * (_SLOWER / _STRIKER) ** 0.2
            remark = (
                f"Measured. The restitution is our choice. A striker of {_SLOWER:g} m/s, not the printed {_STRIKER:g}, "
                f"would make it {slower:.0f} m/s, by the fifth root of its speed."
            )
        yield Row(f"V, N2 = {chain.n}, {kind}", "m/s", known, chain.speed, _PLACE + "section 4", remark)
    if len(chains) > 1:
        known = first.n in source.speeds and last.n in source.speeds
        printed = 100 * (source.speeds[last.n] / source.speeds[first.n] - 1) if known else None
        yield Row(f"Change of V from N2 = {first.n} to {last.n}, {kind}", "%", printed,
                  100 * (last.speed / first.speed - 1), _PLACE + "section 4",
                  "Source: of its two values of V." if known else "")  # fmt: skip
        yield Row(f"Change of lambda from N2 = {first.n} to {last.n}, {kind}", "%", None,
                  100 * (last.ratio / first.ratio - 1), _PLACE + "Fig. 11",
                  f"From {first.ratio:.3f} to {last.ratio:.3f}. The source's falls exponentially.")  # fmt: skip
    for chain in (one for one in chains if one.n == _WATCHED):
        ends = [chain.pressure(bead) for bead in (chain.first, chain.last - 1)]
        begin, end = source.stresses
        printed = end / begin if begin and end else None
        yield Row(f"Largest pressure of the section's last contact over that of its first, N2 = {chain.n}, {kind}", "",
                  printed, ends[1] / ends[0], _PLACE + "3.3",
                  "Source: of its two compressive stresses, without N2." if printed else "")  # fmt: skip


def pictures(found: list[Series]) -> Iterator[Picture]:
    """Speed and lambda against the section's length, for each restitution."""
    caption = "Speed and height of the output pulse against the section's length, by restitution of the contacts"
    drawing = figures.of_composites({one.light: one.chains for one in found}, [one.source.speeds for one in found])
    yield Picture("composite_loss", caption, drawing)


def verdict(found: list[Series]) -> Iterator[str]:
    """Tell whether such losses explain what the source measures."""
    for series in found:
        value = min(series.chains)
        chains = series.chains[value]
        if value == 1 or len(chains) < 2:
            continue
        first, last = chains[0], chains[-1]
        text = (
            f"With restitution {value:g} lambda falls from {first.ratio:.3f} ({first.n} beads of {series.light}) to "
            f"{last.ratio:.3f} ({last.n}), and V by {100 * (1 - last.speed / first.speed):.2g} %"
        )
        speeds = series.source.speeds
        if first.n in speeds and last.n in speeds:
            text += f" (measured: {100 * (1 - speeds[last.n] / speeds[first.n]):.2g} %)"
        yield text + "."


def _restitution_of(run: ChainRecord) -> float:
    """Restitution that the dashpot of all contacts is given by; NaN without one."""
    loss = run.case.contact.loss
    given = loss.dashpot if loss is not None and not run.case.pair else None
    return given.restitution if isinstance(given, DashpotRestitution) else math.nan
