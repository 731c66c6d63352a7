// SPDX-License-Identifier: GPL-2.0-only
/* Elastic contacts with laws other than Hertz's: along a line, or a power of the overlap that does not depend on the
   radii. No LAMMPS types.

   A contact along a line of finite length is that of a cylinder of diameter d and length L on a plane, or of two parallel
   cylinders.

   On a half-space, which yields over a length of about L:

       alpha = (F V/L) [1 - ln(V F d/(2 L^3))]      V = sum over both bodies of (1 - nu^2)/(pi E)

   (M. J. Puttock and E. G. Thwaite, National Standards Laboratory Technical Paper 25, 1969, case 9; thesis 7.1.) Of two
   parallel cylinders d is twice their effective radius. With
   u = V F d/(2 L^3) and w = 1 - ln u it is s = alpha d/(2 L^2) = w exp(1 - w), so that

       F = alpha L/(V w),   w - ln w = 1 - ln s,   w > 1          w = |W_-1(-s/e)|, the lower branch of Lambert's function

   It holds for s < 1.

   In plane strain (K. L. Johnson, Contact Mechanics, 1985, section 5.6), with P = F/L, 1/E_i' = (1 - nu_i^2)/E_i, 1/E' and 1/R
   the sums of both 1/E_i' and 1/R_i, each cylinder is compressed between contact and center by

       P/(pi E_i') (2 ln(4 R_i/a) - 1)      a^2 = 4 P R/(pi E')

   and a plane, down to the depth of one diameter of the cylinder on it, by P/(pi E_i') (2 ln(4 R_i/a) - nu_i/(1 - nu_i)) with
   R_i that of the cylinder (Johnson's eq. 5.56). The sum is alpha = P/(pi E') (ln(S/P) - 1), S = 8 pi E' R_1 for equal
   cylinders and 4 pi E' R_1 on a rigid plane: the same form as above, with other scales of overlap and force.

   Overlaps below 1e-25 m count as none: in a row that just touches, what runs ahead of a wave is smaller
   than any number, and its logarithm would not be one. */

#ifndef GRANWAVE_ELASTIC_CONTACT_H
#define GRANWAVE_ELASTIC_CONTACT_H

#include "kernel.h"
#include "material.h"
#include "power.h"

#include <cmath>
#include <utility>
#include <variant>

namespace granwave {

class LineContact {
 public:
  static constexpr double LEAST = 1e-25;
  static constexpr int STEPS = 8;               // most iterations of Newton's method
  static constexpr double PRECISION = 1e-16;    // relative change at which they end

  LineContact(const Material &first, const Material &second, double diameter, double length) :
      overlap_(2.0 * length * length / diameter),
      force_(2.0 * length * length * length * PI * effective_modulus(first, second) / diameter)
  {
  }

  /* Two parallel cylinders in plane strain, or one on a plane (second radius infinite), in contact along this length. */
  static LineContact plane_strain(const Material &first, const Material &second, double r1, double r2, double length)
  {
    const double modulus = effective_modulus(first, second), least = std::fmin(r1, r2);
    const double per_radius = 4.0 * PI * modulus / effective_radius(r1, r2);
    double scale = 0.0;    // ln S
    for (const auto &[material, radius] : {std::pair<const Material &, double>{first, r1}, {second, r2}}) {
      if (!std::isfinite(material.youngs_modulus)) continue;
      const double nu = material.poisson_ratio, share = modulus * (1.0 - nu * nu) / material.youngs_modulus;
      const double within = std::isfinite(radius) ? radius : least;
      const double depth = std::isfinite(radius) ? 0.0 : 1.0 - nu / (1.0 - nu);
      scale += share * (logarithm(per_radius * within * within) + depth);
    }
    const double force = exponential(scale - 2.0);    // S/e^2
    return {force / (PI * modulus), force * length};
  }

  /* Largest overlap for which the law is valid. */
  double largest_overlap() const { return overlap_; }
  double overlap_scale() const { return overlap_; }
  double force_scale() const { return force_; }

  double force(double overlap) const
  {
    if (!(overlap > LEAST)) return 0.0;
    return force_ * (overlap / overlap_) / exponent(overlap / overlap_);
  }

  /* Slope of the force against the overlap. */
  double stiffness(double overlap) const
  {
    if (!(overlap > LEAST)) return 0.0;
    return force_ / overlap_ / (exponent(overlap / overlap_) - 1.0);
  }

