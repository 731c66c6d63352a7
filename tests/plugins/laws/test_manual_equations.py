"""Equations of the manual page of the pair style, evaluated and compared with the compiled laws."""

from __future__ import annotations

import re

import pytest

from granwave._contact_laws import ContactLaw
from tests.helpers.formulas import equations, expression, value
from tests.helpers.manual import PAGES

PAGE = (PAGES / "pair_gran_hysteretic.md").read_text(encoding="utf-8")
E = (115e9, 210e9)
NU = (0.34, 0.28)
STRENGTH = (550e6, 900e6)
RADIUS = (0.005, 0.003)
LAWS = ("hertz", "elastoplastic", "elastoplastic-fe", "thornton", "bilinear", "power")
OVERLAPS = [0.5, 1.05, 3.0, 40.0, 150.0, 177.6, 400.0]


def part(title: str, level: str = "###") -> str:
    """Section of the page."""
    (text,) = re.findall(rf"(?ms)^{level} {title}\n(.*?)(?=^##)", PAGE)
    return text


def law_part(name: str) -> dict[str, str]:
    """Equations of a law of the page."""
    text = part("Laws")
    start = text.index(f"**{name}**")
    ends = [text.find(f"\n**{other}**", start + 1) for other in LAWS]
    return equations(text[start : min(end for end in ends if end > start)])


def contact(law: str, **options: object) -> ContactLaw:
    return ContactLaw(
        law,
        youngs_modulus=E,
        poisson_ratio=NU,
        yield_strength=STRENGTH,
        radius=RADIUS,
        **options,
    )


def variant(column: int) -> dict[str, float]:
    """Constants of a variant in the table of the page, for the yield factor 1.6."""
    rows = re.findall(r"(?m)^\| \$(p_y|m)\$ \| \$?(.*?)\$? \| (.*?) \|$", PAGE)
    constants = {}
    for name, *cells in rows:
        formula, _, number = cells[column].partition("=")
        formula = re.sub(r"ln\\,([\d.]+)", r"ln(\1)", formula)
        constants[name] = value(formula, {"C": 1.6})
        assert not number or f"{constants[name]:.6f}" == number.strip()
    assert set(constants) == {"p_y", "m"}
    return constants


def test_scales_follow_the_page():
    names = {"C": 1.6}
    for number, body in enumerate("ij"):
        names[f"R_{body}"] = RADIUS[number]
        names[f"E_{body}"] = E[number]
        names[f"nu_{body}"] = NU[number]
        names[f"sigma_y{body}"] = STRENGTH[number]
    sides = equations(part("Scales of a contact"))
    names["R_star"] = 1 / value(sides[r"\frac{1}{R^*}"], names)
    names["E_star"] = 1 / value(sides[r"\frac{1}{E^*}"], names)
    names["sigma_y"] = value(sides[r"\sigma_y"], names)
    names["alpha_y"] = value(sides[r"\alpha_y"], names)
    law = contact("elastoplastic")
    assert names["R_star"] == pytest.approx(law.effective_radius, rel=1e-14, abs=0)
    assert names["E_star"] == pytest.approx(law.effective_modulus, rel=1e-14, abs=0)
    assert names["alpha_y"] == pytest.approx(law.yield_overlap, rel=1e-12, abs=0)
    assert value(sides["F_y"], names) == pytest.approx(law.yield_force, rel=1e-12, abs=0)


def assert_curve(law: ContactLaw, sides: dict[str, str], names: dict[str, object], a: float):
    """Compare the force on loading, the residual overlap and the force on unloading."""
    unit = law.yield_overlap
    force = value(sides["f"], {**names, "a": a})
    assert force == pytest.approx(law.loading_force(a * unit) / law.yield_force, rel=1e-12, abs=0)
    if a <= 1:
        return
    residual = a_residual(sides, {**names, "a_max": a, "f_max": force})
    assert residual == pytest.approx(law.residual_overlap(a * unit) / unit, rel=1e-9, abs=0)
    middle = (a + residual) / 2
    unloading = equations(part("Scales of a contact"))["f"]
    exponent = law.unloading_exponent(a * unit)
    known = {"a": middle, "a_R": residual, "a_max": a, "f_max": force, "n": exponent}
    expected = law.force(middle * unit, a * unit) / law.yield_force
    assert value(unloading, known) == pytest.approx(expected, rel=1e-9, abs=0)


def a_residual(sides: dict[str, str], names: dict[str, object]) -> float:
    """Residual overlap, with the flattened radius r of Thornton's law."""
    if "r" in sides:
        names = {**names, "r": value(sides["r"], names)}
    return value(sides["a_R"], names)


@pytest.mark.parametrize("a", OVERLAPS)
@pytest.mark.parametrize("name", ["continuous", "published"])
def test_elastoplastic_follows_the_page(name, a):
    law = contact("elastoplastic", variant=name)
    sides = law_part("elastoplastic")
    names = {"C": 1.6, "K": 1.5 / 1.6, **variant(["continuous", "published"].index(name))}
    names["A"] = lambda overlap: value(sides["A"], {**names, "a": overlap})
    names["p"] = lambda overlap: value(sides["p"], {**names, "a": overlap})
    assert_curve(law, sides, names, a)


