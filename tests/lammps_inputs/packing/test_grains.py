"""Grains at given positions, held grains, selected grains, and further materials."""

from __future__ import annotations

import dataclasses
import tomllib
from pathlib import Path
from typing import Any

import ase
import ase.io
import numpy as np
import pytest

from granwave._contact_laws import elliptic_radius
from granwave.lammps_inputs import build_packing, plan
from granwave.lammps_inputs.case.packing.grains import parse_grains
from granwave.lammps_inputs.contact.initial_dents import contacts_at_start
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.lattices import Lattice
from granwave.lammps_inputs.load_case import case_from_dict, load_case
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.cylinders import grains_called, in_grains
from granwave.lammps_inputs.packing.motion import struck_of, velocities_of
from granwave.lammps_inputs.packing.places import Places
from granwave.workflows.cli.tables.plan_table import plan_table

ROW = "x,y,z,diameter\n0,0,0,0.01\n0,0,0.01,0.01\n0,0,0.0225,0.015\n"
SOFT = {"youngs_modulus": 1e9, "poisson_ratio": 0.4, "density": 1200, "yield_strength": 2e7}


def case_of(text: str = ROW, **changes: Any) -> dict[str, Any]:
    packing = {"kind": "file", "grains": text} | changes.pop("packing", {})
    return {"packing": packing, "material": "brass"} | changes


def of_file(path: Path, **changes: Any) -> dict[str, Any]:
    return {"packing": {"kind": "file", "file": str(path)}, "material": "brass"} | changes


def beside_chain(size: int, grains: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "packing": {"kind": "chain", "size": size, "diameter": 0.01},
        "material": "brass",
        "grains": grains,
    }


def test_columns_in_any_order_and_comments() -> None:
    grains = parse_grains(
        "# mine\nz, diameter, x, y, material\n0, 1e-2, 1, 2, steel\n\n3, 2e-2, 4, 5,\n", None
    )
    assert grains.position.tolist() == [[1, 2, 0], [4, 5, 3]]
    assert (grains.diameter.tolist(), grains.material) == ([0.01, 0.02], ("steel", ""))
    assert parse_grains(
        "x,y,z,radius\n0,0,0,5e-3\n0,0,0.0125,7.5e-3\n", None
    ).diameter.tolist() == [0.01, 0.015]


def test_text_holds_every_bit() -> None:
    rng = np.random.default_rng(1)
    lines = [",".join(map(repr, row)) for row in np.abs(rng.normal(size=(20, 7))).tolist()]
    grains = parse_grains("x,y,z,diameter,vx,vy,vz\n" + "\n".join(lines), None)
    again = parse_grains(grains.text, None)
    assert again == grains
    assert np.array_equal(again.position, grains.position)
    assert np.array_equal(again.velocity, grains.velocity)


def test_case_is_complete_without_its_file(tmp_path: Path) -> None:
    (tmp_path / "row.csv").write_text(ROW)
    (tmp_path / "case.toml").write_text(
        'material = "brass"\n[packing]\nkind = "file"\nfile = "row.csv"\n'
    )
    case = load_case(tmp_path / "case.toml")
    (tmp_path / "row.csv").unlink()
    assert case_from_dict(tomllib.loads(case.to_toml()), "case") == case
    assert (case.packing.size, case.packing.diameter) == ((3,), 0.01)


def test_read_by_ase(tmp_path: Path) -> None:
    atoms = ase.Atoms("X3", positions=[[0, 0, 0], [0, 0, 0.01], [0, 0, 0.0225]])
    atoms.set_array("radius", np.array([0.005, 0.005, 0.0075]))
    atoms.set_array("material", np.array(["brass", "steel", "brass"]))
    ase.io.write(tmp_path / "row.extxyz", atoms)
    assembly = assemble(case_from_dict(of_file(tmp_path / "row.extxyz", material="steel"), "mine"))
    assert assembly.sphere_diameters().tolist() == pytest.approx([0.01, 0.01, 0.015])
    assert [assembly.material_of(n).name for n in (1, 2, 3)] == ["brass", "steel", "brass"]


