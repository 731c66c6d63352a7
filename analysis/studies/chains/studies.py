"""All studies of chains; each takes what it knows from the runs that there are."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from granwave.analysis.figures.style import style
from granwave.analysis.studies.chains.bar import bars
from granwave.analysis.studies.chains.bilinear_long import long_loads
from granwave.analysis.studies.chains.bilinear_short import short_pulses
from granwave.analysis.studies.chains.composite_study import composite_chain
from granwave.analysis.studies.chains.elastic import long_load, solitary
from granwave.analysis.studies.chains.elastic_pulses import master_curve, wave_train
from granwave.analysis.studies.chains.elastoplastic_study import elastoplastic_pulses
from granwave.analysis.studies.chains.homogeneous import homogeneous_chain
from granwave.analysis.studies.chains.intruder import intruder
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.chains.split_hopkinson import split_hopkinson
from granwave.analysis.studies.chains.unlike import unlike_spheres
from granwave.analysis.studies.study import Study

#: Each finds its runs among all, and yields nothing where there are none.
STUDIES: tuple[Callable[[Sequence[ChainRun]], Iterator[Study]], ...] = (
    solitary,
    long_load,
    wave_train,
    master_curve,
    elastoplastic_pulses,
    short_pulses,
    long_loads,
    unlike_spheres,
    homogeneous_chain,
    composite_chain,
    bars,
    intruder,
    split_hopkinson,
)


def studies(runs: Sequence[ChainRun]) -> list[Study]:
    """What the runs show of each study."""
    with style():
        return [study for find in STUDIES for study in find(runs)] if runs else []
