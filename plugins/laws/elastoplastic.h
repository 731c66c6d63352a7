// SPDX-License-Identifier: GPL-2.0-only
/* Elastoplastic law: a fit to finite-element solutions of two elastic-perfectly-plastic spheres (thesis 2.8 to 2.17),
   with K = 1.5/C:

       loading      f = a^1.5                                                 a <= 1
                    f = K (2.48 - (2.48 - c_y) exp(-0.098 (a-1))) A(a)        a > 1
                    A = a^c3 (a < 177.6), 2.37 a - 59.96 otherwise
       unloading    exponent n
       residual     a_R = 0.95 a_max - 25.94 + 24.99 exp(-0.015 (a_max - 1))

   The numbers are defaults of parameters, which can be set for materials with another curve. */

#ifndef GRANWAVE_ELASTOPLASTIC_H
#define GRANWAVE_ELASTOPLASTIC_H

#include "material.h"
#include "normal_law.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace granwave {

inline constexpr LawParameter VARIANT =
    LawParameter("variant", "", "constants of the elasto-plastic law: modified for continuity, or as published")
        .one_of({"continuous", "published"})
        .usually(0.0);

/* Constants of the curve, for materials whose curve differs from the published one. a = alpha/alpha_y; pressure in units of
   sigma_y, area in units of pi R* alpha_y. */
inline constexpr LawParameter PRESSURE_LIMIT =    // thesis 2.8
    LawParameter("pressure_limit", "x", "constant c1 of the mean pressure, p = c1 - (c1 - 2C/3) exp(-c2 (a-1))")
        .in_cases(POSITIVE)
        .optional(2.48);
inline constexpr LawParameter PRESSURE_RATE = LawParameter("pressure_rate", "x", "constant c2 of the mean pressure")
                                                  .in_cases({1e-4, 10.0, true, true})
                                                  .optional(0.098);
inline constexpr LawParameter AREA_SWITCH =    // thesis 2.10
    LawParameter("area_switch", "x", "normalised overlap a above which the contact area is linear, A = c4 a - c5")
        .in_cases({1.0})
        .optional(177.6);
inline constexpr LawParameter AREA_SLOPE =
    LawParameter("area_slope", "x", "constant c4 of the contact area").in_cases(POSITIVE).optional(2.37);
inline constexpr LawParameter AREA_OFFSET =
    LawParameter("area_offset", "x", "constant c5 of the contact area").optional(59.96);
inline constexpr LawParameter RESIDUAL_SLOPE =    // thesis 2.13
    LawParameter("residual_slope", "x",
                 "constant c6 of the residual overlap, a_R = c6 a_max - c7 + (c7 - c6) exp(-c8 (a_max - 1))")
        .in_cases(POSITIVE)
        .optional(0.95);
inline constexpr LawParameter RESIDUAL_OFFSET =
    LawParameter("residual_offset", "x", "constant c7 of the residual overlap").optional(25.94);
inline constexpr LawParameter RESIDUAL_RATE =
    LawParameter("residual_rate", "x", "constant c8 of the residual overlap").in_cases(POSITIVE).optional(0.015);
inline constexpr LawParameter UNLOADING_EXPONENT =    // thesis 2.12
    LawParameter("unloading_exponent", "x", "exponent n of unloading, f = f_max ((a - a_R)/(a_max - a_R))^n")
        .in_cases(AT_LEAST_ONE)
        .optional(1.35);

class Elastoplastic : public NormalLaw {
 public:
  Elastoplastic(const LawValues &values, const LawScales &) :
      continuous_(is_continuous(values)), constants_(values), amplitude_(1.5 / values[YIELD_FACTOR])
  {
    pressure_at_yield_ = continuous_ ? 2.0 * values[YIELD_FACTOR] / 3.0 : 1.07;
    const double joint = constants_.area_switch;
    area_exponent_ = continuous_ ? std::log(linear_area(joint)) / std::log(joint) : 1.14;
    // rounded to 12 decimals, so that 25.94 - 0.95 is 24.99 and not a neighboring double
    residual_amplitude_ = std::round((constants_.residual_offset - constants_.residual_slope) * 1e12) / 1e12;
    if (continuous_) examine();
  }

  /* Description of incompatible values; empty if there are none. */
  static std::string conflict(const LawValues &values, bool has_constants, bool has_rate)
  {
    if (is_continuous(values)) return "";
    if (has_rate) return "rate requires a passive law: use variant continuous";
    return has_constants ? "variant published has fixed constants: remove the variant, or the constants" : "";
  }

  std::string fault() const
  {
    if (!fault_) return "";
    char where[80] = "";
    if (fault_at_ > 0.0) std::snprintf(where, sizeof where, " at %.4g times the overlap of first yield", fault_at_);
    return std::string(fault_) + where;
  }

  GRANWAVE_KERNEL double loading(double a, const Site &) const
  {
    return a <= 1.0 ? hertz_force(a) : loading_beyond_yield(a);
  }
  GRANWAVE_KERNEL double loading_beyond_yield(double a) const { return amplitude_ * pressure(a) * area_beyond_yield(a); }

  double loading_slope(double a, const Site &) const
  {
    if (a <= 1.0) return hertz_slope(a);
    const double area = area_beyond_yield(a), limit = constants_.pressure_limit, rate = constants_.pressure_rate;
    const double area_slope = a < constants_.area_switch ? area_exponent_ * area / a : constants_.area_slope;
    const double pressure_slope = rate * (limit - pressure_at_yield_) * exponential(-rate * (a - 1.0));
    return amplitude_ * (pressure_slope * area + pressure(a) * area_slope);
  }

