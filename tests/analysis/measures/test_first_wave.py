"""First wave in packings: layers before the reflection have the forces of a deeper packing."""

from __future__ import annotations

import numpy as np
import pytest

from granwave.analysis.figures.peak_force_depth import peak_force_depth
from granwave.analysis.figures.style import style
from granwave.analysis.measures.force_decay import both_decays, force_decay, no_decay_reason
from granwave.analysis.measures.geometry import layers
from granwave.analysis.measures.layer_peaks import layer_peaks, reflection_arrivals
from granwave.analysis.result.reader import Result
from granwave.workflows import load_case, run_case
from tests.helpers.selection import with_every_test

N_LAYERS = 10


def run(directory, kind, n_layers, changes=None):
    across = [8] if kind == "hexagonal" else [8, 8]
    case = {"packing.kind": kind, "packing.size": [*across, n_layers], "run.end_time": 4e-4}
    run_case(load_case("fcc-small", case | (changes or {})), directory, figures=False)
    return Result(directory)


@pytest.fixture(scope="module")
def cubic(tmp_path_factory):
    """A simple cubic packing, where the reflection from the wall is larger than the first wave."""
    with run(tmp_path_factory.mktemp("cubic"), "sc", N_LAYERS) as result:
        yield result


@pytest.mark.parametrize(
    ("kind", "changes"),
    [
        ("sc", {}),
        ("sc", {"boundary.bottom": "free"}),
        ("sc", {"boundary.bottom": "fixed"}),
        ("fcc", {}),
        ("hcp", {}),
        ("bcc", {"contact.law": "hertz"}),
        ("hexagonal", {}),
        ("sc", {"precompression": {"kind": "uniaxial", "force": 2.0}}),
    ],
)
def test_forces_of_the_first_wave_do_not_depend_on_the_base(tmp_path, kind, changes):
    """A packing of twice the depth has no reflection there in that time."""
    with run(tmp_path / "deep", kind, 2 * N_LAYERS, changes) as result:
        deep = layer_peaks(result)
    with run(tmp_path / "packing", kind, N_LAYERS, changes) as result:
        peaks = layer_peaks(result)
    assert peaks.of_first_wave and np.count_nonzero(peaks.is_known) >= N_LAYERS // 2
    assert not np.any(peaks.is_known & peaks.is_later)
    first = np.flatnonzero(peaks.is_known)
    assert peaks.largest[first] == pytest.approx(deep.largest[first], rel=1e-4)


def test_later_forces_are_not_fitted(cubic, tmp_path):
    """They are up to half as large again as in the packing of twice the depth; the decay is that
    of the fitted layers.
    """
    peaks = layer_peaks(cubic)
    later = np.flatnonzero(peaks.is_later)
    with run(tmp_path, "sc", 2 * N_LAYERS) as result:
        deep = layer_peaks(result)
    assert len(later) >= 2
    assert (peaks.largest[later] / deep.largest[later]).max() > 1.2
    decay = force_decay(cubic)
    fitted = (peaks.depth > 0.5 * cubic.case.packing.diameter) & peaks.is_known
    assert decay.n_layers == np.count_nonzero(fitted)
    assert decay(peaks.depth[fitted]) == pytest.approx(peaks.largest[fitted], rel=0.1)


def test_reflection_returns_in_the_time_of_the_way_down(cubic):
    """It starts when the front is at the last layer, and returns with its speed."""
    depth = cubic["spheres/position"][:, 2] - cubic.origin[2]
    mean, layer = layers(depth, cubic["spheres/radius"], cubic.case.packing.diameter)
    arrivals = reflection_arrivals(cubic, mean, layer)
    front = np.array([np.nanmin(cubic["spheres/time_first"][layer == n]) for n in range(len(mean))])
    assert arrivals[-1] == pytest.approx(front[-1], rel=0.01)
    assert arrivals[2:] - arrivals[-1] == pytest.approx(front[-1] - front[2:], rel=0.05, abs=2e-6)


def test_figure_shows_later_forces_as_hollow_markers(cubic):
    peaks = layer_peaks(cubic)
    with style():
        drawing = peak_force_depth(cubic)
    axes = drawing.figure.axes[0]
    lines = {line.get_label(): line for line in axes.lines}
    later = lines["after the reflection, not fitted"]
    assert later.get_markerfacecolor() == "none" and later.get_linestyle() == "None"
    assert later.get_xdata() == pytest.approx(peaks.depth[peaks.is_later] * 1e3)
    assert lines["largest of the layer"].get_xdata() == pytest.approx(
        peaks.depth[peaks.is_known] * 1e3
    )
    assert "of the first wave" in axes.get_ylabel()
    assert drawing.columns["layer_peak_after_reflection"].sum() == len(later.get_xdata())


def test_no_reflection_before_the_wave_is_at_the_base(tmp_path):
    """All layers that the wave has passed are of the first wave."""
    with run(tmp_path, "sc", N_LAYERS, {"run.end_time": 9e-5}) as result:
        peaks = layer_peaks(result)
    assert np.all(np.isinf(peaks.reflection)) and not peaks.is_later.any()
    assert peaks.n_left_out > 0


@pytest.mark.parametrize(
    "end", with_every_test([1.4e-4, 1.7e-4, 3.3e-4, 4.3e-4, 1.5e-3], [1.4e-4, 4.3e-4])
)
def test_no_pulse_is_missed_behind_the_front(tmp_path, end):
    """Lines of a yielding simple cubic packing are chains. Layers whose larger, second pulse comes
    after the end of the run are not known.
    """
    cubic = {"packing.kind": "sc", "boundary.bottom": "wall"}
    for material, velocity in (("aluminium", 1.5), ("steel", 0.8)):
        changes = cubic | {"material": material, "load.velocity": velocity}
        peaks = []
        for n_layers, until in ((20, end), (45, 1.5e-3)):
            packing = {"packing.size": [3, 3, n_layers], "run.end_time": until}
            case = load_case("fcc-small", changes | packing)
            directory = tmp_path / f"{material}-{n_layers}"
            run_case(case, directory, figures=False)
            with Result(directory) as result:
                peaks.append(layer_peaks(result))
        packing, deep = peaks
        known = np.flatnonzero(packing.is_known[:-1])
        assert len(known) >= 6
        assert packing.largest[known] == pytest.approx(deep.largest[known], rel=0.01)


def test_a_long_load_has_no_first_wave_of_four_layers(tmp_path):
    """A pulse that lasts longer than the way to the base and back."""
    pulse = {"kind": "force", "shape": "half-sine", "amplitude": 50.0, "duration": 8e-4}
    with run(tmp_path, "sc", 6, {"load": pulse, "run.end_time": 1e-3}) as result:
        assert isinstance(both_decays(result), str)
        reason = no_decay_reason(result)
        assert reason.endswith("layers before the reflection") and " 0 " not in reason
