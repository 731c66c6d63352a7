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
from tests.helpers.small_cases import FILE, changed, faults_of


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

    @pytest.mark.parametrize("text", ["velocity", "=3", "a..b=3", "packing.size=[24,", "a=", "a=1\nb=2", "a b=3"])
    def test_bad_overrides(self, text: str) -> None:
        with pytest.raises(InputError, match="--set"):
            parse_override(text)

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

    def test_faults_name_the_command_line(self, file: Path) -> None:
        with pytest.raises(InputError, match=r"^--set: load\.velocty: unknown key; did you mean velocity"):
            load_case(file, ["load.velocty=3"])

    def test_a_path_through_a_value(self, file: Path) -> None:
        with pytest.raises(InputError, match=r"expected a table \[kind\]"):
            load_case(file, ["packing.kind.x=3"])

    def test_every_bad_override_is_named(self, file: Path) -> None:
        with pytest.raises(InputError) as caught:
            load_case(file, ["a", "b=[", "load.velocity=3"])
        assert len(caught.value.errors) == 2


class TestFiles:
    def test_invalid_toml_names_the_line(self, tmp_path: Path) -> None:
        path = tmp_path / "bad.toml"
        path.write_text("name = 'x'\nsize = = 3\n")
        with pytest.raises(InputError, match=r"bad.toml: not valid TOML: .*line 2"):
            load_case(path)

    def test_missing_file_names_a_similar_one(self, file: Path) -> None:
        with pytest.raises(InputError, match=r"no such file; did you mean .*impact.toml"):
            load_case(file.with_name("impakt.toml"))

    def test_directory(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match="found a directory"):
            load_case(tmp_path)

    def test_byte_order_mark_is_no_fault(self, file: Path) -> None:
        file.write_bytes(b"\xef\xbb\xbf" + FILE.encode())
        assert load_case(file).packing.kind == "fcc"

    def test_other_encodings(self, file: Path) -> None:
        file.write_bytes(("# \u00e9\n" + FILE).encode("latin-1"))
        with pytest.raises(InputError, match=r"not UTF-8 \(line 1\)"):
            load_case(file)


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


