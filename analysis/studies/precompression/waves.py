"""Runs of precompressed elastic chains whose first bead is struck, with their waves."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from granwave.analysis.measures.chains.hertz_chain import ChainScales
from granwave.analysis.measures.precompressed.line_waves import Wave
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.runs import FinishedRun, rising

WHERE = "composite (3)"
SMALL = 0.05  # F_m/F0 - 1 up to which a pulse is small: the speed of (3) is then within 0.3 % of c0
LARGE = 100.0  # F_m/F0 from which on a chain is as good as uncompressed
_FEWEST = 30  # contacts passed


class ChainWave(Wave):
    """The wave of a run."""

    def __init__(self, run: ChainRun) -> None:
        super().__init__(run.case, run.law, run.time, run.force, run.velocity)
        self.run = run

    @property
    def uncompressed_speed(self) -> float:
        """Speed of Nesterenko's wave of the same largest force added, m/s."""
        return ChainScales(self.run.case).nesterenko(self.added)


Waves = Sequence[ChainWave]


def waves_of(runs: Iterable[FinishedRun]) -> list[ChainWave]:
    """Waves that came far enough, by rising impact velocity."""
    chains = [run.seen_as(ChainRun) for run in runs if _fits(run)]
    waves = [wave for run in chains if run.recorded and (wave := ChainWave(run)).last >= _FEWEST]
    return sorted(waves, key=lambda wave: wave.velocity)


def series(
    waves: Sequence[ChainWave], same: Callable[[ChainWave], float], key: Callable[[ChainWave], float]
) -> list[list[ChainWave]]:
    """Waves of one value each, by rising key; three waves and more."""
    found = (rising((wave for wave in waves if same(wave) == value), key) for value in sorted(set(map(same, waves))))
    return [one for one in found if len(one) > 2]


def _fits(run: FinishedRun) -> bool:
    """A chain of like elastic beads under a uniaxial load whose first is struck along it, without dents."""
    case, load = run.case, run.case.load
    if case.packing.kind != "chain" or case.contact.law != "hertz" or not run.assembly.plain:
        return False
    if case.precompression is None or case.precompression.kind != "uniaxial" or case.contact.initial_overlap:
        return False
    return load.kind == "impact" and load.spheres == 1 and not load.angle
