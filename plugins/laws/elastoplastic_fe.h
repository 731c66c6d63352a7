// SPDX-License-Identifier: GPL-2.0-only
/* Elastoplastic law fitted to finite elements of spheres and flats of one or two materials with linear isotropic hardening
   (workflows/finite_elements/sphere_contact/law_table.py). With first yield where von Mises' stress under Hertz's pressure
   reaches the yield strength (Johnson, Contact Mechanics, 1985, eq. 3.45; C a polynomial in nu), d = alpha/R*, t = sqrt(a) - 1:

       loading      f = a^1.5                                                                     a <= 1
                    f = a^1.5 (1 + ks s (sqrt(d) - sqrt(d_y)))/(1 + D)                            a > 1
                    D = t K (b + (c - b)/(1 + t/tc)),  K = 1/(1 + (t0/t)^tk)                      from elastic to plastic
                    b = (2/3) C/(P (G + H)),  c = c0 W/(1 + hc H)                                 f -> a/b: fully plastic
                    G = 0.05 + 0.95/(1 + g^gq + fl g^2)                                           flattening
                    H = h1 r d^h2 (1 + hg g) ...,  r = eta^h3,  h = H/(1 + H)                     hardening
                    a straight line from d = 0.2 on, where there are no finite elements           d > 0.2
       residual     a_R = a_max - B f_max^(2/3),  ln B a sum of terms that vanish at yield
       unloading    exponent n, 1.5 at yield

   P, the mean pressure times the contact area over pi R* alpha sigma_y, is 2.8 to 3 times 2.7. Body A is the one that yields
   first: of like yield strengths the smaller one. s_A = R* / R_A is its share of the relative curvature; p the share of
   body A in the plastic deformation; eta = E h/((1 - h) sigma_y), with the tangent modulus h E. */

#ifndef GRANWAVE_ELASTOPLASTIC_FE_H
#define GRANWAVE_ELASTOPLASTIC_FE_H

#include "elastoplastic_fe_constants.h"
#include "material.h"
#include "normal_law.h"

#include <algorithm>
#include <tuple>

namespace granwave {

class ElastoplasticFe : public NormalLaw {
 public:
  ElastoplasticFe(const Material &m1, const Material &m2, double overlap_per_radius, const FeConstants &constants) :
      c_(constants), overlap_per_radius_(overlap_per_radius)
  {
    const auto key = [](const Material &m) {
      return std::make_tuple(m.yield_strength, m.youngs_modulus, m.poisson_ratio, m.hardening);
    };
    swapped_ = key(m2) < key(m1);
    same_ = key(m1) == key(m2);
    const Material &a = swapped_ ? m2 : m1, &b = swapped_ ? m1 : m2;
    const auto softness = [](const Material &m) { return (1.0 - m.poisson_ratio * m.poisson_ratio) / m.youngs_modulus; };
    const auto rate = [](const Material &m) {
      return std::isfinite(m.yield_strength) ? m.youngs_modulus * m.hardening / ((1.0 - m.hardening) * m.yield_strength)
                                             : 0.0;
    };
    compliance_a_ = softness(a) / (softness(a) + softness(b));
    rate_a_ = rate(a);
    rate_b_ = rate(b);
    stronger_ = std::isfinite(b.yield_strength) ? STRENGTH * logarithm(b.yield_strength / a.yield_strength) : LARGE;
    const double ps = logistic(stronger_), even = 4.0 * ps * (1.0 - ps);
    const double yielding = ps * compliance_a_ + (1.0 - ps) * (1.0 - compliance_a_);
    nu_ = a.poisson_ratio - 0.3;
    pressure_ = 2.0 / 3.0 * yield_pressure(m1, m2) / a.yield_strength;
    knee_ = c_.c0 * exponential(c_.cn * nu_) * power(1.0 - (1.0 - even) * (1.0 - yielding), c_.cw);
    start_ = c_.t0 * exponential(c_.te * (1.0 - even));
    steep_ = c_.tk * exponential(c_.tkn * nu_);
    limit_ = c_.p0 * (1.0 + c_.pe * (1.0 - even) * (1.0 - yielding));
    alike_ = even;
  }

