"""One impact on elastic chains under many static forces: from the uncompressed chain to small pulses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from granwave.analysis.figures.chains.precompressed import transition_speeds
from granwave.analysis.measures.chains.hertz_chain import ChainScales
from granwave.analysis.studies.precompression.waves import LARGE, WHERE, ChainWave, Waves, series, waves_of
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row


def select(runs: Sequence[FinishedRun]) -> list[list[ChainWave]]:
    """Waves of one impact by rising static force, from far below that of the wave to about it."""
    found = series(waves_of(runs), lambda wave: wave.velocity, lambda wave: wave.static)
    return [one for one in found if one[0].ratio > LARGE and one[-1].ratio < 2]


def name(waves: Waves) -> str:
    """``precompressed-chain-0-1-m-s``."""
    return f"precompressed-chain-{waves[0].velocity:g}-m-s".replace(".", "-")


def title(waves: Waves) -> str:
    """By impact velocity."""
    return f"Precompressed to uncompressed chain, {waves[0].velocity:g} m/s"


def text(waves: Waves) -> str:
    """The forces, and where the two limits meet."""
    first, last = waves[0], waves[-1]
    crossing = (first.uncompressed_speed / last.c0) ** 6 * last.static
    return (
        f"One impact, at {first.velocity:g} m/s, on a chain under {len(waves)} static forces from {first.static:g} to "
        f"{last.static:g} N: the wave is that of an uncompressed chain as long as c0 is far below its speed, and a "
        f"small pulse beyond; the two lines cross at F0 = {crossing:.3g} N."
    )


def rows(waves: Waves) -> Iterator[Row]:
    """Speed and height at both ends."""
    first, last = waves[0], waves[-1]
    free = first.uncompressed_speed
    height = 0.7176 * float(ChainScales(first.run.case).impulse_force(first.run.mass * first.velocity))
    yield Row(
        f"Speed at F0 = {first.static:g} N over that of an uncompressed chain", "", None, first.speed / free,
        "composite (4)", "At the same largest force added; theory: the travelling wave of the lattice under F0.",
        first.of_lattice / free,
    )  # fmt: skip
    yield Row(
        f"Largest force at F0 = {first.static:g} N", "N", None, first.static + first.added, "thesis 4.5",
        "Theory: the uncompressed lattice, 0.7176 (m^3 E*^2 R* v^6)^(1/5), and F0.", height + first.static,
    )  # fmt: skip
    remark = f"Equation 3 gives {last.printed:.5g} m/s."
    if not last.steady:
        remark += " The crest still spreads: it is slower than a solitary wave."
    yield Row(f"Speed at F0 = {last.static:g} N", "m/s", None, last.speed, WHERE, remark, last.of_lattice)


def pictures(waves: Waves) -> Iterator[Picture]:
    """Speed against the static force."""
    caption = f"One impact at {waves[0].velocity:g} m/s on chains under static forces"
    yield Picture("", caption, transition_speeds(waves, waves[0].uncompressed_speed))
