"""Single contacts in Python: values of the literature, inverse and derivatives, invalid input."""

from __future__ import annotations

import logging
import math

import numpy as np
import pytest
from scipy.special import ellipe, ellipk

import granwave as gw
from granwave.lammps_inputs import material, pair_contact
from granwave.lammps_inputs.contact.law import contact_of
from granwave.workflows.python import contacts

BRASS = {"youngs_modulus": 115e9, "poisson_ratio": 0.30}
MODULUS = 115e9 / (1 - 0.3**2)  # one brass body on a rigid one, Pa
BALL = {"shape": "sphere", "radius": 4.7625e-3, "material": "brass"}
ROD = {"shape": "cylinder", "diameter": 4.76e-3, "length": 9.525e-3, "material": BRASS}
SOFT = {
    "shape": "cylinder",
    "radius": 6.35e-3,
    "length": 1.0,
    "material": {"youngs_modulus": 90e6, "poisson_ratio": 0},
}


@pytest.fixture(autouse=True)
def nothing_warned_about(monkeypatch):
    """Reset the warnings, so that each test receives the warnings of its contacts."""
    monkeypatch.setattr(contacts, "_warned", set())


def test_error_bars_come_with_the_force():
    """Law elastoplastic-fe has a bar within the range of its fit; other laws have NaN."""
    bodies = [BALL, {"shape": "plane"}]
    overlap = np.array([[1e-7, 1e-5], [1e-4, 1e-3]])
    force, bar = gw.contact_force("elastoplastic-fe", bodies, overlap, error=True)
    np.testing.assert_array_equal(force, gw.contact_force("elastoplastic-fe", bodies, overlap))
    assert bar.shape == overlap.shape and np.isnan(bar[1, 1])  # beyond 0.2 R*
    within = bar.ravel()[:3] / force.ravel()[:3]
    assert within[0] == 0 and np.all((within[1:] > 0.01) & (within[1:] < 0.1))
    unloaded, bar = gw.contact_force(
        "elastoplastic-fe", bodies, 0.9e-4, peak_overlap=1e-4, error=True
    )
    assert isinstance(bar, float) and bar > 0.02 * unloaded
    for law in ("elastoplastic", "hertz"):
        assert math.isnan(gw.contact_force(law, bodies, 1e-5, error=True)[1])


def test_a_sphere_on_a_cylinder_of_the_thesis():
    """Thesis 7.2, with its radius of 2.38 mm: K = 4.528092e9 N/m^1.5."""
    overlap = np.array([[1e-8, 1e-7], [1e-6, -1e-6]])
    force = gw.contact_force("hertz", [BALL, {**ROD, "diameter": 2 * 2.38e-3}], overlap)
    assert force == pytest.approx(4.528092e9 * np.maximum(overlap, 0) ** 1.5, rel=2e-7)


def test_a_cylinder_on_a_plane_of_the_thesis():
    """Thesis 7.1, half-space of the length of the cylinder."""
    assert gw.contact_force("hertz", [ROD, {"shape": "plane"}], 1e-6) == pytest.approx(
        266.272, rel=1e-6
    )
    assert gw.contact_stiffness("hertz", ["plane", ROD], 1e-6) == pytest.approx(2.86441e8, rel=2e-6)
    # two such bodies of finite stiffness give way as one of half the modulus
    both = gw.contact_force("hertz", [ROD, {"shape": "plane", "material": BRASS}], 1e-6)
    half = gw.contact_force(
        "hertz", [{**ROD, "material": {**BRASS, "youngs_modulus": 57.5e9}}, "plane"], 1e-6
    )
    assert both == pytest.approx(half, rel=1e-12)


def test_parallel_cylinders_in_plane_strain():
    """Johnson 1985, section 5.6: E* 45 MPa, R 6.35 mm."""
    pair = [SOFT, SOFT]
    assert gw.contact_force("line", pair, [1e-5, 1e-4, 1e-3]) == pytest.approx(
        [144.00, 1962.05, 32040.4], rel=3e-5
    )
    assert gw.contact_energy("line", pair, 1e-4) == pytest.approx(0.0912949, rel=1e-6)


def test_parallel_cylinders_of_finite_length_have_their_effective_radius():
    """Half-spaces deform as under a cylinder of R* on a plane."""
    one, other = ({**ROD, "diameter": diameter} for diameter in (4e-3, 12e-3))
    alone = {**ROD, "diameter": 2 * (2e-3 * 6e-3 / 8e-3)}
    flat = {"shape": "plane", "material": BRASS}
    assert gw.contact_force("hertz", [one, other], 1e-6) == pytest.approx(
        gw.contact_force("hertz", [alone, flat], 1e-6)
    )