  /* Contact pressure at first yield over the yield strength; exact for 0 <= nu <= 0.5 to 1e-8. */
  static double yield_factor(double nu)
  {
    const double x = std::min(std::max(nu, 0.0), 0.5);
    return 1.2993050250823506 +
           x * (0.9106119252292305 +
                x * (0.3951633795461314 +
                     x * (0.15688813722665162 +
                          x * (0.056913757624188974 + x * (0.015481397233576165 + x * 0.011876780136307627)))));
  }

  static double yield_pressure(const Material &m1, const Material &m2)
  {
    return std::min(yield_factor(m1.poisson_ratio) * m1.yield_strength, yield_factor(m2.poisson_ratio) * m2.yield_strength);
  }

  /* The law of a material whose yield strength and hardening are larger by this factor, in units of its own first yield. */
  ElastoplasticFe stronger(double factor) const
  {
    ElastoplasticFe found(*this);
    found.overlap_per_radius_ *= factor * factor;
    return found;
  }

  double loading(double a, const Site &site) const { return a <= 1.0 ? hertz_force(a) : beyond(a, shape(site)); }

  double loading_slope(double a, const Site &site) const
  {
    if (a <= 1.0) return hertz_slope(a);
    const double step = 1e-5 * a;
    const Shape s = shape(site);
    return (beyond(a + step, s) - (a - step > 1.0 ? beyond(a - step, s) : hertz_force(a - step))) / (2.0 * step);
  }

  /* 10-point Gauss-Legendre quadrature in t on panels of doubling width. */
  double loading_work(double a, const Site &site) const
  {
    if (a <= 1.0) return hertz_work(a);
    const Shape s = shape(site);
    const double end = std::sqrt(a) - 1.0;
    double sum = 0.4;
    for (double lo = 0.0, hi = FIRST_PANEL; lo < end; lo = hi, hi *= 2.0) {
      const double top = std::min(hi, end), mid = 0.5 * (lo + top), half = 0.5 * (top - lo);
      for (int n = 0; n < 10; n++) {
        const double u = 1.0 + mid + (n % 2 == 0 ? -half : half) * GAUSS_POINTS[n / 2];
        sum += half * GAUSS_WEIGHTS[n / 2] * 2.0 * u * beyond(u * u, s);
      }
    }
    return sum;
  }

  Turning turning(double peak, const Site &site) const
  {
    const Shape s = shape(site);
    Turning t = branch(peak, beyond(peak, s), s);
    // a cycle must not give back more than it took
    t.exponent = std::max(t.exponent, t.force * (peak - t.residual) / loading_work(peak, site) - 1.0);
    return t;
  }

  double dissipated_energy(const Turning &t, const Site &site) const
  {
    return std::max(0.0, energy_lost(loading_work(t.peak, site), t));
  }

  /* From the stiffness at the start of unloading, 2 E* times the contact radius. */
  double area(double a, const Site &site) const
  {
    if (a <= 1.0) return a;
    const Shape s = shape(site);
    const Turning t = branch(a, beyond(a, s), s);
    const double radius = 2.0 / 3.0 * t.slope() /
                          (1.0 + STIFFER * s.stiff * (std::sqrt(a * overlap_per_radius_) - std::sqrt(overlap_per_radius_)));
    return radius * radius;
  }

 private:
  static constexpr double STRENGTH = 40.0, LARGE = 40.0;    // sharpness of the logistic function, and its largest argument
  static constexpr double FLAT = 0.05;                      // of G at any depth, so that the force rises
  static constexpr double STRAIN = 0.1;     // mean plastic strain over sqrt(d), for the hardening of unloading
  static constexpr double DEEPEST = 0.2;    // overlap over R* of the finite elements
  static constexpr double STIFFER = 1.2;    // of a sphere with a large contact than of a half-space
  static constexpr double FIRST_PANEL = 0.125, LEAST = 1e-9, STEEPEST = 1.05;

  FeConstants c_;
  double overlap_per_radius_, compliance_a_, rate_a_, rate_b_, stronger_, nu_, pressure_, knee_, start_, steep_, limit_,
      alike_;
  bool swapped_, same_;

  /* What follows from the radii. */
  struct Shape {
    double stiff, curved, flat, knee, eta, rate, hard;
  };

  static double logistic(double y) { return 1.0 / (1.0 + exponential(-std::min(std::max(y, -LARGE), LARGE))); }

