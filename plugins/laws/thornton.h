// SPDX-License-Identifier: GPL-2.0-only
/* Thornton's law (thesis 2.4 to 2.6): loading f = 1 + K (a-1) beyond first yield, K = 1.5/C; Hertzian unloading with the
   flattened radius R*_p. */

#ifndef GRANWAVE_THORNTON_H
#define GRANWAVE_THORNTON_H

#include "hertz.h"

namespace granwave {

class Thornton : public NormalLaw {
 public:
  explicit Thornton(double yield_factor) : yield_factor_(yield_factor), slope_(1.5 / yield_factor) {}

  double loading(double a, const double *) const { return a <= 1.0 ? hertz_force(a) : 1.0 + slope_ * (a - 1.0); }
  double loading_slope(double a, const double *) const { return a <= 1.0 ? hertz_slope(a) : slope_; }

  double loading_work(double a, const double *) const
  {
    return a <= 1.0 ? hertz_work(a) : 0.4 + (a - 1.0) + 0.5 * slope_ * (a - 1.0) * (a - 1.0);
  }

  Turning turning(double peak, const double *extra) const
  {
    const double force = loading(peak, extra);
    const double radius = power(yield_factor_ * (2.0 * force + 1.0) / 3.0, 1.5) / force;    // R*_p / R*
    return {peak, force, peak - power(force / std::sqrt(radius), 2.0 / 3.0), 1.5};
  }

  double dissipated_energy(const Turning &t, const double *extra) const
  {
    return energy_lost(loading_work(t.peak, extra), t);
  }

 private:
  double yield_factor_, slope_;
};

}    // namespace granwave

#endif
