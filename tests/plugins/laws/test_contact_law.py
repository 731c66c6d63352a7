"""Compiled contact laws compared with check values, closed forms, and a second implementation;
their powers and batches.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from granwave._contact_laws import ContactLaw, exponential, power
from granwave.extensions.continuum.sphere_contact.law_fit import bars, errors, measured
from granwave.lammps_inputs.case.contact.contact import hertz_von_mises_yield_factor
from tests.conftest import script_of
from tests.helpers.bodies.rubbing import state
from tests.helpers.twins.twin import LawTwin, scales

BRASS = {
    "youngs_modulus": (115e9, 115e9),
    "poisson_ratio": (0.3, 0.3),
    "yield_strength": (550e6, 550e6),
}
# a_max: f, a_R, W, dissipated; default variant, in units of F_y and alpha_y (derived from thesis
# 2.8 to 2.17)
CHECK = {
    1.05: (1.0639, 0.0288, 0.4516, 0.0),
    2: (2.4711, 0.5779, 2.1026, 0.6072),
    10: (24.3497, 5.3942, 99.717, 51.993),
    50: (197.692, 33.543, 4436.13, 3051.69),
    200: (962.643, 165.323, 89704.9, 75500.0),
    400: (2064.69, 354.12, 392438, 352131),
}


def brass(law="elastoplastic", radius=4.76e-3, **options):
    return ContactLaw(law, **BRASS, radius=(radius, radius), **options)


def test_yield_point_of_the_reference():
    law = brass()
    assert law.yield_overlap == pytest.approx(1.139e-6, rel=1e-3)
    assert law.yield_force == pytest.approx(4.996, rel=1e-3)
    assert (law.yield_overlap, law.yield_force) == pytest.approx(scales(4.76e-3), rel=1e-13)


@pytest.mark.parametrize("peak", CHECK)
def test_check_values(peak):
    law = brass()
    length = law.yield_overlap
    force = law.yield_force
    found = (
        law.loading_force(peak * length) / force,
        law.residual_overlap(peak * length) / length,
        law.loading_work(peak * length) / (force * length),
        law.dissipated_energy(peak * length) / (force * length),
    )
    assert found == pytest.approx(CHECK[peak], rel=5e-5, abs=5e-5)


@pytest.mark.parametrize("variant", ["continuous", "published"])
@pytest.mark.parametrize("peak", [0.5, 1.0001, 1.04, 1.2, 3.0, 30.0, 177.0, 178.0, 350.0])
def test_against_the_second_implementation(variant, peak):
    law = brass(variant=variant)
    twin = LawTwin(variant)
    length = law.yield_overlap
    force = law.yield_force
    a = np.linspace(0, 1.2 * peak, 50)
    expected = [twin.force(x, max(x, peak)) for x in a]
    assert law.force(a * length, np.full(50, peak * length)) / force == pytest.approx(
        expected, rel=1e-10, abs=1e-12
    )
    assert law.loading_work(peak * length) / (force * length) == pytest.approx(
        twin.work(peak), rel=1e-10
    )
    if peak > 1.1 or variant == "published":
        assert law.dissipated_energy(peak * length) / (force * length) == pytest.approx(
            twin.dissipated(peak), rel=1e-9, abs=1e-10
        )


@pytest.mark.parametrize(
    "law_name", ["elastoplastic", "elastoplastic-fe", "hertz", "bilinear", "thornton"]
)
@pytest.mark.parametrize("peak", [0.7, 1.05, 5.0, 60.0, 250.0])
def test_force_is_the_slope_of_the_energy(law_name, peak):
    law = brass(law_name)
    length = law.yield_overlap
    residual = law.residual_overlap(peak * length)
    for overlap in np.linspace(
        residual + 0.05 * (peak * length - residual), 0.98 * peak * length, 9
    ):
        h = 1e-5 * (peak * length - residual)
        slope = (
            law.elastic_energy(overlap + h, peak * length)
            - law.elastic_energy(overlap - h, peak * length)
        ) / (2 * h)
        assert slope == pytest.approx(law.force(overlap, peak * length), rel=1e-6)
    h = 1e-6 * peak * length
    slope = (law.loading_work(peak * length + h) - law.loading_work(peak * length - h)) / (2 * h)
    assert slope == pytest.approx(law.loading_force(peak * length), rel=1e-6)


@pytest.mark.parametrize(
    "law_name", ["elastoplastic", "elastoplastic-fe", "hertz", "bilinear", "thornton"]
)
def test_work_is_stored_or_dissipated_at_the_peak(law_name):
    law = brass(law_name)
    peak = np.geomspace(1e-3, 400, 300) * law.yield_overlap
    assert law.elastic_energy(peak, peak) + law.dissipated_energy(peak) == pytest.approx(
        law.loading_work(peak), rel=1e-12
    )


FE = "elastoplastic-fe"


@pytest.fixture(scope="module")
def finite_elements():
    """Contacts of the table of finite elements, including contacts excluded from the fit."""
    return measured()


def test_the_fitted_law_is_near_its_finite_elements(finite_elements):
    """Largest errors agree with the page on the contact law."""
    found = errors(finite_elements)
    assert found["within_3"].min() > 97 and found[["1-10", "10-100", "100-inf"]].max().max() < 5
    assert found["unloading"].max() < 5.5 and found["restitution"].max() < 4


@pytest.mark.parametrize("mirrored", [True, False])
def test_contacts_held_out_of_the_fit_are_within_the_error_bars(finite_elements, mirrored):
    """Force on loading, fraction of the peak force on unloading, and coefficient of restitution."""
    held = [one for one in finite_elements if one.held and one.mirrored == mirrored]
    assert len(held) > 10
    for contact in held:
        law = contact.law(FE)
        bar = law.force_error(contact.overlap, contact.overlap) / law.loading_force(contact.overlap)
        assert np.all(np.abs(contact.loading_errors(law)) < bar), contact.name
        residual = law.residual_overlap(contact.peak)  # where the bar is that of unloading alone
        bar = law.force_error(residual, contact.peak) / law.loading_force(contact.peak)
        assert np.all(np.abs(contact.unloading_errors(law)).max(axis=1) < bar), contact.name
        rebound = np.sqrt(1 - law.dissipated_energy(contact.peak) / law.loading_work(contact.peak))
        bar = law.restitution_error(contact.peak) / rebound
        assert np.all(np.abs(contact.restitution_errors(law)) < bar), contact.name


def test_the_stated_error_bars_are_those_of_the_fit(finite_elements):
    law = brass(FE)
    table = bars(finite_elements)
    mirrored = table[table["contacts"].str.startswith("equal")]
    for _, row in mirrored.iterrows():
        peak = 1.5 * row["from"] * law.yield_overlap
        assert law.force_error(peak, peak) / law.loading_force(peak) == pytest.approx(row["force"])


def equal_and_mirror(nu, ratio, hardening):
    """A pair of equal spheres, and one of them on a rigid flat of any Poisson's ratio."""
    pair = ContactLaw(
        FE,
        youngs_modulus=(70e9, 70e9),
        poisson_ratio=(nu, nu),
        yield_strength=(70e9 / ratio,) * 2,
        radius=(0.004, 0.004),
        hardening=(hardening, hardening),
    )
    mirror = ContactLaw(
        FE,
        youngs_modulus=(70e9, math.inf),
        poisson_ratio=(nu, 0.2),
        yield_strength=(70e9 / ratio, math.inf),
        radius=(0.004, math.inf),
        hardening=(hardening, 0.0),
    )
    return pair, mirror