  GRANWAVE_KERNEL double loading_work(double a, const Site &) const
  {
    if (a <= 1.0) return hertz_work(a);
    const double joint = constants_.area_switch;
    double work = 0.4 + amplitude_ * curved_work(smaller(a, joint));
    if (a > joint) work += amplitude_ * (linear_primitive(a) - linear_primitive(joint));
    return work;
  }

  GRANWAVE_KERNEL Turning turning(double peak, const Site &site) const
  {
    Turning t{peak, loading(peak, site), residual(peak), constants_.unloading_exponent};
    // just after yield this exponent would return more energy than loading absorbed, but the law must be passive
    if (continuous_ && peak < settled_)
      t.exponent = larger(t.exponent, t.force * (peak - t.residual) / loading_work(peak, site) - 1.0);
    return t;
  }

  double dissipated_energy(const Turning &t, const Site &site) const
  {
    // if the exponent was chosen to return all energy, the difference is only rounding
    if (continuous_ && t.exponent > constants_.unloading_exponent) return 0.0;
    return energy_lost(loading_work(t.peak, site), t);
  }

  GRANWAVE_KERNEL double area(double a, const Site &) const { return a <= 1.0 ? a : area_beyond_yield(a); }
  /* Without branches (plastic_batch.h). */
  GRANWAVE_KERNEL double area_beyond_yield(double a) const
  {
    const double curved = power(a, area_exponent_);
    return a < constants_.area_switch ? curved : linear_area(a);
  }

 private:
  // overlaps for examine(), in alpha_y
  static constexpr double FIRST_STEP = 1e-3, STEP_GROWTH = 1.1, LARGEST_PEAK = 1e5;
  // tolerance relative to the work, for a difference of energies
  static constexpr double ROUNDING = 1e-12;
  static constexpr double LEAST_RATE = 1e-4, LARGEST_RATE = 10.0;    // range in which loading_work is accurate to 1e-8

  struct Constants {
    double pressure_limit, pressure_rate, area_switch, area_slope, area_offset, residual_slope, residual_offset,
        residual_rate, unloading_exponent;

    explicit Constants(const LawValues &values) :
        pressure_limit(values[PRESSURE_LIMIT]), pressure_rate(values[PRESSURE_RATE]), area_switch(values[AREA_SWITCH]),
        area_slope(values[AREA_SLOPE]), area_offset(values[AREA_OFFSET]), residual_slope(values[RESIDUAL_SLOPE]),
        residual_offset(values[RESIDUAL_OFFSET]), residual_rate(values[RESIDUAL_RATE]),
        unloading_exponent(values[UNLOADING_EXPONENT])
    {
    }
  };

  bool continuous_;
  Constants constants_;
  double amplitude_, pressure_at_yield_, area_exponent_, residual_amplitude_;
  double settled_ = INFINITE;    // peak from which on the law is passive with the given unloading exponent
  const char *fault_ = nullptr;
  double fault_at_ = 0.0;

  static bool is_continuous(const LawValues &values) { return values[VARIANT] == 0.0; }

  GRANWAVE_KERNEL double pressure(double a) const
  {
    const double limit = constants_.pressure_limit;
    return limit - (limit - pressure_at_yield_) * exponential(-constants_.pressure_rate * (a - 1.0));
  }

  GRANWAVE_KERNEL double linear_area(double a) const { return constants_.area_slope * a - constants_.area_offset; }

  GRANWAVE_KERNEL double residual(double peak) const
  {
    return constants_.residual_slope * peak - constants_.residual_offset +
           residual_amplitude_ * exponential(-constants_.residual_rate * (peak - 1.0));
  }

  /* Check peaks from first yield to far beyond those of all contacts. A law is passive if the loading force increases, if
     residual overlaps lie in [0, a_max) and if a larger peak has dissipated more: no cycle then returns more energy than it
     absorbed. */
  void examine()
  {
    const Constants &c = constants_;
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
      if (!(f > force)) fault_ = "the loading force does not increase";
      else if (!(r >= dent)) fault_ = "the residual overlap is negative or decreases";
      else if (!(r < peak)) fault_ = "the residual overlap is not below the largest overlap";
      else if (!(kept >= lost - ROUNDING * work))
        fault_ = "a larger overlap dissipates less energy, so a cycle would create energy";
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
  GRANWAVE_KERNEL double curved_work(double a) const
  {
    double sum = 0.0;
    for (double lo = 1.0; lo < a; lo *= 2.0) sum += panel_work(lo, smaller(2.0 * lo, a));
    return sum;
  }

  GRANWAVE_KERNEL double panel_work(double lo, double hi) const
  {
    const double mid = 0.5 * (lo + hi), half = 0.5 * (hi - lo);
    double value[10], sum = 0.0;
    for (int n = 0; n < 10; n++) {    // several powers are computed at a time
      const double at = mid + (n % 2 == 0 ? -half : half) * gauss_point(n / 2);
      value[n] = gauss_weight(n / 2) * pressure(at) * power(at, area_exponent_);
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
  GRANWAVE_KERNEL double linear_primitive(double a) const
  {
    const double limit = constants_.pressure_limit, slope = constants_.area_slope, b = constants_.pressure_rate;
    const double decay = exponential(-b * (a - 1.0));
    return limit * a * (0.5 * slope * a - constants_.area_offset) +
           (limit - pressure_at_yield_) * decay * (linear_area(a) / b + slope / (b * b));
  }
};

}    // namespace granwave

#endif