@pytest.mark.parametrize("kind", ["fcc", "hcp", "bcc", "sc"])
def test_contacts_are_those_of_the_lattice(kind: str) -> None:
    lattice = Lattice(kind, (6, 6, 4), 0.01)
    rows = [
        ",".join(map(repr, place)) for place in lattice.positions(1, lattice.n_spheres).tolist()
    ]
    grains = parse_grains("x,y,z\n" + "\n".join(rows), 0.01)
    places = Places(grains, 0.01)
    expected = np.concatenate(list(lattice.pairs()))
    assert sorted(map(tuple, next(places.pairs()).tolist())) == sorted(
        map(tuple, expected.tolist())
    )
    assert places.neighbours(50) == lattice.neighbours(50)
    assert places.top_layer.tolist() == lattice.top_layer.tolist()
    assert places.last_layer.tolist() == lattice.last_layer.tolist()


def test_contacts_of_unlike_sizes() -> None:
    small = [(0.05 + 0.0005, 0.0), (-0.05 - 0.0005, 0.0), (0.0, 0.05 + 0.0005), (0.0, 0.06)]
    rows = ["0,0,0,0.1", *(f"{x},{y},0,0.001" for x, y in small)]
    places = Places(parse_grains("x,y,z,diameter\n" + "\n".join(rows), None), 0.001)
    assert next(places.pairs()).tolist() == [[1, 2], [1, 3], [1, 4]]


def test_walls_touch_the_outermost_grains() -> None:
    case = case_from_dict(case_of(boundary={"sides": "wall"}), "mine")
    planes = {wall.name: wall.coordinate for wall in build_packing(case).walls}
    assert planes == pytest.approx(
        {"bottom": 0.03, "xlo": -0.0075, "xhi": 0.0075, "ylo": -0.0075, "yhi": 0.0075}
    )


def test_struck_grains() -> None:
    assert struck_of(assemble(case_from_dict(case_of(), "mine"))) == (1,)
    chosen = case_from_dict(
        case_of(load={"index": [3], "velocity": 2.0}, packing={"diameter": 0.02}), "mine"
    )
    assert velocities_of(assemble(chosen)) == {3: (0.0, 0.0, 2.0)}
    assert (chosen.packing.diameter, assemble(chosen).sphere_diameters().tolist()) == (
        0.02,
        [0.01, 0.01, 0.015],
    )


def test_velocities_of_the_file_are_the_load() -> None:
    text = "x,y,z,diameter,vx,vy,vz\n0,0,0,0.01,0,0,1\n0,0,0.01,0.01,0,0,0\n0,0,0.03,0.01,1,0,-2\n"
    case = case_from_dict(case_of(text), "mine")
    assert case.load.kind == "grains"
    assert list(velocities_of(assemble(case)).items()) == [
        (3, (1.0, 0.0, -2.0)),
        (1, (0.0, 0.0, 1.0)),
    ]


def test_further_materials_serve_wherever_a_material_is_named() -> None:
    lattice = {"kind": "chain", "size": 4, "diameter": 0.01}
    data = {
        "packing": lattice, "material": "brass", "materials": {"soft": SOFT},
        "replace": [{"index": 2, "material": "soft"}], "boundary": {"bottom": {"material": "soft"}},
    }  # fmt: skip
    case = case_from_dict(data, "mine")
    assert case.replace[0].material == case.boundary.bottom_material == case.materials[0]
    assert case_from_dict(tomllib.loads(case.to_toml()), "mine") == case


