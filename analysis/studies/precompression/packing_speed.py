"""Speed of small longitudinal waves along [111] of fcc and along c of hcp against the static pressure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from itertools import groupby

import numpy as np

from granwave.analysis.figures.chains.precompressed import small_wave_speeds
from granwave.analysis.measures.precompressed.line_waves import speed_along_layers
from granwave.analysis.measures.signals import Array, power
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.precompression.runs import DentedRun, past_runs
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

TITLE = "Precompressed packings: speed of small waves"
TEXT = (
    "Small impacts on packings under static pressure, along the stacking of their layers. c0 by the times of the "
    "crests of the layers' mean velocities, over the places that layers had before the load. Theory: "
    "c0 = h sqrt((2 k - f/D)/m), layers h = D sqrt(2/3) apart, k = 3/2 f/alpha, and f = p D^2/(2 sqrt 2) the force "
    "of a contact, by balance on a layer (uniaxial) as by the virial (uniform)."
)
_SMALL = 0.1  # impact velocity over omega alpha0 up to which everything is linear enough


class SmallWave(DentedRun):
    """A run of a small wave along the stacking of a precompressed packing."""

    @property
    def kind(self) -> tuple[str, str]:
        """Kind of the packing and of the load."""
        assert self.case.precompression is not None
        return self.case.packing.kind, self.case.precompression.kind

    @cached_property
    def speed(self) -> float:
        """c0, m/s; see `granwave.analysis.measures.precompressed.line_waves.speed_along_layers`."""
        with Result(self.directory) as result:
            return speed_along_layers(result, self.line)


def select(runs: Sequence[FinishedRun]) -> list[list[SmallWave]]:
    """All precompressed fcc and hcp packings of like elastic spheres with a small impact, by kind and pressure."""
    found = [run.seen_as(SmallWave) for run in past_runs(runs) if fits(run)]
    found = sorted((run for run in found if np.isfinite(run.speed)), key=lambda run: (run.kind, run.pressure))
    return [found] if found else []


def fits(run: DentedRun) -> bool:
    """A small impact along the stacking of like elastic spheres under pressure."""
    case, stage = run.case, run.case.precompression
    if stage is None or stage.kind == "gravity" or case.packing.kind not in ("fcc", "hcp"):
        return False
    if not run.assembly.plain or case.contact.law != "hertz" or case.load.angle:
        return False
    return case.load.velocity < _SMALL * run.line.velocity


def rows(runs: Sequence[SmallWave]) -> Iterator[Row]:
    """The power of each kind, and the speed at each pressure."""
    for where, pressure, speed, theirs in _series(runs):
        if len(set(pressure.tolist())) > 1:
            quantity, fit = f"Power of the speed with the pressure, {', '.join(where)}", power(pressure, speed)
            yield Row(quantity, "", None, fit.exponent, "Hertz lattice", "Forced by similarity.", 1 / 6, True)
        for p, ours, expected in zip(pressure.tolist(), speed.tolist(), theirs.tolist(), strict=True):
            remark = ""
            if abs(ours / expected - 1) > 0.01:
                uneven = where[1] == "uniform"
                remark = "Free sides: the static forces are not even." if uneven else "Not small enough."
            quantity = f"Speed of small waves, {', '.join(where)}, {p:.4g} Pa"
            yield Row(quantity, "m/s", None, ours, "Hertz lattice", remark, expected)


def pictures(runs: Sequence[SmallWave]) -> Iterator[Picture]:
    """Speed against pressure."""
    yield Picture("", "Speed of small waves against pressure", small_wave_speeds(_series(runs)))


def _series(runs: Sequence[SmallWave]) -> Iterator[tuple[tuple[str, str], Array, Array, Array]]:
    """Kind, pressure, Pa, speed and its theory, m/s: (n_runs,) each."""
    for kind, members in groupby(runs, key=lambda run: run.kind):
        pressure, speed, theirs = np.array([(run.pressure, run.speed, run.line.speed) for run in members]).T
        yield kind, pressure, speed, theirs
