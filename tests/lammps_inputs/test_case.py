"""Case files: keys, defaults, overrides, and what is wrong in them."""

from __future__ import annotations

import logging
import pickle
from pathlib import Path
from typing import Any

import pytest

from granwave.lammps_inputs.case.bodies import parse_index
from granwave.lammps_inputs.case.parse import parse_override
from granwave.lammps_inputs.case.schema import ValidationError
from granwave.lammps_inputs.errors import GranwaveError, InputError
from granwave.lammps_inputs.load_case import case_from_dict, load_case
from tests.helpers.small_cases import FILE, changed


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "impact.toml"
    path.write_text(FILE, encoding="utf-8")
    return path


def test_defaults(file: Path) -> None:
    case = load_case(file)
    assert case.name == "impact"
    assert (case.contact.law, case.contact.variant, case.contact.yield_factor) == (
        "elastoplastic",
        "continuous",
        1.6,
    )
    assert (case.load.kind, case.load.velocity, case.load.spheres) == ("impact", 5.0, 1)
    assert (case.boundary.bottom, case.boundary.sides, case.boundary.forget_gap) == ("wall", "free", 0.1)
    assert (case.run.end_time, case.run.timestep, case.run.frames) == (1e-3, "auto", 20)
    assert case.output.probes == ()
    assert case.sphere_mass == pytest.approx(8500 * 3.141592653589793 / 6 * 1e-6)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"packing": {"kind": "chain", "size": 8, "diameter": 0.02}},
        {"packing": {"kind": "square", "size": [8, 7], "diameter": 0.02}, "boundary__sides": "wall"},
        {"run__frames": [0.0, 1e-4, 2e-4], "run__end_time": "auto", "run__timestep": 1e-8},
        {"output__probes": [{"sphere": 3}, {"contact": [1, 2]}], "output__probe_interval": 1e-6},
        {"contact": {"law": "hertz"}, "material": "ptfe"},
    ],
)
def test_round_trip_through_toml(tmp_path: Path, changes: dict[str, Any]) -> None:
    case = case_from_dict(changed(**changes))
    path = tmp_path / "again.toml"
    path.write_text(case.to_toml(resolved={"timestep": 1e-7, "walls": ("bottom",)}), encoding="utf-8")
    assert load_case(path) == case


class TestOverrides:
    @pytest.mark.parametrize(
        ("text", "key", "value"),
        [
            ("load.velocity=10", "load.velocity", 10),
            ("packing.size=[24,24,12]", "packing.size", [24, 24, 12]),
            ("packing.kind=hcp", "packing.kind", "hcp"),
            ("material=stainless-steel-316", "material", "stainless-steel-316"),
            (' name = "a b" ', "name", "a b"),
            ("name=a b", "name", "a b"),
            ("run.end_time=1e-4", "run.end_time", 1e-4),
            ("output.probes=[{sphere=1}]", "output.probes", [{"sphere": 1}]),
        ],
    )
    def test_parsing(self, text: str, key: str, value: Any) -> None:
        assert parse_override(text) == (key, value)

    def test_only_the_named_key_changes(self, file: Path) -> None:
        case = load_case(file, ["packing.kind=hcp", "load.velocity=10"])
        assert (case.packing.kind, case.packing.size, case.load.velocity) == ("hcp", (12, 12, 6), 10.0)

    def test_a_material_by_name_replaces_the_table(self, tmp_path: Path) -> None:
        path = tmp_path / "c.toml"
        path.write_text(FILE.replace('material = "brass"\n', "") + "[material]\npreset = 'brass'\ndensity = 1.0\n")
        assert load_case(path).material.density == 1.0
        assert load_case(path, ["material=steel"]).material.density == 7850

    def test_a_key_of_a_material_given_by_name(self, file: Path) -> None:
        case = load_case(file, ["material.yield_strength=4e8"])
        assert (case.material.yield_strength, case.material.youngs_modulus) == (4e8, 115e9)

    def test_a_mapping_serves_as_well(self, file: Path) -> None:
        assert load_case(file, {"load.velocity": 2, "material": "steel"}).load.velocity == 2.0

    def test_the_last_one_counts(self, file: Path) -> None:
        assert load_case(file, ["load.velocity=1", "load.velocity=2"]).load.velocity == 2.0

    def test_every_bad_override_is_named(self, file: Path) -> None:
        with pytest.raises(InputError) as caught:
            load_case(file, ["a", "b=[", "load.velocity=3"])
        assert len(caught.value.errors) == 2


def test_errors_are_builtins_too() -> None:
    error = InputError(["a", "b"])
    assert isinstance(error, GranwaveError) and isinstance(error, ValueError)
    assert str(error) == "a\nb"
    assert pickle.loads(pickle.dumps(error)).errors == ["a", "b"]


class TestWarnings:
    def test_poisson_ratio_off_the_fit_names_the_exact_factor(self, caplog: pytest.LogCaptureFixture) -> None:
        with caplog.at_level(logging.WARNING, "granwave"):
            case_from_dict(changed(material__poisson_ratio=0.35))
        assert "C = 1.67" in caplog.text

    @pytest.mark.parametrize("changes", [{"contact__yield_factor": 1.67}, {"contact__law": "hertz"}])
    def test_not_if_the_factor_was_chosen_or_nothing_yields(
        self, caplog: pytest.LogCaptureFixture, changes: dict[str, Any]
    ) -> None:
        with caplog.at_level(logging.WARNING, "granwave"):
            case_from_dict(changed(material__poisson_ratio=0.35, **changes))
        assert caplog.text == ""

    def test_probed_spheres_apart(self, caplog: pytest.LogCaptureFixture) -> None:
        with caplog.at_level(logging.WARNING, "granwave"):
            case_from_dict(changed(output__probes=[{"contact": [1, 2]}, {"contact": [1, 3]}]))
        assert "(1, 3)" in caplog.text
        assert "(1, 2)" not in caplog.text

    @pytest.mark.parametrize("begins", [1e-3, 5e-4])
    def test_a_load_after_the_end(self, caplog: pytest.LogCaptureFixture, begins: float) -> None:
        load = {"kind": "force", "shape": "table", "table": [[0.0, 0.0], [begins, 0.0], [2e-3, 100.0]]}
        with caplog.at_level(logging.WARNING, "granwave"):
            case_from_dict(changed(load=load, run__end_time=8e-4))
        assert ("begins at 0.001 s" in caplog.text) == (begins > 8e-4)

    @pytest.mark.parametrize("gap", [1e-9, 0.1])
    def test_dents_that_are_forgotten_under_a_static_load(self, caplog: pytest.LogCaptureFixture, gap: float) -> None:
        pressed = {"kind": "uniform", "pressure": 1e4}
        with caplog.at_level(logging.WARNING, "granwave"):
            case_from_dict(changed(contact__initial_overlap=1e-5, precompression=pressed, boundary__forget_gap=gap))
        assert ("never come to rest" in caplog.text) == (gap < 1e-3)


def test_every_third_sphere() -> None:
    assert parse_index({"first": 8, "last": 17, "step": 3}) == (8, 11, 14, 17)
    assert parse_index({"first": 1, "last": 1_000_000_000, "step": 500_000_000}) == (1, 500_000_001)
    for wrong in ({"first": 8, "last": 17, "step": 0}, {"first": 8, "step": 3}, {"first": 8, "last": 17, "every": 3}):
        with pytest.raises(ValidationError, match="step = 3 for every third"):
            parse_index(wrong)
