// SPDX-License-Identifier: GPL-2.0-only
/* Hertzian contact: f = a^1.5 at any overlap, without dissipation. */

#ifndef GRANWAVE_HERTZ_H
#define GRANWAVE_HERTZ_H

#include "normal_law.h"

namespace granwave {

/* Force of Hertzian contacts, and of other laws in their elastic range. */
inline double hertz_force(double a) { return a * std::sqrt(a); }
inline double hertz_slope(double a) { return 1.5 * std::sqrt(a); }
inline double hertz_work(double a) { return 0.4 * a * a * std::sqrt(a); }

class Hertz : public NormalLaw {
 public:
  double loading(double a, const double *) const { return hertz_force(a); }
  double loading_slope(double a, const double *) const { return hertz_slope(a); }
  double loading_work(double a, const double *) const { return hertz_work(a); }
  Turning turning(double peak, const double *) const { return {peak, hertz_force(peak), 0.0, 1.5}; }
  double dissipated_energy(const Turning &, const double *) const { return 0.0; }
};

}    // namespace granwave

#endif
