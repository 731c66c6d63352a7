"""Cylinders in case files: shapes, masses, contacts, laws of the deck, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from granwave.lammps_inputs.contact.law import flat_contact, pair_contact
from granwave.lammps_inputs.deck.commands import contacts, cylinder_commands, wall_commands
from granwave.lammps_inputs.deck.deck import write_data
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.packing import build_packing

CHAIN = {"kind": "chain", "size": 3, "diameter": 0.01}
SMALL = {"shape": "cylinder", "diameter": 0.006, "length": 0.01, "material": "steel"}
BESIDE = 0.5 * math.sqrt(0.016**2 - 0.01**2)


def case(packing=CHAIN, **tables):
    return case_from_dict(
        {"material": "brass", "contact": {"law": "hertz"}, "boundary": {"bottom": "free"}, "load": {"index": [1]},
         "packing": packing, **tables}
    )  # fmt: skip


def beside(**changes):
    return SMALL | {"at": [[BESIDE, 0, 0.005], [-BESIDE, 0, 0.005]]} | changes


def test_a_row_with_cylinders():
    """Two cylinders beside a contact touch both spheres; their masses are those of cylinders."""
    made = assemble(case(grains=[beside()], boundary={"bottom": "free", "x": "wall"}))
    assert {tuple(pair) for pair in made.contacts().tolist()} == {(1, 2), (2, 3), (1, 4), (1, 5), (2, 4), (2, 5)}
    assert build_packing(made).coordination.tolist() == [3, 4, 1, 2, 2]
    density = made.material_of(4).density
    assert made.mass_of(4) == made.sphere_masses()[3] == pytest.approx(density * math.pi * 0.003**2 * 0.01)
    assert cylinder_commands(made) == ["fix             cylinders all gran/cylinder 2 0.01 0 1 0"]
    assert "line plane-strain" not in "".join(wall_commands(made))
    law = pair_contact(made, 1, 4)
    assert 0.003 < law.effective_radius < 0.005 and math.isinf(flat_contact(made, 4).yield_overlap)
    again = case_from_dict(made.case.to_dict())
    assert again.packing.grains == made.case.packing.grains and "line" not in again.to_dict()["contact"]


@pytest.mark.parametrize(("kind", "size", "axis"), [("chain", 4, "0 1 0"), ("square", [3, 2], "0 0 1")])
def test_packings_of_cylinders(tmp_path, kind, size, axis):
    packing = {"kind": kind, "size": size, "diameter": 0.01, "shape": "cylinder", "length": 0.03}
    tables = {"boundary": {"bottom": "free", "sides": "wall"}}
    made = assemble(case(packing, **tables, contact={"law": "line"}))
    assert made.plane_strain and f"gran/cylinder 1 0.03 {axis} line plane-strain" in "\n".join(contacts(made))
    as_half_spaces = assemble(case(packing, **tables))
    assert "plane-strain" not in "\n".join(contacts(as_half_spaces))
    modulus, depth = pair_contact(as_half_spaces, 1, 2).effective_modulus, 1e-6
    force = float(pair_contact(as_half_spaces, 1, 2).loading_force(np.array([depth]))[0])
    v = 1 / (math.pi * modulus)  # both bodies; d is twice the effective radius
    assert force * v / 0.03 * (1 - math.log(v * force * 0.005 / (2 * 0.03**3))) == pytest.approx(depth, rel=1e-9)
    mass = made.material.density * math.pi * 0.005**2 * 0.03
    assert made.case.sphere_mass == pytest.approx(mass) and np.allclose(made.sphere_masses(), mass)
    write_data(made, tmp_path / "data")
    row = (tmp_path / "data").read_text().splitlines()[-1].split()
    assert float(row[3]) * math.pi / 6 * 0.01**3 == pytest.approx(mass)
    assert "line plane-strain" in "".join(wall_commands(made))


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ({"packing": CHAIN | {"shape": "cylinder"}}, "packing.length: missing"),
        ({"packing": CHAIN | {"length": 0.01}}, 'packing.length: found without shape = "cylinder"'),
        ({"packing": CHAIN | {"shape": "cylinder", "length": 1.0, "axis": "z"}}, "a direction across all contacts of chain"),
        ({"packing": CHAIN | {"shape": "cylinder", "length": 1.0, "axis": [0, 0, 0]}}, "packing.axis: found \\[0, 0, 0\\]"),
        ({"packing": {"kind": "sc", "size": [2, 2, 2], "diameter": 0.01, "shape": "cylinder", "length": 1.0}},
         "expected a packing in a plane"),
        ({"grains": [beside(length=-1)]}, "grains.1.length: found -1"),
        ({"grains": [beside(at=[[0, 0, 0]])]}, "grains 1 and 4 at one place"),
        ({"grains": [beside(at=[[0.9 * BESIDE, 0, 0.005]])]}, "grains 1 and 4, which overlap by"),
        ({"grains": [beside(at=[[0.0, 0.0095, 0.0]])]}, "grains 1 and 4, which touch at the end of a cylinder"),
        ({"grains": [beside(at=[[0.1, 0, 0]], axis=[1, 0, 1])], "boundary": {"x": "wall"}}, "oblique to the wall across x"),
        ({"grains": [beside()], "boundary": {"bottom": "free", "sides": {"tube": {"radius": 0.1}}}}, "a tube holds spheres"),
        ({"contact": {"law": "power", "constant": 1e7}}, "contact.exponent: missing"),
        ({"pair": [{"materials": ["brass", "brass"], "law": "hertz", "exponent": 2.0}]}, 'belongs to law = "power"'),
    ],
)  # fmt: skip
def test_faults(words, expected):
    with pytest.raises(InputError, match=expected):
        case(**words)


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        ("0,0,0,0.01,cylinder,0,0,1,0", "line 2: found a cylinder with a length of 0 m"),
        ("0,0,0,0.01,cone,0.1,0,1,0", "line 2: found the shape 'cone'"),
        ("0,0,0,0.01,,0.1,0,0,0", "line 2: found the axis .* no direction"),
        ("0,0,0,0.01,cylinder,long,0,1,0", 'line 2: found "long" for length'),
    ],
)
def test_faults_of_a_file(tmp_path, row, expected):
    path = tmp_path / "grains.csv"
    path.write_text(f"x,y,z,diameter,shape,length,axis_x,axis_y,axis_z\n{row}\n")
    with pytest.raises(InputError, match=expected):
        case({"kind": "file", "file": str(path)})


def test_powers_in_the_deck():
    pairs = [{"materials": ["brass", "brass"], "law": "power", "constant": 3e7, "exponent": 1.2}]
    made = case(pair=pairs)
    assert "power 1.15e+11 0.3 constant 3e+07 exponent 1.2" in "\n".join(contacts(assemble(made)))
    assert pair_contact(made, 1, 2).loading_force(1e-6) == pytest.approx(3e7 * 1e-6**1.2)
