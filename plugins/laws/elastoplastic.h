// SPDX-License-Identifier: GPL-2.0-only
/* Elastoplastic law: a fit to finite-element solutions of two elastic-perfectly-plastic spheres (thesis 2.8 to 2.17),
   with K = 1.5/C:

       loading      f = a^1.5                                                 a <= 1
                    f = K (2.48 - (2.48 - c_y) exp(-0.098 (a-1))) A(a)        a > 1
                    A = a^c3 (a < 177.6), 2.37 a - 59.96 otherwise
       unloading    exponent n
       residual     a_R = 0.95 a_max - 25.94 + 24.99 exp(-0.015 (a_max - 1))

   The numbers are the defaults of LawConstants, which can be set for materials with another curve. */

#ifndef GRANWAVE_ELASTOPLASTIC_H
#define GRANWAVE_ELASTOPLASTIC_H

#include "material.h"
#include "normal_law.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace granwave {

enum class Variant { continuous, published };

/* Constants of the elastoplastic law. Derived constants are computed in Elastoplastic: the pressure at yield 2C/3, the area
   exponent by which the area is continuous, and the amplitude by which a_R(1) = 0. */
struct LawConstants {
  double pressure_limit = 2.48, pressure_rate = 0.098;                             // thesis 2.8
  double area_switch = 177.6, area_slope = 2.37, area_offset = 59.96;              // thesis 2.10
  double residual_slope = 0.95, residual_offset = 25.94, residual_rate = 0.015;    // thesis 2.13
  double unloading_exponent = 1.35;                                                // thesis 2.12

  bool operator==(const LawConstants &other) const { return std::memcmp(this, &other, sizeof(other)) == 0; }
};

/* Names of the constants in input scripts, case files and Python, in the order of restart files. */
constexpr std::pair<const char *, double LawConstants::*> LAW_CONSTANTS[] = {
    {"pressure_limit", &LawConstants::pressure_limit},
    {"pressure_rate", &LawConstants::pressure_rate},
    {"area_switch", &LawConstants::area_switch},
    {"area_slope", &LawConstants::area_slope},
    {"area_offset", &LawConstants::area_offset},
    {"residual_slope", &LawConstants::residual_slope},
    {"residual_offset", &LawConstants::residual_offset},
    {"residual_rate", &LawConstants::residual_rate},
    {"unloading_exponent", &LawConstants::unloading_exponent},
};

class Elastoplastic : public NormalLaw {
 public:
  Elastoplastic(Variant variant, double yield_factor, const LawConstants &constants) :
      variant_(variant), constants_(constants), amplitude_(1.5 / yield_factor)
  {
    const bool printed = variant == Variant::published;
    pressure_at_yield_ = printed ? 1.07 : 2.0 * yield_factor / 3.0;
    area_exponent_ = printed ? 1.14 : std::log(linear_area(constants.area_switch)) / std::log(constants.area_switch);
    // rounded to 12 decimals: the result for 25.94 - 0.95 is 24.99 and not the neighboring double
    residual_amplitude_ = std::round((constants.residual_offset - constants.residual_slope) * 1e12) / 1e12;
    if (variant == Variant::continuous) examine();
  }

  std::string fault() const
  {
    if (!fault_) return "";
    char where[80] = "";
    if (fault_at_ > 0.0) std::snprintf(where, sizeof where, " at %.4g times the overlap of first yield", fault_at_);
    return std::string(fault_) + where;
  }

  double loading(double a, const Site &) const { return a <= 1.0 ? hertz_force(a) : loading_beyond_yield(a); }
  double loading_beyond_yield(double a) const { return amplitude_ * pressure(a) * area_beyond_yield(a); }

  double loading_slope(double a, const Site &) const
  {
    if (a <= 1.0) return hertz_slope(a);
    const double area = area_beyond_yield(a), limit = constants_.pressure_limit, rate = constants_.pressure_rate;
    const double area_slope = a < constants_.area_switch ? area_exponent_ * area / a : constants_.area_slope;
    const double pressure_slope = rate * (limit - pressure_at_yield_) * exponential(-rate * (a - 1.0));
    return amplitude_ * (pressure_slope * area + pressure(a) * area_slope);
  }

  double loading_work(double a, const Site &) const
  {
    if (a <= 1.0) return hertz_work(a);
    const double joint = constants_.area_switch;
    double work = 0.4 + amplitude_ * curved_work(std::min(a, joint));
    if (a > joint) work += amplitude_ * (linear_primitive(a) - linear_primitive(joint));
    return work;
  }

  Turning turning(double peak, const Site &site) const
  {
    Turning t{peak, loading(peak, site), residual(peak), constants_.unloading_exponent};
    // just after yield this exponent would return more energy than loading absorbed, but the law must be passive
    if (variant_ == Variant::continuous && peak < settled_)
      t.exponent = std::max(t.exponent, t.force * (peak - t.residual) / loading_work(peak, site) - 1.0);
    return t;
  }

  double dissipated_energy(const Turning &t, const Site &site) const
  {
    // if the exponent was chosen to return all energy, the difference is rounding
    if (variant_ == Variant::continuous && t.exponent > constants_.unloading_exponent) return 0.0;
    return energy_lost(loading_work(t.peak, site), t);
  }

