// SPDX-License-Identifier: GPL-2.0-only
/* Interface of a normal contact law, in units of the overlap and force at first yield. No LAMMPS types.

   Compression is positive: overlap alpha = R1 + R2 - |x1 - x2|, force F >= 0 (thesis: R. K. Pal, 2015, eqs 2.2, 2.3)

       alpha_y = (pi^2/4) (C sigma_y / E*)^2 R*        F_y = (4/3) E* sqrt(R*) alpha_y^1.5

   a = alpha/alpha_y, f = F/F_y. Un- and reloading below a peak is the same curve for all laws,

       f = f_max ((a - a_R)/(a_max - a_R))^n     a_R < a < a_max, else 0

   which a law sets by its residual overlap a_R and exponent n.

   The history of a contact is its largest overlap (the peak) and, of a law that needs more, a block of `extra` doubles
   without unit, as many as the table of laws says (law_table.h). The block is zero when a contact begins; pair style,
   walls, migration and restart files copy it whole and know nothing of its meaning. */

#ifndef GRANWAVE_NORMAL_LAW_H
#define GRANWAVE_NORMAL_LAW_H

#include <cmath>
#include <string>

namespace granwave {

/* Un-/reloading branch, fixed at the turning point. */
struct Turning {
  double peak;        // a_max for which the rest holds
  double force;       // f_max
  double residual;    // a_R
  double exponent;    // n

  double unloading(double a) const
  {
    if (a <= residual) return 0.0;
    const double part = (a - residual) / (peak - residual);
    return exponent == 1.0 ? force * part : force * std::pow(part, exponent);
  }

  /* Area under the branch up to a: the energy that the contact can give back. */
  double elastic_energy(double a) const
  {
    if (a <= residual || peak <= residual) return 0.0;
    const double span = peak - residual;
    return force * span / (exponent + 1.0) * std::pow((a - residual) / span, exponent + 1.0);
  }

  /* Slope where unloading starts. */
  double slope() const { return peak > residual ? exponent * force / (peak - residual) : 0.0; }

  /* Contact circle below a peak whose circle is given; radii squared, in units of R* alpha_y. */
  double area(double a, double area_at_peak) const
  {
    return a > residual ? area_at_peak * ((a - residual) / (peak - residual)) : 0.0;
  }
};

/* Base of the laws. A law is a class with the functions

       double loading(double a, const double *extra) const              force on the loading branch, a > 0
       double loading_work(double a, const double *extra) const         work of loading from zero overlap, a > 0
       Turning turning(double peak, const double *extra) const          the branch below a peak beyond the elastic limit
       double dissipated_energy(const Turning &, const double *extra) const     energy lost for good by a contact that has yielded

   and, where the defaults below do not hold, with those. No virtual functions: loading is in the innermost loop, and the
   table (law_table.h) knows all classes. */
struct NormalLaw {
  /* Radius of the contact circle on loading, squared, in units of R* alpha_y. */
  double area(double a) const { return a; }

  /* Update the block of a contact that overlaps by a > 0, in every step, before its peak is raised; true if it changed.
     Called again with the same overlap it must leave the block alone: a run may be cut in pieces. */
  bool update(double /* a */, double /* peak */, double * /* extra */) const { return false; }

  /* Fault of the law's constants, in a line; empty where they make a passive law. */
  std::string fault() const { return ""; }

  /* Work of loading up to the peak less what unloading gives back. */
  static double energy_lost(double work, const Turning &t)
  {
    return work - t.force * (t.peak - t.residual) / (t.exponent + 1.0);
  }
};

}    // namespace granwave

#endif
