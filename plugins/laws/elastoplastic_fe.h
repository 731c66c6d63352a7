// SPDX-License-Identifier: GPL-2.0-only
/* Elastoplastic law fitted to finite elements of spheres and flats of one or two materials with linear isotropic hardening
   (extensions/continuum/sphere_contact/law_table.py). With first yield where von Mises' stress under Hertz's pressure
   reaches the yield strength (Johnson, Contact Mechanics, 1985, eq. 3.45; C a polynomial in nu), d = alpha/R*, t = sqrt(a) - 1:

       loading      f = a^1.5                                                                     a <= 1
                    f = a^1.5 (1 + ks s (sqrt(d) - sqrt(d_y)))/(1 + D)                            a > 1
                    D = t K (b + (c - b)/(1 + t/tc)),  K = 1/(1 + (t0/t)^tk)                      from elastic to plastic
                    b = (2/3) C/(P (G + H)),  c = c0 W/(1 + hc H)                                 f -> a/b: fully plastic
                    G = 0.05 + 0.95/(1 + g^gq + fl g^2),  g = d phi ...                           flattening
                    H = h1 r (d w)^h2 (1 + hg g) ...,  r = eta^h3,  h = H/(1 + H)                 hardening
                    a straight line from d w = 0.2 on, where there are no finite elements
       residual     a_R = a_max - B f_max^(2/3),  ln B a sum of terms that vanish at yield
       unloading    exponent n, 1.5 at yield

   P, the mean pressure times the contact area over pi R* alpha sigma_y, is 2.8 to 3 times 2.7. Body A is the one that yields
   first: of like yield strengths the smaller one. s_A = R* / R_A is its share of the relative curvature; p_A its share in the
   plastic deformation; c_A its share in the elastic compliance; eta = E h/((1 - h) sigma_y), with the tangent modulus h E.

   A sphere on a rigid flat at overlap alpha is half a pair of equal spheres at 2 alpha: the force is the same, the energy half.
   The law has this symmetry, since it is composed of the bodies' own overlaps p_i alpha over their own radii R* / p_i, that is

       w = sum p_i^3        phi = q0 w + (1 - q0) sum p_i^3 (s_i/p_i)^q1        s = sum c_i s_i

   All of them are 1 on a rigid flat, and 1/4, 1/4 and 1/2 for a pair, whose d is four times as large. What else depends on the
   two bodies vanishes for these: u = 1 - c_A where A alone yields (gradually more as B is stronger), v = (s_A - s_B)^2 where the strengths are alike, and
   z = 1 - s_A where they are not. */

#ifndef GRANWAVE_ELASTOPLASTIC_FE_H
#define GRANWAVE_ELASTOPLASTIC_FE_H

#include "elastoplastic_fe_constants.h"
#include "material.h"
#include "normal_law.h"

#include <algorithm>
#include <tuple>

