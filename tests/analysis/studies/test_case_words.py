"""Descriptions of the struck object in titles of studies."""

from __future__ import annotations

from typing import Any

import pytest

from granwave.analysis.studies.titles import bottom_label, impact_title, load_label, packing_title, time_label
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.load_case import case_from_dict


def made(kind: str = "fcc", size: Any = (6, 5, 4), material: Any = "brass", **sections: Any) -> Case:
    packing = {"kind": kind, "size": list(size) if isinstance(size, tuple) else size, "diameter": 0.00952}
    return case_from_dict({"name": "words", "packing": packing, "material": material, **sections})


@pytest.mark.parametrize(
    ("kind", "size", "words", "of_any_height"),
    [
        ("fcc", (6, 5, 4), "FCC packing of 6 x 5 x 4 brass spheres of 9.52 mm", "FCC packing of 6 x 5 brass spheres of 9.52 mm a layer"),
        ("sc", (6, 5, 4), "Simple cubic packing of 6 x 5 x 4 brass spheres of 9.52 mm", "Simple cubic packing of 6 x 5 brass spheres of 9.52 mm a layer"),
        ("square", (6, 5), "Square packing of 6 x 5 brass spheres of 9.52 mm", "Square packing of 6 x 5 brass spheres of 9.52 mm"),
        ("chain", 20, "Chain of 20 brass spheres of 9.52 mm", "Chain of brass spheres of 9.52 mm"),
        ("chain", 1, "Brass sphere of 9.52 mm", "Chain of brass spheres of 9.52 mm"),
    ],
)  # fmt: skip
def test_packings(kind: str, size: Any, words: str, of_any_height: str) -> None:
    load = (
        {"load": {"kind": "striker"}, "striker": [{"touches": 1, "velocity": [0.3, 0.4, 0]}]}
        if kind == "square"
        else {}
    )
    case = made(kind, size, **load)
    assert packing_title(case) == words
    assert packing_title(case, height=False) == of_any_height


def test_a_material_without_a_name() -> None:
    own = {"youngs_modulus": 1e11, "poisson_ratio": 0.3, "density": 8000, "yield_strength": 5e8}
    assert packing_title(made("chain", 3, own)) == "Chain of 3 spheres of 9.52 mm"
    assert packing_title(made("chain", 1, own)) == "Sphere of 9.52 mm"


def test_loads() -> None:
    assert impact_title(made(load={"velocity": 2.5}, contact={"law": "hertz"})).endswith(", elastic contacts, 2.5 m/s")
    assert load_label(made(load={"velocity": 5, "angle": 30})) == "5 m/s"
    force = {"kind": "force", "shape": "half-sine", "amplitude": 100.0, "duration": 1e-5}
    assert load_label(made("chain", 3, load=force)) == "force on top"
    strikers = [{"touches": 1, "velocity": [0, 0, 0.6]}, {"touches": 2, "velocity": [0, 0.6, 0.8]}]
    assert load_label(made(load={"kind": "striker"}, striker=strikers)) == "1 m/s"


@pytest.mark.parametrize(
    ("bottom", "words"),
    [
        ("wall", "rigid wall"),
        ("fixed", "fixed last layer"),
        ("free", "no bottom"),
        ({"material": "steel"}, "steel wall"),
        ({"plate": {"mass": 0.5, "stiffness": 2e8}}, "plate of 0.5 kg, 314 µs"),
        ({"plate": {"mass": 1.0, "stiffness": 1e6, "damping": 10.0}, "material": "steel"}, "plate of 1 kg, 6.28 ms, damped"),
        ({"half_space": {}, "material": "steel"}, "steel half-space"),
        ({"half_space": {"radius": 0.05}, "material": "steel"}, "steel half-space, disc of 50 mm"),
        ({"bar": {"length": 1, "area": 0.0125}, "material": "steel"}, "steel bar of 125 cm²"),
        ({"bar": {"length": 1, "area": 0.0125, "end": "fixed"}, "material": "steel"}, "steel bar of 125 cm², far end fixed"),
    ],
)  # fmt: skip
def test_bottoms(bottom: Any, words: str) -> None:
    assert bottom_label(made(boundary={"bottom": bottom})) == words


def test_times() -> None:
    assert [time_label(time) for time in (2.5e-5, 9.99e-4, 1e-3)] == ["25 µs", "999 µs", "1 ms"]
