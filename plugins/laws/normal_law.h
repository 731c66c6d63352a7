// SPDX-License-Identifier: GPL-2.0-only
/* Interface of a normal contact law, and three short laws: Hertz's, the bilinear law and Thornton's. In units of the
   overlap and force at first yield. No LAMMPS types.

   Compression is positive: overlap alpha = R1 + R2 - |x1 - x2|, force F >= 0 (thesis: R. K. Pal, 2015, eqs 2.2, 2.3)

       alpha_y = (pi^2/4) (C sigma_y / E*)^2 R*        F_y = (4/3) E* sqrt(R*) alpha_y^1.5

   a = alpha/alpha_y, f = F/F_y. Unloading and reloading below a peak follow the same curve, which for all laws is

       f = f_max ((a - a_R)/(a_max - a_R))^n     a_R < a < a_max, else 0

   with the residual overlap a_R and the exponent n of the law.

   The history of a contact is its largest overlap (the peak) and, for a law that needs more, a block of `extra`
   dimensionless doubles, whose number is in the table of laws (law_table.h). The block is zero when a contact begins. Pair
   style, walls, migration and restart files copy it as a whole, without interpreting it. */

#ifndef GRANWAVE_NORMAL_LAW_H
#define GRANWAVE_NORMAL_LAW_H

#include "kernel.h"
#include "material.h"
#include "power.h"

#include <cmath>
#include <string>

namespace granwave {

/* Unloading and reloading branch, determined by the turning point. */
struct Turning {
  double peak;        // turning point a_max of this branch
  double force;       // f_max
  double residual;    // a_R
  double exponent;    // n

  /* Without branches (plastic_batch.h). */
  GRANWAVE_KERNEL double unloading(double a) const
  {
    const double part = (a - residual) / (peak - residual), powered = power(part, exponent);
    const double unloaded = force * (exponent == 1.0 ? part : powered);
    return a > residual ? unloaded : 0.0;
  }

  /* Area under the branch up to a: the recoverable energy of the contact. */
  GRANWAVE_KERNEL double elastic_energy(double a) const
  {
    if (a <= residual || peak <= residual) return 0.0;
    const double span = peak - residual;
    return force * span / (exponent + 1.0) * power((a - residual) / span, exponent + 1.0);
  }

  /* Slope below the peak. */
  GRANWAVE_KERNEL double slope(double a) const { return a > residual ? exponent * unloading(a) / (a - residual) : 0.0; }

  /* Slope at the start of unloading. */
  GRANWAVE_KERNEL double slope() const { return peak > residual ? exponent * force / (peak - residual) : 0.0; }

  /* Squared radius of the contact circle below a peak, from its value at the peak, in units of R* alpha_y. */
  GRANWAVE_KERNEL double area(double a, double area_at_peak) const
  {
    return a > residual ? area_at_peak * ((a - residual) / (peak - residual)) : 0.0;
  }
};

/* Inputs of a law in addition to overlaps: its block of history, and the shares R* / R1 and R* / R2 of both bodies in the
   relative curvature, 0 of a plane. */
struct Site {
  const double *extra = nullptr;
  double share1 = 0.5, share2 = 0.5;
};

/* Error bars of a law; not a number if it has none. */
struct ErrorBar {
  double force = NAN;          // relative error of the force on loading
  double unloading = NAN;      // error of the force below the peak over the peak force
  double restitution = NAN;    // relative error of the coefficient of restitution
};

/* Base of the laws. A law is a class with the functions

       double loading(double a, const Site &) const              force on the loading branch, a > 0
       double loading_slope(double a, const Site &) const        slope of that branch, a > 0
       double loading_work(double a, const Site &) const         work of loading from zero overlap, a > 0
       Turning turning(double peak, const Site &) const          branch below a peak beyond the elastic limit
       double dissipated_energy(const Turning &, const Site &) const     dissipated energy of a contact that has yielded

   a constructor from the values of its parameters and the scales of the pair,

       Law(const LawValues &, const LawScales &)

   and with those below whose defaults do not apply. There are no virtual functions: loading is called in the innermost loop,
   and the table (law_table.h) lists all classes. */
struct NormalLaw {
  /* Radius of the contact circle on loading, squared, in units of R* alpha_y. */
  double area(double a, const Site &) const { return a; }

