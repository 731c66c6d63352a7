// SPDX-License-Identifier: GPL-2.0-only
/* Laws of metals whose yield strength grows with the strain rate. No LAMMPS types.

   After Johnson and Cook (1983) the yield strength at a plastic strain rate r is lambda sigma_y,

       lambda = 1 + C ln(r/r0)     r > r0, else 1

   Tabor's representative strain of a contact, 0.2 a/R (Johnson, Contact Mechanics, 1985, section 6.3), with the contact
   radius a^2 = 2 R* alpha of a plastic contact, gives the rate

       r = 0.2 s d(a)/dt/R* = 0.1 sqrt(2) s (d(alpha)/dt)/sqrt(R* alpha)

   where s is 1, or 1/2 where both bodies yield. Only the logarithm of it matters.

   At a given lambda the law is that of a material of yield strength lambda sigma_y; with all that is in units of the
   overlap and force at first yield of sigma_y,

       f(a; lambda) = lambda^3 f(a/lambda^2)     e(a; lambda) = lambda^5 e(a/lambda^2)

   A contact on its loading curve follows lambda, which is kept below the peak: the branch there is that of the rate at the
   peak. Let F and E be force and recoverable energy at the peak. In a step from peak p to a

       lost <- lost + (F(p) + F(a))/2 (a - p) - E(a) + E(p)

   which is the energy that velocity Verlet takes from the motion in that step, less what is stored. Two bounds keep the law
   passive and the force continuous, however the rate changes:

   * lambda increases only so fast that the dissipated energy does not decrease: a harder impact stays elastic until
     it meets the curve of the new rate;
   * lambda decreases only so fast that the force does not decrease on loading: a softer impact yields at its old
     force until it meets the curve of the new rate. */

#ifndef GRANWAVE_RATE_DEPENDENT_H
#define GRANWAVE_RATE_DEPENDENT_H

#include "elastoplastic_fe.h"

#include <algorithm>

namespace granwave {

inline constexpr LawParameter RATE_SENSITIVITY =
    LawParameter("rate_sensitivity", "C",
                 "rate dependence of the yield strength: C of the factor 1 + C ln(rate/reference rate)")
        .of_material()
        .after("rate")
        .in(NOT_NEGATIVE)
        .in_cases({0.0, 0.2, true, true})
        .optional(0.0, 0.014);
inline constexpr LawParameter REFERENCE_RATE =
    LawParameter("reference_rate", "r0", "strain rate up to which the yield strength is constant; 1/s, usually 1")
        .of_material()
        .after("rate")
        .in(POSITIVE)
        .optional(1.0);

/* Growth of the yield strength with the strain rate in a contact. */
struct RateModel {
  static constexpr double TABOR = 0.2;    // strain divided by the ratio of contact radius to radius

  double sensitivity = 0.0, reference_rate = 1.0;    // C, and r0 in 1/s
  double depth = 1.0;                                // overlap at first yield over R*
  double share = 1.0;                                // fraction of the plastic deformation in the body that yields

  explicit operator bool() const { return sensitivity > 0.0; }

  /* Strain rate at the overlap a, from the rate of the overlap over R*, 1/s. */
  double strain_rate(double a, double rate) const { return 0.5 * TABOR * share * rate * std::sqrt(2.0 / (a * depth)); }

