// SPDX-License-Identifier: GPL-2.0-only
/* Contact law of a pair of materials in normalized units (ContactLaw), and in physical units for one contact (ScaledLaw), for
   the LAMMPS styles and the Python bindings. No LAMMPS types. SI or any other consistent units. */

#ifndef GRANWAVE_CONTACT_LAW_H
#define GRANWAVE_CONTACT_LAW_H

#include "elastic_contact.h"
#include "law_table.h"

#include <algorithm>
#include <optional>

namespace granwave {

/* History variables of a contact that enter its law. */
struct LawHistory {
  double peak;            // largest overlap
  const double *extra;    // further history variables of the law, n_extra doubles
};

constexpr int RATE_EXTRA = RateDependent<Elastoplastic>::N_EXTRA;

/* A law with a rate-dependent yield strength, derived from the rate-independent law. */
inline AnyLaw with_rate(const AnyLaw &any, const RateModel &model)
{
  return std::visit(
      [&](const auto &law) -> AnyLaw {
        using Law = std::decay_t<decltype(law)>;
        if constexpr (std::is_constructible_v<AnyLaw, RateDependent<Law>>) return RateDependent<Law>(law, model);
        else return law;
      },
      any);
}

/* Law of a pair of materials, in units of the overlap and force at first yield (normal_law.h). */
class ContactLaw {
  template <class Function> auto with(const Function &function) const { return std::visit(function, normal_); }

 public:
  ContactLaw() : ContactLaw(law_table().front(), {1.0, 0.0, INFINITE}, {1.0, 0.0, INFINITE}, {}) {}

  ContactLaw(const LawEntry &entry, const Material &m1, const Material &m2, const LawOptions &options) :
      entry_(&entry), values_(options.values), cohesion_(options.cohesion), modulus_(granwave::effective_modulus(m1, m2)),
      shear_modulus_(granwave::effective_shear_modulus(m1, m2)), yield_(std::min(m1.yield_strength, m2.yield_strength)),
      share1_(m1.yield_strength == m2.yield_strength ? 0.5 : (m1.yield_strength < m2.yield_strength ? 1.0 : 0.0))
  {
    const double pressure =
        entry.exact_yield ? ElastoplasticFe::yield_pressure(m1, m2) : options.values[YIELD_FACTOR] * yield_;
    const double ratio = pressure / modulus_;
    overlap_per_radius_ = std::isfinite(yield_) ? 0.25 * PI * PI * ratio * ratio : INFINITE;
    force_per_area_ = std::isfinite(yield_) ? 4.0 / 3.0 * modulus_ * power(overlap_per_radius_, 1.5) : INFINITE;
    normal_ = entry.make(options, {yield_, overlap_per_radius_, force_per_area_, m1, m2});
    const auto softness = [](const Material &m) {
      return std::make_tuple(m.yield_strength, m[RATE_SENSITIVITY], m[REFERENCE_RATE]);
    };
    const Material &softer = softness(m2) < softness(m1) ? m2 : m1;
    if (entry.takes(RATE_SENSITIVITY))
      rate_ = {softer[RATE_SENSITIVITY], softer[REFERENCE_RATE], overlap_per_radius_, share1_ == 0.5 ? 0.5 : 1.0};
    if (rate_) normal_ = with_rate(normal_, rate_);
    if (entry.is_power())
      elastic_.emplace(
          PowerContact{entry.no_force ? 0.0 : values_[POWER_CONSTANT], entry.no_force ? 1.5 : values_[POWER_EXPONENT]});
  }