@pytest.mark.parametrize("a", OVERLAPS)
@pytest.mark.parametrize("factor", [1.3, 1.6])
def test_thornton_follows_the_page(factor, a):
    law = contact("thornton", yield_factor=factor)
    assert_curve(law, law_part("thornton"), {"C": factor, "K": 1.5 / factor}, a)
    assert "the unloading exponent is $n = 1.5$" in PAGE
    assert law.unloading_exponent(a * law.yield_overlap) == 1.5


@pytest.mark.parametrize("a", OVERLAPS)
def test_hertz_and_bilinear_follow_the_page(a):
    hertz = contact("hertz")
    alpha = a * contact("elastoplastic").yield_overlap
    names = {
        "E_star": hertz.effective_modulus,
        "R_star": hertz.effective_radius,
        "alpha": alpha,
        "sigma_y": min(STRENGTH),
    }
    force = value(law_part("hertz")["F"], names)
    assert force == pytest.approx(hertz.loading_force(alpha), rel=1e-12, abs=0)
    bilinear = contact("bilinear", beta=0.7)
    sides = re.findall(r"(?m)^F = k .alpha, .qquad k = (.*)$", PAGE)
    names |= {"k": value(sides[0], names), "b": 0.7}
    assert names["k"] * alpha == pytest.approx(bilinear.loading_force(alpha), rel=1e-12, abs=0)
    unloading = law_part("bilinear")["F"]
    for share in (0.3, 0.69, 0.71, 0.95):
        known = {**names, "alpha": share * alpha, "alpha_max": alpha}
        expected = bilinear.force(share * alpha, alpha)
        assert value(unloading, known) == pytest.approx(expected, rel=1e-9, abs=0)


@pytest.mark.parametrize("x", [1.1, 1.3, 1.7, 2.5, 8.0])
def test_jkr_follows_the_page(x):
    """Overlap, force and stored energy for the radius x^2 a_f of the contact circle."""
    law = contact("hertz", cohesion=("jkr", 0.5))
    begin, _, end = part("Cohesion").partition("The contact forms when")
    curve = equations(begin)
    limits = equations(end.partition("**dmt**")[0])
    names = {"E_star": law.effective_modulus, "R_star": law.effective_radius, "W": 0.5}
    names["a_f"] = value(limits["a_f^3"], names) ** (1 / 3)
    (width,) = re.findall(r"contact circle and \$s = (.*?)\$", begin)
    names["s"] = value(width, names)
    names["x"] = x
    names["a_c"] = x**2 * names["a_f"]
    alpha = value(curve[r"\alpha"], names)
    peak = max(alpha, 1e-7)  # surfaces that have met
    assert value(curve["F"], names) == pytest.approx(float(law.force(alpha, peak)), rel=1e-9, abs=0)
    stored = float(law.elastic_energy(alpha, peak))
    assert value(limits["U"], names) == pytest.approx(stored, rel=1e-9, abs=0)
    largest = value(r"\frac{3}{2} \pi W R^*", names)
    assert r"$\tfrac{3}{2} \pi W R^*$" in end
    assert law.pull_off_force == pytest.approx(largest, rel=1e-12, abs=0)


@pytest.mark.parametrize("a", [0.5, 3.0, 150.0, 400.0])
@pytest.mark.parametrize("share", [1.0, 0.99])
def test_the_contact_circle_and_its_stiffness_follow_the_page(share, a):
    law = contact("elastoplastic")
    sections = part("Friction").partition("Below the peak of a yielded contact")
    unit = law.yield_overlap
    sides = law_part("elastoplastic")
    area = {"A": lambda overlap: value(sides["A"], {**variant(0), "a": overlap})}
    names = {"R_star": law.effective_radius, "alpha_y": unit, "alpha": a * unit}
    if a < 1:  # while the contact is Hertzian
        area["A"] = float
    square = value(equations(sections[0])["a_c^2"], {**names, **area})
    if share < 1 < a:
        names |= {"alpha": share * a * unit, "alpha_max": a * unit, "a_cmax": square**0.5}
        names["alpha_R"] = float(law.residual_overlap(a * unit))
        below = equations(sections[2])["a_c^2"].replace("_{c,\\text{max}}^2", "_{c,max}^2")
        square = value(below, names)
    overlap = names["alpha"]
    assert square**0.5 == pytest.approx(
        float(law.contact_radius(overlap, a * unit)), rel=1e-9, abs=0
    )
    names |= {"G_star": law.shear_modulus, "a_c": square**0.5}
    stiffness = float(law.tangential_stiffness(overlap, a * unit))
    assert value(equations(sections[0])["k_t"], names) == pytest.approx(stiffness, rel=1e-9, abs=0)


def test_a_formula_with_an_unknown_command_is_an_error():
    with pytest.raises(AssertionError):
        expression(r"\frac{a}{b} \otimes c")
