"""Materials, pairs of materials, and the roots of their equations."""

from __future__ import annotations

import math
import re
import tomllib
from argparse import Namespace
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq as scipy_brentq

from granwave.analysis.figures.style import write_csv
from granwave.extensions.continuum.terminal import fit
from granwave.lammps_inputs import flat_contact, pair_contact, write_deck
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact.contact import hertz_von_mises_yield_factor
from granwave.lammps_inputs.case.material import load_materials, material, presets
from granwave.lammps_inputs.case.run import BALANCE_TOLERANCE as TOLERANCE
from granwave.lammps_inputs.contact.law import contact_of, sphere_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict, load_case
from granwave.lammps_inputs.roots import brentq
from granwave.workflows.run.driver import run_case
from tests.helpers.twins.twin import OTHER

PACKING = '[packing]\nkind = "chain"\nsize = 5\ndiameter = 0.01\n'


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("brass", (115e9, 0.30, 8500, 550e6)),
        ("steel", (210e9, 0.30, 7850, 700e6)),
        ("aluminium", (67e9, 0.30, 2700, 150e6)),
        (
            "stainless-steel",
            (209e9, 0.28, 7925, None),
        ),  # densities in kg/m^3, printed in their source as g/m^3
        ("brass-composite", (103e9, 0.34, 8398, None)),
        ("ptfe", (1.46e9, 0.46, 1870, None)),
        ("glass", (70e9, 0.20, 2500, None)),
        ("alumina", (416e9, 0.231, 3984, None)),
        ("zirconia", (205e9, 0.30, 6050, None)),
        ("acrylic", (3.3e9, 0.37, 1190, None)),
        ("nylon", (2.93e9, 0.41, 1150, None)),
    ],
)
def test_presets_are_those_of_their_sources(name: str, values: tuple[float | None, ...]) -> None:
    found = material(name)
    assert (
        found.youngs_modulus,
        found.poisson_ratio,
        found.density,
        found.yield_strength,
    ) == values


def longitudinal_speed(name: str) -> float:
    """Speed of sound that the constants of a preset give, m/s."""
    solid = material(name)
    ratio = solid.poisson_ratio
    constrained = solid.youngs_modulus * (1 - ratio) / ((1 + ratio) * (1 - 2 * ratio))
    return math.sqrt(constrained / solid.density)


@pytest.mark.parametrize(
    ("name", "measured", "below"),
    [
        # by ultrasound: Olympus 45MG, user's manual, table 28 (nylon); Onda, acoustic properties of
        # plastics (acrylic). Polymers are stiffer there than in the slow tension of data sheets.
        ("nylon", 2600.0, 0.064),
        ("acrylic", 2670.0, 0.171),
    ],
)
def test_sound_in_polymers_is_faster_than_their_static_moduli_give(
    name: str, measured: float, below: float
) -> None:
    assert 1 - longitudinal_speed(name) / measured == pytest.approx(below, abs=0.002)


def test_alumina_has_the_bulk_modulus_of_its_source() -> None:
    solid = material("alumina")
    bulk = solid.youngs_modulus / (3 * (1 - 2 * solid.poisson_ratio))
    assert bulk == pytest.approx(257e9, rel=5e-3)


@pytest.mark.parametrize("name", ["glass", "alumina", "zirconia", "acrylic", "nylon", "ptfe"])
def test_what_has_no_yield_strength_is_elastic_or_says_what_is_missing(name: str) -> None:
    """A chain of the material passes with Hertz's law; the elasto-plastic law requires the
    strength.
    """
    packing = {"kind": "chain", "size": 4, "diameter": 0.01}
    tables = {"name": "beads", "packing": packing, "material": name}
    assert case_from_dict({**tables, "contact": {"law": "hertz"}}).material.name == name
    with pytest.raises(InputError, match=f'preset = "{name}", yield_strength'):
        case_from_dict(tables)


def test_every_preset_names_its_source() -> None:
    assert len(presets()) >= 15
    for name, preset in presets().items():
        assert preset.name == name
        assert preset.source


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def test_preset_from_the_users_file_relative_to_the_case(tmp_path: Path) -> None:
    write(
        tmp_path / "mine.toml",
        "[glass]\nyoungs_modulus = 70e9\npoisson_ratio = 0.22\ndensity = 2500\nsource = 'us'\n",
    )
    own = '[material]\npreset = "glass"\nfile = "mine.toml"\n{}[contact]\nlaw = "hertz"\n'
    plain, lighter = (load_case(write(tmp_path / "c.toml", PACKING + own.format(more))).material
                      for more in ("", "density = 2600\n"))  # fmt: skip
    assert (plain.name, plain.youngs_modulus, plain.density, plain.source) == (
        "glass",
        70e9,
        2500,
        "us",
    )
    assert (lighter.youngs_modulus, lighter.density, lighter.source) == (
        70e9,
        2600,
        None,
    )  # changed values lose it