def test_material_of_a_grain_is_a_preset_or_a_table() -> None:
    text = "x,y,z,diameter,material\n0,0,0,0.01,soft\n0,0,0.01,0.01,steel\n0,0,0.02,0.01,\n"
    assembly = assemble(case_from_dict(case_of(text, materials={"soft": SOFT}), "mine"))
    assert [assembly.material_of(n).name for n in (1, 2, 3)] == ["soft", "steel", "brass"]


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (
            "x,y,z\n0,0,0\n",
            "line 1: found no column diameter, expected x, y, z, diameter (or radius, volume, ",
        ),
        ("x,x,z,diameter\n0,0,0,1\n", "line 1: found the column x twice"),
        (
            "x,y,z,radius,diameter\n0,0,0,5e-3,1e-2\n",
            "line 1: found the column diameter (or radius for it) twice",
        ),
        ("x,y,z,diameter\n", "found no grain, expected a row for each"),
        ("# nothing\n", "found no grain, expected a line of names"),
        ("x,y,z,diameter\n0,0,0,1\n\n0,0,0\n", "line 4: found 3 values, expected 4"),
        ("x,y,z,diameter\n0,0,nan,1\n", 'line 2: found "nan" for z, expected a finite number'),
        ("x,y,z,diameter\n0,one,0,1\n", 'line 2: found "one" for y'),
        ("x,y,z,diameter\n0,0,0,0.01\n0,0,1,-1\n", "line 3: found a diameter of -1 m"),
        (
            "x,y,z,diameter,group\n0,0,0,0.01,a\tb\n",
            'line 2: found "a\\tb" for group, expected a name',
        ),
        (
            f"{ROW}\n0,0,0.001,0.01\n",
            "found grains 1 (line 2) and 4 (line 6), which overlap by 0.009 m",
        ),
        (f"{ROW}0,0,0,0.01\n", "found grains 1 (line 2) and 4 (line 5) at the same position"),
        (
            "x,y,z,diameter,material\n# here\n0,0,0,0.01,stel\n",
            'found material "stel" of grain 1 (line 3)',
        ),
    ],
)
def test_faults_of_tables_name_file_and_line(tmp_path: Path, text: str, fault: str) -> None:
    (tmp_path / "wrong.csv").write_text(text)
    with pytest.raises(InputError) as caught:
        case_from_dict(of_file(tmp_path / "wrong.csv", load={"index": [1]}), "my.toml")
    assert caught.value.errors[0].startswith(
        f"my.toml: packing.file: {tmp_path}/wrong.csv: {fault}"
    )


def test_faults_of_added_grains_name_their_entry() -> None:
    beside = [{"at": [[0, 0, z]], "diameter": 0.01} for z in (0.03, 0.039)]
    with pytest.raises(
        InputError, match=r"grains\.2: found grains 4 and 5, which overlap by 0\.001 m"
    ):
        case_from_dict(beside_chain(3, beside))


RINGS = [{"ring": {"n": 6, "radius": 0.008, "z": 0.005}, "repeat": {"times": 3, "step": [0, 0, 0.01]}, "diameter": 0.003,
          "material": "steel", "group": "rings"}]  # fmt: skip


def test_grains_around_a_chain() -> None:
    case = case_from_dict(beside_chain(4, RINGS), "mine")
    assembly = assemble(case)
    assert (assembly.n_spheres, assembly.n_contacts, case.packing.kind) == (22, 3, "file")
    assert assembly.positions()[:4, 2].tolist() == [0.0, 0.01, 0.02, 0.03]
    assert assembly.positions()[4] == pytest.approx([0.008, 0.0, 0.005])
    assert assembly.positions()[-1] == pytest.approx([0.004, -0.004 * np.sqrt(3), 0.025])
    assert [assembly.material_of(n).name for n in (4, 5)] == ["brass", "steel"]
    assert case.packing.grains is not None
    assert case.packing.grains.of_group("rings") == tuple(range(5, 23))
    assert case_from_dict(tomllib.loads(case.to_toml()), "mine") == case


def test_a_material_of_added_grains_by_value() -> None:
    case = case_from_dict(
        beside_chain(2, [{"at": [[0.02, 0, 0]], "diameter": 0.003, "material": SOFT}]), "mine"
    )
    assert assemble(case).material_of(3).youngs_modulus == SOFT["youngs_modulus"]
    assert [one.name for one in case.materials] == ["grains"]


def test_check_tells_the_coordination_found() -> None:
    case = case_from_dict(case_of(), "mine")
    assert "contacts per grain     1.33 on average: 1 on 2 grains, 2 on 1 grain" in plan_table(
        assemble(case), plan(case)
    )


