"""``granwave keys``: every key of every file, with what the code says of it."""

from __future__ import annotations

import dataclasses
import tomllib

import pytest

from granwave.analysis.inference.case import InferCase
from granwave.lammps_inputs.case.case import TABLES, case_keys
from granwave.lammps_inputs.case.load import Load, read_load
from granwave.lammps_inputs.case.schema import ErrorList
from granwave.workflows.cli import keys
from granwave.workflows.cli.main import main
from granwave.workflows.finite_elements.punch.case import ContinuumCase
from granwave.workflows.finite_elements.sphere_contact.case import SphereContactCase
from granwave.workflows.scanning.header import Header, RanksBySize
from granwave.workflows.scanning.slurm import Profile
from granwave.workflows.scanning.suite import SuiteFile

SECTIONS = {
    **{(keys.CASE, heading.strip("[]")): section for heading, section in TABLES.items()},
    **{(keys.CONTINUUM, name): section for name, section in ContinuumCase.SECTIONS.items()},
    **{(keys.SPHERE_CONTACT, name): section for name, section in SphereContactCase.SECTIONS.items()},
    (keys.SCAN, "scan"): Header,
    (keys.SCAN, "ranks"): RanksBySize,
    (keys.SUITE, "suite"): SuiteFile,
    (keys.PROFILE, "slurm"): Profile,
    **{(keys.INFERENCE, name): section for name, section in InferCase.SECTIONS.items()},
}
# tables and words that code besides the field's validator reads
ELSEWHERE = {("boundary", "bottom"), ("load", "file")}


def example(key: keys.Key) -> object:
    (value,) = tomllib.loads(key.example).values()
    return value


def test_every_key_that_is_read_is_listed():
    listed = {f"{table.name}.{key.name}" for table in keys.tables() if table.file == keys.CASE for key in table.keys}
    known = {key.replace(".1.", ".") for key in case_keys() if "." in key}
    assert known <= listed
    assert set(Load.__dataclass_fields__) <= {key.name for key in keys.find("load")[0].keys}


@pytest.mark.parametrize("table", keys.tables(), ids=lambda table: f"{table.file}-{table.name}")
def test_every_key_has_what_a_reader_needs(table):
    assert table.description and table.keys
    for key in table.keys:
        assert key.description and key.accepts != "any value", key.name
        assert not (key.required and key.default), key.name
        assert key.example.split(" = ", 1)[1], f"{key.name}: give an example in key_examples.toml"
        example(key)  # is TOML


@pytest.mark.parametrize(("file", "name"), SECTIONS)
def test_examples_are_valid(file, name):
    (table,) = [table for table in keys.tables() if (table.file, table.name) == (file, name)]
    fields = {field.name: field for field in dataclasses.fields(SECTIONS[file, name])}
    for key in table.keys:
        if key.name in fields and "parse" in fields[key.name].metadata and (name, key.name) not in ELSEWHERE:
            fields[key.name].metadata["parse"](example(key))


def test_no_example_of_a_key_that_does_not_exist():
    for file, tables in keys._examples().items():
        for name, examples in tables.items():
            (table,) = [table for table in keys.tables() if (table.file, table.name) == (file, name)]
            assert set(examples) <= {key.name for key in table.keys}, (file, name)


def test_a_load_knows_its_file():
    errors = ErrorList("case")
    read_load({"kind": "force", "file": "no-such-file"}, errors)
    assert "cannot be read" in errors.lines[0]


def test_the_command(capsys):
    assert main(["keys"]) == 0
    shown = capsys.readouterr().out
    assert all(f"  {table.name} " in shown for table in keys.tables())
    assert main(["keys", "packing"]) == 0
    assert "diameter  m  required\n    diameter of the spheres; in a file" in capsys.readouterr().out
    assert main(["keys", "run.end_time"]) == 0  # of three kinds of files two have it
    assert capsys.readouterr().out.count("end_time  s  default") == 2
    assert main(["keys", "[[replace]]"]) == 0


def test_words_of_a_key_may_stand_apart(capsys):
    assert main(["keys", "load", "velocity"]) == 0
    apart = capsys.readouterr().out
    assert main(["keys", "load.velocity"]) == 0
    assert capsys.readouterr().out == apart and "m/s" in apart
    assert main(["keys", "load", "velocty"]) == 2
    assert "load.velocty: no such table or key; did you mean load.velocity?" in capsys.readouterr().err


def test_usual_magnitudes_are_those_that_messages_name():
    """Warnings begin far beyond for bodies that stand for rigid ones, and the text says from where on."""
    found = {
        key.name: key.usual for table in keys.tables() for key in table.keys if table.name in ("material", "packing")
    }
    assert found["diameter"] == "usual: 1e-6 to 1 m; others give a warning"
    assert found["youngs_modulus"] == "usual: 1e6 to 1e12 Pa; below, and above 1e14 Pa, a warning is given"