  /* Update the block of a contact with overlap a > 0 and this rate of the overlap over R* (1/s), in every timestep, before its
     peak is increased. Returns true if the block has changed. A second call with the same overlap must not change the block,
     since runs may be continued. */
  bool update(double /* a */, double /* peak */, double /* rate */, const Site &, double * /* extra */) const
  {
    return false;
  }

  /* Error bars of a contact with this peak. */
  ErrorBar error_bar(double /* peak */, const Site &) const { return {}; }

  /* One-line reason why the constants do not give a passive law; empty if they do. */
  std::string fault() const { return ""; }

  /* Work of loading up to the peak minus the energy recovered by unloading. */
  static double energy_lost(double work, const Turning &t)
  {
    return work - t.force * (t.peak - t.residual) / (t.exponent + 1.0);
  }
};

/* Force of Hertzian contacts, and of other laws in their elastic range. */
GRANWAVE_KERNEL double hertz_force(double a) { return a * std::sqrt(a); }
GRANWAVE_KERNEL double hertz_slope(double a) { return 1.5 * std::sqrt(a); }
GRANWAVE_KERNEL double hertz_work(double a) { return 0.4 * a * a * std::sqrt(a); }

/* Quadrature after Gauss and Legendre with 10 points, those on one side of the middle of an interval from -1 to 1. */
GRANWAVE_KERNEL double gauss_point(int n)
{
  constexpr double POINTS[] = {0.1488743389816312, 0.4333953941292472, 0.6794095682990244, 0.8650633666889845,
                               0.9739065285171717};
  return POINTS[n];
}

GRANWAVE_KERNEL double gauss_weight(int n)
{
  constexpr double WEIGHTS[] = {0.2955242247147529, 0.2692667193099963, 0.2190863625159820, 0.1494513491505806,
                                0.0666713443086881};
  return WEIGHTS[n];
}

/* Hertzian contact: f = a^1.5 at any overlap, without dissipation. */
class Hertz : public NormalLaw {
 public:
  double loading(double a, const Site &) const { return hertz_force(a); }
  double loading_slope(double a, const Site &) const { return hertz_slope(a); }
  double loading_work(double a, const Site &) const { return hertz_work(a); }
  Turning turning(double peak, const Site &) const { return {peak, hertz_force(peak), 0.0, 1.5}; }
  double dissipated_energy(const Turning &, const Site &) const { return 0.0; }
};

inline constexpr LawParameter YIELD_FACTOR =
    LawParameter("yield_factor", "C", "C = p_y / sigma_y, contact pressure at first yield")
        .in(POSITIVE)
        .in_cases({0.1, 10.0, true, true})
        .usually(1.6);

inline constexpr LawParameter BETA =
    LawParameter("beta", "b", "bilinear law: residual overlap divided by the largest overlap").in(BELOW_ONE).usually(0.8);

/* Bilinear law of Walton and Braun (thesis 4.2): F = k alpha on loading, k = 18.5 sigma_y R*; unloading slope k/(1-beta),
   residual overlap beta alpha_max. It has no elastic range. */
class Bilinear : public NormalLaw {
 public:
  static constexpr double STIFFNESS = 18.5;    // k / (sigma_y R*), thesis 4.2

  Bilinear(const LawValues &values, const LawScales &scales) :
      slope_(STIFFNESS * scales.yield_strength * scales.overlap_per_radius / scales.force_per_area), beta_(values[BETA])
  {
  }

  double loading(double a, const Site &) const { return slope_ * a; }
  double loading_slope(double, const Site &) const { return slope_; }
  double loading_work(double a, const Site &) const { return 0.5 * slope_ * a * a; }
  Turning turning(double peak, const Site &) const { return {peak, slope_ * peak, beta_ * peak, 1.0}; }
  double dissipated_energy(const Turning &t, const Site &site) const { return energy_lost(loading_work(t.peak, site), t); }

 private:
  double slope_, beta_;    // k alpha_y / F_y, beta
};

/* Thornton's law (thesis 2.4 to 2.6): loading f = 1 + K (a-1) beyond first yield, K = 1.5/C; Hertzian unloading with the
   flattened radius R*_p. */
class Thornton : public NormalLaw {
 public:
  Thornton(const LawValues &values, const LawScales &) : yield_factor_(values[YIELD_FACTOR]), slope_(1.5 / yield_factor_) {}

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