def test_a_sphere_on_a_mirror_plane_is_half_a_pair():
    """At half the overlap: the same force, half the energies, half the indentation, the same error
    bar.
    """
    rng = np.random.default_rng(5)
    for _ in range(300):
        nu = rng.uniform(0.0, 0.5)
        ratio = 10 ** rng.uniform(1.5, 3.3)
        pair, mirror = equal_and_mirror(nu, ratio, rng.choice([0.0, rng.uniform(0.0, 0.12)]))
        overlap = mirror.yield_overlap * np.geomspace(0.5, 0.4 * 0.004 / mirror.yield_overlap, 40)
        force = mirror.loading_force(overlap)
        np.testing.assert_allclose(pair.loading_force(2 * overlap), force, rtol=1e-12)
        work = mirror.loading_work(overlap)
        np.testing.assert_allclose(pair.loading_work(2 * overlap), 2 * work, rtol=1e-12)
        for half, whole in (
            (mirror.dissipated_energy(overlap) / work, pair.dissipated_energy(2 * overlap) / work),
            (
                mirror.residual_overlap(overlap) / overlap,
                pair.residual_overlap(2 * overlap) / overlap,
            ),
        ):
            np.testing.assert_allclose(whole, 2 * half, rtol=0, atol=2e-12)
        unloaded = mirror.force(0.97 * overlap, overlap) / force
        np.testing.assert_allclose(
            pair.force(1.94 * overlap, 2 * overlap) / force, unloaded, rtol=0, atol=1e-11
        )
        radius = mirror.contact_radius(overlap)
        np.testing.assert_allclose(pair.contact_radius(2 * overlap), radius, rtol=1e-11)
        bar = mirror.force_error(overlap, overlap)
        np.testing.assert_allclose(pair.force_error(2 * overlap, 2 * overlap), bar, rtol=1e-11)


