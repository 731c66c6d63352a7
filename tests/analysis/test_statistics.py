"""Statistics of replicates compared with scipy and closed forms, and the coverage of their
intervals.
"""

from __future__ import annotations

import json
import math
import sys
import types
import warnings
from fnmatch import fnmatchcase

import numpy as np
import pytest
from scipy import stats
from scipy.special import gammaln

from granwave.analysis.formatting.numbers import interval, tick, with_interval
from granwave.analysis.formatting.values import as_label, shown_unit, unique_labels
from granwave.analysis.progress_bar import in_notebook, progress_bar
from granwave.analysis.quantities import (
    ENTRIES,
    REPORT_COLUMNS,
    RUN_ROWS,
    SCAN_COLUMNS,
    all_scan_figures,
    entries,
    quantities,
    quantity,
)
from granwave.analysis.statistics import (
    Estimate,
    crossing,
    differ_significantly,
    estimate,
    exactly,
    growing,
    half_width,
    seeds_needed,
)
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows import load_case, run_case
from tests.golden.outputs import FOLDER, SUMMARIES


@pytest.mark.parametrize("n", [2, 3, 5, 20])
@pytest.mark.parametrize("confidence", [0.68, 0.95, 0.99])
def test_interval_is_students(n: int, confidence: float) -> None:
    values = np.random.default_rng(n).normal(7.0, 2.0, n)
    found = estimate(values, confidence)
    low, high = stats.t.interval(confidence, n - 1, loc=values.mean(), scale=stats.sem(values))
    assert (found.low, found.high) == pytest.approx((low, high), rel=1e-12)
    assert (found.n, found.mean) == (n, pytest.approx(values.mean()))
    assert found.deviation == pytest.approx(values.std(ddof=1))


def test_closed_forms() -> None:
    two = estimate([1.0, 3.0])  # t with one degree of freedom is Cauchy's: tan(0.475 pi)
    assert two.half_width == pytest.approx(
        math.tan(0.475 * math.pi) * math.sqrt(2) / math.sqrt(2), rel=1e-12
    )
    assert half_width(1.0, 10**6) == pytest.approx(1.959964e-3, rel=1e-5)
    one = estimate([4.0])
    assert (
        one.mean == 4.0
        and math.isnan(one.deviation)
        and math.isnan(one.half_width)
        and not one.exact
    )
    assert exactly(4.0).exact and exactly(4.0).low == exactly(4.0).high == 4.0
    alike = estimate([0.1 + 0.2, 0.3, 0.3])  # values that differ by rounding only
    assert alike.deviation == alike.half_width == 0 and not alike.exact
    halved = two.over(-2.0)
    assert (halved.mean, halved.half_width) == (-1.0, pytest.approx(two.half_width / 2))
    with pytest.raises(ValueError, match="found no value"):
        estimate([])


@pytest.mark.parametrize("n", [3, 5, 10])
def test_interval_covers_the_mean_as_often_as_it_says(n: int) -> None:
    rng = np.random.default_rng(8)
    width = half_width(1.0, n)

    def coverage(values: np.ndarray, mean: float) -> float:
        off = np.abs(values.mean(axis=1) - mean)
        return float(np.mean(off <= width * values.std(axis=1, ddof=1)))

    assert coverage(rng.normal(10.0, 1.0, (20_000, n)), 10.0) == pytest.approx(0.95, abs=0.005)
    assert coverage(rng.lognormal(0.0, 0.5, (20_000, n)), math.exp(0.125)) > 0.90


def test_seeds_needed_is_the_least_that_suffices() -> None:
    for ratio in (0.05, 0.3, 1.0, 4.0, 30.0):
        n = seeds_needed(ratio, 1.0)
        assert half_width(ratio, n) <= 1.0 and (n == 2 or half_width(ratio, n - 1) > 1.0)
    assert seeds_needed(0.0, 1e-9) == 2
    assert seeds_needed(1.0, 0.02) == pytest.approx((1.96 / 0.02) ** 2, rel=2e-3)
    with pytest.raises(ValueError, match="positive"):
        seeds_needed(1.0, 0.0)
    with pytest.raises(ValueError, match="more than"):
        seeds_needed(1e9, 1.0)


def test_means_that_differ_by_welch() -> None:
    rng = np.random.default_rng(3)
    for _ in range(50):
        a = rng.normal(0.0, 1.0, 4)
        b = rng.normal(1.5, 3.0, 9)
        expected = stats.ttest_ind(a, b, equal_var=False).pvalue < 0.05
        assert differ_significantly(estimate(a), estimate(b)) == expected
        assert differ_significantly(estimate(a), exactly(1.0)) == (
            stats.ttest_1samp(a, 1.0).pvalue < 0.05
        )
    same = [differ_significantly(*map(estimate, rng.normal(0.0, 1.0, (2, 5)))) for _ in range(4000)]
    assert np.mean(same) == pytest.approx(0.05, abs=0.012)  # by chance only
    assert differ_significantly(exactly(1.0), exactly(1.1)) is True and not differ_significantly(
        exactly(1.0), exactly(1.0)
    )
    assert differ_significantly(estimate([1.0]), exactly(2.0)) is None


