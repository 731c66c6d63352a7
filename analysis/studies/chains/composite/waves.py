"""Waves in and behind the section of a composite chain: reflections, output, energy, pressure (source 3.3)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from granwave.analysis.document.model import Column, Table
from granwave.analysis.measures.chains.composite_section import Composite, Wave
from granwave.analysis.measures.chains.section_energy import SectionEnergy
from granwave.analysis.measures.signals import first_peak
from granwave.analysis.studies.study import Row
from granwave.analysis.studies.tables import numeric, table_of
from granwave.lammps_inputs.case.yield_factor import hertz_von_mises_yield_factor

_MILLI, _MEGA, _MICRO = 1e3, 1e6, 1e6
_PLACE = "composite chain, "
_SAME = 0.25  # by how much the time between two waves may change on their way through the section
_NAMES = {
    "incident": "Incident pulse",
    "BRW": "Back reflection (BRW)",
    "FRW": "Forth reflection (FRW)",
    "DFRW": "Delayed forth reflection (DFRW)",
    "end": "Pulse back from the chain's end",
}
_SECTIONS = "first steel section", "light section", "second steel section"


def rows_of_reflections(chain: Composite, from_end: float | None) -> Iterator[Row]:
    """Times of the waves at the watched contact, and energy that turns back (source Fig. 6).

    Parameters
    ----------
    from_end
        The source's time of the pulse back from the chain's end, ms.
    """
    found = chain.reflections
    for key in (key for key in _NAMES if key in found and key != "end"):
        remark = f"{found[key].force:.3g} N."
        if key == "BRW" and "FRW" not in found:
            remark += _not_found(chain)
        if key == "FRW" and not found[key].forth:
            remark += " It meets a second wave back here, and their forces add up."
        yield Row(f"{_NAMES[key]} {_at(chain)}", "ms", None, _MILLI * found[key].time, _PLACE + "Fig. 6", remark)
    if last := found.get("end"):
        remark = f"{last.force:.3g} N; time from the impact on."
        yield Row(f"{_NAMES['end']} {_at(chain)}", "ms", from_end, _MILLI * last.time, _PLACE + "3.3", remark)
    energy = SectionEnergy(chain)
    _, back = energy.passed(chain.middle)
    forth, _ = energy.passed(chain.last)
    yield Row(f"Energy back {_at(chain)} over energy out of the section", "", None, back / forth, _PLACE + "Fig. 6",
              "Until a pulse is back from the chain's end. Source: much higher for PTFE than for brass.")  # fmt: skip


def rows_of_output(shown: Composite, longest: Composite, kind: str) -> Iterator[Row]:
    """Second peak of the output, and what makes it (source Fig. 7).

    Parameters
    ----------
    longest
        The longest chain of the kind, in which a reflection comes last.
    """
    out = shown.transmitted
    if len(out) < 2:
        return
    late = out[1].time - out[0].time
    yield Row(f"Second output peak over the first, N2 = {shown.n}, {kind}", "", None, out[1].force / out[0].force,
              _PLACE + "Fig. 7", f"{_MICRO * late:.0f} µs later.")  # fmt: skip
    train = longest.train
    if len(train) < 2:
        return
    behind = train[1].time - train[0].time
    remark = f"{_MICRO * behind:.0f} µs later, before anything is reflected: the incident pulse becomes a train."
    if abs(late - behind) < _SAME * behind:
        remark += (
            " The second output peak is this wave; for the source it comes of a collision of the incident pulse with "
            "the BRW."
        )
    yield Row(f"Second wave into the section over the first, N2 = {longest.n}, {kind}", "", None,
              train[1].force / train[0].force, _PLACE + "Fig. 7", remark)  # fmt: skip


def rows_of_energy(chain: Composite, kind: str) -> Iterator[Row]:
    """Energy by section, and the largest energy density along the chain (source Fig. 8)."""
    energy = SectionEnergy(chain)
    until = energy.before_return
    for share, section in zip(energy.at(until), _SECTIONS, strict=True):
        what = f"Energy of the {section} over the input, N2 = {chain.n}, {kind}"
        remark = f"At {_MICRO * until:.0f} µs, when a pulse is back from the chain's end."
        yield Row(what, "", None, float(share), _PLACE + "Fig. 8", remark)
    density, place = energy.highest_densities, list(chain.run.array("chain/id")).index
    spans = (
        ("steel before the section", 3, chain.first - 2, "The source: constant. The pulse still finds its shape here."),
        ("section, its last bead left out", chain.first, chain.last - 1, "The source: falls, by yielding alone."),
    )
    for where, first, last, remark in spans:
        if last > first:
            change = 100 * (density[place(last)] / density[place(first)] - 1)
            yield Row(f"Change of the largest energy density along the {where}, N2 = {chain.n}, {kind}", "%", None,
                      float(change), _PLACE + "Fig. 8", remark)  # fmt: skip


def rows_of_pressure(chain: Composite, sources: Sequence[float | None]) -> Iterator[Row]:
    """Largest pressure in the first and the last contact of the section of an elastic chain (source 3.3).

    Parameters
    ----------
    sources
        The source's two compressive stresses, MPa.
    """
    found = [chain.pressure(bead) / _MEGA for bead in (chain.first, chain.last - 1)]
    factor = hertz_von_mises_yield_factor(chain.light.poisson_ratio)
    first = sources[0]
    remarks = (
        "The source: largest compressive stress in the contact area, without N2 and place. In Hertz's contact that is "
        f"the largest pressure; the mean one is {2 / 3 * found[0]:.0f}, the largest von Mises stress "
        f"{found[0] / factor:.0f} MPa."
        + (f" The source's would be a force of {_force(chain, first):.2g} N." if first else ""),
        "Without loss it stays as it was; the source's has fallen along the section.",
    )
    for source, ours, place, remark in zip(sources, found, ("first", "last"), remarks, strict=True):
        what = f"Largest pressure, {place} contact of the section, N2 = {chain.n}, elastic"
        yield Row(what, "MPa", source, ours, _PLACE + "3.3", remark if source else "")
    first, last = sources
    if first and last:
        yield Row(f"Last of these pressures over the first, N2 = {chain.n}, elastic", "", None, found[1] / found[0],
                  _PLACE + "3.3", f"The source's two values: {last / first:.3f}. Any stress goes with the cube "
                  f"root of the force, which then falls to {(last / first) ** 3:.2f} of the first within the section: "
                  "only loss can do that.")  # fmt: skip


def table_of_waves(chain: Composite) -> Table:
    """All waves at the watched contact."""
    names = {
        id(wave): _NAMES[key] + (", with a wave back" if key == "FRW" and not wave.forth else "")
        for key, wave in chain.reflections.items()
    }
    waves = chain.waves(chain.middle)
    labels = [names.get(id(wave), _second(chain, wave)) for wave in waves]
    columns = (*numeric(("Time", "ms"), ("Largest force", "N")), Column("Towards"), Column("Wave"))
    rows = [
        (_MILLI * wave.time, wave.force, "the far end" if wave.forth else "the struck end", name)
        for wave, name in zip(waves, labels, strict=True)
    ]
    return table_of(f"Waves {_at(chain)}, {_strength(chain)}", columns, rows)


def _force(chain: Composite, pressure: float) -> float:
    """Force in the section's first contact at a largest pressure in MPa, N."""
    _, force = first_peak(chain.run.time, chain.run.force[:, chain.run.contact_between(chain.first)])
    return force * (pressure * _MEGA / chain.pressure(chain.first)) ** 3


def _at(chain: Composite) -> str:
    return f"between beads {chain.middle} and {chain.middle + 1}, N2 = {chain.n}"


def _strength(chain: Composite) -> str:
    return "elastic" if math.isinf(chain.strength) else f"yielding at {chain.strength / _MEGA:g} MPa"


def _second(chain: Composite, wave: Wave) -> str:
    """Name a wave that is none of the reflections: one of the incident train, or empty."""
    forth = [one for one in chain.waves(chain.middle) if one.forth]
    number = next((n for n, one in enumerate(forth, start=1) if one is wave), 0)
    return f"number {number} of the incident train" if 1 < number <= len(chain.train) else ""


def _not_found(chain: Composite) -> str:
    """Sentence on a chain in which no forth reflection follows the first back reflection."""
    share = " No forth reflection above 0.5 % of the largest force follows it"
    second = [wave for wave in chain.waves(chain.middle) if _second(chain, wave)]
    if not second:
        return share + "."
    return (
        f"{share}; the wave forth at {_MILLI * second[0].time:.3g} ms, {second[0].force:.3g} N, is the second of the "
        "incident train, which enters without any reflection."
    )