  const LawEntry &entry() const { return *entry_; }
  const AnyLaw &normal() const { return normal_; }
  // values of parameters of the contact
  const LawValues &values() const { return values_; }
  // constants of a power of the overlap
  const ElasticContact *elastic() const { return elastic_ ? &*elastic_ : nullptr; }
  const CohesionModel &cohesion() const { return cohesion_; }
  std::string fault() const
  {
    return with([](const auto &law) { return law.fault(); });
  }
  double modulus() const { return modulus_; }
  double shear_modulus() const { return shear_modulus_; }
  double yield_strength() const { return yield_; }
  const RateModel &rate() const { return rate_; }
  /* Doubles of history beyond the largest overlap. */
  int n_extra() const { return entry_->n_extra + (rate_ ? RATE_EXTRA : 0); }
  // fraction of the dissipated energy: all of it for the softer sphere
  double share_of_first() const { return share1_; }
  double overlap_per_radius() const { return overlap_per_radius_; }
  double force_per_area() const { return force_per_area_; }

  bool yields(double peak) const { return peak > entry_->elastic_limit; }
  double loading(double a, const Site &site) const
  {
    return a <= 0.0 ? 0.0 : with([&](const auto &law) { return law.loading(a, site); });
  }
  double loading_slope(double a, const Site &site) const
  {
    return a <= 0.0 ? 0.0 : with([&](const auto &law) { return law.loading_slope(a, site); });
  }
  double loading_work(double a, const Site &site) const
  {
    return a <= 0.0 ? 0.0 : with([&](const auto &law) { return law.loading_work(a, site); });
  }
  Turning turning(double peak, const Site &site) const
  {
    return yields(peak) ? with([&](const auto &law) { return law.turning(peak, site); })
                        : Turning{peak, loading(peak, site), 0.0, 1.5};
  }
  double dissipated_energy(const Turning &t, const Site &site) const
  {
    return yields(t.peak) ? with([&](const auto &law) { return law.dissipated_energy(t, site); }) : 0.0;
  }
  double area(double a, const Site &site) const
  {
    return with([&](const auto &law) { return law.area(a, site); });
  }
  double area_slope(double a, const Site &site) const
  {
    constexpr double STEP = 1e-5;    // relative
    return (area(a + STEP * a, site) - area(a - STEP * a, site)) / (2.0 * STEP * a);
  }
  ErrorBar error_bar(double peak, const Site &site) const
  {
    return with([&](const auto &law) { return law.error_bar(peak, site); });
  }
  bool update(double a, double peak, double rate, const Site &site, double *extra) const
  {
    return with([&](const auto &law) { return law.update(a, peak, rate, site, extra); });
  }

  /* k_t = 8 G* a of a contact circle of this radius, in physical units. */
  double tangential_stiffness(double circle) const { return 8.0 * shear_modulus_ * circle; }

 private:
  const LawEntry *entry_;
  LawValues values_;
  CohesionModel cohesion_;
  double modulus_, shear_modulus_, yield_, share1_;
  double overlap_per_radius_, force_per_area_;
  RateModel rate_;
  AnyLaw normal_;
  std::optional<ElasticContact> elastic_;
};

/* Law of one contact, in physical units. Holds a pointer to the law of the pair of materials, and to the law of an
   elastic contact other than Hertz's, if it is one: a line contact, whose materials do not yield, or a power of the
   overlap. */
class ScaledLaw {
 public:
  ScaledLaw() = default;
  /* Contact of two bodies of these radii; 0 or infinite: a plane. */
  ScaledLaw(const ContactLaw &law, double effective_radius, double r1, double r2) : ScaledLaw(law, effective_radius)
  {
    share1_ = r1 > 0.0 ? effective_radius / r1 : 0.0;
    share2_ = r2 > 0.0 ? effective_radius / r2 : 0.0;
  }
  ScaledLaw(const ContactLaw &law, double effective_radius) :
      law_(&law), elastic_(law.elastic()), effective_radius_(effective_radius),
      hertz_(4.0 / 3.0 * law.modulus() * std::sqrt(effective_radius)), overlap_(law.overlap_per_radius() * effective_radius),
      force_(law.force_per_area() * effective_radius * effective_radius)
  {
    const double limit = law.entry().elastic_limit;
    elastic_limit_ = limit > 0.0 && std::isfinite(limit) ? limit * overlap_ : limit;
    if (!law.cohesion()) return;
    cohesion_ = law.cohesion().kind;
    pull_per_length_ = 2.0 * PI * law.cohesion().energy;
    if (cohesion_ == CohesionKind::JKR) neck_ = Neck(law.modulus(), effective_radius, law.cohesion().energy);
  }
  ScaledLaw(const ContactLaw &law, double effective_radius, const ElasticContact &elastic) : ScaledLaw(law, effective_radius)
  {
    if (!elastic_) elastic_ = &elastic;
    overlap_ = force_ = elastic_limit_ = INFINITE;
  }

