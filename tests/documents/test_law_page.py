"""The equations of `elastoplastic-fe` on the page of the contact law, compared with the program.

The functions below follow the section "All terms" of the page, with its symbols.
"""

from __future__ import annotations

import dataclasses
import sys
from functools import cache
from math import exp, inf, log, sqrt

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw
from tests.documents.pages import ROOT, extension

sys.path.append(str(ROOT / "docs" / "_ext"))  # its modules import each other
PARTS = extension("reference_parts")
K = PARTS.fe_constants()

BRASS = (115e9, 0.30, 550e6, 0.0)
STEEL = (193e9, 0.28, 800e6, 0.02)
SOFT = (10e9, 0.40, 100e6, 0.05)
RIGID = (inf, 0.3, inf, 0.0)
CONTACTS = {
    "equal brass spheres": ((BRASS, BRASS), (0.005, 0.005)),
    "brass on a rigid flat": ((BRASS, RIGID), (0.005, inf)),
    "brass of two radii": ((BRASS, BRASS), (0.009, 0.003)),
    "brass and steel": ((BRASS, STEEL), (0.005, 0.004)),
    "steel and soft, hardening": ((STEEL, SOFT), (0.005, 0.02)),
    "soft on a steel flat": ((SOFT, STEEL), (0.005, inf)),
    "equal soft spheres, hardening": ((SOFT, SOFT), (0.005, 0.005)),
}


def logistic(y: float) -> float:
    return 1 / (1 + exp(-min(max(y, -40.0), 40.0)))


def yield_factor(nu: float) -> float:
    return sum(number * nu**power for power, number in enumerate(PARTS.fe_yield_coefficients()))