def test_a_file_of_materials_reports_every_fault(tmp_path: Path) -> None:
    path = write(
        tmp_path / "m.toml",
        "a = 3\n[b]\nyoungs_modulus = -1\npoisson_ratio = 0.6\ndensity = true\n",
    )
    with pytest.raises(InputError) as caught:
        load_materials(path)
    assert len(caught.value.errors) == 4


def test_yield_factor() -> None:
    # K. L. Johnson, Contact Mechanics (1985), section 4.2: 1.60 for nu = 0.3, of 1.613 unrounded
    assert hertz_von_mises_yield_factor(0.3) == pytest.approx(1.6128, abs=5e-5)
    # R. L. Jackson, I. Green, J. Tribol. 127 (2005) 343: C = 1.295 exp(0.736 nu)
    for ratio in (0.0, 0.1, 0.2, 0.3, 0.4, 0.49):
        assert hertz_von_mises_yield_factor(ratio) == pytest.approx(
            1.295 * math.exp(0.736 * ratio), rel=6e-3
        )


R = 0.005


def make(kind: str = "chain", size: Any = 4, **sections: Any) -> Case:
    packing = {"kind": kind, "size": size, "diameter": 2 * R}
    return case_from_dict({"name": "pairs", "packing": packing, "material": "brass", **sections})


def script(case: Case, directory: Path) -> str:
    return write_deck(case, directory).script.read_text()


def coefficients(text: str) -> dict[str, str]:
    """Argument of the keyword friction, or the whole law, by types or by the name of a wall."""
    found = dict(re.findall(r"^pair_coeff +(\d \d) (.*)$", text, re.M))
    return found | dict(re.findall(r"^fix +(\w+) \w+ wall/gran/hysteretic (.*)$", text, re.M))


THREE_LAWS: dict[str, Any] = {
    "replace": [{"index": 2, "material": "steel"}],
    "pair": [
        {"materials": ["brass", "steel"], **OTHER},
        {"materials": ["brass", "rigid"], "law": "bilinear", "beta": 0.5},
        {"materials": ["steel", "steel"], "law": "hertz"},
    ],
}


def test_a_deck_without_friction_has_no_trace_of_it(tmp_path: Path) -> None:
    text = script(make("fcc", [5, 5, 3], boundary={"sides": "wall"}), tmp_path)
    for word in (
        " friction ",
        "nve/sphere",
        "vel yes",
        "omega",
        "rotational",
        "elastic_tangential",
        "c_contact[6]",
    ):
        assert word not in text


def test_friction_of_contacts_and_of_walls(tmp_path: Path) -> None:
    text = script(make("fcc", [5, 5, 3], contact={"friction": 0.3}), tmp_path / "all")
    assert all(law.endswith("friction 0.3") for law in coefficients(text).values())
    for line in (
        r"fix +motion all gran/nve/sphere",
        r"variable +elastic equal c_contact\+f_bottom\[4\]\+v_elastic_tangential",
        r"variable +friction equal c_contact\[7\]\+f_bottom\[9\]",
    ):
        assert re.search(f"^{line}$", text, re.M), line
    boundary = {"sides": "wall", "friction": 0.1}
    case = make("fcc", [5, 5, 3], contact={"friction": 0.3}, boundary=boundary)
    found = coefficients(script(case, tmp_path / "walls"))
    assert found["1 1"].endswith("friction 0.3")
    assert all(found[name].endswith("friction 0.1") for name in ("bottom", "xlo", "yhi"))


def test_friction_of_pairs(tmp_path: Path) -> None:
    pairs = [
        {"materials": ["steel", "brass"], "friction": 0.5},
        {"materials": ["brass", "rigid"], "friction": 0.2},
        {"materials": ["steel", "steel"], "law": "hertz"},
    ]
    case = make("fcc", [5, 5, 3], replace=[{"index": [1, 2], "material": "steel"}], pair=pairs)
    found = coefficients(script(case, tmp_path))
    assert found["1 2"].endswith("friction 0.5") and found["bottom"].endswith("friction 0.2")
    assert found["2 2"] == "hertz 2.1e+11 0.3"
    assert "friction" not in found["1 1"] and "friction" not in found["bottom_2"]
    assert case_from_dict(case.to_dict()) == case


