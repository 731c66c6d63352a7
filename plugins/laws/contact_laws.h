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
     The numbers are defaults: LawConstants holds them, for materials whose curve differs.
   hertz            f = a^1.5; without a yield strength in physical units only
   thornton         loading f = 1 + K (a-1), unloading Hertzian on a flattened radius (thesis 2.4 to 2.6)
   bilinear         F = k alpha, k = 18.5 sigma_y R*; unloading slope k/(1-beta), residual beta alpha_max (thesis 4.2)  */

#ifndef GRANWAVE_CONTACT_LAWS_H
#define GRANWAVE_CONTACT_LAWS_H

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <utility>

namespace granwave {

constexpr double PI = 3.14159265358979323846;
constexpr double INFINITE = std::numeric_limits<double>::infinity();

enum class Law { hertz, elastoplastic, bilinear, thornton };
enum class Variant { continuous, published };

/* Elastic-perfectly-plastic sphere material; a rigid partner has infinite modulus and yield strength. */
struct Material {
  double youngs_modulus, poisson_ratio, yield_strength;
};

/* Constants of the elasto-plastic law. What follows from them does so in ContactLaw: the pressure at yield 2C/3, the area
   exponent that makes both branches meet, and the amplitude that makes a_R(1) = 0. */
struct LawConstants {
  double pressure_limit = 2.48, pressure_rate = 0.098;                     // thesis 2.8
  double area_switch = 177.6, area_slope = 2.37, area_offset = 59.96;      // thesis 2.10
  double residual_slope = 0.95, residual_offset = 25.94, residual_rate = 0.015;    // thesis 2.13
  double unloading_exponent = 1.35;                                        // thesis 2.12

