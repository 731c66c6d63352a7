/* Force-overlap laws of a contact, in one place: used by the LAMMPS styles and bound to Python. No LAMMPS types.

   SI or any other consistent units. Compression is positive: overlap alpha = R1 + R2 - |x1 - x2|, force F >= 0.
   A law is written in units of the overlap and force at first yield (thesis: R. K. Pal, 2015, eqs 2.2, 2.3)

       alpha_y = (pi^2/4) (C sigma_y / E*)^2 R*        F_y = (4/3) E* sqrt(R*) alpha_y^1.5

   a = alpha/alpha_y, f = F/F_y. The only history variable is the largest overlap that the contact ever had.

   elastoplastic (thesis 2.8 to 2.17), K = 1.5/C:
       loading      f = a^1.5                                                 a <= 1
                    f = K (2.48 - (2.48 - c_y) exp(-0.098 (a-1))) A(a)        a > 1
                    A = a^c3 (a < 177.6), 2.37 a - 59.96 otherwise
       unloading    f = f_max ((a - a_R)/(a_max - a_R))^n                     a_R < a < a_max, else 0
       residual     a_R = 0.95 a_max - 25.94 + 24.99 exp(-0.015 (a_max - 1))
   hertz            f = a^1.5; without a yield strength in physical units only
   thornton         loading f = 1 + K (a-1), unloading Hertzian on a flattened radius (thesis 2.4 to 2.6)
   bilinear         F = k alpha, k = 18.5 sigma_y R*; unloading slope k/(1-beta), residual beta alpha_max (thesis 4.2)  */

#ifndef GRANWAVE_CONTACT_LAWS_H
#define GRANWAVE_CONTACT_LAWS_H

#include <algorithm>
#include <cmath>
#include <limits>

namespace granwave {

constexpr double PI = 3.14159265358979323846;
constexpr double INFINITE = std::numeric_limits<double>::infinity();

enum class Law { hertz, elastoplastic, bilinear, thornton };
enum class Variant { continuous, published };

/* Elastic-perfectly-plastic sphere material; a rigid partner has infinite modulus and yield strength. */
struct Material {
  double youngs_modulus, poisson_ratio, yield_strength;
};

inline double effective_modulus(const Material &a, const Material &b)
{
  const auto compliance = [](const Material &m) {
    return (1.0 - m.poisson_ratio * m.poisson_ratio) / m.youngs_modulus;
  };
  return 1.0 / (compliance(a) + compliance(b));
}

/* 1/R* = 1/R1 + 1/R2; an infinite radius is a plane. */
inline double effective_radius(double r1, double r2)
{
  return 1.0 / (1.0 / r1 + 1.0 / r2);
}

/* A law with its scales for one contact: what F = F_y f(a) needs, and the Hertzian fast path. */
struct ContactScale {
  double hertz;            // F = hertz * alpha^1.5 up to elastic_limit
  double elastic_limit;    // overlap up to which the contact is Hertzian and forgets: alpha_y, infinite, or 0
  double overlap, force;   // alpha_y, F_y
};

/* Everything that the un-/reloading branch needs, fixed at the turning point. */
struct Turning {
  double peak;        // a_max for which the rest holds
  double force;       // f_max
  double residual;    // a_R
  double exponent;    // n
};

/* Contact law of a pair of materials; a and f below are the normalised overlap and force. */
class ContactLaw {
 public:
  ContactLaw() = default;

  ContactLaw(Law law, const Material &m1, const Material &m2, Variant variant, double yield_factor, double beta) :
      law_(law), variant_(variant), yield_factor_(yield_factor), beta_(beta),
      modulus_(granwave::effective_modulus(m1, m2)), yield_(std::min(m1.yield_strength, m2.yield_strength)),
      share1_(m1.yield_strength == m2.yield_strength ? 0.5 : (m1.yield_strength < m2.yield_strength ? 1.0 : 0.0)),
      amplitude_(1.5 / yield_factor)
  {
    const bool printed = variant == Variant::published;
    pressure_at_yield_ = printed ? 1.07 : 2.0 * yield_factor / 3.0;
    area_exponent_ = printed ? 1.14 : std::log(AREA_SLOPE * AREA_SWITCH - AREA_OFFSET) / std::log(AREA_SWITCH);
    const double ratio = yield_factor * yield_ / modulus_;
    overlap_per_radius_ = std::isfinite(yield_) ? 0.25 * PI * PI * ratio * ratio : INFINITE;
    force_per_area_ = std::isfinite(yield_) ? 4.0 / 3.0 * modulus_ * std::pow(overlap_per_radius_, 1.5) : INFINITE;
    linear_slope_ = law == Law::bilinear
        ? 18.5 * yield_ * overlap_per_radius_ / force_per_area_ : 0.0;    // k alpha_y / F_y
  }

