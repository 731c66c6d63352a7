"""Case files: overrides, writing and reading again, warnings, and the table [figures]."""

from __future__ import annotations

import pickle
from operator import attrgetter
from pathlib import Path
from typing import Any

import pytest

from granwave.analysis.figures.run_figures import run_figures
from granwave.lammps_inputs import make_schedule
from granwave.lammps_inputs.case.figures import CutPlane, Figures, figure_names
from granwave.lammps_inputs.case.ids import INDEX
from granwave.lammps_inputs.case.parse import parse_override
from granwave.lammps_inputs.case.run import FRAMES_OF_A_FILM
from granwave.lammps_inputs.case.schema import ValidationError
from granwave.lammps_inputs.errors import GranwaveError, InputError
from granwave.lammps_inputs.load_case import case_from_dict, load_case
from tests.helpers.made_up.small_cases import FILE, changed
from tests.helpers.made_up.synthetic import make_case


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "impact.toml"
    path.write_text(FILE, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {
            "packing": {"kind": "square", "size": [8, 7], "diameter": 0.02},
            "boundary__sides": "wall",
        },
        {"run__frames": [0.0, 1e-4, 2e-4], "run__end_time": "auto", "run__timestep": 1e-8},
        {"output__probes": [{"sphere": 3}, {"contact": [1, 2]}], "output__probe_interval": 1e-6},
        {"contact": {"law": "hertz"}, "material": "ptfe"},
        {
            "figures": {
                "plane": {"normal": [1, 1, 0], "through": [0.1, 0, 0]},
                "formats": ["svg", "png"],
                "width": 0.1,
            }
        },
    ],
)
def test_round_trip_through_toml(tmp_path: Path, changes: dict[str, Any]) -> None:
    case = case_from_dict(changed(**changes))
    path = tmp_path / "again.toml"
    path.write_text(
        case.to_toml(resolved={"timestep": 1e-7, "walls": ("bottom",)}), encoding="utf-8"
    )
    assert load_case(path) == case


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("load.velocity=10", "load.velocity", 10),
        ("packing.size=[24,24,12]", "packing.size", [24, 24, 12]),
        ("material=stainless-steel-316", "material", "stainless-steel-316"),
        (' name = "a b" ', "name", "a b"),
        ("name=a b", "name", "a b"),
        ("run.end_time=1e-4", "run.end_time", 1e-4),
        ("output.probes=[{sphere=1}]", "output.probes", [{"sphere": 1}]),
    ],
)
def test_overrides_are_parsed(text: str, key: str, value: Any) -> None:
    assert parse_override(text) == (key, value)


@pytest.mark.parametrize(
    ("overrides", "found"),
    [
        (["packing.kind=hcp", "load.velocity=10"],  # only the named key changes
         {"packing.kind": "hcp", "packing.size": (12, 12, 6), "load.velocity": 10.0}),
        # by name: the whole table
        (["material.density=1.0", "material=steel"], {"material.density": 7850}),
        (["material.yield_strength=4e8"], {"material.yield_strength": 4e8, "material.youngs_modulus": 115e9}),
        ({"load.velocity": 2, "material": "steel"}, {"load.velocity": 2.0, "material.name": "steel"}),
        (["load.velocity=1", "load.velocity=2"], {"load.velocity": 2.0}),
    ],
)  # fmt: skip
def test_overrides_of_a_file(file: Path, overrides: Any, found: dict[str, Any]) -> None:
    case = load_case(file, overrides)
    assert {name: attrgetter(name)(case) for name in found} == found


def test_every_bad_override_is_named(file: Path) -> None:
    with pytest.raises(InputError) as caught:
        load_case(file, ["a", "b=[", "load.velocity=3"])
    error = caught.value
    assert (
        len(error.errors) == 2
        and isinstance(error, GranwaveError)
        and isinstance(error, ValueError)
    )
    assert (
        str(error) == "\n".join(error.errors)
        and pickle.loads(pickle.dumps(error)).errors == error.errors
    )


LATE = {"kind": "force", "shape": "table", "table": [[0.0, 0.0], [1e-3, 0.0], [2e-3, 100.0]]}
PRESSED = {"precompression": {"kind": "uniform", "pressure": 1e4}, "contact__initial_overlap": 1e-5}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"material__poisson_ratio": 0.35}, "C = 1.67"),
        ({"material__poisson_ratio": 0.35, "contact__yield_factor": 1.67}, ""),
        ({"material__poisson_ratio": 0.35, "contact__law": "hertz"}, ""),
        (
            {"output__probes": [{"contact": [1, 2]}, {"contact": [1, 3]}]},
            "contact (1, 3) do not touch",
        ),
        ({"load": LATE, "run__end_time": 8e-4}, "begins at 0.001 s"),
        ({"load": LATE, "run__end_time": 1.2e-3}, ""),
        (PRESSED | {"boundary__forget_gap": 1e-9}, "never come to rest"),
        (PRESSED | {"boundary__forget_gap": 0.1}, ""),
    ],
)
def test_warnings(caplog: pytest.LogCaptureFixture, changes: dict[str, Any], said: str) -> None:
    case_from_dict(changed(**changes))
    messages = [record.getMessage() for record in caplog.records]
    assert len(messages) == bool(said) and said in "".join(messages)


def test_every_third_sphere() -> None:
    assert INDEX.read({"first": 8, "last": 17, "step": 3}) == (8, 11, 14, 17)
    assert INDEX.read({"first": 1, "last": 1_000_000_000, "step": 500_000_000}) == (1, 500_000_001)
    for wrong in (
        {"first": 8, "last": 17, "step": 0},
        {"first": 8, "step": 3},
        {"first": 8, "last": 17, "every": 3},
    ):
        with pytest.raises(ValidationError, match="step = 3 for every third"):
            INDEX.read(wrong)


def test_figures() -> None:
    """Names are the names of drawn figures; values are checked; a case without the table has no
    settings.
    """
    assert tuple(run_figures()) == figure_names()
    assert (
        "figures" not in (plain := case_from_dict(changed())).to_dict()
        and plain.figures == Figures()
    )
    found = case_from_dict(
        changed(figures={"plane": "y", "force_limits": [1, 50], "formats": ["svg", "png"]})
    ).figures
    assert (found.plane, found.force_limits, found.formats) == (
        CutPlane((0.0, 1.0, 0.0)),
        (1.0, 50.0),
        ("svg",),
    )


def test_a_film_has_enough_frames_unless_they_are_given() -> None:
    assert case_from_dict(changed(figures={"film": "mp4"})).n_frames == FRAMES_OF_A_FILM
    assert case_from_dict(changed(figures={"film": "gif"}, run__frames=5)).n_frames == 5
    assert case_from_dict(changed(figures={"view": True})).n_frames == 20
    assert case_from_dict(changed(run__frames=["10 %", "50 %"])).n_frames == 2
    short = make_case(run={"end_time": 3e-6, "timestep": 1e-7}, figures={"film": "gif"})
    assert make_schedule(short).n_frames == 31  # one a step, at most