  inline bool operator==(const LawConstants &other) const;
  bool operator!=(const LawConstants &other) const { return !(*this == other); }
};

/* Their names in input scripts, case files and Python, in the order of restart files. */
constexpr std::pair<const char *, double LawConstants::*> LAW_CONSTANTS[] = {
    {"pressure_limit", &LawConstants::pressure_limit},     {"pressure_rate", &LawConstants::pressure_rate},
    {"area_switch", &LawConstants::area_switch},           {"area_slope", &LawConstants::area_slope},
    {"area_offset", &LawConstants::area_offset},           {"residual_slope", &LawConstants::residual_slope},
    {"residual_offset", &LawConstants::residual_offset},   {"residual_rate", &LawConstants::residual_rate},
    {"unloading_exponent", &LawConstants::unloading_exponent},
};

bool LawConstants::operator==(const LawConstants &other) const
{
  for (const auto &[name, member] : LAW_CONSTANTS)
    if (this->*member != other.*member) return false;
  return true;
}

inline double effective_modulus(const Material &a, const Material &b)
{
  const auto compliance = [](const Material &m) {
    return (1.0 - m.poisson_ratio * m.poisson_ratio) / m.youngs_modulus;
  };
  return 1.0 / (compliance(a) + compliance(b));
}

/* 1/G* = (2 - nu1)/G1 + (2 - nu2)/G2, G = E/(2 (1 + nu)): Mindlin's, for slip of bodies pressed together. */
inline double effective_shear_modulus(const Material &a, const Material &b)
{
  const auto compliance = [](const Material &m) {
    return 2.0 * (2.0 - m.poisson_ratio) * (1.0 + m.poisson_ratio) / m.youngs_modulus;
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

  ContactLaw(Law law, const Material &m1, const Material &m2, Variant variant, double yield_factor, double beta,
             const LawConstants &constants = {}) :
      law_(law), variant_(variant), yield_factor_(yield_factor), beta_(beta), constants_(constants),
      modulus_(granwave::effective_modulus(m1, m2)), shear_modulus_(granwave::effective_shear_modulus(m1, m2)),
      yield_(std::min(m1.yield_strength, m2.yield_strength)),
      share1_(m1.yield_strength == m2.yield_strength ? 0.5 : (m1.yield_strength < m2.yield_strength ? 1.0 : 0.0)),
      amplitude_(1.5 / yield_factor)
  {
    const bool printed = variant == Variant::published;
    pressure_at_yield_ = printed ? 1.07 : 2.0 * yield_factor / 3.0;
    area_exponent_ = printed ? 1.14 : std::log(linear_area(constants.area_switch)) / std::log(constants.area_switch);
    // to 12 decimals, as decimal constants have it: 25.94 - 0.95 is 24.99 and not the double above
    residual_amplitude_ = std::round((constants.residual_offset - constants.residual_slope) * 1e12) / 1e12;
    const double ratio = yield_factor * yield_ / modulus_;
    overlap_per_radius_ = std::isfinite(yield_) ? 0.25 * PI * PI * ratio * ratio : INFINITE;
    force_per_area_ = std::isfinite(yield_) ? 4.0 / 3.0 * modulus_ * std::pow(overlap_per_radius_, 1.5) : INFINITE;
    linear_slope_ = law == Law::bilinear
        ? 18.5 * yield_ * overlap_per_radius_ / force_per_area_ : 0.0;    // k alpha_y / F_y
    if (law == Law::elastoplastic && variant == Variant::continuous) examine();
  }

  /* What is wrong with the constants, in a line; empty where they make a passive law. */
  std::string fault() const
  {
    if (!fault_) return "";
    char where[80] = "";
    if (fault_at_ > 0.0) std::snprintf(where, sizeof where, " at %.4g times the overlap of first yield", fault_at_);
    return std::string(fault_) + where;
  }

  Law law() const { return law_; }
  Variant variant() const { return variant_; }
  double yield_factor() const { return yield_factor_; }
  double beta() const { return beta_; }
  const LawConstants &constants() const { return constants_; }
  double modulus() const { return modulus_; }
  double shear_modulus() const { return shear_modulus_; }
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
    const double joint = constants_.area_switch;
    double work = 0.4 + amplitude_ * curved_work(std::min(a, joint));
    if (a > joint) work += amplitude_ * (linear_primitive(a) - linear_primitive(joint));
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
        t.residual = residual(peak);
        t.exponent = constants_.unloading_exponent;
        // just after yield this exponent would return more than loading took (physics: passive law)
        if (variant_ == Variant::continuous && peak < settled_)
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
    const bool raised = law_ == Law::elastoplastic && t.exponent > constants_.unloading_exponent;
    return raised && variant_ == Variant::continuous ? 0.0 : lost;
  }

  double unloading_slope(const Turning &t) const
  {
    return t.peak > t.residual ? t.exponent * t.force / (t.peak - t.residual) : 0.0;
  }

  /* Radius of the contact circle, squared, in units of R* alpha_y: on loading, and below a peak whose circle is given. The
     peak's circle also sets what is one place on a wall. */
  double area(double a) const
  {
    if (a <= 1.0 || law_ != Law::elastoplastic) return a;
    return a < constants_.area_switch ? std::pow(a, area_exponent_) : linear_area(a);
  }

  static double unloading_area(double a, const Turning &t, double area_at_peak)
  {
    return a > t.residual ? area_at_peak * ((a - t.residual) / (t.peak - t.residual)) : 0.0;
  }

  /* k_t = 8 G* a of a contact circle, in physical units */
  double tangential_stiffness(double circle_squared) const { return 8.0 * shear_modulus_ * std::sqrt(circle_squared); }

 private:
  static constexpr double FIRST_STEP = 1e-3, STEP_GROWTH = 1.1, LARGEST_PEAK = 1e5;    // of examine(), in alpha_y
  static constexpr double ROUNDING = 1e-12;                         // of the work, in a difference of energies
  static constexpr double LEAST_RATE = 1e-4, LARGEST_RATE = 10.0;    // for which loading_work is exact to 1e-8

  Law law_ = Law::hertz;
  Variant variant_ = Variant::continuous;
  double yield_factor_ = 1.6, beta_ = 0.0;
  LawConstants constants_;
  double modulus_ = 1.0, shear_modulus_ = 1.0, yield_ = INFINITE, share1_ = 0.5;
  double amplitude_ = 0.9375, pressure_at_yield_ = 0.0, area_exponent_ = 0.0, residual_amplitude_ = 0.0;
  double settled_ = INFINITE;    // peak from which on the unloading exponent meets the energy rule by itself
  const char *fault_ = nullptr;
  double fault_at_ = 0.0;
  double overlap_per_radius_ = INFINITE, force_per_area_ = INFINITE, linear_slope_ = 0.0;

  double pressure(double a) const
  {
    const double limit = constants_.pressure_limit;
    return limit - (limit - pressure_at_yield_) * std::exp(-constants_.pressure_rate * (a - 1.0));
  }

  double linear_area(double a) const { return constants_.area_slope * a - constants_.area_offset; }

  double residual(double peak) const
  {
    return constants_.residual_slope * peak - constants_.residual_offset +
        residual_amplitude_ * std::exp(-constants_.residual_rate * (peak - 1.0));
  }

  /* Goes through peaks from first yield to far beyond every contact. A law is passive if loading rises, if dents lie within
     [0, a_max) and if a larger peak has lost more: then no cycle gives back more than it took. */
  void examine()
  {
    const LawConstants &c = constants_;
    if (!(c.area_switch > 1.0 && linear_area(c.area_switch) > 1.0))
      fault_ = "area_switch and area_slope area_switch - area_offset must both exceed 1";
    else if (!(c.pressure_rate >= LEAST_RATE && c.pressure_rate <= LARGEST_RATE))
      fault_ = "pressure_rate must lie between 1e-4 and 10";
    else if (!(c.unloading_exponent >= 1.0))
      fault_ = "unloading_exponent must be at least 1";
    double before = 1.0, work = 0.4, force = 1.0, dent = 0.0, lost = 0.0;
    for (double step = FIRST_STEP; !fault_ && step < LARGEST_PEAK;) {
      double peak = 1.0 + step;
      if (before < c.area_switch && peak > c.area_switch)
        peak = c.area_switch;    // where the slope of the force may jump: look at it and right behind it
      else if (before == c.area_switch)
        peak = c.area_switch * (1.0 + FIRST_STEP);
      else
        step *= STEP_GROWTH;
      if (peak <= before) continue;
      const double f = loading(peak), r = residual(peak);
      work += step_work(before, peak);
      const double loss = work - f * (peak - r) / (c.unloading_exponent + 1.0), kept = std::max(loss, 0.0);
      if (!(f > force))
        fault_ = "the force of loading does not rise";
      else if (!(r >= dent))
        fault_ = "the residual overlap is negative or falls";
      else if (!(r < peak))
        fault_ = "the residual overlap is not below the largest one";
      else if (!(kept >= lost - ROUNDING * work))
        fault_ = "a larger overlap loses less energy, so that a cycle gives back more than it took";
      if (fault_) fault_at_ = peak;
      settled_ = loss <= 0.0 ? INFINITE : std::min(settled_, peak);
      before = peak;
      force = f;
      dent = r;
      lost = kept;
    }
    if (fault_) settled_ = INFINITE;
  }

  /* integral of pressure(a) a^c3 from 1: 10-point Gauss-Legendre on panels that double */
  double curved_work(double a) const
  {
    double sum = 0.0;
    for (double lo = 1.0; lo < a; lo *= 2.0) sum += panel_work(lo, std::min(2.0 * lo, a));
    return sum;
  }

  double panel_work(double lo, double hi) const
  {
    static constexpr double x[5] = {0.1488743389816312, 0.4333953941292472, 0.6794095682990244, 0.8650633666889845,
                                    0.9739065285171717};
    static constexpr double w[5] = {0.2955242247147529, 0.2692667193099963, 0.2190863625159820, 0.1494513491505806,
                                    0.0666713443086881};
    const double mid = 0.5 * (lo + hi), half = 0.5 * (hi - lo);
    double sum = 0.0;
    for (int k = 0; k < 5; k++)
      for (const double at : {mid - half * x[k], mid + half * x[k]})
        sum += w[k] * pressure(at) * std::pow(at, area_exponent_);
    return half * sum;
  }

  /* work of loading from one overlap to another that is little larger */
  double step_work(double lo, double hi) const
  {
    const double joint = std::min(std::max(lo, constants_.area_switch), hi);
    const double curved = joint > lo ? panel_work(lo, joint) : 0.0;
    return amplitude_ * (hi > joint ? curved + linear_primitive(hi) - linear_primitive(joint) : curved);
  }

  /* primitive of pressure(a) linear_area(a) */
  double linear_primitive(double a) const
  {
    const double limit = constants_.pressure_limit, slope = constants_.area_slope, b = constants_.pressure_rate;
    const double decay = std::exp(-b * (a - 1.0));
    return limit * a * (0.5 * slope * a - constants_.area_offset) +
        (limit - pressure_at_yield_) * decay * (linear_area(a) / b + slope / (b * b));
  }
};

}    // namespace granwave

#endif