@dataclasses.dataclass(frozen=True)
class PageLaw:
    """The law as the page has it."""

    materials: tuple
    shares: tuple[float, float]
    d_y: float

    @property
    def bodies(self):
        """Materials and s of body A and of body B."""
        pairs = list(zip(self.materials, self.shares, strict=True))
        pairs.sort(key=lambda pair: (pair[0][2], pair[0][0], pair[0][1], pair[0][3], -pair[1]))
        return [(material, max(share, 0.01)) for material, share in pairs]

    @property
    def terms(self):
        """Terms that do not depend on the overlap."""
        ((e_a, nu_a, y_a, h_a), s_a), ((e_b, nu_b, y_b, h_b), s_b) = self.bodies
        soft_a = (1 - nu_a**2) / e_a
        soft_b = (1 - nu_b**2) / e_b
        c_a = soft_a / (soft_a + soft_b)
        eta_a = h_a * e_a / ((1 - h_a) * y_a)
        eta_b = h_b * e_b / ((1 - h_b) * y_b) if y_b < inf else 0.0
        pressure = min(yield_factor(nu_a) * y_a, yield_factor(nu_b) * y_b) / y_a
        nu = nu_a - 0.3
        ell = log(y_b / y_a) if y_b < inf else inf
        first = 40.0 if ell == inf else 40 * ell
        p_s = logistic(first)
        p_u = logistic(K["st"] * exp(K["stn"] * nu) * ell)
        lam = 4 * p_s * (1 - p_s)
        u = (1 - 4 * p_u * (1 - p_u)) * (1 - p_u * c_a - (1 - p_u) * (1 - c_a))
        p_a = logistic(first + K["rb"] * log(s_a / s_b))
        p_b = 1 - p_a
        v = lam * (s_a - s_b) ** 2
        z = (1 - lam) * (1 - s_a)
        w = p_a**3 + p_b**3
        own = sum(p**3 * (s / p) ** K["q1"] for p, s in ((p_a, s_a), (p_b, s_b)) if p > 0)
        phi = exp(K["qr"] * v) * (K["q0"] * w + (1 - K["q0"]) * own)
        s = c_a * s_a + (1 - c_a) * s_b
        eta = p_a * eta_a + p_b * eta_b
        uneven = (1 - 4 * p_a * p_b) * (1 - p_a * s_a - p_b * s_b)
        return dict(locals())

    def fitted(self, a: float) -> float:
        """Force on loading within the range of the finite elements, a > 1."""
        q = self.terms
        t = sqrt(a) - 1
        d = a * self.d_y
        g_0 = exp(K["gu"] * q["u"]) * d * q["phi"] / K["gk"]
        hard = 0.0
        if q["eta"] > 0:
            r = q["eta"] ** K["h3"]
            hard = K["h1"] * r * exp(K["hq"] * q["v"]) * (1 + K["e3"] * q["uneven"])
            hard *= (d * q["w"]) ** (K["h2"] + K["h2a"] * q["v"])
            hard *= 1 + K["hg"] * exp(K["hge"] * q["z"]) * K["gk"] * g_0
            hard *= (1 + r) ** (K["hd"] * d * q["w"])
        chi = hard / (1 + hard)
        soft = K["hf"] * exp(K["hfa"] * q["v"] + K["hfe"] * q["z"])
        g = g_0 * (1 + chi * (soft + K["hf2"] * chi))
        power = K["gq"] * exp(K["gqe"] * q["z"] + K["gqh"] * chi)
        fall = K["fl"] * exp(K["fla"] * q["v"])
        flattening = 0.05 + 0.95 / (1 + g**power + fall * g**2)
        t_c = K["tc"] * exp(K["tcn"] * q["nu"] + K["tch"] * chi)
        t_0 = K["t0"] * exp(K["te"] * q["u"])
        k = K["tk"] * exp(K["tkn"] * q["nu"])
        b = 2 / 3 * q["pressure"] / (K["p0"] * (flattening + hard))
        c = K["c0"] * exp(K["cn"] * q["nu"] + K["cq"] * q["v"]) * (1 - q["u"]) ** K["cw"]
        c /= 1 + K["hc"] * hard
        onset = 1 / (1 + (t_0 / t) ** k)
        plastic = t * onset * (b + (c - b) / (1 + t / t_c))
        stiffer = 1 + K["ks"] * q["s"] * (sqrt(d) - sqrt(self.d_y))
        return a**1.5 * stiffer / (1 + plastic)

    def loading(self, a: float) -> float:
        """Force on loading."""
        if a <= 1:
            return a**1.5
        q = self.terms
        rho = 1 - 3 * q["lam"] * q["c_a"] * (1 - q["c_a"]) * exp(-q["v"] / 0.02)
        end = 0.2 / (rho * self.d_y)
        if a <= end:
            return self.fitted(a)
        before = end - 0.002 * (end - 1)
        slope = (self.fitted(end) - self.fitted(before)) / (end - before)
        return self.fitted(end) + slope * (a - end)

    def residual_and_exponent(self, peak: float) -> tuple[float, float]:
        """a_R, and n before its limit by the work of loading."""
        q = self.terms
        force = self.loading(peak)
        d = peak * self.d_y
        j = log(peak)
        zeta = max(0.0, 1.5 * j - log(force))
        x = sqrt(d) - sqrt(self.d_y)
        y = (d - self.d_y) * q["phi"]
        x_w = x * sqrt(q["w"])
        m = 0.2 * q["eta"] * x_w
        total = K["r0"] * j + K["r1"] * zeta + K["r2"] * j * zeta + K["r3"] * q["nu"] * zeta
        total += K["r4"] * zeta**2 + K["r5"] * q["s"] * x + K["r6"] * y + K["r7"] * j * q["nu"]
        total += (K["r8"] * j + K["r9"] * x_w) * m / (1 + m)
        part = zeta / (1 + zeta)
        drop = (K["n0"] + K["n9"] * q["u"]) * j / (1 + j) + (K["n1"] + K["n7"] * q["u"]) * part
        drop += K["n2"] * j / (3 + j) ** 2 + K["n3"] * y + K["n4"] * q["s"] * x
        drop += K["n5"] * part * min(j / 9, 1) + K["n6"] * part**2 + K["n8"] * x_w
        residual = max(0.0, peak - exp(-max(0.0, total)) * force ** (2 / 3))
        return residual, min(1.5, max(1.05, 1.5 - drop))