namespace granwave {

inline constexpr LawParameter HARDENING =
    LawParameter("hardening", "h",
                 "tangent modulus after yield divided by Young's modulus; used only by the "
                 "law elastoplastic-fe and by finite elements of two spheres")
        .of_material()
        .in(BELOW_ONE)
        .in_cases({0.0, 0.2, true, true})
        .optional(0.0, 0.02);

class ElastoplasticFe : public NormalLaw {
 public:
  ElastoplasticFe(const Material &m1, const Material &m2, double overlap_per_radius, const FeConstants &constants) :
      c_(constants), overlap_per_radius_(overlap_per_radius)
  {
    const auto key = [](const Material &m) {
      return std::make_tuple(m.yield_strength, m.youngs_modulus, m.poisson_ratio, m[HARDENING]);
    };
    swapped_ = key(m2) < key(m1);
    same_ = key(m1) == key(m2);
    const Material &a = swapped_ ? m2 : m1, &b = swapped_ ? m1 : m2;
    const auto softness = [](const Material &m) { return (1.0 - m.poisson_ratio * m.poisson_ratio) / m.youngs_modulus; };
    const auto rate = [](const Material &m) {
      return std::isfinite(m.yield_strength) ? m.youngs_modulus * m[HARDENING] / ((1.0 - m[HARDENING]) * m.yield_strength)
                                             : 0.0;
    };
    compliance_a_ = softness(a) / (softness(a) + softness(b));
    rate_a_ = rate(a);
    rate_b_ = rate(b);
    nu_ = a.poisson_ratio - 0.3;
    const bool both_yield = std::isfinite(b.yield_strength);
    const double stronger = both_yield ? logarithm(b.yield_strength / a.yield_strength) : LARGE;
    stronger_ = both_yield ? STRENGTH * stronger : LARGE;
    const double ps = logistic(stronger_), pu = logistic(both_yield ? c_.st * exponential(c_.stn * nu_) * stronger : LARGE);
    alike_ = 4.0 * ps * (1.0 - ps);
    const double u = (1.0 - 4.0 * pu * (1.0 - pu)) * (1.0 - pu * compliance_a_ - (1.0 - pu) * (1.0 - compliance_a_));
    pressure_ = 2.0 / 3.0 * yield_pressure(m1, m2) / a.yield_strength;
    knee_ = c_.c0 * exponential(c_.cn * nu_) * power(1.0 - u, c_.cw);
    knee_width_ = c_.tc * exponential(c_.tcn * nu_);
    start_ = c_.t0 * exponential(c_.te * u);
    steep_ = c_.tk * exponential(c_.tkn * nu_);
    flat_ = exponential(c_.gu * u) / c_.gk;
    unlike_ = u;
    in_range_ = compliance_a_ >= LEAST_COMPLIANCE && is_fitted(a) && (alike_ < NOT_ALIKE || is_fitted(b));
    equal_ = shape(0.5, 0.5);
    on_flat_ = shape(1.0, 0.0);
  }