  double factor(double a, double rate) const
  {
    const double ratio = strain_rate(a, rate) / reference_rate;
    return ratio > 1.0 ? 1.0 + sensitivity * logarithm(ratio) : 1.0;
  }
};

template <class Law> class RateDependent : public NormalLaw {
 public:
  // part of the history at the peak; a factor of 0: the contact has not yielded in a step
  enum { FACTOR, LOST, FORCE, STORED, N_EXTRA };

  RateDependent(const Law &law, const RateModel &model) : law_(law), model_(model) {}

  std::string fault() const { return law_.fault(); }
  double loading(double a, const Site &site) const { return force(a, factor(site), site); }

  double loading_slope(double a, const Site &site) const
  {
    const double factor = this->factor(site), unit = factor * factor;
    return a <= unit ? hertz_slope(a) : factor * stronger(law_, factor).loading_slope(a / unit, site);
  }

  double loading_work(double a, const Site &site) const
  {
    const double factor = this->factor(site), unit = factor * factor;
    return a <= unit ? hertz_work(a) : factor * unit * unit * stronger(law_, factor).loading_work(a / unit, site);
  }

  Turning turning(double peak, const Site &site) const { return branch(peak, factor(site), site); }

  double dissipated_energy(const Turning &t, const Site &site) const
  {
    return is_set(site) ? site.extra[LOST] : law_.dissipated_energy(t, site);
  }

  double area(double a, const Site &site) const
  {
    const double factor = this->factor(site), unit = factor * factor;
    return a <= unit ? a : unit * stronger(law_, factor).area(a / unit, site);
  }

  bool update(double a, double peak, double rate, const Site &site, double *extra) const
  {
    if (a <= peak || a <= 1.0) return false;
    const double wanted = model_.factor(a, rate), before = peak > 1.0 ? factor(site) : wanted;
    const State from = peak > 1.0 ? state(peak, site) : State{hertz_force(peak), hertz_work(peak), 0.0};
    const auto at = [&](double factor) {
      if (from.lost == 0.0 && a <= factor * factor) return State{hertz_force(a), hertz_work(a), 0.0};
      const Turning t = branch(a, factor, site);
      const double stored = t.elastic_energy(a);
      return State{t.force, stored, from.lost + 0.5 * (from.force + t.force) * (a - peak) - stored + from.stored};
    };
    State to = at(wanted);
    double found = wanted;
    if (wanted > before && to.lost < from.lost)
      found = nearest(before, wanted, [&](double factor) { return at(factor).lost >= from.lost; });
    if (wanted < before && to.force < from.force)
      found = nearest(before, wanted, [&](double factor) { return force(a, factor, site) >= from.force; });
    if (found != wanted) to = at(found);
    to.lost = std::max(to.lost, from.lost);    // up to rounding, it is
    extra[FACTOR] = found;
    extra[LOST] = to.lost;
    extra[FORCE] = to.force;
    extra[STORED] = to.stored;
    return true;
  }

 private:
  static constexpr int HALVINGS = 24;

  Law law_;
  RateModel model_;

  /* The law of a stronger material in its own units, which is unchanged for most laws. */
  template <class Other> static const Other &stronger(const Other &law, double) { return law; }
  static ElastoplasticFe stronger(const ElastoplasticFe &law, double factor) { return law.stronger(factor); }

  static bool is_set(const Site &site) { return site.extra && site.extra[FACTOR] > 0.0; }
  static double factor(const Site &site) { return is_set(site) ? site.extra[FACTOR] : 1.0; }

  struct State {    // at the peak
    double force, stored, lost;
  };

  State state(double peak, const Site &site) const
  {
    if (is_set(site)) return {site.extra[FORCE], site.extra[STORED], site.extra[LOST]};
    const Turning t = turning(peak, site);
    return {t.force, t.elastic_energy(peak), law_.dissipated_energy(t, site)};
  }

  double force(double a, double factor, const Site &site) const
  {
    const double unit = factor * factor;
    return a <= unit ? hertz_force(a) : factor * unit * stronger(law_, factor).loading(a / unit, site);
  }

  Turning branch(double peak, double factor, const Site &site) const
  {
    const double unit = factor * factor;
    if (peak <= unit) return {peak, hertz_force(peak), 0.0, 1.5};
    const Turning t = stronger(law_, factor).turning(peak / unit, site);
    return {peak, factor * unit * t.force, unit * t.residual, t.exponent};
  }

  /* The admissible number nearest to `to`, between `to` and the admissible number `from`. */
  template <class Fits> static double nearest(double from, double to, const Fits &fits)
  {
    for (int n = 0; n < HALVINGS; n++) {
      const double middle = 0.5 * (from + to);
      (fits(middle) ? from : to) = middle;
    }
    return from;
  }
};

}    // namespace granwave

#endif