  /* Overlap with this force. */
  double overlap(double force) const
  {
    const double u = force / force_;
    return u > 0.0 ? overlap_ * u * (1.0 - std::log(u)) : 0.0;
  }

  /* Work of loading, which unloading returns. */
  double energy(double overlap) const
  {
    if (!(overlap > LEAST)) return 0.0;
    const double w = exponent(overlap / overlap_), u = overlap / overlap_ / w;
    return 0.25 * force_ * overlap_ * u * u * (2.0 * w - 1.0);
  }

  /* Roots w > 1 of w - ln w = 1 - ln s, several at a time: one that has been found, or has left the range of the law, stays. */
  template <int GROUP> static ALWAYS_INLINE void exponents(const double *s, double *w)
  {
    double wanted[GROUP], open[GROUP];
    for (int m = 0; m < GROUP; m++) {
      wanted[m] = 1.0 - logarithm(s[m]);
      const double near_end = 1.0 + std::sqrt(2.0 * (wanted[m] - 1.0)) + (wanted[m] - 1.0) / 1.5;
      const double first = wanted[m] < 2.0 ? near_end : wanted[m] + logarithm(wanted[m]);
      w[m] = s[m] < 1.0 ? first : 1.0;
      open[m] = 1.0;
    }
    // Two steps at a time: because of rounding the iteration ends at one root, or alternates between two, and the number of steps is even.
    static_assert(STEPS % 2 == 0);
    for (int n = 0; n < STEPS; n += 2) {
      double before[GROUP];
      int moved = 0;
      for (int m = 0; m < GROUP; m++) before[m] = w[m];
      for (int half = 0; half < 2; half++)
        for (int m = 0; m < GROUP; m++) {
          const double step = (w[m] - logarithm(w[m]) - wanted[m]) * w[m] / (w[m] - 1.0);
          const double next = open[m] > 0.0 ? w[m] - step : w[m];
          open[m] = std::fabs(step) <= PRECISION * next ? 0.0 : open[m];
          w[m] = w[m] > 1.0 ? next : 1.0;
        }
      for (int m = 0; m < GROUP; m++) moved += w[m] != before[m];
      if (moved == 0) break;
    }
  }

 private:
  LineContact(double overlap, double force) : overlap_(overlap), force_(force) {}

  double overlap_, force_;    // scales: 2 L^2/d and 2 L^3/(V d), or S/(e^2 pi E') and S L/e^2

  /* Root w > 1 of w - ln w = 1 - ln s; 1 where the law ends. */
  static double exponent(double s)
  {
    double w;
    exponents<1>(&s, &w);
    return w;
  }
};

/* F = constant overlap^exponent; no force at all with constant 0. */
struct PowerContact {
  double constant, exponent;

  double force(double overlap) const { return overlap > LineContact::LEAST ? constant * power(overlap, exponent) : 0.0; }
  double stiffness(double overlap) const
  {
    if (exponent == 1.0) return overlap > LineContact::LEAST ? constant : 0.0;
    return overlap > LineContact::LEAST ? exponent * constant * power(overlap, exponent - 1.0) : 0.0;
  }
  double overlap(double force) const { return force > 0.0 ? std::pow(force / constant, 1.0 / exponent) : 0.0; }
  double energy(double overlap) const { return force(overlap) * overlap / (exponent + 1.0); }
};

class ElasticContact {
 public:
  explicit ElasticContact(const PowerContact &law) : law_(law) {}

  /* `valid` is the overlap beyond which a line contact is no longer described. */
  ElasticContact(const LineContact &law, double valid) :
      law_(law), valid_(std::fmin(valid, law.largest_overlap())), largest_(law.largest_overlap())
  {
  }

  double force(double overlap) const
  {
    return std::visit([&](const auto &law) { return law.force(overlap); }, law_);
  }
  double stiffness(double overlap) const
  {
    return std::visit([&](const auto &law) { return law.stiffness(overlap); }, law_);
  }
  double energy(double overlap) const
  {
    return std::visit([&](const auto &law) { return law.energy(overlap); }, law_);
  }
  double overlap(double force) const
  {
    return std::visit([&](const auto &law) { return law.overlap(force); }, law_);
  }
  const LineContact *line() const { return std::get_if<LineContact>(&law_); }
  double valid() const { return valid_; }                // overlap beyond which the law is only an estimate
  double largest_overlap() const { return largest_; }    // where it ends

 private:
  std::variant<LineContact, PowerContact> law_;
  double valid_ = INFINITE, largest_ = INFINITE;
};

}    // namespace granwave

#endif