def test_equal_spheres_and_a_mirror_plane_rebound_alike():
    """Half the effective mass and twice the speed of approach give the same collision."""
    pair, mirror = equal_and_mirror(0.08, 600.0, 0.015)
    mass = 0.002
    for speed in (0.01, 0.5, 5.0):
        whole = pair.collide(mass / 2, 2 * speed)["restitution"]
        half = mirror.collide(mass, speed)["restitution"]
        assert whole == pytest.approx(half, rel=1e-9)


def test_error_bars_end_where_the_fit_ends():
    law = brass(FE)
    deep = 0.79 * law.effective_radius
    assert law.force_error(deep, deep) > 0 and law.restitution_error(deep) > 0
    assert law.force_error(0.5 * law.yield_overlap, 0.0) == 0
    assert math.isnan(law.force_error(0.81 * law.effective_radius, 0.0))
    flat = ContactLaw(FE, **BRASS, radius=(0.005, math.inf))
    limit = 0.2 * flat.effective_radius
    assert flat.force_error(0.99 * limit, 0.0) > 0 and math.isnan(
        flat.force_error(1.01 * limit, 0.0)
    )
    brittle = {**BRASS, "yield_strength": (5e9, 5e9)}
    assert math.isnan(ContactLaw(FE, **brittle, radius=(0.005, 0.005)).force_error(1e-5, 1e-5))
    fast = ContactLaw(FE, **BRASS, radius=(0.005, 0.005), rate_sensitivity=(0.01, 0.01))
    sticky = ContactLaw(FE, **BRASS, radius=(0.005, 0.005), cohesion=("dmt", 0.1))
    for other in (fast, sticky, brass(), brass("hertz")):
        assert math.isnan(other.force_error(1e-5, 1e-5))
    peak = 30 * law.yield_overlap
    below = law.force_error(0.9 * peak, peak) / law.loading_force(peak)
    assert below > law.force_error(peak, peak) / law.loading_force(peak)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45])