def test_confidence_converges_with_the_root_of_the_seeds() -> None:
    """Mean over many sets of seeds: 1/sqrt(n) times Student's factor, which tends to 1.96."""
    rng = np.random.default_rng(5)
    counts = np.array([8, 32, 128, 512])
    widths = np.array(
        [
            np.mean([estimate(values).half_width for values in rng.normal(100, 20, (300, n))])
            for n in counts
        ]
    )
    bias = np.sqrt(2 / (counts - 1)) * np.exp(
        gammaln(counts / 2) - gammaln((counts - 1) / 2)
    )  # of a standard deviation
    expected = [bias_n * half_width(20.0, int(n)) for bias_n, n in zip(bias, counts, strict=True)]
    assert widths == pytest.approx(expected, rel=0.03)
    slope = np.polyfit(np.log(counts[1:]), np.log(widths[1:]), 1)[0]
    assert slope == pytest.approx(-0.5, abs=0.02)
    steps = growing(rng.normal(100, 20, 50))
    assert [one.n for one in steps] == list(range(2, 51)) and isinstance(steps[0], Estimate)


@pytest.mark.parametrize(
    ("y", "expected"),
    [
        ([1.0, 0.95, 0.85], 1.5),
        ([1.0, 0.8, 1.2], 0.5),
        ([1.0, 1.2, 0.9], None),
        ([0.5, 1.0, 1.0], 0.0),
    ],
)
def test_crossing_is_the_first(y: list[float], expected: float | None) -> None:
    found = crossing([0.0, 1.0, 2.0], y, 0.9)
    assert found == (None if expected is None else pytest.approx(expected))


SHORT = {"run.end_time": 1e-6}
BARS_AND_SENSORS = ("split-hopkinson", "composite-chain", "square-in-plane")
RESISTANCE = {"contact.friction": 0.2, "contact.rolling": 0.01, "contact.twisting": "marshall"}
COHESION = {"contact.law": "hertz", "contact.cohesion": {"kind": "jkr", "energy": 0.1}}
NAMES = [entry.name for entry in ENTRIES]


GRAINS = """x,y,z,diameter,clump,vx,vy,vz
0,0,0,0.01,1,0,0,0
0,0,0.009,0.01,1,0,0,0
0,0,-0.01,0.01,0,0,0,1
"""
DIMER = {
    "name": "dimer",
    "material": "steel",
    "packing": {"kind": "file", "grains": GRAINS},
    "load": {"kind": "grains"},
    "boundary": {"bottom": "free"},
    "run": {"end_time": 1e-5, "frames": 2},
}


@pytest.fixture(scope="module")
def summaries(tmp_path_factory):
    """Summaries of runs of spheres; most granular summaries are golden outputs, which are compared
    with runs there.
    """
    place = tmp_path_factory.mktemp("runs")
    found = list(json.loads((FOLDER / SUMMARIES).read_text()).values())
    found += [
        run_case(load_case(n, SHORT), place / n, figures=False).summary for n in BARS_AND_SENSORS
    ]
    crystal = {"packing.size": [3, 4], "run.end_time": 1e-4}
    found.append(
        run_case(load_case("lateral-square", crystal), place / "crystal", figures=False).summary
    )
    resisting = load_case("fcc-small", SHORT | RESISTANCE | COHESION | {"packing.size": [4, 4, 3]})
    found.append(run_case(resisting, place / "resisting", figures=False).summary)
    found.append(run_case(case_from_dict(DIMER), place / "dimer", figures=False).summary)
    pressed = load_case("precompressed-chain", {"packing.size": 20, "run.end_time": 4e-4})
    found.append(run_case(pressed, place / "pressed", figures=False).summary)
    return found


@pytest.mark.xdist_group("summaries")
def test_every_value_has_an_entry_and_every_entry_a_value(summaries):
    keys = {key for summary in summaries for key in summary}
    assert sorted(key for key in keys if not any(fnmatchcase(key, name) for name in NAMES)) == []
    assert sorted(name for name in NAMES if not any(fnmatchcase(key, name) for key in keys)) == []


@pytest.mark.xdist_group("summaries")
def test_values_are_shown_with_their_digits(summaries):
    """Every number with decimals that the terminal shows has a format."""
    for entry in (*RUN_ROWS, *SCAN_COLUMNS):
        assert entry.digits or not any(
            isinstance(summary.get(entry.name), float) for summary in summaries
        ), entry.name


def test_what_is_shown_has_one_entry():
    assert len(entries()) == len(quantities())
    assert set(REPORT_COLUMNS) <= set(NAMES)
    assert all(quantities()[name].axis for name in all_scan_figures().values())