  const ContactLaw &law() const { return *law_; }
  double effective_radius() const { return effective_radius_; }
  double hertz() const { return hertz_; }                    // F = hertz alpha^1.5 up to the elastic limit
  double elastic_limit() const { return elastic_limit_; }    // overlap up to which the contact is Hertzian, without history
  double yield_overlap() const { return overlap_; }
  double yield_force() const { return force_; }

  Site site(const double *extra) const { return {extra, share1_, share2_}; }
  bool yielded(double peak) const { return peak > elastic_limit_; }
  double normalised(double overlap) const { return overlap / overlap_; }

  bool is_hertzian() const { return !elastic_; }                                       // within the elastic limit
  const LineContact *line() const { return elastic_ ? elastic_->line() : nullptr; }    // null for other laws
  /* Contacts within their elastic limit: Hertz's law, or another elastic law. */
  double elastic_force(double overlap) const
  {
    return elastic_ ? elastic_->force(overlap) : hertz_ * overlap * std::sqrt(overlap);
  }
  double elastic_energy(double overlap) const
  {
    return elastic_ ? elastic_->energy(overlap) : 0.4 * hertz_ * overlap * overlap * std::sqrt(overlap);
  }
  double elastic_stiffness(double overlap) const
  {
    return elastic_ ? elastic_->stiffness(overlap) : 1.5 * hertz_ * std::sqrt(overlap);
  }
  double elastic_overlap(double force) const    // with this force
  {
    return elastic_ ? elastic_->overlap(force) : std::cbrt(force / hertz_ * (force / hertz_));
  }
  double largest_overlap() const { return elastic_ ? elastic_->largest_overlap() : INFINITE; }    // end of the law
  /* Overlap above which the law is not valid. */
  double valid_overlap() const
  {
    if (elastic_) return elastic_->valid();
    return law_->entry().fitted ? 0.2 * effective_radius_ : INFINITE;
  }

  /* Update the history block of the law, for a contact with positive overlap and this velocity of approach, before its peak is
     increased. Returns true if the block has changed. */
  bool update(double overlap, double peak, double velocity, double *extra) const
  {
    return law_->update(normalised(overlap), normalised(peak), velocity / effective_radius_, site(extra), extra);
  }

  /* ---- contacts that have yielded */

  Turning turning(const LawHistory &h) const { return law_->turning(normalised(h.peak), site(h.extra)); }
  double loading_beyond_yield(double overlap, const double *extra) const
  {
    return force_ * law_->loading(normalised(overlap), site(extra));
  }
  double unloading(double overlap, const Turning &t) const { return force_ * t.unloading(normalised(overlap)); }
  double peak_force(const Turning &t) const { return force_ * t.force; }
  double elastic_energy(double overlap, const Turning &t) const
  {
    return force_ * overlap_ * t.elastic_energy(normalised(overlap));
  }
  double dissipated_energy(const Turning &t, const double *extra) const
  {
    return force_ * overlap_ * law_->dissipated_energy(t, site(extra));
  }
  double stiffness(const Turning &t) const { return force_ / overlap_ * t.slope(); }
  /* Squared radius of the contact circle, normalized. */
  double area(double a, const double *extra) const { return law_->area(a, site(extra)); }
  double loading_circle(double overlap, const double *extra) const
  {
    return effective_radius_ * overlap_ * area(normalised(overlap), extra);
  }
  double unloading_circle(double overlap, const Turning &t, double area_at_peak) const
  {
    return effective_radius_ * overlap_ * t.area(normalised(overlap), area_at_peak);
  }

