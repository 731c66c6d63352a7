// SPDX-License-Identifier: GPL-2.0-only
/* Material of a sphere or a wall, and the effective constants of two bodies in contact. No LAMMPS types. */

#ifndef GRANWAVE_MATERIAL_H
#define GRANWAVE_MATERIAL_H

#include "law_parameters.h"

namespace granwave {

constexpr double PI = 3.14159265358979323846;

/* Elastic-perfectly-plastic material; a rigid partner has infinite modulus and yield strength. */
struct Material {
  double youngs_modulus, poisson_ratio, yield_strength;
  LawValues values = {};    // values of parameters that laws have for each material

  double operator[](const LawParameter &parameter) const { return values[parameter]; }
};

/* Scales of a pair of materials, on which a law may depend. */
struct LawScales {
  double yield_strength;        // values of the softer body
  double overlap_per_radius;    // alpha_y / R*
  double force_per_area;        // F_y / R*^2
  Material first, second;
};

inline double effective_modulus(const Material &a, const Material &b)
{
  const auto compliance = [](const Material &m) { return (1.0 - m.poisson_ratio * m.poisson_ratio) / m.youngs_modulus; };
  return 1.0 / (compliance(a) + compliance(b));
}

/* Effective shear modulus after Mindlin: 1/G* = (2 - nu1)/G1 + (2 - nu2)/G2, G = E/(2 (1 + nu)). */
inline double effective_shear_modulus(const Material &a, const Material &b)
{
  const auto compliance = [](const Material &m) {
    return 2.0 * (2.0 - m.poisson_ratio) * (1.0 + m.poisson_ratio) / m.youngs_modulus;
  };
  return 1.0 / (compliance(a) + compliance(b));
}

/* Effective radius: 1/R* = 1/R1 + 1/R2; a plane has an infinite radius. */
inline double effective_radius(double r1, double r2) { return 1.0 / (1.0 / r1 + 1.0 / r2); }

}    // namespace granwave

#endif
