"""Every kind of load fulfils the contract of its base class."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from granwave.lammps_inputs.case.loads.load import Load
from granwave.lammps_inputs.case.loads.registry import load_keys, load_kinds, load_section
from granwave.lammps_inputs.case.schema import info_of

PAGE = Path(__file__).parents[2] / "docs" / "howto" / "case-files.md"
every_load = pytest.mark.parametrize("load", load_kinds().values(), ids=load_kinds())


@every_load
def test_a_load_says_what_it_is(load: type[Load]) -> None:
    assert load.means
    assert f"| `{load.kind}` |" in PAGE.read_text(encoding="utf-8")


@every_load
def test_the_section_has_the_keys_of_the_load(load: type[Load]) -> None:
    """Keys that several loads share are the same field."""
    of_section = {field.name: field for field in dataclasses.fields(load_section())}
    for field in dataclasses.fields(load):
        description = info_of(field).description
        assert description == info_of(of_section[field.name]).description
        assert field.default == of_section[field.name].default


@every_load
def test_keys_of_other_loads_are_none(load: type[Load]) -> None:
    """`run.case.load.amplitude` exists for an impact too, because studies use it for all kinds of
    runs.
    """
    made = load()
    numbers = ("spheres", "velocity", "angle", "spin")  # zero in loads that lack them
    for field in dataclasses.fields(load_section()):
        if field.name not in (*load_keys(load), *numbers):
            assert getattr(made, field.name) is None