@pytest.mark.parametrize(
    ("radius", "strength", "hardening"),
    [(1, 1, 0), (math.inf, 1, 0.01), (0.2, math.inf, 0), (3, 2, 0.1)],
)
def test_the_fitted_law_is_passive_and_begins_at_first_yield(nu, radius, strength, hardening):
    for ratio in (30, 200, 2000):
        bodies = {
            "youngs_modulus": (1.0, 2.0), "poisson_ratio": (nu, 0.3), "yield_strength": (1 / ratio, strength / ratio),
            "radius": (1.0, radius), "hardening": (hardening, hardening),
        }  # fmt: skip
        law = ContactLaw("elastoplastic-fe", **bodies)
        pressure = (
            min(hertz_von_mises_yield_factor(nu), strength * hertz_von_mises_yield_factor(0.3))
            / ratio
        )
        first = (math.pi * pressure / (2 * law.effective_modulus)) ** 2 * law.effective_radius
        assert law.yield_overlap == pytest.approx(first, rel=1e-6)
        peak = (
            np.concatenate(
                [
                    1 + np.geomspace(1e-3, 1, 30),
                    np.geomspace(2.1, 0.5 * law.effective_radius / first, 100),
                ]
            )
            * first
        )
        work = law.loading_work(peak)
        assert np.all(np.diff(law.loading_force(peak)) > 0) and np.all(
            np.diff(law.residual_overlap(peak)) >= -1e-12 * first
        )
        assert np.all(np.diff(law.dissipated_energy(peak)) >= -1e-9 * work[1:])
        swapped = ContactLaw(
            "elastoplastic-fe", **{name: both[::-1] for name, both in bodies.items()}
        )
        assert np.array_equal(swapped.loading_force(peak), law.loading_force(peak))


def test_the_default_law_is_continuous_and_passive():
    law = brass()
    length = law.yield_overlap
    for joint in (1.0, 177.6):
        below = law.loading_force(joint * length * (1 - 1e-12))
        above = law.loading_force(joint * length * (1 + 1e-12))
        assert below == pytest.approx(above, rel=1e-9)
    peak = np.linspace(1, 1.5, 20001) * length
    assert law.dissipated_energy(peak).min() >= 0
    exponent = law.unloading_exponent(peak)
    assert exponent[0] == pytest.approx(1.5, abs=1e-6)
    assert np.all(np.diff(exponent) <= 1e-12) and exponent[-1] == 1.35
    settled = peak[np.argmax(exponent == 1.35)] / length
    assert 1.08 < settled < 1.09


def test_the_printed_law_jumps_and_gives_back_more_than_it_took():
    law = brass(variant="published")
    length = law.yield_overlap
    jump = law.loading_force(length * (1 + 1e-12)) / law.loading_force(length) - 1
    assert jump == pytest.approx(0.003, abs=3e-4)
    second = (
        law.loading_force(177.6 * length * (1 + 1e-12))
        / law.loading_force(177.6 * length * (1 - 1e-12))
        - 1
    )
    assert second == pytest.approx(-0.016, abs=1e-3)
    peak = np.linspace(1.0001, 1.2, 4000)
    lost = law.dissipated_energy(peak * length) / law.loading_work(peak * length)
    assert lost.min() == pytest.approx(-0.067, abs=2e-3)
    assert peak[lost < 0].max() == pytest.approx(1.087, abs=3e-3)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.floats(0, 300), min_size=2, max_size=60),
    st.sampled_from(["elastoplastic", "elastoplastic-fe", "bilinear", "thornton", "hertz"]),
)
def test_no_history_gives_back_more_than_it_took(turns, name):
    """Work over any path of overlaps = stored + dissipated energy, and the stored energy never
    exceeds the work.
    """
    law = brass(name)
    length = law.yield_overlap
    unit = law.yield_overlap * law.yield_force
    work = 0.0
    peak = 0.0
    here = 0.0
    for turn in turns:
        there = turn * length
        if there > peak:  # along the elastic branch to the peak, then loading
            work += law.elastic_energy(peak, peak) - law.elastic_energy(here, peak)
            work += law.loading_work(there) - law.loading_work(peak)
            peak = there
        else:
            path = np.linspace(here, there, 400)
            work += np.trapezoid(law.force(path, np.full_like(path, peak)), path)
        here = there
        balance = work - law.elastic_energy(here, peak) - law.dissipated_energy(peak)
        assert abs(balance) <= 2e-4 * max(abs(work), law.loading_work(peak), 1e-3 * unit) * len(
            turns
        )
        assert law.dissipated_energy(peak) >= -1e-12 * unit