@cache
def laws(name: str) -> tuple[ContactLaw, PageLaw]:
    """The compiled law of a contact, and the law of the page."""
    materials, radii = CONTACTS[name]
    modulus, ratio, strength, hardening = zip(*materials, strict=True)
    law = ContactLaw(
        law="elastoplastic-fe",
        youngs_modulus=modulus,
        poisson_ratio=ratio,
        yield_strength=strength,
        radius=radii,
        hardening=hardening,
    )
    radius = law.effective_radius
    shares = tuple(radius / each for each in radii)
    return law, PageLaw(materials, shares, law.yield_overlap / radius)


@pytest.mark.parametrize("name", CONTACTS)
@pytest.mark.parametrize("peak", [0.5, 1.2, 3.0, 20.0, 150.0, 1000.0])
def test_the_force_on_loading_follows_the_page(name, peak):
    law, page = laws(name)
    force = law.force(peak * law.yield_overlap, peak * law.yield_overlap)
    assert force / law.yield_force == pytest.approx(page.loading(peak), rel=1e-7)


@pytest.mark.parametrize("name", CONTACTS)
@pytest.mark.parametrize("peak", [3.0, 20.0, 150.0])
def test_unloading_follows_the_page(name, peak):
    law, page = laws(name)
    residual, exponent = page.residual_and_exponent(peak)
    unit = law.yield_overlap
    assert law.residual_overlap(peak * unit) / unit == pytest.approx(residual, rel=1e-7)
    middle = (peak + residual) / 2
    ratio = law.force(middle * unit, peak * unit) / law.force(peak * unit, peak * unit)
    assert ratio == pytest.approx(0.5**exponent, rel=1e-6)


def test_the_page_has_each_constant():
    """Each constant is in the table, and in an equation of the page."""
    text = (ROOT / "docs" / "explanation" / "contact-law.md").read_text(encoding="utf-8")
    _, _, terms = text.partition("### All terms")
    assert len(K) == 60 and len(PARTS.fe_yield_coefficients()) == 7
    for name, value in K.items():
        assert f"| {name} | {value:g} |" in terms, name
        assert f"\\mathrm{{{name}}}" in terms, name


#: Constants of the default law, as the page has them.
C = 1.6
C1 = 2.48
C2 = 0.098
C3 = 177.6
C4 = 2.37
C5 = 59.96
C6 = 0.95
C7 = 25.94
C8 = 0.015


def loading(a: np.ndarray, pressure: float, exponent: float) -> np.ndarray:
    """Return the normalised force on loading below c3, from the pressure at yield and m."""
    return 3 / (2 * C) * (C1 - (C1 - pressure) * np.exp(-C2 * (a - 1))) * a**exponent


def largest_gain(pressure: float, exponent: float, unloading: float) -> float:
    """Return the largest energy gain on unloading, divided by the work of loading."""
    gains = [0.0]
    for peak in np.linspace(1.0001, 1.5, 200):
        a = np.linspace(1, peak, 500)
        forces = loading(a, pressure, exponent)
        work = 2 / 5 + np.trapezoid(forces, a)
        residual = C6 * peak - C7 + (C7 - C6) * np.exp(-C8 * (peak - 1))
        gains.append(forces[-1] * (peak - residual) / (unloading + 1) / work - 1)
    return max(gains)


def test_rounding_explains_the_jumps_and_the_exponent_the_gain():
    """With the printed constants; n of Hertz's law is 1.5."""
    exact = (2 * C / 3, log(C4 * C3 - C5) / log(C3))
    printed = (1.07, 1.14)
    jump = loading(np.ones(1), *printed)[0] - 1
    later = C3 ** printed[1] / (C4 * C3 - C5) - 1
    gains = [largest_gain(*values, 1.35) for values in (printed, exact)]
    text = (ROOT / "docs" / "explanation" / "contact-law.md").read_text(encoding="utf-8")
    for number in (jump, later, *gains):
        assert f" {100 * number:.1f} %" in text, number
    assert gains[1] == pytest.approx((1 / 2.35) / (2 / 5) - 1, abs=1e-3)
    assert largest_gain(*exact, 1.5) == 0.0
