// SPDX-License-Identifier: GPL-2.0-only
/* Bilinear law of Walton and Braun (thesis 4.2): F = k alpha on loading, k = 18.5 sigma_y R*; unloading slope k/(1-beta),
   residual overlap beta alpha_max. It has no elastic range. */

#ifndef GRANWAVE_BILINEAR_H
#define GRANWAVE_BILINEAR_H

#include "normal_law.h"

namespace granwave {

class Bilinear : public NormalLaw {
 public:
  static constexpr double STIFFNESS = 18.5;    // k / (sigma_y R*), thesis 4.2

  /* `slope` is k alpha_y / F_y. */
  Bilinear(double slope, double beta) : slope_(slope), beta_(beta) {}

  double loading(double a, const double *) const { return slope_ * a; }
  double loading_slope(double, const double *) const { return slope_; }
  double loading_work(double a, const double *) const { return 0.5 * slope_ * a * a; }
  Turning turning(double peak, const double *) const { return {peak, slope_ * peak, beta_ * peak, 1.0}; }
  double dissipated_energy(const Turning &t, const double *extra) const
  {
    return energy_lost(loading_work(t.peak, extra), t);
  }

 private:
  double slope_, beta_;
};

}    // namespace granwave

#endif