def test_unlike_spheres():
    law = ContactLaw(
        youngs_modulus=(115e9, 210e9),
        poisson_ratio=(0.3, 0.3),
        yield_strength=(550e6, 700e6),
        radius=(0.004, 0.008),
    )
    assert law.effective_radius == pytest.approx(0.004 * 0.008 / 0.012)
    assert law.effective_modulus == pytest.approx(1 / (0.91 / 115e9 + 0.91 / 210e9))
    assert law.yield_strength == 550e6 and law.share_of_first == 1.0
    assert brass().share_of_first == 0.5


def test_thornton_against_its_equations():
    law = brass("thornton")
    overlap_y = law.yield_overlap
    force_y = law.yield_force
    r_star = law.effective_radius
    peak = 40 * overlap_y
    top = force_y + np.pi * 550e6 * r_star * (peak - overlap_y)  # thesis 2.4
    assert law.loading_force(peak) == pytest.approx(top, rel=1e-12)
    flattened = (
        4 * law.effective_modulus / (3 * top) * ((2 * top + force_y) / (2 * np.pi * 550e6)) ** 1.5
    )  # thesis 2.6
    residual = peak - (top / (4 / 3 * law.effective_modulus * np.sqrt(flattened))) ** (2 / 3)
    assert law.residual_overlap(peak) == pytest.approx(residual, rel=1e-10)
    x = 0.5 * (peak + residual)
    assert law.force(x, peak) == pytest.approx(
        4 / 3 * law.effective_modulus * np.sqrt(flattened) * (x - residual) ** 1.5, rel=1e-10
    )


def test_bilinear_against_its_equations():
    law = brass("bilinear", beta=0.8)
    slope = 18.5 * 550e6 * law.effective_radius
    peak = 3e-5
    assert law.loading_force(peak) == pytest.approx(slope * peak, rel=1e-12)
    assert law.residual_overlap(peak) == pytest.approx(0.8 * peak, rel=1e-12)
    assert law.unloading_stiffness(peak) == pytest.approx(slope / 0.2, rel=1e-12)
    top = slope * peak
    assert law.dissipated_energy(peak) == pytest.approx(
        top**2 / 2 * (1 / slope - 0.2 / slope), rel=1e-12
    )


@pytest.mark.parametrize(
    "wrong",
    [
        {"yield_strength": (0.0, 1.0)},
        {"poisson_ratio": (0.6, 0.3)},
        {"radius": (-1.0, 1.0)},
        {"law": "rubber"},
        {"beta": 1.0},
        {"yield_strength": (np.inf, np.inf)},
    ],
)
def test_constants_without_meaning_are_refused(wrong):
    with pytest.raises(ValueError, match=r"must|needs|positive"):
        ContactLaw(**{**BRASS, "radius": (0.005, 0.005), **wrong})


RNG = np.random.default_rng(7)
R = 0.005
ALIKE = {"youngs_modulus": (115e9, 115e9), "poisson_ratio": (0.3, 0.3), "radius": (R, R)}
EXTENDED = np.finfo(np.longdouble).nmant > 60  # long doubles of x86


def units(found: np.ndarray, exact: np.ndarray) -> float:
    """Largest error in units in the last place."""
    return float(np.max(np.abs(found - exact) / np.spacing(np.abs(exact.astype(float)))))