  /* ---- all contacts */

  double loading_force(double overlap, const double *extra) const
  {
    if (overlap <= 0.0) return 0.0;
    return yielded(overlap) ? loading_beyond_yield(overlap, extra) : elastic_force(overlap);
  }

  /* Overlap at which the force had reached a fraction of the force at a larger overlap, on loading; below an initial dent on
     its reloading curve. */
  double overlap_at_part(double overlap, double part, const double *extra, const LawHistory &initial) const
  {
    const bool dented = yielded(initial.peak);
    if (!dented && !yielded(overlap) && is_hertzian()) return overlap * std::cbrt(part * part);
    const Turning dent = dented ? turning(initial) : Turning{};
    const double highest = dented && overlap < initial.peak ? unloading(overlap, dent) : loading_force(overlap, extra);
    const double wanted = part * highest;
    if (dented && wanted < peak_force(dent)) {
      const double elongation = std::pow(wanted / peak_force(dent), 1.0 / dent.exponent);
      return std::min(overlap, overlap_ * (dent.residual + (dent.peak - dent.residual) * elongation));
    }
    return overlap_on_loading(wanted, overlap, highest, extra);
  }

  double loading_work(double overlap, const double *extra) const
  {
    if (overlap <= 0.0) return 0.0;
    return yielded(overlap) ? force_ * overlap_ * law_->loading_work(normalised(overlap), site(extra))
                            : elastic_energy(overlap);
  }

  /* ---- cohesion; forces and energies of the functions above do not include it */

  bool cohesive() const { return cohesion_ != CohesionKind::NONE; }
  bool has_neck() const { return cohesion_ == CohesionKind::JKR; }
  double neck_length() const { return neck_.length(); }    // largest gap of surfaces that are held by a neck
  double pull_off() const { return has_neck() ? neck_.pull_off() : pull_per_length_ * effective_radius_; }    // without dent

  /* Return true if surfaces touch or are joined by a neck; `joined` is the answer at the last step. Smaller overlaps than
     `rounding` are none. */
  bool joins(double overlap, bool joined, double rounding) const
  {
    return overlap > rounding || (joined && has_neck() && overlap > -neck_.length());
  }

  /* State of a cohesive contact; `turning` is the turning point of its peak if it has yielded. */
  CohesiveState cohesive_state(double overlap, const LawHistory &h, const Turning *turning) const
  {
    if (has_neck()) return neck_.at(overlap);
    const bool loads = overlap >= h.peak;
    if (overlap <= 0.0 || (turning && !loads && normalised(overlap) <= turning->residual)) return {};
    CohesiveState s;
    double law_force = 0.0;
    if (!turning) {
      law_force = elastic_force(overlap);
      s.energy = elastic_energy(overlap);
      s.circle_squared = effective_radius_ * overlap;
    } else {
      law_force = loads ? loading_beyond_yield(overlap, h.extra) : unloading(overlap, *turning);
      s.energy = elastic_energy(overlap, *turning);
      s.circle_squared =
          loads ? loading_circle(overlap, h.extra) : unloading_circle(overlap, *turning, area(turning->peak, h.extra));
    }
    const double pull = pull_of(loads, overlap, turning);
    s.force = law_force - pull;
    s.pressing = law_force + pull;
    s.energy -= pull_per_length_ * s.circle_squared;
    return s;
  }
  CohesiveState cohesive_state(double overlap, const LawHistory &h) const
  {
    const double peak = std::max(overlap, h.peak);
    if (has_neck() || !yielded(peak)) return cohesive_state(overlap, h, nullptr);
    const Turning t = turning({peak, h.extra});
    return cohesive_state(overlap, {peak, h.extra}, &t);
  }

