"""All studies of packings that strikers hit; each takes what it knows from the runs that there are."""

from __future__ import annotations

from collections.abc import Sequence

from granwave.analysis.figures.style import style
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.square.directional import directional
from granwave.analysis.studies.square.impact import square_impacts
from granwave.analysis.studies.square.runs import PackingRun
from granwave.analysis.studies.square.scaling import wave_speeds
from granwave.analysis.studies.square.sensor_mass import lighter_sphere, sensors_in_square
from granwave.analysis.studies.square.yielding import yielding
from granwave.analysis.studies.study import Study


def studies(packings: Sequence[PackingRun], chains: Sequence[ChainRun]) -> list[Study]:
    """What the runs show of each study: of packings, and of the chain in which the source tried its sensors."""
    with style():
        found = [
            study
            for find in (square_impacts, wave_speeds, yielding, sensors_in_square, directional)
            for study in find(packings)
        ]
        return found + list(lighter_sphere(chains))