AROUND_862 = [718, 719, 850, 851, 861, 863]  # all that touch this sphere of the last layer
FORCE = {"kind": "force", "shape": "half-sine", "amplitude": 1.0, "duration": 1.0}
TABLE = {"kind": "force", "shape": "table"}


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"laod": {}}, "laod: unknown key; did you mean load?"),
        ({"packing__dimeter": 1.0}, "packing.dimeter: unknown key; did you mean diameter?"),
        ({"packing": 3}, "packing: found 3, expected a table"),
        ({"packing__kind": "fxc"}, 'packing.kind: found "fxc", expected one of "fcc"'),
        ({"packing__kind": ["fcc"]}, "packing.kind: found"),
        ({"packing__diameter": 0}, "packing.diameter: found 0, expected a number above 0 (m)"),
        ({"packing__diameter": 10**400}, "packing.diameter: found 1000"),
        ({"material__poisson_ratio": -1}, "material.poisson_ratio: found -1"),
        ({"contact__beta": 1.0}, "contact.beta: found 1.0"),
        ({"packing__size": [12, 12]}, "packing.size: found [12, 12], expected [nx, ny, nz] for fcc"),
        ({"packing__size": 12}, "packing.size: found [12], expected [nx, ny, nz] for fcc"),
        ({"packing__size": [12, 12, 0]}, "packing.size: found [12, 12, 0]"),
        ({"packing__size": [12, 12, 6.0]}, "packing.size: found [12, 12, 6.0]"),
        ({"packing__size": [12, 12, True]}, "packing.size: found [12, 12, true]"),
        ({"packing__size": [100000, 100000, 100000]}, "packing.size: found"),
        ({"packing__kind": "chain"}, "packing.size: found [12, 12, 6], expected a number n for chain"),
        ({"packing__kind": "square"}, "packing.size: found [12, 12, 6], expected [nx, ny] for square"),
        ({"material": "bras"}, 'material: found "bras", expected one of'),
        ({"material": 3}, "material: found 3"),
        ({"material__poisson_ratio": 0.5}, "material.poisson_ratio: found 0.5, expected a number above -1 and below"),
        ({"material": "ptfe"}, "material.yield_strength: missing; the elastoplastic law needs it"),
        ({"contact__law": "hertzian"}, 'contact.law: found "hertzian", expected one of'),
        ({"contact__variant": "new"}, "contact.variant: found"),
        ({"load__velocity": 0}, "load.velocity: found 0, expected a number above 0 (m/s)"),
        ({"load__spheres": 2}, "load.spheres: found 2, expected one of 1, 3, 7"),
        ({"load__spheres": 7, "packing__size": [2, 2, 2]}, "load.spheres: found 7, but the struck sphere has"),
        ({"load__spheres": 3, "packing__kind": "bcc"}, "load.spheres: found 3, but 3 spheres need hexagonal"),
        ({"load__kind": "force"}, "load.shape: missing; a force needs one of"),
        ({"load__kind": "forse"}, 'load.kind: found "forse", expected one of'),
        ({"load__duration": 1.0}, 'load.duration: belongs to a load of kind "force" or "displacement"'),
        ({"load": FORCE | {"duration": 0.0}}, "load.duration: found 0.0, expected a number above 0 (s)"),
        ({"load": FORCE | {"velocity": 1.0}}, 'load.velocity: belongs to a load of kind "impact"'),
        ({"load": FORCE | {"frequency": 1.0}}, 'load.frequency: does not belong to shape "half-sine"'),
        ({"load": TABLE}, 'load.table: missing; shape "table" needs it (or load.file)'),
        ({"load": TABLE | {"table": [[0, 1], [0, 2]]}}, "load.table: found [[0, 1], [0, 2]], expected rows"),
        ({"load": TABLE | {"table": [[0, 0], [1, 0]]}}, "load.table: found [[0, 0], [1, 0]], expected a value other than"),
        ({"load": TABLE | {"file": "/no/such.txt"}}, "load.file: /no/such.txt: cannot be read: No such file"),
        ({"load": FORCE | {"kind": "displacement"}}, 'load.shape: found "half-sine"; a displacement needs one of "harmonic"'),
        ({"replace": [{"index": 3}]}, "replace.1: changes nothing; give a material, or a diameter"),
        ({"replace": [{"index": 1000, "material": "steel"}]}, "replace.1.index: found 1000, expected an id from 1 to"),
        ({"replace": [{"index": 0, "material": "steel"}]}, "replace.1.index: found 0, expected an id from 1 up"),
        ({"replace": [{"index": 1, "diameter": 0.02}]}, "replace.1.diameter: sphere 1 of 0.02 m overlaps sphere 2 by"),
        ({"replace": [{"index": 862, "diameter": 0.0101}], "packing__vacancies": AROUND_862}, "replace.1.diameter: sphere 862 of 0.0101 m overlaps the wall bottom by 5e-05 m"),
        ({"replace": [{"material": "steel"}]}, "replace.1: found no spheres, expected one of index, a box"),
        ({"replace": [{"index": 1, "share": 0.5, "material": "steel"}]}, "replace.1: found index and share, expected one of index, a box from low to high, or share"),
        ({"replace": [{"low": [0, 0, 0], "share": 0.5, "material": "steel"}]}, "replace.1: found a box and share, expected one of"),
        ({"replace": [{"low": [0, 0, 0], "material": "steel"}]}, "replace.1.high: missing; a box has both corners"),
        ({"replace": [{"low": [0, 0, 1], "high": [1, 1, 0], "material": "steel"}]}, "replace.1.high: found [1.0, 1.0, 0.0], expected none of it below low, [0.0, 0.0, 1.0]"),
        ({"replace": [{"low": [0.001, 0, 0], "high": [0.002, 1, 0], "material": "steel"}]}, "replace.1: found no sphere in the box from [0.001, 0.0, 0.0] to [0.002, 1.0, 0.0]; centres lie from [0, 0, 0]"),
        ({"replace": [{"share": 1e-4, "material": "steel"}]}, "replace.1: found a share of 0.0001 of 864 spheres, which is none"),
        ({"packing__diameter_scatter": -1e-6}, "packing.diameter_scatter: found -1e-06, expected a number at least 0"),
        ({"packing__diameter_scatter": 0.005}, "packing.diameter_scatter: found 0.005, expected less than the radius, 0.005"),
        ({"packing__diameter_scatter": 1e-3, "replace": [{"index": 1, "diameter": 2e-3}]}, "replace.1.diameter: found 0.002, expected more than twice packing.diameter_scatter, 0.001 m"),
        ({"packing__scatter_distribution": "gauss"}, 'packing.scatter_distribution: found "gauss", expected one of'),
        ({"packing__seed": -1}, "packing.seed: found -1, expected a whole number from 0"),
        ({"packing__vacancies": 1.0}, "packing.vacancies: found 1.0, expected a share of the spheres"),
        ({"packing__vacancies": [865]}, "packing.vacancies: found 865, expected ids from 1 to 864, the end of the packing"),
        ({"packing__vacancies": [66]}, "packing.vacancies: found 66, which load.spheres needs"),
        ({"packing__vacancies": [7], "replace": [{"index": {"first": 5, "last": 9}, "material": "steel"}]}, "packing.vacancies: found 7, which replace.1.index needs; expected a sphere that nothing names"),
        ({"packing__vacancies": [7], "output__probes": [{"contact": [6, 7]}]}, "packing.vacancies: found 7, which output.probes needs"),
        ({"packing__vacancies": 0.9999}, "packing.vacancies: found 0.9999 of 864 spheres, which leaves no sphere; make the share smaller"),
        ({"packing__vacancies": 0.5, "replace": [{"index": {"first": 1, "last": 800}, "material": "steel"}]}, "packing.vacancies: found 0.5 of 864 spheres, which takes 432 spheres, 64 may go: the case names the others"),
        ({"packing": {"kind": "chain", "size": 8, "diameter": 0.01, "vacancies": [3]}}, "packing.vacancies: found in a chain, which has none"),
        ({"replace": [{"index": 1, "material": "bras"}]}, 'replace.1.material: found "bras", expected one of'),
        ({"replace": [{"index": 1, "material": "ptfe"}]}, "replace.1.material.yield_strength: missing; the elastoplastic"),
        ({"replace": {"index": 1}}, "replace: found {index = 1}, expected one or more [[replace]] tables"),
        ({"striker": [{"touches": 1000}]}, "striker.1.touches: found 1000, expected ids from 1 to"),
        ({"striker": [{"touches": [1, 144]}]}, "striker: striker 1: found no place where it touches [1, 144] all at once"),
        ({"striker": [{"touches": 1, "velocity": 3}]}, "striker.1.velocity: found 3, expected [x, y, z] in m/s"),
        ({"bar": {"length": 1, "area": 1e-4}}, 'bar: found with packing.kind = "fcc", expected a chain'),
        ({"bar": {"length": 1, "area": 0}}, "bar.area: found 0, expected a number above 0 (m^2)"),
        ({"sensor": [{"name": "A", "id": 1000}]}, "sensor.1.id: found 1000, expected an id from 1 to"),
        ({"striker": [{"touches": []}]}, "striker.1.touches: found [], expected an id from 1 up"),
        ({"striker": [{"velocity": [0, 0, 1]}]}, "striker.1.touches: missing"),
        ({"output__history": 10}, "output.history: found 10 for fcc, expected 0: only chains and [[line]]s have one"),
        ({"boundary__bottom": {"matter": "steel"}}, "boundary.bottom.matter: unknown key; did you mean material?"),
        ({"boundary__bottom": {"material": "stele"}}, 'boundary.bottom.material: found "stele", expected one of'),
        ({"boundary__bottom": "soft"}, "boundary.bottom: found"),
        ({"boundary__bottom": "fixed", "packing__size": [12, 12, 1]}, 'boundary.bottom: found "fixed" with a single'),
        ({"boundary__forget_gap": 3}, "boundary.forget_gap: found 3, expected a number above 0 and at most 2"),
        ({"boundary__sides": "periodic", "packing__size": [2, 12, 6]}, "packing.size: found 2 x 12 spheres in a layer"),
        ({"boundary__sides": "periodic", "packing__size": [5, 5, 6]}, "packing.size: found 5 rows, expected an even"),
        ({"boundary__sides": "periodic", "packing__kind": "chain", "packing__size": 9}, 'boundary.sides: found "periodic" for a chain'),
        ({"run__end_time": "never"}, 'run.end_time: found "never", expected a number above 0 (s) or "auto"'),
        ({"run__timestep": 2e-3}, "run.timestep: found 0.002 s, expected at most run.end_time"),
        ({"run__frames": ["50 %", "20 %"]}, 'run.frames: found ["50 %", "20 %"], expected how many'),
        ({"run__frames": [1e-4, "50 %"]}, 'run.frames: found [0.0001, "50 %"], expected how many'),
        ({"run__frames": ["120 %"]}, "run.frames: found"),
        ({"run__frames": ["half"]}, "run.frames: found"),
        ({"run__frames": ["50 %"], "run__end_time": "auto"}, "run.frames: found shares of an end that is not known"),
        ({"run__frames": [2e-4, 1e-4]}, "run.frames: found [0.0002, 0.0001], expected how many"),
        ({"run__frames": [-1e-4]}, "run.frames: found [-0.0001]"),
        ({"run__frames": [1e-4, 2e-3]}, "run.frames: found a time of 0.002 s, expected none beyond"),
        ({"output__probes": {"sphere": 3}}, "output.probes: found {sphere = 3}, expected a list"),
        ({"output__probes": [{"sphere": 0}]}, "output.probes: found"),
        ({"output__probes": [{"sphere": 865}]}, "output.probes: found sphere 865, expected an id from 1 to 864"),
        ({"output__probes": [{"contact": [1]}]}, "output.probes: found"),
        ({"output__probes": [{"contact": [4, 4]}]}, "output.probes: found contact [4, 4], expected two different"),
        ({"output__probes": [{"sphere": 3, "contact": [1, 2]}]}, "output.probes: found"),
        ({"output__probe_interval": 1.0}, "output.probe_interval: found 1 s"),
        ({"name": "a/b"}, "name: found"),
        ({"name": ""}, "name: found"),
        ({"name": 3}, "name: found 3"),
        ({"name": "a\nb"}, "name: found"),
        ({"block": {}}, "block: belongs to a continuum case"),
        ({"replicates": 3}, "replicates: belongs in a scan file: granwave scan runs it"),
    ],
)  # fmt: skip
def test_bad_cases(changes: dict[str, Any], fault: str) -> None:
    errors = faults_of(**changes)
    assert len(errors) == 1, errors
    assert errors[0].startswith(f"my.toml: {fault}")
    assert "\n" not in errors[0]


def test_missing_tables() -> None:
    with pytest.raises(InputError) as caught:
        case_from_dict({}, "my.toml")
    assert [line.split(":")[1].strip() for line in caught.value.errors] == ["packing", "material"]


def test_all_faults_are_named_at_once() -> None:
    errors = faults_of(
        packing__kind="fxc", packing__diameter=-1, material="bras", load__velocity=True, run__frames=0, laod=3
    )
    assert len(errors) == 6


def test_material_of_values_needs_them_all() -> None:
    errors = faults_of(material={"youngs_modulus": 1e9})
    assert {line.split(":")[1].strip() for line in errors} == {"material.poisson_ratio", "material.density"}
