"""Waves of any height on a precompressed elastic chain: their speed, and the height that an impact makes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from granwave.analysis.figures.chains.precompressed import speeds_and_heights
from granwave.analysis.measures.precompressed import loaded_line as theory
from granwave.analysis.studies.precompression.waves import LARGE, SMALL, WHERE, ChainWave, Waves, series, waves_of
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row


def select(runs: Sequence[FinishedRun]) -> list[list[ChainWave]]:
    """Waves by rising impact velocity for each static force, of three velocities and more."""
    return series(waves_of(runs), lambda wave: wave.static, lambda wave: wave.velocity)


def name(waves: Waves) -> str:
    """``precompressed-chain-waves-20-N``."""
    return f"precompressed-chain-waves-{waves[0].static:g}-N".replace(".", "-")


def title(waves: Waves) -> str:
    """By static force."""
    return f"Precompressed chain: waves on {waves[0].static:g} N"


def text(waves: Waves) -> str:
    """Describe the measurements and the theory."""
    one = waves[0]
    return (
        f"A chain under a static force of {one.static:g} N is struck at {one.velocity:g} to "
        f"{waves[-1].velocity:g} m/s. F_m, with F0 in it, and the speed of its crest are taken around contact "
        f"{one.middle + 1}. Theory: the travelling wave of the lattice, up to 1.2 % faster than that of equation 3, "
        "a continuum's. In the limits the equation is right: its last factors go to 1 for f_r = F_m/F0 to 1, and "
        "0.9314 sqrt(8/15) = 0.6802 makes it equation 4 for large f_r."
    )


def rows(waves: Waves) -> Iterator[Row]:
    """The speed of each wave, and the height in the limits."""
    for wave in waves:
        remark = "" if wave.steady else "The crest still spreads and falls: no solitary wave yet, and slower than one."
        expected = wave.of_lattice
        if wave.ratio < 1 + SMALL:
            remark += " Theory: the crest in the linear chain."
            expected = wave.linear_speed
        remark = f"Equation 3 gives {wave.printed:.5g} m/s. {remark}".rstrip()
        quantity = f"Speed of the wave, F_m/F0 = {wave.ratio:.4g}, impact at {wave.velocity:g} m/s"
        yield Row(quantity, "m/s", None, wave.speed, WHERE, remark, expected)
    first, last = waves[0], waves[-1]
    if first.reduced_velocity < SMALL:
        remark = f"Theory: the linear chain at contact {first.middle + 1}."
        yield Row(f"F_m/F0 at {first.velocity:g} m/s", "", None, first.ratio, "ours", remark, first.linear_ratio)
    if last.ratio > LARGE:
        remark = "Theory: the uncompressed chain of the same impact, plus 1: the limit for small F0."
        expected = 1 + float(theory.uncompressed_height(last.reduced_velocity))
        yield Row(f"F_m/F0 at {last.velocity:g} m/s", "", None, last.ratio, "thesis 4.5", remark, expected)


def pictures(waves: Waves) -> Iterator[Picture]:
    """Speed against height, and height against impact velocity."""
    yield Picture("", "Speed of the wave and height of its crest on a precompressed chain", speeds_and_heights(waves))