  Law law() const { return law_; }
  Variant variant() const { return variant_; }
  double yield_factor() const { return yield_factor_; }
  double beta() const { return beta_; }
  double modulus() const { return modulus_; }
  double yield_strength() const { return yield_; }
  double share_of_first() const { return share1_; }    // of the dissipated energy: all to the softer sphere
  bool plastic() const { return law_ != Law::hertz; }
  bool fitted() const { return law_ == Law::elastoplastic; }    // has a limit of validity, 0.2 R*

  ContactScale scale(double effective_radius) const
  {
    ContactScale s;
    s.hertz = 4.0 / 3.0 * modulus_ * std::sqrt(effective_radius);
    s.overlap = overlap_per_radius_ * effective_radius;
    s.force = force_per_area_ * effective_radius * effective_radius;
    s.elastic_limit = law_ == Law::hertz ? INFINITE : law_ == Law::bilinear ? 0.0 : s.overlap;
    return s;
  }

  /* loading branch: force, and work from zero overlap */
  double loading(double a) const
  {
    if (a <= 0.0) return 0.0;
    if (law_ == Law::bilinear) return linear_slope_ * a;
    if (a <= 1.0 || law_ == Law::hertz) return a * std::sqrt(a);
    if (law_ == Law::thornton) return 1.0 + amplitude_ * (a - 1.0);
    return amplitude_ * pressure(a) * area(a);
  }

  double loading_work(double a) const
  {
    if (a <= 0.0) return 0.0;
    if (law_ == Law::bilinear) return 0.5 * linear_slope_ * a * a;
    if (a <= 1.0 || law_ == Law::hertz) return 0.4 * a * a * std::sqrt(a);
    if (law_ == Law::thornton) return 0.4 + (a - 1.0) + 0.5 * amplitude_ * (a - 1.0) * (a - 1.0);
    double work = 0.4 + amplitude_ * curved_work(std::min(a, AREA_SWITCH));
    if (a > AREA_SWITCH) work += amplitude_ * (linear_primitive(a) - linear_primitive(AREA_SWITCH));
    return work;
  }

  /* A peak that has left a dent: below it the contact is reversible and unloads along its loading curve. */
  bool yields(double peak) const { return law_ == Law::bilinear ? peak > 0.0 : plastic() && peak > 1.0; }

  Turning turning(double peak) const
  {
    Turning t{peak, loading(peak), 0.0, 1.5};
    if (law_ == Law::bilinear) {
      t.residual = beta_ * peak;
      t.exponent = 1.0;
    } else if (yields(peak)) {
      if (law_ == Law::thornton) {
        const double radius = std::pow(yield_factor_ * (2.0 * t.force + 1.0) / 3.0, 1.5) / t.force;    // R*_p / R*
        t.residual = peak - std::pow(t.force / std::sqrt(radius), 2.0 / 3.0);
      } else {
        t.residual = RESIDUAL_SLOPE * peak - RESIDUAL_OFFSET + RESIDUAL_AMPLITUDE * std::exp(-RESIDUAL_RATE * (peak - 1.0));
        t.exponent = UNLOADING_EXPONENT;
        // just after yield the printed exponent would return more than loading took (physics: passive law)
        if (variant_ == Variant::continuous && peak < EXPONENT_SETTLED)
          t.exponent = std::max(t.exponent, t.force * (peak - t.residual) / loading_work(peak) - 1.0);
      }
    }
    return t;
  }

  static double unloading(double a, const Turning &t)
  {
    if (a <= t.residual) return 0.0;
    const double part = (a - t.residual) / (t.peak - t.residual);
    return t.exponent == 1.0 ? t.force * part : t.force * std::pow(part, t.exponent);
  }