def test_faces_of_bars_have_no_friction_and_nodes_do_not_turn(tmp_path: Path) -> None:
    bar = {"length": 0.1, "area": 1e-4, "elements": 5, "material": "steel"}
    text = script(make(contact={"friction": 0.3}, bar=bar), tmp_path)
    found = coefficients(text)
    assert found["1 1"].endswith("friction 0.3") and "friction" not in found["1 3"]
    assert re.search(r"^fix +motion mobile gran/nve/sphere\nfix +motion_bar bar nve$", text, re.M)


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_balance_with_angle_and_spin(tmp_path: Path, friction: float) -> None:
    load = {"velocity": 3.0, "angle": 40.0, "spin": [0.0, 200.0, 50.0]}
    case = make("fcc", [5, 5, 3], load=load, contact={"friction": friction}, run={"end_time": 1e-4})
    outcome = run_case(case, tmp_path / "r", figures=False)
    given = 0.5 * case.sphere_mass * 9.0 + 0.2 * case.sphere_mass * R**2 * (200.0**2 + 50.0**2)
    assert outcome.summary["energy_input_J"] == pytest.approx(given, rel=1e-12)
    assert outcome.summary["energy_balance_error"] < TOLERANCE
    lines = (tmp_path / "r" / "dumps" / "energy.txt").read_text().splitlines()
    last = dict(zip(lines[1].lstrip("#").split(), map(float, lines[-1].split()), strict=True))
    assert (last.get("friction", 0.0) > 1e-6) == (friction > 0) and last["rotational"] > 0
    text = (tmp_path / "r" / "in.granwave").read_text()
    velocity = re.search(r"^velocity +hit set (\S+) 0.0 (\S+) units box$", text, re.M)
    assert velocity is not None
    expected = [3 * math.sin(math.radians(40)), 3 * math.cos(math.radians(40))]
    assert [float(part) for part in velocity.groups()] == pytest.approx(expected)
    assert re.search(r"^set +group hit omega 0.0 200 50$", text, re.M)


def test_a_spinning_striker(tmp_path: Path) -> None:
    striker = [{"touches": 1, "spin": [0.0, 300.0, 0.0], "velocity": [0.0, 0.0, 1.0]}]
    case = make(striker=striker, contact={"friction": 0.3}, run={"end_time": 5e-5})
    outcome = run_case(case, tmp_path / "r", figures=False)
    assert outcome.state == "finished" and outcome.summary["energy_balance_error"] < TOLERANCE


def test_every_law_asked_for_is_that_of_the_pair(tmp_path: Path) -> None:
    """In the compiled laws and in a run, peak force and indentation of the contact are on the
    loading curve of the pair.
    """
    import h5py

    case = make(**THREE_LAWS, run={"end_time": 5e-5})
    law = pair_contact(case, 1, 2)
    brass = material("brass")
    assert law.constants == pytest.approx(contact_of([brass], [R], constants=OTHER).constants)
    assert pair_contact(case, 2, 2).name == "hertz"
    assert (
        flat_contact(case, 1).name == "bilinear" and flat_contact(case, 2).name == "elastoplastic"
    )
    assert sphere_contact(case).constants != law.constants
    assert run_case(case, tmp_path / "r", figures=False).summary["energy_balance_error"] < TOLERANCE
    with h5py.File(tmp_path / "r" / "result.h5") as file:
        peak, force, alone = (
            file[f"contacts/{name}"][0] for name in ("peak_overlap", "peak_force", "yield_overlap")
        )
    assert alone == pytest.approx(law.yield_overlap) and peak > 5 * alone
    assert force == pytest.approx(float(law.loading_force(np.array([peak]))[0]), rel=1e-6)


def test_only_who_yields_needs_a_strength() -> None:
    soft = {"name": "soft", "youngs_modulus": 1e9, "poisson_ratio": 0.4, "density": 1e3}
    sections = {"replace": [{"index": 2, "material": soft}]}
    with pytest.raises(InputError, match=r"replace.1.material.yield_strength: missing"):
        make(**sections)
    make(**sections, pair=[{"materials": ["soft", "soft"], "law": "hertz"}])