  /* Snap-in or separation of the surfaces. */
  Jump jump(bool meets, double overlap, double peak, const Turning *turning) const
  {
    if (has_neck()) return neck_.jump(meets);
    if (!turning || (meets && overlap >= peak)) return {0.0, -pull_per_length_ * effective_radius_};
    return {overlap_ * turning->residual, -pull_of(false, overlap, turning)};
  }

  /* Slope of the force at an overlap. */
  double cohesive_stiffness(double overlap, const LawHistory &h) const
  {
    return has_neck() ? neck_.stiffness(overlap) : tangent_stiffness(overlap, h);
  }

  /* Overlap on first loading at zero contact force; 0 without cohesion. */
  double balanced_overlap() const
  {
    if (has_neck()) return neck_.balanced();
    if (!cohesive()) return 0.0;
    const std::vector<double> zero(std::max(law_->entry().n_extra, 1), 0.0);
    double low = 0.0, high = effective_radius_;
    for (int n = 0; n < 200; n++) {
      const double middle = 0.5 * (low + high);
      (cohesive_state(middle, {middle, zero.data()}).force < 0.0 ? low : high) = middle;
    }
    return high;
  }

  /* Force at an overlap; beyond the peak the force on the loading curve. */
  double force(double overlap, const LawHistory &h) const
  {
    return overlap >= h.peak || !yielded(h.peak) ? loading_force(overlap, h.extra) : unloading(overlap, turning(h));
  }

  double peak_force(const LawHistory &h) const { return yielded(h.peak) ? peak_force(turning(h)) : elastic_force(h.peak); }

  /* Energy stored at an overlap up to the peak, 0 if the surfaces do not touch. */
  double elastic_energy(double overlap, const LawHistory &h) const
  {
    if (overlap <= 0.0) return 0.0;
    return yielded(h.peak) ? elastic_energy(overlap, turning(h)) : elastic_energy(overlap);
  }

  /* Energy stored along the normal, with cohesion including that of the joined surfaces; 0 if the surfaces do not touch.

     joined    with cohesion: true if the surfaces touch or are held by a neck
     known     turning point of the peak, if it has been computed */
  double stored_energy(double overlap, const LawHistory &h, bool joined, const Turning *known = nullptr) const
  {
    if (cohesive() ? !joined : !(overlap > 0.0)) return 0.0;
    const LawHistory present{std::max(overlap, h.peak), h.extra};
    const bool has_branch = yielded(present.peak) && !has_neck();
    Turning branch{};
    if (has_branch) branch = known && overlap <= h.peak ? *known : turning(present);
    if (cohesive()) return cohesive_state(overlap, present, has_branch ? &branch : nullptr).energy;
    return has_branch ? elastic_energy(overlap, branch) : elastic_energy(overlap);
  }

  /* Dissipated energy of the contact once the peak has been reached. */
  double dissipated_energy(const LawHistory &h) const
  {
    return yielded(h.peak) ? dissipated_energy(turning(h), h.extra) : 0.0;
  }

  double residual_overlap(const LawHistory &h) const { return yielded(h.peak) ? overlap_ * turning(h).residual : 0.0; }
  double unloading_exponent(const LawHistory &h) const { return yielded(h.peak) ? turning(h).exponent : 1.5; }

  /* Error bar of the force that the law states, not a number where it states none: below the peak that of the peak force plus
     that of the unloading curve. */
  double force_error(double overlap, const LawHistory &h) const
  {
    if (elastic_ || cohesive()) return NAN;
    const double peak = std::max(overlap, h.peak);
    const ErrorBar bar = law_->error_bar(normalised(peak), site(h.extra));
    const double of_peak = overlap < h.peak ? bar.unloading * peak_force(h) : 0.0;
    return of_peak + bar.force * std::abs(force(overlap, h));
  }