  /* Contact pressure at first yield / yield strength, to 1e-8 for 0 <= nu <= 0.5. */
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
        const double u = 1.0 + mid + (n % 2 == 0 ? -half : half) * gauss_point(n / 2);
        sum += half * gauss_weight(n / 2) * 2.0 * u * beyond(u * u, s);
      }
    }
    return sum;
  }

  Turning turning(double peak, const Site &site) const
  {
    const Shape s = shape(site);
    Turning t = branch(peak, beyond(peak, s), s);
    // a cycle must not return more energy than it received
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

  /* The error bars of the fit; none outside its range, and 0 before yield, where the law is Hertz's. */
  ErrorBar error_bar(double peak, const Site &site) const
  {
    if (!in_range_ || (!same_ && share_of_a(site) < LEAST_SHARE)) return {};
    if (peak <= 1.0) return {0.0, 0.0, 0.0};
    if (peak * overlap_per_radius_ * reach(shape(site)) > DEEPEST) return {};
    const auto &bars = FE_BARS[is_mirrored(site) ? 0 : 1];
    const FeBar *bar = bars;
    for (const FeBar &each : bars)
      if (peak >= each.from) bar = &each;
    return {bar->force, bar->unloading, bar->restitution};
  }

  /* Range of the finite elements: Poisson's ratio, Young's modulus / yield strength, hardening. */
  static constexpr double LARGEST_POISSON = 0.45, LEAST_RATIO = 50.0, LARGEST_RATIO = 1000.0, LARGEST_HARDENING = 0.1;

 private:
  static constexpr double STRENGTH = 40.0, LARGE = 40.0;    // sharpness of the logistic function, and its largest argument
  // limit of the flattening at large depth, so that the force increases
  static constexpr double FLAT = 0.05;
  static constexpr double STRAIN = 0.2;    // mean plastic strain over sqrt(d w), for the hardening of unloading
  // overlap of a body over its radius, at the end of the finite-element results
  static constexpr double DEEPEST = 0.2;
  static constexpr double STIFFER = 1.2;    // coefficient: a sphere with a large contact is stiffer than a half-space
  static constexpr double SECANT = 2e-3;    // step for the slope of the straight line beyond the range, over the overlap
  static constexpr double FIRST_PANEL = 0.125, LEAST = 1e-9, STEEPEST = 1.05;
  // smallest fraction of a flat in the relative curvature: radii beyond 99:1 count as flats
  static constexpr double FLATTEST = 0.01;
  static constexpr double LEAST_PART = 1e-12, EVEN = 1e-12, NOT_ALIKE = 1e-6;
  static constexpr double UNEVEN = 0.02;    // value of v above which the finite elements end at 0.2 R*, as for a flat
  static constexpr double MIRRORED =
      0.05;    // largest difference of radii, or compliance of the flat, for which a contact is mirrored
  static constexpr double LEAST_COMPLIANCE = 0.33, LEAST_SHARE = 0.09, ROUNDING = 1e-9;    // range of the finite elements

  /* Quantities that follow from the radii. */
  struct Shape {
    double stiff, own, curved, flat, knee, fall, bend, eta, rate, hard, harder, power, soft, uneven;
  };

  FeConstants c_;
  double overlap_per_radius_, compliance_a_, rate_a_, rate_b_, stronger_, nu_, pressure_, knee_, knee_width_, start_, steep_,
      flat_, unlike_, alike_;
  bool swapped_, same_, in_range_;
  Shape equal_, on_flat_;    // of equal radii, and of body A on a flat

  static double logistic(double y) { return 1.0 / (1.0 + exponential(-std::min(std::max(y, -LARGE), LARGE))); }

  static bool is_fitted(const Material &m)
  {
    const double ratio = m.youngs_modulus / m.yield_strength;
    return m.poisson_ratio >= 0.0 && m.poisson_ratio <= LARGEST_POISSON + ROUNDING &&
           ratio >= LEAST_RATIO * (1.0 - ROUNDING) && ratio <= LARGEST_RATIO * (1.0 + ROUNDING) &&
           m[HARDENING] <= LARGEST_HARDENING + ROUNDING;
  }

  /* True for equal spheres, and a sphere on a rigid flat. */
  bool is_mirrored(const Site &site) const
  {
    return same_ ? std::abs(site.share1 - site.share2) < MIRRORED
                 : std::min(compliance_a_, share_of_a(site)) > 1.0 - MIRRORED;
  }

  double share_of_a(const Site &site) const { return swapped_ ? site.share2 : site.share1; }

  /* exp(x), without computing it where the result is known. */
  static double factor(double x) { return x == 0.0 ? 1.0 : exponential(x); }

  /* Depth at which the finite elements of equal spheres end / depth for a flat. */
  double reach(const Shape &s) const
  {
    return 1.0 - 3.0 * alike_ * compliance_a_ * (1.0 - compliance_a_) * exponential(-s.uneven / UNEVEN);
  }

  Shape shape(const Site &site) const
  {
    if (std::abs(site.share1 - site.share2) < EVEN) return equal_;
    const bool second = same_ ? site.share2 > site.share1 : swapped_;
    const double share_a = second ? site.share2 : site.share1;
    return std::abs(share_a - 1.0) < EVEN ? on_flat_ : shape(share_a, second ? site.share1 : site.share2);
  }

  Shape shape(double share_a, double share_b) const
  {
    const double sa = std::max(share_a, FLATTEST), sb = std::max(share_b, FLATTEST);
    const double p = logistic(stronger_ + c_.rb * logarithm(sa / sb)), q = 1.0 - p, even = 4.0 * p * q;
    const double v = alike_ * (sa - sb) * (sa - sb), z = (1.0 - alike_) * (1.0 - sa);
    const auto own = [&](double part, double share) {
      return part == 0.0 ? 0.0 : part * part * part * power(share / std::max(part, LEAST_PART), c_.q1);
    };
    Shape s;
    s.stiff = compliance_a_ * sa + (1.0 - compliance_a_) * sb;
    s.own = p * p * p + q * q * q;
    s.curved = (c_.q0 * s.own + (1.0 - c_.q0) * (own(p, sa) + own(q, sb))) * factor(c_.qr * v);
    s.flat = s.curved * flat_;
    s.knee = knee_ * factor(c_.cq * v);
    s.fall = c_.fl * factor(c_.fla * v);
    s.bend = c_.gq * factor(c_.gqe * z);
    s.eta = p * rate_a_ + q * rate_b_;
    s.uneven = v;
    s.rate = s.hard = s.harder = s.power = s.soft = 0.0;
    if (s.eta > 0.0) {
      s.rate = power(s.eta, c_.h3);
      s.hard = c_.h1 * s.rate * (1.0 + c_.e3 * (1.0 - even) * (1.0 - p * sa - q * sb)) * factor(c_.hq * v);
      s.harder = c_.hg * factor(c_.hge * z);
      s.power = c_.h2 + c_.h2a * v;
      s.soft = c_.hf * factor(c_.hfa * v + c_.hfe * z);
    }
    return s;
  }

  double beyond(double a, const Shape &s) const
  {
    if (!(a * overlap_per_radius_ > DEEPEST)) return fitted(a, s);
    const double end = DEEPEST / (reach(s) * overlap_per_radius_);
    if (!(a > end && end > 1.0)) return fitted(a, s);
    const double before = end - SECANT * (end - 1.0), force = fitted(end, s);
    return force + (force - fitted(before, s)) / (end - before) * (a - end);
  }

  double fitted(double a, const Shape &s) const
  {
    const double d = a * overlap_per_radius_, root = std::sqrt(a), t = root - 1.0;
    if (!(t > LEAST)) return hertz_force(a);
    double g = d * s.flat, hard = 0.0, bend = s.bend, width = knee_width_;
    if (s.rate > 0.0) {
      const double own = d * s.own;
      hard =
          s.hard * power(own, s.power) * (1.0 + s.harder * c_.gk * g) * exponential(c_.hd * own * logarithm(1.0 + s.rate));
      const double h = hard / (1.0 + hard);
      g *= 1.0 + h * (s.soft + c_.hf2 * h);
      bend *= exponential(c_.gqh * h);
      width *= exponential(c_.tch * h);
    }
    const double flattening = FLAT + (1.0 - FLAT) / (1.0 + power(g, bend) + s.fall * g * g);
    const double b = pressure_ / (c_.p0 * (flattening + hard)), c = s.knee / (1.0 + c_.hc * hard);
    const double k = 1.0 / (1.0 + power(start_ / t, steep_));
    const double stiffer = 1.0 + c_.ks * s.stiff * std::sqrt(overlap_per_radius_) * t;
    return a * root * stiffer / (1.0 + k * t * (b + (c - b) / (1.0 + t / width)));
  }

  Turning branch(double a, double f, const Shape &s) const
  {
    const double l = logarithm(a), z = std::max(0.0, 1.5 * l - logarithm(f)), d = a * overlap_per_radius_;
    const double root = std::sqrt(d) - std::sqrt(overlap_per_radius_), own = std::sqrt(s.own) * root;
    const double far = (d - overlap_per_radius_) * s.curved, stiff = root * s.stiff;
    const double h = STRAIN * s.eta * own, hard = h / (1.0 + h);
    const double sum = c_.r0 * l + c_.r1 * z + c_.r2 * l * z + c_.r3 * nu_ * z + c_.r4 * z * z + c_.r5 * stiff +
                       c_.r6 * far + c_.r7 * l * nu_ + (c_.r8 * l + c_.r9 * own) * hard;
    const double share = z / (1.0 + z), late = l / (1.0 + l);
    const double drop = (c_.n0 + c_.n9 * unlike_) * late + (c_.n1 + c_.n7 * unlike_) * share +
                        c_.n2 * l / ((3.0 + l) * (3.0 + l)) + c_.n3 * far + c_.n4 * stiff +
                        c_.n5 * share * std::min(l / 9.0, 1.0) + c_.n6 * share * share + c_.n8 * own;
    const double back = exponential(-std::max(0.0, sum)) * exponential(2.0 / 3.0 * logarithm(f));
    return {a, f, std::max(0.0, a - back), std::min(1.5, std::max(STEEPEST, 1.5 - drop))};
  }
};

}    // namespace granwave

#endif
