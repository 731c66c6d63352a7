"""All studies of spheres with a past; each takes what it knows from the runs that there are."""

from __future__ import annotations

from collections.abc import Sequence

from granwave.analysis.figures.style import style
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.precompression.chain_waves import precompressed_chains
from granwave.analysis.studies.precompression.hits import repeated_hits
from granwave.analysis.studies.precompression.packing_impact import precompressed_impacts
from granwave.analysis.studies.precompression.packing_speed import packing_speeds
from granwave.analysis.studies.precompression.preconditioned import preconditioned
from granwave.analysis.studies.precompression.runs import PastRun
from granwave.analysis.studies.precompression.settled import settled_packings
from granwave.analysis.studies.study import Study

_OF_RUNS = (packing_speeds, precompressed_impacts, settled_packings, preconditioned, repeated_hits)


def studies(runs: Sequence[PastRun], chains: Sequence[ChainRun]) -> list[Study]:
    """What the runs show of each study; chains are those with a recorded history."""
    with style():
        return [*precompressed_chains(chains), *(study for find in _OF_RUNS for study in find(runs))]