  /* area under the unloading branch up to a: the energy that the contact can give back */
  static double elastic_energy(double a, const Turning &t)
  {
    if (a <= t.residual || t.peak <= t.residual) return 0.0;
    const double span = t.peak - t.residual;
    return t.force * span / (t.exponent + 1.0) * std::pow((a - t.residual) / span, t.exponent + 1.0);
  }

  /* energy lost for good once the peak was reached: a function of the peak alone */
  double dissipated_energy(const Turning &t) const
  {
    if (!yields(t.peak)) return 0.0;
    const double lost = loading_work(t.peak) - t.force * (t.peak - t.residual) / (t.exponent + 1.0);
    // where the exponent was chosen to give back all, what is left is rounding
    return variant_ == Variant::continuous && t.exponent > UNLOADING_EXPONENT && law_ == Law::elastoplastic ? 0.0 : lost;
  }

  double unloading_slope(const Turning &t) const
  {
    return t.peak > t.residual ? t.exponent * t.force / (t.peak - t.residual) : 0.0;
  }

  /* radius of the contact circle under the peak, squared, in units of R* alpha_y: sets what is one place on a wall */
  double area(double a) const
  {
    if (a <= 1.0 || law_ != Law::elastoplastic) return a;
    return a < AREA_SWITCH ? std::pow(a, area_exponent_) : AREA_SLOPE * a - AREA_OFFSET;
  }

 private:
  static constexpr double PRESSURE_LIMIT = 2.48, PRESSURE_RATE = 0.098;                       // thesis 2.8
  static constexpr double AREA_SWITCH = 177.6, AREA_SLOPE = 2.37, AREA_OFFSET = 59.96;        // thesis 2.10
  static constexpr double RESIDUAL_SLOPE = 0.95, RESIDUAL_OFFSET = 25.94;                     // thesis 2.13
  static constexpr double RESIDUAL_AMPLITUDE = 24.99, RESIDUAL_RATE = 0.015;
  static constexpr double UNLOADING_EXPONENT = 1.35;                                          // thesis 2.12
  static constexpr double EXPONENT_SETTLED = 4.0;    // the energy rule is met by 1.35 well before this peak

  Law law_ = Law::hertz;
  Variant variant_ = Variant::continuous;
  double yield_factor_ = 1.6, beta_ = 0.0, modulus_ = 1.0, yield_ = INFINITE, share1_ = 0.5;
  double amplitude_ = 0.9375, pressure_at_yield_ = 0.0, area_exponent_ = 0.0;
  double overlap_per_radius_ = INFINITE, force_per_area_ = INFINITE, linear_slope_ = 0.0;

  double pressure(double a) const
  {
    return PRESSURE_LIMIT - (PRESSURE_LIMIT - pressure_at_yield_) * std::exp(-PRESSURE_RATE * (a - 1.0));
  }

  /* integral of pressure(a) a^c3 from 1: 10-point Gauss-Legendre on panels that double */
  double curved_work(double a) const
  {
    static constexpr double x[5] = {0.1488743389816312, 0.4333953941292472, 0.6794095682990244, 0.8650633666889845,
                                    0.9739065285171717};
    static constexpr double w[5] = {0.2955242247147529, 0.2692667193099963, 0.2190863625159820, 0.1494513491505806,
                                    0.0666713443086881};
    double sum = 0.0;
    for (double lo = 1.0; lo < a;) {
      const double hi = std::min(2.0 * lo, a), mid = 0.5 * (lo + hi), half = 0.5 * (hi - lo);
      double panel = 0.0;
      for (int k = 0; k < 5; k++)
        for (const double at : {mid - half * x[k], mid + half * x[k]})
          panel += w[k] * pressure(at) * std::pow(at, area_exponent_);
      sum += half * panel;
      lo = hi;
    }
    return sum;
  }

  /* primitive of pressure(a) (2.37 a - 59.96) */
  double linear_primitive(double a) const
  {
    const double b = PRESSURE_RATE, decay = std::exp(-b * (a - 1.0));
    return PRESSURE_LIMIT * a * (0.5 * AREA_SLOPE * a - AREA_OFFSET) +
        (PRESSURE_LIMIT - pressure_at_yield_) * decay * ((AREA_SLOPE * a - AREA_OFFSET) / b + AREA_SLOPE / (b * b));
  }
};

}    // namespace granwave

#endif