def test_a_fitted_curve_becomes_a_pair(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Law of a pair from a computed curve: constants by `granwave fit`, and the table in a case."""
    materials = [material("steel"), material("brass")]
    law = contact_of(materials, [R, R], constants=OTHER)
    cycles = [
        np.linspace(0, 60, 80),
        *(np.linspace(*ends, 60)[1:] for ends in ((60, 30), (30, 150), (150, 120))),
    ]
    cycles += [np.linspace(*ends, 80)[1:] for ends in ((120, 300), (300, 270))]
    overlap = np.concatenate(cycles) * law.yield_overlap
    force = law.force(overlap, np.maximum.accumulate(overlap))
    write_csv({"overlap_m": overlap, "force_N": force}, tmp_path / "curve.csv")
    asked = Namespace(
        curve=tmp_path / "curve.csv", directory=tmp_path / "fit", material=["steel", "brass"], radius=[R], free=None,
        fit_yield=False, fit_zero=False, force=False, pair=["steel", "brass"],
    )  # fmt: skip
    assert fit(asked) == 0
    table = (tmp_path / "fit" / "pair.toml").read_text()
    assert table.strip() in capsys.readouterr().out
    assert tomllib.loads(table)["pair"][0]["materials"] == ["steel", "brass"]
    text = (
        'material = "brass"\n[packing]\nkind = "chain"\nsize = 3\ndiameter = 0.01\n'
        '[[replace]]\nindex = 2\nmaterial = "steel"\n' + table
    )
    (tmp_path / "case.toml").write_text(text)
    case = load_case(tmp_path / "case.toml")
    assert pair_contact(case, 1, 2).constants == pytest.approx(OTHER, rel=1e-3)
    assert pair_contact(case, 1, 2).loading_force(overlap[60]) == pytest.approx(force[60], rel=1e-6)
    assert sphere_contact(case).constants == contact_of([material("brass")], [R]).constants


FUNCTIONS: dict[str, tuple[Callable[[float], float], float, float]] = {
    "cosine": (math.cos, 0.0, 3.0),
    "steep": (lambda x: math.exp(20 * x) - 3, -4.0, 5.0),
    "kinked": (lambda x: x - 0.1 if x < 0.1 else 1e3 * (x - 0.1), -7.0, 2.0),
    "stepped": (lambda x: -1.0 if x < 1 / 3 else 1.0, 0.0, 1.0),
    "work": (lambda x: math.log(math.exp(2.5 * x) * (1 + math.exp(x)) / 0.07), -60.0, 3.0),
}


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("xtol", [1e-3, 1e-10, 1e-16])
def test_same_zero_as_scipy(name: str, xtol: float) -> None:
    function, low, high = FUNCTIONS[name]
    found = brentq(function, low, high, xtol=xtol)
    assert found == pytest.approx(
        scipy_brentq(function, low, high, xtol=xtol), rel=1e-14, abs=1e-3 * xtol
    )
    assert brentq(function, high, low, xtol=xtol) == pytest.approx(found, rel=1e-12, abs=xtol)


def test_same_places_as_scipy() -> None:
    """Enough cubic functions to use every branch; they are evaluated at the same points."""
    rng = np.random.default_rng(3)
    for _ in range(200):
        a, b, c = rng.normal(size=3) * 10.0 ** rng.integers(-3, 3, 3)
        bound = 2 + abs(a) + abs(b) + abs(c)
        seen = []
        zeros = []
        for solver in (brentq, scipy_brentq):
            seen.append([])

            def cubic(
                x: float, seen: list[float] = seen[-1], a: float = a, b: float = b, c: float = c
            ) -> float:
                seen.append(x)
                return x**3 + a * x**2 + b * x + c

            zeros.append(solver(cubic, -bound, bound, xtol=1e-12, rtol=1e-10))
        assert zeros[0] == pytest.approx(zeros[1], rel=1e-14)
        assert len(seen[0]) == len(seen[1])
        np.testing.assert_allclose(*seen, rtol=1e-12)


def test_zeros_at_a_bound_and_none() -> None:
    assert brentq(lambda x: x, 0.0, 1.0, xtol=1e-12) == 0.0
    assert brentq(lambda x: x - 1, 0.0, 1.0, xtol=1e-12) == 1.0
    with pytest.raises(ValueError, match="expected different signs, found 2 at 1 and 5 at 2"):
        brentq(lambda x: x * x + 1, 1.0, 2.0, xtol=1e-12)
    with pytest.raises(RuntimeError, match="found no zero in 100 steps"):
        brentq(lambda x: math.nan if 0 < abs(x) < 1 else x + 2e-300, -1.0, 1.0, xtol=1e-12)