def test_names_end_in_units():
    capitals = [entry for entry in ENTRIES if not entry.name.rpartition("_")[2].islower()]
    assert len(capitals) > 20 and [entry.name for entry in capitals if not entry.unit] == []
    names = (
        "wave_speed_m_s",
        "sensor_A_peak_acceleration_m_s2",
        "peak_reduction_per_kg",
        "packing_mass_kg",
        "n_steps",
    )
    assert [quantity(name).unit for name in names] == ["m/s", "m/s^2", "1/kg", "kg", ""]


def test_value_without_an_entry_is_called_by_its_name():
    found = quantity("largest_spin_per_s")
    assert (found.label, found.unit, found.heading) == ("Largest spin", "1/s", "largest spin (1/s)")
    assert quantity("sensor_A_peak_force_N").label == "Sensor A peak force"


@pytest.fixture
def ipython(monkeypatch):
    """Replacement for IPython, whose configuration identifies the front end."""
    module = types.ModuleType("IPython")
    shell = types.SimpleNamespace(config={})
    module.get_ipython = lambda: shell
    monkeypatch.setitem(sys.modules, "IPython", module)
    return shell


def test_no_terminal_no_bar():
    assert not in_notebook()
    assert progress_bar(True, total=2).disable and progress_bar(False, total=2).disable


def test_a_notebook_has_a_bar_without_a_terminal(ipython):
    assert not in_notebook()  # IPython at a terminal
    ipython.config["IPKernelApp"] = {}
    assert in_notebook()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of tqdm, that ipywidgets are missing
        bar = progress_bar(True, total=2, leave=False)
    assert not bar.disable
    bar.close()
    assert progress_bar(False, total=2).disable


def test_outside_of_ipython_nothing_is_a_notebook(ipython):
    sys.modules["IPython"].get_ipython = lambda: None
    assert not in_notebook()


@pytest.mark.parametrize(
    ("mean", "half_width", "text"),
    [
        (0.901453, 0.00131, "0.9015 ± 0.0013"),
        (0.7, 0.2484, "0.70 ± 0.25"),
        (1232.8, 38.2, "1233 ± 38"),
        (1020.0, 182.0, "1020 ± 180"),
        (4.623e-4, 7.6e-6, "(4.623 ± 0.076)e-4"),
        (0.5, 0.0996, "0.50 ± 0.10"),  # two digits after rounding, no more
        (0.0, 0.5, "0.00 ± 0.50"),
        (-3.0, 20.0, "-3 ± 20"),
        (2.5e7, 1.2e5, "(2.500 ± 0.012)e7"),
        (0.9, 1e-12, "0.9 ± 1.0e-12"),
    ],
)
def test_a_mean_has_the_digits_that_its_interval_allows(mean, half_width, text):
    assert interval(mean, half_width) == text


def test_intervals_of_estimates():
    assert (
        with_interval(estimate([0.6, 0.7, 0.8]), unit="N") == "0.70 ± 0.25 N"
    )  # 4.303 x 0.1 / sqrt 3
    assert with_interval(exactly(1234.5)) == "1230"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"),
        (20000, "20000"),
        (1e5, "1e5"),
        (2.5e5, "2.5e5"),
        (0.0042, "0.0042"),
        (1.3e-5, "1.3e-5"),
        (-3.5, "-3.5"),
    ],
)
def test_ticks(value, text):
    assert tick(value) == text


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ({"plate": {"mass": 5, "stiffness": 5e9}}, "plate mass=5 stiffness=5e9"),
        (
            '{"half_space": {}, "material": {"name": "concrete", "density": 2447}}',
            "half_space, concrete",
        ),
        (
            '{"bar": {"length": 0.5, "area": 0.0125}, "material": "steel"}',
            "bar length=0.5 area=0.0125, steel",
        ),
        ({"material": {"name": "steel"}}, "wall, steel"),
        ('{"preset": "steel", "yield_strength": 21000000.0}', "steel yield_strength=2.1e7"),
        ('[{"index": 2, "material": "steel"}, {"index": 3}]', "index=2, steel; index=3"),
        ('{"force": 300}', "force=300"),
        ("[24, 24, 6]", "[24, 24, 6]"),
        ("{broken", "{broken"),
        ("wall", "wall"),
        ("", "none"),
    ],
)
def test_tables_of_cases_in_words(value, words):
    assert as_label(value) == words


def test_different_tables_have_different_words():
    first = '{"name": "a", "density": 1}'
    second = '{"name": "a", "density": 2}'
    assert unique_labels([first, second, first, "", "a (2)"]) == [
        "a",
        "a (2)",
        "a",
        "none",
        "a (2) (2)",
    ]


def test_units_within_a_bottom():
    assert shown_unit("boundary.bottom.plate.stiffness") == "N/m"
    assert shown_unit("boundary.bottom.bar.area") == "m²"
    assert shown_unit("boundary.bottom.material.density") == "kg/m³"
    assert shown_unit("boundary.bottom") == ""