def test_dents_of_a_tube_are_where_its_grains_touch() -> None:
    """Four grains around the axis touch the tube; a fifth, on the axis, does not."""
    ring = "".join(
        f"{0.01 * np.cos(a)!r},{0.01 * np.sin(a)!r},0,0.01\n"
        for a in np.pi / 4 + np.pi / 2 * np.arange(4)
    )
    text = f"x,y,z,diameter\n{ring}0,0,0.03,0.01\n".replace("np.float64(", "").replace("),", ",")
    tube = {"bottom": "free", "sides": {"tube": {"radius": 0.015}}}
    case = case_from_dict(case_of(text, boundary=tube, contact={"initial_overlap": 1e-5}), "mine")
    (near,) = [one for one in contacts_at_start(assemble(case)) if "tube" in one.first]
    assert near.second.tolist() == [1, 2, 3, 4]
    assert np.hypot(*near.place.T[:2]) == pytest.approx(np.full(4, 0.015))
    assert near.effective_radius == pytest.approx(
        np.full(4, elliptic_radius(200.0, 200.0 - 1 / 0.015))
    )


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize(("kind", "holes", "n", "n_holes"), [
    ("fcc", "octahedral", 6, 64), ("hcp", "octahedral", 6, 64), ("fcc", "tetrahedral", 4, 128), ("hcp", "tetrahedral", 4, 128),
])  # fmt: skip
def test_grains_in_holes(periodic: bool, kind: str, holes: str, n: int, n_holes: int) -> None:
    """In periodic layers each sphere of a pair of layers has one octahedral and two tetrahedral
    holes.
    """
    ratio = {"octahedral": 2**0.5 - 1, "tetrahedral": 1.5**0.5 - 1}[holes]
    tables = case_of(packing={"kind": kind, "size": [4, 4, 5], "diameter": 0.01},
                     grains=[{"at": holes, "diameter": 0.01 * ratio, "material": "steel", "group": "small"}],
                     boundary={"sides": "periodic" if periodic else "free"})  # fmt: skip
    del tables["packing"]["grains"]
    case = case_from_dict(tables, "mine")
    packing = build_packing(case)
    inside = packing.coordination[80:]
    assert (inside == n).all() if holes == "octahedral" else (inside >= n).all()
    assert len(inside) == n_holes if periodic else 0 < len(inside) < n_holes
    again = case_from_dict(tomllib.loads(case.to_toml()), "mine")
    assert again == case and (again.packing.period is not None) == periodic


def test_grains_by_their_names() -> None:
    assert [grains_called(5, n) for n in (0, 2, 5)] == ["spheres", "grains", "cylinders"]
    text = "Spheres, 3 sphere-steps/s, spherical: plastic spheres of a sphere"
    assert in_grains(text, "spheres") == text
    assert (
        in_grains(text, "grains") == "Grains, 3 grain-steps/s, spherical: plastic grains of a grain"
    )


HOSTILE = [
    "CuZn37, hard", "Bob's steel", '3/8" bearing', "x # y", "#", '"""', "'''", "a = b", "\\n \\", "[1]", "=1+1", "Ω",
]  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE)
def test_any_name_in_one_line_is_read_again(name: str, tmp_path: Path) -> None:
    """Names of materials and groups, in a table of grains, in [[grains]] and [[hold]], and in the
    stored case of a run.
    """
    soft = {"youngs_modulus": 70e9, "poisson_ratio": 0.3, "density": 2700.0, "yield_strength": 3e8}
    quoted = '"' + name.replace('"', '""') + '"'
    (tmp_path / "a.csv").write_text(
        f"x,y,z,diameter,material,group\n0,0,0,0.01,{quoted},{quoted} # hard\n", "utf-8"
    )
    case = case_from_dict(
        {
            "material": {"preset": "brass", "name": name},
            "materials": {name: soft},
            "packing": {"kind": "file", "file": str(tmp_path / "a.csv")},
            "grains": [
                {"at": [[0, 0, 0.01]], "diameter": 0.01, "material": name, "group": f"{name}2"}
            ],
            "hold": [{"group": f"{name}2", "directions": "x"}],
            "load": {"index": [1]},
        },
        "case",
    )
    assert case.packing.grains is not None
    assert (case.packing.grains.material, case.packing.grains.group) == (
        (name, name),
        (name, f"{name}2"),
    )
    (tmp_path / "case.toml").write_text(case.to_toml(), "utf-8")
    again = load_case(tmp_path / "case.toml")
    assert dataclasses.replace(again, packing=case.packing) == case
    assert again.packing.grains == case.packing.grains
