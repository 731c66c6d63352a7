"""Errors in a first case with a packing of another program, and their messages."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows.cli.tables.grain_file_values import grain_file_values
from granwave.workflows.run.checks import warn_of_strikers

D = 0.010
OVERLAP = 1e-5
# a square of four grains that overlap; four squares are the grains of a periodic box
STEP = D - OVERLAP
PLACES = ((0.0, 0.0), (STEP, 0.0), (0.0, STEP), (STEP, STEP))
WIDTH = 4 * STEP  # of the box, m
BOX = f"0 {WIDTH}\n0 {WIDTH}\n0 0.1\n"
SOFT = {"youngs_modulus": 1e7, "poisson_ratio": 0.3, "density": 2500.0}
STRIKER = {"touches": 1, "velocity": [0.0, 0.0, 1.0]}


def dump(directory: Path) -> Path:
    """A LAMMPS dump of four such squares, periodic along x and y."""
    half = WIDTH / 2
    corners = [(0.0, 0.0), (half, 0.0), (0.0, half), (half, half)]
    places = np.repeat(corners, 4, axis=0) + np.tile(PLACES, (4, 1))
    rows = [f"{n} 1 {x!r} {y!r} 0.005 0.005" for n, (x, y) in enumerate(places.tolist(), start=1)]
    text = (
        f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{len(rows)}\n"
        f"ITEM: BOX BOUNDS pp pp ff\n{BOX}ITEM: ATOMS id type x y z radius\n"
    )
    path = directory / "bed.dump"
    path.write_text(text + "\n".join(rows) + "\n")
    return path


def case_of(path: Path, contacts: str = "relax", **tables: Any) -> dict[str, Any]:
    """A case with the grains of a file."""
    packing = {"kind": "file", "file": str(path), "up": "z", "contacts": contacts}
    return {
        "name": "first",
        "material": SOFT,
        "contact": {"law": "hertz"},
        "packing": packing,
        "striker": [STRIKER],
        "run": {"end_time": 1e-4},
        **tables,
    }


def warnings_of(table: dict[str, Any], caplog: pytest.LogCaptureFixture) -> str:
    """Warnings of a case."""
    with caplog.at_level(logging.WARNING, "granwave"):
        case_from_dict(table, "first")
    return caplog.text


def test_contacts_across_a_periodic_box_are_missed(tmp_path, caplog):
    text = warnings_of(case_of(dump(tmp_path)), caplog)
    assert "8 contacts cross its sides" in text
    assert 'boundary.sides = "periodic" includes them' in text


def test_overlaps_without_a_load_push_grains_apart(tmp_path, caplog):
    text = warnings_of(case_of(dump(tmp_path)), caplog)
    assert "24 overlaps, up to 1e-05 m, push apart grains that no load, wall or held grain" in text


@pytest.mark.parametrize(
    "tables",
    [
        {"boundary": {"sides": "periodic"}},
        {"boundary": {"sides": "periodic"}, "precompression": {"kind": "gravity"}},
    ],
    ids=["periodic", "gravity"],
)
def test_a_packing_that_is_held_gives_no_warning(tmp_path, caplog, tables):
    text = warnings_of(case_of(dump(tmp_path), **tables), caplog)
    assert "across its sides" not in text
    assert "press grains" not in text


def test_a_missing_period_is_that_of_the_box(tmp_path):
    text = dump(tmp_path).read_text().replace("pp pp ff", "ff ff ff")
    path = tmp_path / "fixed.dump"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        case_from_dict(case_of(path, boundary={"sides": "periodic"}), "first")
    width = f"{WIDTH:.6g}"
    assert f"packing.period = [{width}, {width}] if it was periodic" in str(error.value)


def test_a_material_without_a_name_is_that_of_the_case(tmp_path):
    assembly = assemble(case_from_dict(case_of(dump(tmp_path)), "first"))
    values = grain_file_values(assembly)
    assert values is not None
    assert values["materials"] == {"of the case": 16}


@pytest.mark.parametrize(
    ("moved", "message"),
    [(0.0, ""), (5e-4, "0.0005 m clear of it"), (-2e-5, "2e-05 m deep in it")],
)
def test_a_striker_that_lost_its_sphere_is_named(tmp_path, caplog, moved, message):
    """The sphere may be one period of the box away, as LAMMPS can place it."""
    table = case_of(dump(tmp_path), boundary={"sides": "periodic"})
    assembly = assemble(case_from_dict(table, "first"))
    ((touched, striker),) = assembly.striker_contacts
    centres = {number: assembly.centre_of(number).copy() for number in (touched, striker)}
    centres[touched] += np.array([WIDTH, 0.0, moved])
    caplog.clear()
    with caplog.at_level(logging.WARNING, "granwave"):
        warn_of_strikers(assembly, centres)
    assert message in caplog.text
    assert bool(caplog.text) == bool(message)
