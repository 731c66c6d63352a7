"""Small pulses on precompressed elastic chains: their speed against the static force."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.figures.chains.precompressed import small_pulse_speeds
from granwave.analysis.measures.precompressed import loaded_line as theory
from granwave.analysis.measures.precompressed.line_waves import FIRST_BEAD
from granwave.analysis.measures.signals import Array, power
from granwave.analysis.studies.precompression.waves import SMALL, WHERE, ChainWave, Waves, waves_of
from granwave.analysis.studies.runs import FinishedRun, rising
from granwave.analysis.studies.study import Picture, Row

TITLE = "Precompressed chain: small pulses"


def select(runs: Sequence[FinishedRun]) -> list[list[ChainWave]]:
    """Small pulses by rising static force, of two forces and more."""
    small = rising((wave for wave in waves_of(runs) if wave.ratio < 1 + SMALL), lambda wave: wave.static)
    return [small] if len(small) > 1 else []


def text(waves: Waves) -> str:
    """Describe how c0 is found."""
    crest = waves[len(waves) // 2]
    return (
        f"The first bead of a precompressed chain is struck so that F_m/F0 stays below {1 + SMALL:g}, at {len(waves)} "
        f"static forces. Such a pulse spreads, and its crest is slower than long waves (here by "
        f"{100 * (1 - crest.speed / crest.c0):.2g} %): c0 is found by the times of the crests at beads {FIRST_BEAD} to "
        f"{crest.last}, which are known for a linear chain. The source prints the formula."
    )


def rows(waves: Waves) -> Iterator[Row]:
    """Power, factor, and the speed at each force."""
    force, speed, printed = _speeds(waves)
    yield Row(
        "Power of the speed of small pulses with the static force", "", None, power(force, speed).exponent, WHERE,
        "Similarity forces it on any correct code.", 1 / 6, True,
    )  # fmt: skip
    yield Row(
        "Factor of c0 in (4 E^2 F0/(a^2 rho^3 (1-nu^2)^2))^(1/6)", "", theory.PRINTED_FACTOR,
        theory.PRINTED_FACTOR * float(np.mean(speed / printed)), WHERE,
        "Theory: long waves of the lattice, sqrt(9/pi) 3^(-1/3) 4^(-1/6), with a the diameter.", theory.EXACT_FACTOR,
    )  # fmt: skip
    for wave, ours in zip(waves, speed, strict=True):
        yield Row(f"Speed of small pulses, F0 = {wave.static:g} N", "m/s", None, ours, "Hertz lattice", "", wave.c0)


def pictures(waves: Waves) -> Iterator[Picture]:
    """Speed against the static force."""
    caption = "Speed of small pulses against the static force (composite 3)"
    yield Picture("precompressed_chain_small_pulses", caption, small_pulse_speeds(*_speeds(waves)))


def _speeds(waves: Waves) -> tuple[Array, Array, Array]:
    """Static force, N, the speed found, and the one that the source prints, m/s: (n_waves,) each."""
    found = [(wave.static, wave.long_wave_speed, theory.printed_speed(wave.case, wave.static)) for wave in waves]
    force, speed, printed = np.array(found).T
    return force, speed, printed