@pytest.mark.parametrize(
    "r, tube, factor",
    [(1 / 3, 1.0, 1.4806), (0.231915, 0.76642, 1.4630), (0.171573, 0.61991, 1.4490)],
)
def test_a_sphere_in_a_tube(r, tube, factor):
    """Thesis chapter 6: K/(E* sqrt(r)); 4/3 on a plane."""
    bodies = [
        {"shape": "tube", "radius": tube},
        {"shape": "sphere", "radius": r, "material": "brass"},
    ]
    assert gw.contact_force("hertz", bodies, 1e-6) / (
        MODULUS * math.sqrt(r) * 1e-9
    ) == pytest.approx(factor, rel=5e-5)


def test_crossed_cylinders_follow_the_elliptic_integrals():
    """Johnson 1985, section 4.2, with scipy's integrals."""
    thin = {**ROD, "diameter": 2e-3, "axis": "x"}
    thick = {**ROD, "diameter": 6e-3, "axis": "y"}
    low = 1 / 3e-3
    high = 1 / 1e-3
    m = 0.0
    lower = 1e-9
    upper = 1 - 1e-9
    for _ in range(100):
        m = (lower + upper) / 2
        ratio = (ellipe(m) / (1 - m) - ellipk(m)) / (ellipk(m) - ellipe(m))
        lower, upper = (m, upper) if ratio < high / low else (lower, m)
    stiff = (
        2
        * np.pi
        * (MODULUS / 2)
        / 3
        * ellipk(m) ** -1.5
        * np.sqrt((ellipk(m) - ellipe(m)) / (m * low / 2))
    )
    assert gw.contact_force("hertz", [thin, thick], 1e-6) == pytest.approx(stiff * 1e-9, rel=1e-7)


def test_first_yield():
    """Thesis 2: the closed forms of alpha_y and F_y of two brass spheres of 10 mm, as used in
    runs.
    """
    sphere = {"shape": "sphere", "diameter": 0.010, "material": "brass"}
    law = contact_of([material("brass")], [0.005])
    assert gw.contact_yield("elastoplastic", [sphere, sphere]) == (
        law.yield_overlap,
        law.yield_force,
    )
    assert gw.contact_yield("hertz", [sphere, "plane"]) == (math.inf, math.inf)


def test_power_is_what_it_says():
    bodies = [
        {"shape": "sphere", "radius": 1e-3},
        {"shape": "cylinder", "radius": 1e-3, "length": 1e-3},
    ]
    assert gw.contact_force(
        "power", bodies, [1e-6, 2e-6], constant=3e6, exponent=2
    ) == pytest.approx([3e-6, 12e-6])
    assert gw.contact_overlap("power", bodies, 12e-6, constant=3e6, exponent=2) == pytest.approx(
        2e-6, rel=1e-14
    )


@pytest.mark.parametrize(
    "law, bodies",
    [
        ("hertz", [BALL, "plane"]),
        ("hertz", [ROD, "plane"]),
        ("line", [SOFT, SOFT]),
        ("elastoplastic", [{**BALL, "material": "steel"}, BALL]),
        ("thornton", [BALL, "plane"]),
        ("bilinear", [BALL, "plane"]),
    ],
)
def test_overlap_stiffness_and_energy_belong_to_the_force(law, bodies):
    overlap = np.geomspace(1e-9, 3e-5, 7)
    force = gw.contact_force(law, bodies, overlap)
    slope = gw.contact_stiffness(law, bodies, overlap)
    assert gw.contact_overlap(law, bodies, force) == pytest.approx(overlap, rel=1e-13)
    step = 1e-5 * overlap
    rise = gw.contact_force(law, bodies, overlap + step) - gw.contact_force(
        law, bodies, overlap - step
    )
    assert slope == pytest.approx(rise / (2 * step), rel=1e-4)
    # of unloading from the peak: the energy that it gives back
    peak = overlap[-1]
    path = np.linspace(0, peak, 20001)
    back = gw.contact_force(law, bodies, path, peak_overlap=peak)
    assert gw.contact_energy(law, bodies, peak) == pytest.approx(np.trapezoid(back, path), rel=1e-4)


def test_the_law_is_that_of_a_run():
    case = gw.case("fcc-small", material="steel")
    ball = {"shape": "sphere", "diameter": case.packing.diameter, "material": "steel"}
    overlap = np.array([1e-7, 1e-6, 1e-5])
    assert (
        gw.contact_force("elastoplastic", [ball, ball], overlap)
        == pair_contact(case, 1, 2).loading_force(overlap)
    ).all()
    less = gw.contact_force("elastoplastic", [ball, ball], overlap, pressure_limit=2.0)
    assert (less <= gw.contact_force("elastoplastic", [ball, ball], overlap)).all() and less[-1] > 0


def test_crystals_in_plane_strain_give_that_law():
    """Law line of a case, for a pair of its grains."""
    grain = {
        "kind": "square",
        "size": [3, 3],
        "diameter": 12.7e-3,
        "shape": "cylinder",
        "length": 1.0,
    }
    case = gw.case({"name": "crystal", "material": {**SOFT["material"], "density": 1000},
                    "packing": grain, "contact": {"law": "line"}, "load": {"velocity": 0.01}})  # fmt: skip
    assert pair_contact(case, 1, 2).loading_force(1e-4) == pytest.approx(1962.05, rel=1e-5)


