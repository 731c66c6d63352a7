"""Cases that are refused: a line for each fault, with the key."""

from __future__ import annotations

from typing import Any

import pytest

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from tests.helpers.small_case import faults_of

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
