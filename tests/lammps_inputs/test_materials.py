"""Materials: presets, files of the user, and the yield factor."""

from __future__ import annotations

from pathlib import Path

import pytest

from granwave.lammps_inputs.case.contact import hertz_von_mises_yield_factor
from granwave.lammps_inputs.case.material import load_materials, material, presets
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import load_case

PACKING = '[packing]\nkind = "chain"\nsize = 5\ndiameter = 0.01\n'


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("brass", (115e9, 0.30, 8500, 550e6)),
        ("steel", (210e9, 0.30, 7850, 700e6)),
        ("aluminium", (67e9, 0.30, 2700, 150e6)),
        ("stainless-steel", (209e9, 0.28, 7925, None)),  # densities in kg/m^3, printed in their source as g/m^3
        ("brass-composite", (103e9, 0.34, 8398, None)),
        ("ptfe", (1.46e9, 0.46, 1870, None)),
    ],
)
def test_presets_are_those_of_their_sources(name: str, values: tuple[float | None, ...]) -> None:
    found = material(name)
    assert (found.youngs_modulus, found.poisson_ratio, found.density, found.yield_strength) == values


def test_every_preset_names_its_source() -> None:
    assert len(presets()) >= 7
    for name, preset in presets().items():
        assert preset.name == name
        assert preset.source


def test_an_unknown_preset_names_the_nearest() -> None:
    with pytest.raises(InputError, match="did you mean aluminium"):
        material("aluminum")


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def test_preset_from_the_users_file_relative_to_the_case(tmp_path: Path) -> None:
    write(tmp_path / "mine.toml", "[glass]\nyoungs_modulus = 70e9\npoisson_ratio = 0.22\ndensity = 2500\n")
    case = write(
        tmp_path / "c.toml",
        PACKING + '[material]\npreset = "glass"\nfile = "mine.toml"\ndensity = 2600\n[contact]\nlaw = "hertz"\n',
    )
    found = load_case(case).material
    assert (found.name, found.youngs_modulus, found.density, found.yield_strength) == (
        "glass",
        70e9,
        2600,
        None,
    )


def test_changed_values_lose_their_source(tmp_path: Path) -> None:
    case = write(tmp_path / "c.toml", PACKING + '[material]\npreset = "brass"\nyield_strength = 4e8\n')
    found = load_case(case).material
    assert found.yield_strength == 4e8
    assert found.youngs_modulus == 115e9
    assert found.source is None


@pytest.mark.parametrize(
    ("table", "fault"),
    [
        ('preset = "brass"\nfile = "nowhere.toml"', "material.file: .*no such file"),
        ('preset = "gold"\nfile = "mine.toml"', 'material.preset: found "gold", expected one of glass'),
        ('file = "mine.toml"', "material.preset: missing"),
        ("preset = 3", "material.preset: found 3"),
        ('preset = "brass"\nfile = 3', "material.file: found 3"),
        (
            'preset = "brass"\nyoungs_module = 3',
            "material.youngs_module: unknown key; did you mean youngs_modulus",
        ),
        ('preset = "brass"\nfile = "broken.toml"', "broken.toml: lead.density: missing"),
    ],
)
def test_bad_material_tables(tmp_path: Path, table: str, fault: str) -> None:
    write(tmp_path / "mine.toml", "[glass]\nyoungs_modulus = 70e9\npoisson_ratio = 0.22\ndensity = 2500\n")
    write(tmp_path / "broken.toml", "[lead]\nyoungs_modulus = 16e9\npoisson_ratio = 0.44\n")
    with pytest.raises(InputError, match=fault):
        load_case(write(tmp_path / "c.toml", PACKING + "[material]\n" + table))


def test_a_file_of_materials_reports_every_fault(tmp_path: Path) -> None:
    path = write(tmp_path / "m.toml", "a = 3\n[b]\nyoungs_modulus = -1\npoisson_ratio = 0.6\ndensity = true\n")
    with pytest.raises(InputError) as caught:
        load_materials(path)
    assert len(caught.value.errors) == 4


def test_yield_factor_at_poisson_ratio_0_3() -> None:
    # K. L. Johnson, Contact Mechanics (1985), section 4.2: 1.60 for nu = 0.3, of 1.613 unrounded
    assert hertz_von_mises_yield_factor(0.3) == pytest.approx(1.6128, abs=5e-5)


def test_yield_factor_follows_the_published_fit() -> None:
    # R. L. Jackson, I. Green, J. Tribol. 127 (2005) 343: C = 1.295 exp(0.736 nu)
    for ratio in (0.0, 0.1, 0.2, 0.3, 0.4, 0.49):
        fit = 1.295 * 2.718281828459045 ** (0.736 * ratio)
        assert hertz_von_mises_yield_factor(ratio) == pytest.approx(fit, rel=6e-3)