@pytest.mark.skipif(not EXTENDED, reason="needs a more precise type to compare with")
@pytest.mark.parametrize(
    ("x", "y"),
    [
        (RNG.uniform(0, 1, 10**5), 1.35),
        (10 ** RNG.uniform(-16, 0, 10**5), RNG.uniform(1, 3, 10**5)),
        (RNG.uniform(1, 400, 10**5), 1.1414),
        (np.exp(RNG.uniform(-100, 100, 10**5)), RNG.uniform(-3, 3, 10**5)),
    ],
)
def test_powers_are_exact_to_a_unit(x, y):
    assert units(power(x, y), np.power(x.astype(np.longdouble), np.longdouble(y))) < 1.0


@pytest.mark.skipif(not EXTENDED, reason="needs a more precise type to compare with")
@pytest.mark.parametrize("reach", [1.0, 20.0, 700.0])
def test_exponentials_are_exact_to_a_unit(reach):
    x = RNG.uniform(-reach, reach, 10**5)
    assert units(exponential(x), np.exp(x.astype(np.longdouble))) < 1.0


def test_ends_of_the_range():
    assert np.all(power(1.0, RNG.uniform(-5, 5, 100)) == 1.0), (
        "a contact at its peak has the peak's force"
    )
    assert exponential(0.0) == 1.0 and 0.0 < exponential(-1e6) < 1e-300
    assert power(1e-300, 3.0) < 1e-300


@pytest.mark.parametrize(
    "law",
    [
        "elastoplastic",
        "elastoplastic-fe",
        "elastoplastic variant published",
        "bilinear",
        "thornton",
        "hertz",
        "mixed",
    ],
)
def test_contacts_of_a_batch_have_the_forces_of_the_law(lammps, law):
    """Pairs of spheres at many overlaps, first on the way in and then on the way out, more than
    fill a batch.
    """
    n = 150
    names = {1: "thornton", 2: "elastoplastic"} if law == "mixed" else {1: law, 2: law}
    deep = 10 ** RNG.uniform(-8, -3.8, n)
    out = RNG.uniform(0.1, 1.0, n)
    places = [(0.02 * k, 0.0, z) for k in range(n) for z in (0.0, 2 * R - deep[k])]
    words = {}
    laws = {}
    for kind, text in names.items():
        name, *options = text.split()
        strength = {"hertz": ""}.get(name, "550e6")
        words[kind] = " ".join([name, "115e9 0.3", strength, *options])
        given = dict(zip(options[::2], options[1::2], strict=True))
        laws[kind] = ContactLaw(
            name, yield_strength=(float(strength or "inf"),) * 2, **ALIKE, **given
        )
    types = [1 + k % 2 for k in range(n) for _ in range(2)]
    coefficients = [
        f"pair_coeff 1 1 {words[1]}",
        f"pair_coeff 2 2 {words[2]}",
        f"pair_coeff 1 2 {words[1]}",
    ]
    lmp = lammps(
        script_of(places, types=types, coefficients=coefficients, box=[-1, 4, -1, 1, -1, 1])
    )

    def agree(peaks: np.ndarray | None, rtol: float) -> np.ndarray:
        """Assert that the forces are those of the law at the present overlaps, which are returned."""
        lmp.command("run 0 post no")
        found = state(lmp, "x", "f")
        overlaps = 2 * R - np.abs(np.diff(found["x"][:, 2].reshape(n, 2))[:, 0])
        reached = overlaps if peaks is None else peaks
        expected = [laws[1 + k % 2].force(overlaps[k], reached[k]) for k in range(n)]
        assert np.allclose(found["f"][1::2, 2], expected, rtol=rtol, atol=0)
        return overlaps

    peaks = agree(None, 1e-13)
    for k in range(n):
        lmp.command(f"set atom {2 * k + 2} z {2 * R - out[k] * deep[k]:.17g}")
    agree(peaks, 1e-9)