  Shape shape(const Site &site) const
  {
    const bool second = same_ ? site.share2 > site.share1 : swapped_;
    const double sa = second ? site.share2 : site.share1, sb = second ? site.share1 : site.share2;
    const double p = logistic(stronger_ + c_.rb * (logarithm(std::max(sa, LEAST)) - logarithm(std::max(sb, LEAST))));
    const double even = 4.0 * p * (1.0 - p);
    const double curved = p * power(std::max(sa, LEAST), c_.q1) + (1.0 - p) * power(std::max(sb, LEAST), c_.q1);
    const double apart = alike_ * (sa - sb) * (sa - sb);
    Shape s;
    s.stiff = compliance_a_ * sa + (1.0 - compliance_a_) * sb;
    s.curved = sa;
    s.flat = (c_.q0 + (1.0 - c_.q0) * curved) * (1.0 + c_.qs * (1.0 - even) * 4.0 * sa * sb) *
             exponential(apart * (c_.qr + c_.qr2 * apart) + c_.qn * nu_);
    s.knee = knee_ * exponential(c_.cq * apart);
    const double mean = p * sa + (1.0 - p) * sb;
    s.eta = p * rate_a_ + (1.0 - p) * rate_b_;
    s.rate = s.eta > 0.0 ? power(s.eta, c_.h3) : 0.0;
    s.hard = c_.h1 * s.rate * (1.0 + c_.e3 * (1.0 - even) * (1.0 - mean)) * exponential(c_.hq * apart);
    return s;
  }

  double beyond(double a, const Shape &s) const
  {
    const double end = DEEPEST / overlap_per_radius_;
    if (!(a > end && end > 1.0)) return fitted(a, s);
    const double before = end - 1e-4 * (end - 1.0), force = fitted(end, s);
    return force + (force - fitted(before, s)) / (end - before) * (a - end);
  }

  double fitted(double a, const Shape &s) const
  {
    const double d = a * overlap_per_radius_, root = std::sqrt(a), t = root - 1.0;
    if (!(t > LEAST)) return hertz_force(a);
    double g = d * s.flat, hard = 0.0, h = 0.0;
    if (s.rate > 0.0) {
      hard = s.hard * power(d, c_.h2) * (1.0 + c_.hg * g) * exponential(c_.hd * d * logarithm(1.0 + s.rate));
      h = hard / (1.0 + hard);
    }
    g *= (1.0 + h * (c_.hf + c_.hf2 * h)) / c_.gk;
    const double flattening = FLAT + (1.0 - FLAT) / (1.0 + power(g, c_.gq * exponential(c_.gqh * h)) + c_.fl * g * g);
    const double b = pressure_ / (limit_ * (flattening + hard)), c = s.knee / (1.0 + c_.hc * hard);
    const double k = 1.0 / (1.0 + power(start_ / t, steep_)), tc = c_.tc * exponential(c_.tch * h + c_.tcn * nu_);
    const double stiffer = 1.0 + c_.ks * s.stiff * std::sqrt(overlap_per_radius_) * t;
    return a * root * stiffer / (1.0 + k * t * (b + (c - b) / (1.0 + t / tc)));
  }

  Turning branch(double a, double f, const Shape &s) const
  {
    const double l = logarithm(a), z = std::max(0.0, 1.5 * l - logarithm(f)), d = a * overlap_per_radius_;
    const double root = std::sqrt(d) - std::sqrt(overlap_per_radius_), far = d - overlap_per_radius_;
    const double h = STRAIN * s.eta * root, hard = h / (1.0 + h);
    const double sum = c_.r0 * l + c_.r1 * z + c_.r2 * l * z + c_.r3 * l * l + c_.r4 * z * z + c_.r5 * root * s.stiff +
                       c_.r6 * far * s.curved + c_.r7 * l * nu_ + (c_.r8 * l + c_.r9 * root) * hard;
    const double share = z / (1.0 + z);
    const double drop = c_.n0 * l / (1.0 + l) + c_.n1 * share + c_.n2 * l / ((3.0 + l) * (3.0 + l)) +
                        c_.n3 * far * s.curved + c_.n4 * root * s.stiff + c_.n5 * share * std::min(l / 9.0, 1.0) +
                        c_.n6 * share * share;
    const double back = exponential(-std::max(0.0, sum)) * exponential(2.0 / 3.0 * logarithm(f));
    return {a, f, std::max(0.0, a - back), std::min(1.5, std::max(STEEPEST, 1.5 - drop))};
  }
};

}    // namespace granwave

#endif
