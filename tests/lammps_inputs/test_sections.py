"""Keys declare the type of their values, tables in tables are sections, and faults have parts."""

from __future__ import annotations

import pickle
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.case import case_tables, unit_of
from granwave.lammps_inputs.case.contact.tables import (
    COHESION,
    DENTS,
    LOSS,
    ROLLING,
    TWISTING,
    Dents,
    Resistance,
)
from granwave.lammps_inputs.case.ids import INDEX
from granwave.lammps_inputs.case.schema import ErrorList, ValidationError
from granwave.lammps_inputs.errors import InputError, InputFault, Mismatch, fault_of
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows import load_case
from granwave.workflows.cli.keys import reference
from granwave.workflows.cli.main import main

ENDLESS = {"sides": "periodic", "bottom": "periodic"}
PACKING = {"kind": "fcc", "size": [3, 3, 2], "diameter": 0.01}


def faults_of(**tables: Any) -> list[InputFault]:
    with pytest.raises(InputError) as caught:
        case_from_dict({"material": "brass", "packing": PACKING, **tables}, "my.toml")
    return caught.value.items


def test_every_key_has_a_type() -> None:
    """Keys of all kinds of files have a type in words and a specific JSON Schema."""
    for table in reference.tables():
        for key in table.keys:
            assert key.accepts and key.json, f"{table.file} {table.name}.{key.name}"
            Draft202012Validator.check_schema(key.json)


def test_tables_in_tables_are_listed() -> None:
    inner = {
        "[contact.loss]": {
            "kind",
            "weights",
            "times",
            "time",
            "restitution",
            "velocity",
            "dashpot",
            "tangential",
        },
        "[contact.loss.dashpot]": {"restitution"},
        "[contact.cohesion]": {"kind", "energy"},
        "[contact.rolling]": {"coefficient", "stiffness", "damping"},
        "[boundary.bottom.plate]": {"mass", "stiffness", "damping"},
        "[boundary.sides.tube]": {"radius"},
        "[[output.probes]]": {"sphere", "contact"},
        "[grains.ring]": {"n", "radius", "z", "gap", "angle"},
    }
    for heading, names in inner.items():
        assert set(schema.declared_fields(case_tables()[heading])) == names
    order = list(case_tables())
    assert order.index("[contact.loss.dashpot]") == order.index("[contact.loss]") + 1
    assert (unit_of("contact.loss.time"), unit_of("contact.cohesion.energy")) == ("s", "J/m^2")


@pytest.mark.parametrize(
    ("value_type", "value", "read"),
    [
        (INDEX, 3, (3,)),
        (INDEX, [3, 5], (3, 5)),
        (INDEX, {"first": 2, "last": 6, "step": 2}, (2, 4, 6)),
        (ROLLING, 0.1, Resistance(coefficient=0.1)),
        (TWISTING, "marshall", "marshall"),
        (DENTS, 1e-6, 1e-6),
        (DENTS, "run/result.h5", "run/result.h5"),
        (DENTS, {"force": 2.0}, (Dents(force=2.0),)),
        (schema.or_word("auto", schema.CountType()), "auto", "auto"),
        (schema.ListType(item=schema.CountType(), expected="ids", alone=True), 4, (4,)),
    ],
)
def test_values_are_read_by_their_type(value_type: schema.ValueType, value: Any, read: Any) -> None:
    assert value_type.read(value) == read
    assert Draft202012Validator(value_type.json).is_valid(value)


@pytest.mark.parametrize(
    ("value_type", "value", "key", "expected"),
    [
        (LOSS, {"time": -1.0}, "time", "a relaxation time from 0 to 1 s"),
        (LOSS, {"dashpot": {"restitution": 2}}, "dashpot.restitution", "above 0 and at most 1"),
        (LOSS, {"time": 1e-6, "restitution": 0.9}, "", "exclude each other"),
        (COHESION, {"kind": "jkr"}, "", "energy is missing"),
        (COHESION, {"kind": "dmt", "enrgy": 1.0}, "", "enrgy is unknown; did you mean energy?"),
        (DENTS, [{"force": 1.0}, {"force": 1.0, "low": [1, 2]}], "2.low", "[x, y, z] in m"),
        (INDEX, {"first": 5, "last": 2}, "", "the last not before the first"),
    ],
)
def test_the_fault_of_a_table_names_the_key_in_it(
    value_type: schema.ValueType, value: Any, key: str, expected: str
) -> None:
    with pytest.raises(ValidationError) as caught:
        value_type.read(value)
    assert caught.value.key == key and expected in caught.value.expected


def test_faults_have_parts() -> None:
    (fault,) = faults_of(contact={"loss": {"time": -1.0}})
    assert (fault.source, fault.key, fault.found) == ("my.toml", "contact.loss.time", "-1.0")
    assert fault.expected.startswith("a relaxation time from 0 to 1 s") and not fault.changed
    (fault,) = faults_of(load={"kind": "force"}, incident_bar={"length": 1.0, "area": 1e-4})[:1]
    assert fault.key == "load.shape" and fault.sentence.startswith("missing; a force needs one of")
    fault = next(one for one in faults_of(boundary=ENDLESS) if "layers" in one.found)
    assert fault.key == "packing.size" and fault.found == "2 layers"
    assert str(fault) == f"my.toml: packing.size: found 2 layers, expected {fault.expected}"


def test_faults_are_written_in_one_place() -> None:
    errors = ErrorList("my.toml", overridden=("load.velocity",))
    errors.check(
        (True, "load.velocity", Mismatch("-1", "a number above 0", "take its magnitude")),
        (True, "run", "is\n  odd"),
        (False, "run", "is right"),
    )
    assert errors.lines == [
        "load.velocity: found -1, expected a number above 0; take its magnitude",
        "my.toml: run: is odd",
    ]
    assert [item.changed for item in errors.items] == [True, False]
    error = InputError(errors.items)
    assert error.errors == errors.lines and str(error) == "\n".join(errors.lines)
    assert pickle.loads(pickle.dumps(error)).items == error.items
    assert str(fault_of("x").inside("a.toml").inside("b.toml")) == "b.toml: a.toml: x"


def test_only_the_command_line_names_its_option(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(InputError) as caught:
        load_case("fcc-small", ["load.velocity=-1"])
    (line,) = caught.value.errors
    assert line.startswith("load.velocity: found -1, expected a number above 0")
    assert main(["check", "fcc-small", "--set", "load.velocity=-1"]) == 2
    assert capsys.readouterr().err == f"granwave: --set: {line}\n"


def test_a_file_that_is_no_toml_has_a_line(tmp_path: Any) -> None:
    path = tmp_path / "my.toml"
    path.write_text('material = "brass"\n[packing\n')
    with pytest.raises(InputError) as caught:
        load_case(path)
    (fault,) = caught.value.items
    assert (fault.source, fault.line) == (str(path), 2) and "not valid TOML" in fault.sentence