def test_overlaps_beyond_the_law_and_lines_of_laws_that_yield_warn(caplog):
    with caplog.at_level(logging.WARNING):
        gw.contact_force("line", [SOFT, SOFT], 1e-3)
        gw.contact_force("thornton", [{**ROD, "material": "brass"}, "plane"], 1e-6)
    beyond, elastic = (record.getMessage() for record in caplog.records)
    assert "beyond 0.000635 m" in beyond and "stay elastic" in elastic


def test_a_contact_is_warned_about_once_and_not_for_rounding(caplog):
    ball = {"shape": "sphere", "diameter": 0.0119, "material": "brass"}
    with caplog.at_level(logging.WARNING):
        gw.contact_force("elastoplastic", [ball, ball], 0.2 * 0.00595 / 2)
        gw.contact_force("elastoplastic", [ball, ball], 0.2 * 0.00595 / 2 * (1 + 1e-12))
    assert not caplog.records
    with caplog.at_level(logging.WARNING):
        for overlap in (0.0006, 0.0007):
            gw.contact_force("elastoplastic", [ball, ball], overlap)
    assert ["beyond 0.000595 m" in record.getMessage() for record in caplog.records] == [True]


@pytest.mark.parametrize(
    "law, bodies, words, options",
    [
        ("hertzz", [BALL, "plane"], 'law: found "hertzz"', {}),
        ("none", [BALL, "plane"], 'law: found "none"', {}),
        ("hertz", BALL, "expected two bodies", {}),
        ("hertz", [BALL], "expected two bodies", {}),
        ("hertz", [BALL, 3], "bodies[1]: found 3", {}),
        ("hertz", [BALL, "plain"], 'bodies[1].shape: found "plain"', {}),
        ("hertz", ["plane", "plane"], "found a plane and a plane", {}),
        (
            "hertz",
            [BALL, {"shape": "plane", "radius": 1}],
            "bodies[1].radius: found with a plane",
            {},
        ),
        ("hertz", [{**BALL, "length": 1}, "plane"], "bodies[0].length: found with a sphere", {}),
        ("hertz", [{**BALL, "diameter": 1}, "plane"], "together with a diameter", {}),
        ("hertz", [{"shape": "sphere", "radius": 1}, "plane"], "bodies[0].material: missing", {}),
        ("hertz", [{**BALL, "material": "bras"}, "plane"], "did you mean brass", {}),
        (
            "hertz",
            [{"shape": "sphere", "material": "brass"}, "plane"],
            "bodies[0].diameter: missing",
            {},
        ),
        ("hertz", [{**BALL, "radius": -1}, "plane"], "bodies[0].radius: found -1", {}),
        ("hertz", [{**ROD, "length": None}, "plane"], "bodies[0].length", {}),
        ("hertz", [BALL, {"shape": "tube", "radius": 4e-3}], "expected a smaller one", {}),
        ("hertz", [ROD, {"shape": "tube", "radius": 4e-3}], "a cylinder in a tube", {}),
        ("hertz", [ROD, {**ROD, "axis": [0, 1, 0.01]}], "less than 1 degree", {}),
        ("line", [ROD, BALL], "touch at a point", {}),
        ("line", [ROD, {**ROD, "axis": "x"}], "touch at a point", {}),
        ("thornton", [{**BALL, "material": BRASS}, "plane"], "yield_strength: missing", {}),
        ("hertz", [BALL, "plane"], "beta: unknown key; available here: cohesion", {"beta": 0.5}),
        ("bilinear", [BALL, "plane"], "beta: found 2", {"beta": 2}),
        ("power", [BALL, "plane"], "exponent: missing", {"constant": 1}),
        ("elastoplastic", [BALL, "plane"], "law elastoplastic", {"residual_slope": 100}),
    ],
)
def test_wrong_bodies_and_laws_are_one_clear_line(law, bodies, words, options):
    with pytest.raises(gw.InputError) as error:
        gw.contact_force(law, bodies, 1e-6, **options)
    assert words in str(error.value) and len(error.value.errors) == 1


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: gw.contact_force("hertz", [BALL, "plane"], "x"), "overlap: found"),
        (lambda: gw.contact_force("hertz", [BALL, "plane"], math.nan), "not finite"),
        (lambda: gw.contact_force("hertz", [BALL, "plane"], [1, 2], peak_overlap=[1, 2, 3]), "the shape (3,)"),
        (lambda: gw.contact_force("hertz", [BALL, "plane"], 2e-6, peak_overlap=1e-6), "below the overlap"),
        (lambda: gw.contact_overlap("hertz", [BALL, "plane"], -1), "expected 0 or more"),
        (lambda: gw.contact_overlap("hertz", [BALL, "plane"], 1e40), "expected a force reached below an overlap"),
    ],
)  # fmt: skip
def test_wrong_overlaps_and_forces_are_one_clear_line(call, words):
    with pytest.raises(gw.InputError) as error:
        call()
    assert words in str(error.value) and len(error.value.errors) == 1