  /* Error bar of the coefficient of restitution of a collision with this peak, absolute. */
  double restitution_error(const LawHistory &h) const
  {
    if (elastic_ || cohesive()) return NAN;
    const double work = loading_work(h.peak, h.extra), lost = dissipated_energy(h);
    return law_->error_bar(normalised(h.peak), site(h.extra)).restitution * std::sqrt(std::max(0.0, 1.0 - lost / work));
  }

  /* Tangent stiffness: slope of the force against the overlap, on loading at the peak, on unloading below it. */
  double tangent_stiffness(double overlap, const LawHistory &h) const
  {
    if (overlap <= 0.0) return 0.0;
    if (!yielded(std::max(overlap, h.peak))) return elastic_stiffness(overlap);
    const double a = normalised(overlap);
    return force_ / overlap_ * (overlap >= h.peak ? law_->loading_slope(a, site(h.extra)) : turning(h).slope(a));
  }
  double tangent_stiffness(double overlap, const Turning &t) const
  {
    return force_ / overlap_ * t.slope(normalised(overlap));
  }

  /* Slope of the force at the start of unloading. */
  double unloading_stiffness(const LawHistory &h) const
  {
    if (yielded(h.peak)) return stiffness(turning(h));
    return h.peak > 0.0 ? elastic_stiffness(h.peak) : 0.0;
  }

  /* Radius of the contact circle, squared; for an elastic law other than Hertz's, that of the Hertzian contact with the
     same stiffness, so that k_t/k_n is that of Mindlin. */
  double circle_squared(double overlap, const LawHistory &h) const
  {
    if (overlap <= 0.0) return 0.0;
    if (elastic_) return circle_squared(elastic_->stiffness(overlap));
    if (!yielded(std::max(overlap, h.peak))) return effective_radius_ * overlap;
    return overlap >= h.peak ? loading_circle(overlap, h.extra)
                             : unloading_circle(overlap, turning(h), area(normalised(h.peak), h.extra));
  }

  /* Same for an elastic law other than Hertz's, from its stiffness. */
  double circle_squared(double stiffness) const
  {
    const double radius = 0.5 * stiffness / law_->modulus();
    return radius * radius;
  }

 private:
  const ContactLaw *law_ = nullptr;
  const ElasticContact *elastic_ = nullptr;
  double effective_radius_ = 0.0, hertz_ = 0.0, overlap_ = INFINITE, force_ = INFINITE, elastic_limit_ = INFINITE;
  double share1_ = 0.5, share2_ = 0.5;
  CohesionKind cohesion_ = CohesionKind::NONE;
  double pull_per_length_ = 0.0;    // DMT: pull-off force / slope of the squared radius of the contact circle
  Neck neck_;

  /* Overlap of a force on the loading curve below a known point, by secants in logarithms: exact for a power law. */
  double overlap_on_loading(double wanted, double overlap, double force, const double *extra) const
  {
    constexpr int SECANTS = 4;
    constexpr double USUAL_EXPONENT = 1.25;
    double before = std::log(overlap), log_before = std::log(force);
    double place = before + std::log(wanted / force) / USUAL_EXPONENT;
    for (int n = 0; n < SECANTS; n++) {
      const double log_force = std::log(loading_force(std::exp(place), extra));
      const double slope = (log_force - log_before) / (place - before);
      before = place;
      log_before = log_force;
      const double change = (std::log(wanted) - log_force) / slope;
      if (!std::isfinite(change) || change == 0.0) break;
      place += change;
    }
    return std::min(std::exp(place), overlap);
  }

  // cohesion has no rate dependence: no history
  double pull_of(bool loads, double overlap, const Turning *turning) const
  {
    double slope = 1.0;    // slope of the squared radius of the circle over R* times the overlap
    if (turning)
      slope = loads ? law_->area_slope(normalised(overlap), site(nullptr))
                    : area(turning->peak, nullptr) / (turning->peak - turning->residual);
    return pull_per_length_ * effective_radius_ * slope;
  }
};

}    // namespace granwave

#endif
