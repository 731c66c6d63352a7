"""First wave of computed chains: its peak forces before the reflection, and speeds by material."""

from __future__ import annotations

import numpy as np
import pytest

from granwave.analysis.figures.chains import along_chain
from granwave.analysis.figures.style import style
from granwave.analysis.measures.force_decay import force_decay, layer_peaks, no_decay_reason
from granwave.analysis.measures.leading_wave import leading_peaks, stretch_speeds
from granwave.analysis.measures.regions import WHOLE, stretches, usual_regions
from granwave.analysis.result.reader import Result
from granwave.analysis.summary import summarise
from granwave.workflows import load_case, run_case

CHAIN = {
    "material": "steel",
    "packing.size": 40,
    "packing.diameter": 0.01,
    "load.velocity": 0.3,
    "boundary.bottom": "wall",
    "run.end_time": 1e-3,
}


def run(directory, changes=None):
    run_case(load_case("homogeneous-chain", CHAIN | (changes or {})), directory, figures=False)
    return Result(directory)


def test_peaks_of_the_first_wave_are_constant_up_to_the_wall(tmp_path):
    """The solitary wave keeps its height; the largest force of the last contact is of the
    reflection.
    """
    with run(tmp_path) as result:
        peaks = leading_peaks(result)
        largest = result.along_chain("peak_force")
    known = np.isfinite(peaks)
    assert known[:35].all()
    assert not known[-1]
    assert peaks[25:35] == pytest.approx(np.full(10, peaks[30]), rel=1e-3)
    assert largest[-1] > 1.03 * peaks[30]


def test_a_solitary_wave_has_no_decay(tmp_path):
    """Its force is constant behind the first beads; reflections at the wall are left out."""
    with run(tmp_path) as result:
        assert force_decay(result) is None
        assert no_decay_reason(result).startswith("the peak force is constant within 0.1 %")
        peaks = layer_peaks(result)
        assert peaks.of_first_wave and peaks.n_left_out > 0
        assert peaks.largest[peaks.is_known][1:].max() == pytest.approx(leading_peaks(result)[0])


def test_a_step_of_the_material_has_no_decay(tmp_path):
    """Both laws would be 50 % from the forces."""
    soft = [{"index": {"first": 21, "last": 40}, "material": "ptfe"}]
    with run(tmp_path, {"replace": soft, "run.end_time": 4e-3}) as result:
        assert force_decay(result) is None
        assert no_decay_reason(result) == "the material or the diameter changes with depth"


def test_a_damped_wave_decays(tmp_path):
    """Also where the wave has not passed the chain: beads ahead of it are left out."""
    rates = []
    for name, end in (("whole", 1e-3), ("part", 4e-4)):
        loss = {"contact.loss": {"dashpot": 0.05}, "run.end_time": end}
        with run(tmp_path / name, loss) as result:
            decay = force_decay(result)
            assert decay is not None and no_decay_reason(result) == ""
            assert decay.misfit < 0.05 and decay.explained > 0.95
            rates.append(layer_peaks(result).largest[5:15])
    assert rates[0] == pytest.approx(rates[1], rel=1e-3)


def test_figure_along_a_chain_is_of_the_first_wave(tmp_path):
    """The figure shows the forces of the sentence; the reflection has marks of its own."""
    with run(tmp_path, {"precompression": {"kind": "uniaxial", "force": 5.0}}) as result, style():
        drawing = along_chain(result)
        first = leading_peaks(result)
        rise = result.along_chain("peak_force") - result["chain/contact_force"][0]
    later, wave = drawing.figure.axes[0].lines
    known = np.nan_to_num(first) > 0
    assert wave.get_ydata() == pytest.approx(first[known])
    assert drawing.figure.axes[0].get_ylabel() == "Dynamic peak force (N)"
    assert len(later.get_xdata()) and rise[int(later.get_xdata()[-1]) - 1] == pytest.approx(
        later.get_ydata()[-1]
    )
    assert drawing.columns["first_wave_peak_force_N"] == pytest.approx(first, nan_ok=True)


def test_speeds_of_two_materials(tmp_path):
    """Each stretch has its own speed; the speed of the summary is of the deeper half."""
    soft = [{"index": {"first": 21, "last": 40}, "material": "ptfe"}]
    with run(tmp_path, {"replace": soft, "run.end_time": 4e-3}) as result:
        speeds = stretch_speeds(result)
    assert list(speeds) == ["beads 1 to 20, steel", "beads 21 to 40, ptfe"]
    steel, ptfe = speeds.values()
    assert steel > 2 * ptfe
    assert summarise(tmp_path)["wave_speed_m_s"] == pytest.approx(ptfe, rel=0.02)
    with run(tmp_path / "uniform") as result:
        assert stretch_speeds(result) == {}


def test_stretches_of_one_material_and_two_diameters(tmp_path):
    """Diameters that scatter, or that all differ, make no stretches."""
    small = {"index": {"first": 21, "last": 40}, "diameter": 0.004}
    with run(tmp_path / "two", {"replace": [small], "run.end_time": 1e-4}) as result:
        names = list(stretches(result))
        assert names == ["beads 1 to 20, steel, 10 mm", "beads 21 to 40, steel, 4 mm"]
    scatter = {"packing.diameter_scatter": 1e-4, "packing.size": 5, "run.end_time": 1e-4}
    with run(tmp_path / "scatter", scatter) as result:
        assert stretches(result) == {}
    tapered = [{"index": n, "diameter": 0.01 - 2e-4 * n} for n in range(1, 41)]
    with run(tmp_path / "tapered", {"replace": tapered, "run.end_time": 1e-4}) as result:
        assert stretches(result) == {}


def test_a_bead_alone(tmp_path):
    """Its force on the wall is exact, and it is no region from 0 to 0 mm."""
    one = {"packing.size": 1, "load.velocity": 1.0, "run.end_time": 2e-4}
    with run(tmp_path, one) as result:
        assert list(usual_regions(result, np.array([0.0, 0.0, 1.0]))) == [WHOLE]
    summary = summarise(tmp_path)
    assert summary["wall_peak_force_N"] == summary["peak_force_with_walls_N"]
    assert summary["ground_peak_force_N"] == summary["wall_peak_force_N"]
    assert "wall_sample_s" not in summary
    assert summary["base_arrival_s"] == pytest.approx(4.13e-7, rel=0.01)
    assert summary["peak_overlap_m"] is None  # no two spheres are in contact