  double area(double a, const Site &) const { return a <= 1.0 ? a : area_beyond_yield(a); }
  /* Without branches (plastic_batch.h). */
  double area_beyond_yield(double a) const
  {
    const double curved = power(a, area_exponent_);
    return a < constants_.area_switch ? curved : linear_area(a);
  }

 private:
  static constexpr double FIRST_STEP = 1e-3, STEP_GROWTH = 1.1, LARGEST_PEAK = 1e5;    // for examine(), in alpha_y
  static constexpr double ROUNDING = 1e-12;                          // relative to the work, in a difference of energies
  static constexpr double LEAST_RATE = 1e-4, LARGEST_RATE = 10.0;    // range in which loading_work is accurate to 1e-8

  Variant variant_;
  LawConstants constants_;
  double amplitude_, pressure_at_yield_, area_exponent_, residual_amplitude_;
  double settled_ = INFINITE;    // peak from which on the law is passive with the given unloading exponent
  const char *fault_ = nullptr;
  double fault_at_ = 0.0;

  double pressure(double a) const
  {
    const double limit = constants_.pressure_limit;
    return limit - (limit - pressure_at_yield_) * exponential(-constants_.pressure_rate * (a - 1.0));
  }

  double linear_area(double a) const { return constants_.area_slope * a - constants_.area_offset; }

  double residual(double peak) const
  {
    return constants_.residual_slope * peak - constants_.residual_offset +
           residual_amplitude_ * exponential(-constants_.residual_rate * (peak - 1.0));
  }

  /* Check peaks from first yield to far beyond those of all contacts. A law is passive if the loading force increases, if
     residual overlaps lie in [0, a_max) and if a larger peak has dissipated more: no cycle then returns more energy than it
     absorbed. */
  void examine()
  {
    const LawConstants &c = constants_;
    if (!(c.area_switch > 1.0 && linear_area(c.area_switch) > 1.0))
      fault_ = "area_switch and area_slope area_switch - area_offset must both exceed 1";
    else if (!(c.pressure_rate >= LEAST_RATE && c.pressure_rate <= LARGEST_RATE))
      fault_ = "pressure_rate must lie between 1e-4 and 10";
    else if (!(c.unloading_exponent >= 1.0)) fault_ = "unloading_exponent must be at least 1";
    double before = 1.0, work = 0.4, force = 1.0, dent = 0.0, lost = 0.0;
    for (double step = FIRST_STEP; !fault_ && step < LARGEST_PEAK;) {
      double peak = 1.0 + step;
      if (before < c.area_switch && peak > c.area_switch)
        peak = c.area_switch;    // the slope of the force may be discontinuous: check it there and just beyond
      else if (before == c.area_switch) peak = c.area_switch * (1.0 + FIRST_STEP);
      else step *= STEP_GROWTH;
      if (peak <= before) continue;
      const double f = loading(peak, {}), r = residual(peak);
      work += step_work(before, peak);
      const double loss = work - f * (peak - r) / (c.unloading_exponent + 1.0), kept = std::max(loss, 0.0);
      if (!(f > force)) fault_ = "the force of loading does not rise";
      else if (!(r >= dent)) fault_ = "the residual overlap is negative or falls";
      else if (!(r < peak)) fault_ = "the residual overlap is not below the largest one";
      else if (!(kept >= lost - ROUNDING * work))
        fault_ = "a larger overlap loses less energy, so that a cycle gives back more than it took";
      if (fault_) fault_at_ = peak;
      settled_ = loss <= 0.0 ? INFINITE : std::min(settled_, peak);
      before = peak;
      force = f;
      dent = r;
      lost = kept;
    }
    if (fault_) settled_ = INFINITE;
  }

  /* Integral of pressure(a) a^c3 from 1: 10-point Gauss-Legendre quadrature on panels of doubling width */
  double curved_work(double a) const
  {
    double sum = 0.0;
    for (double lo = 1.0; lo < a; lo *= 2.0) sum += panel_work(lo, std::min(2.0 * lo, a));
    return sum;
  }

  double panel_work(double lo, double hi) const
  {
    const double mid = 0.5 * (lo + hi), half = 0.5 * (hi - lo);
    double value[10], sum = 0.0;
    for (int n = 0; n < 10; n++) {    // several powers at a time
      const double at = mid + (n % 2 == 0 ? -half : half) * GAUSS_POINTS[n / 2];
      value[n] = GAUSS_WEIGHTS[n / 2] * pressure(at) * power(at, area_exponent_);
    }
    for (const double term : value) sum += term;
    return half * sum;
  }

  /* Work of loading from one overlap to a slightly larger one */
  double step_work(double lo, double hi) const
  {
    const double joint = std::min(std::max(lo, constants_.area_switch), hi);
    const double curved = joint > lo ? panel_work(lo, joint) : 0.0;
    return amplitude_ * (hi > joint ? curved + linear_primitive(hi) - linear_primitive(joint) : curved);
  }

  /* Primitive of pressure(a) linear_area(a) */
  double linear_primitive(double a) const
  {
    const double limit = constants_.pressure_limit, slope = constants_.area_slope, b = constants_.pressure_rate;
    const double decay = exponential(-b * (a - 1.0));
    return limit * a * (0.5 * slope * a - constants_.area_offset) +
           (limit - pressure_at_yield_) * decay * (linear_area(a) / b + slope / (b * b));
  }
};

}    // namespace granwave

#endif
