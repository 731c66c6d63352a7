"""Rows with a light bead: made-up powers, and small motions of the built-in scan's cases."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from granwave.analysis.studies.bands.rectification import ratios, select, sides, switch
from granwave.analysis.studies.runs import FinishedRun
from granwave.workflows import load_case
from granwave.workflows.spectra import steady

DASHPOT = 2500.0
SCANNED = {"packing.size": 20, "contact.loss": {"time": 5e-8}, "boundary.bottom": "free",
           "absorb": [{"index": [20], "impedance": DASHPOT}], "load.kind": "displacement", "load.frequency": 20700.0,
           "run.end_time": 0.02, "output.history": 0}  # fmt: skip


def made_up(near, opens, amplitude):
    """A run whose power is that of small motions, 2 W/m^2, up to an amplitude, and a million times more above."""
    through = 2.0 * amplitude**2 * (1e6 if amplitude > opens else 1.0)
    return SimpleNamespace(near=near, amplitude=amplitude, through=through, gain=through / (2.0 * amplitude**2))


def test_where_a_row_opens():
    runs = [made_up(near, 3.0 if near else 7.0, size) for near in (False, True) for size in (8.0, 1.0, 2.0, 4.0)]
    near, far = sides(runs).values()
    assert [one.amplitude for one in near] == [1, 2, 4, 8]
    assert switch(near) == (2, 4) and switch(far) == (4, 8) and switch(far[:3]) is None and switch(far[:1]) is None
    size, ratio = ratios(runs)
    assert size.tolist() == [1, 2, 4, 8] and ratio == pytest.approx([1, 1, 1e6, 1])
    assert not len(ratios(near)[0])


def test_small_motions_of_both_places():
    """The power of the command's steady response; a frequency between the cut-off and the mode of the light bead."""
    runs = []
    for place in (3, 18):
        case = load_case("driven-row", SCANNED | {"replace": [{"index": [place], "diameter": 0.0085}]})
        runs.append(FinishedRun(str(place), Path(), case, {"absorbed_power_W": 1e-9}))
    [[near, far]] = select(runs)
    assert (near.light, near.near, far.light, far.near) == (3, True, 18, False)
    for one in (near, far):
        found, *_ = steady(one.case, None, drive=1, sensors=[20], frequencies=np.array([20700.0]))
        velocity = 2 * np.pi * 20700.0 * found.amplitude[0, 0]
        assert one.of_small == pytest.approx(DASHPOT * velocity**2 / 2, rel=1e-9)
        assert one.cut_off < one.frequency < one.mode
    assert near.of_small == pytest.approx(far.of_small, rel=0.05)  # reciprocity, but for the dashpot's impedance
    assert near.mode == pytest.approx(far.mode, rel=1e-6)
    unlit = load_case("driven-row", SCANNED)
    assert not select([*runs[:1], FinishedRun("", Path(), unlit, {"absorbed_power_W": 1e-9})])
