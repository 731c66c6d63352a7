// SPDX-License-Identifier: GPL-2.0-only
/* Normal laws of a few lines: Hertz's, the bilinear one and Thornton's. */

#ifndef GRANWAVE_SIMPLE_LAWS_H
#define GRANWAVE_SIMPLE_LAWS_H

#include "normal_law.h"

namespace granwave {

/* Force of Hertzian contacts, and of other laws in their elastic range. */
inline double hertz_force(double a) { return a * std::sqrt(a); }
inline double hertz_slope(double a) { return 1.5 * std::sqrt(a); }
inline double hertz_work(double a) { return 0.4 * a * a * std::sqrt(a); }

/* Quadrature after Gauss and Legendre with 10 points, those on one side of the middle of an interval from -1 to 1. */
constexpr double GAUSS_POINTS[] = {0.1488743389816312, 0.4333953941292472, 0.6794095682990244, 0.8650633666889845,
                                   0.9739065285171717};
constexpr double GAUSS_WEIGHTS[] = {0.2955242247147529, 0.2692667193099963, 0.2190863625159820, 0.1494513491505806,
                                    0.0666713443086881};

/* Hertzian contact: f = a^1.5 at any overlap, without dissipation. */
class Hertz : public NormalLaw {
 public:
  double loading(double a, const Site &) const { return hertz_force(a); }
  double loading_slope(double a, const Site &) const { return hertz_slope(a); }
  double loading_work(double a, const Site &) const { return hertz_work(a); }
  Turning turning(double peak, const Site &) const { return {peak, hertz_force(peak), 0.0, 1.5}; }
  double dissipated_energy(const Turning &, const Site &) const { return 0.0; }
};

/* Bilinear law of Walton and Braun (thesis 4.2): F = k alpha on loading, k = 18.5 sigma_y R*; unloading slope k/(1-beta),
   residual overlap beta alpha_max. It has no elastic range. */
class Bilinear : public NormalLaw {
 public:
  static constexpr double STIFFNESS = 18.5;    // k / (sigma_y R*), thesis 4.2

  /* `slope` is k alpha_y / F_y. */
  Bilinear(double slope, double beta) : slope_(slope), beta_(beta) {}

  double loading(double a, const Site &) const { return slope_ * a; }
  double loading_slope(double, const Site &) const { return slope_; }
  double loading_work(double a, const Site &) const { return 0.5 * slope_ * a * a; }
  Turning turning(double peak, const Site &) const { return {peak, slope_ * peak, beta_ * peak, 1.0}; }
  double dissipated_energy(const Turning &t, const Site &site) const { return energy_lost(loading_work(t.peak, site), t); }

 private:
  double slope_, beta_;
};

/* Thornton's law (thesis 2.4 to 2.6): loading f = 1 + K (a-1) beyond first yield, K = 1.5/C; Hertzian unloading with the
   flattened radius R*_p. */
class Thornton : public NormalLaw {
 public:
  explicit Thornton(double yield_factor) : yield_factor_(yield_factor), slope_(1.5 / yield_factor) {}

  double loading(double a, const Site &) const { return a <= 1.0 ? hertz_force(a) : 1.0 + slope_ * (a - 1.0); }
  double loading_slope(double a, const Site &) const { return a <= 1.0 ? hertz_slope(a) : slope_; }

  double loading_work(double a, const Site &) const
  {
    return a <= 1.0 ? hertz_work(a) : 0.4 + (a - 1.0) + 0.5 * slope_ * (a - 1.0) * (a - 1.0);
  }

  Turning turning(double peak, const Site &site) const
  {
    const double force = loading(peak, site);
    const double radius = power(yield_factor_ * (2.0 * force + 1.0) / 3.0, 1.5) / force;    // R*_p / R*
    return {peak, force, peak - power(force / std::sqrt(radius), 2.0 / 3.0), 1.5};
  }

  double dissipated_energy(const Turning &t, const Site &site) const { return energy_lost(loading_work(t.peak, site), t); }

 private:
  double yield_factor_, slope_;
};

}    // namespace granwave

#endif
