// SPDX-License-Identifier: GPL-2.0-only
/* Contact law of two bodies for Python. */

#ifndef GRANWAVE_BINDINGS_BOUND_CONTACT_H
#define GRANWAVE_BINDINGS_BOUND_CONTACT_H

#include "../laws/cylinders.h"
#include "../laws/partial_slip.h"
#include "arguments.h"
#include "collision.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace granwave::bindings {

namespace py = pybind11;

using Cohesion = std::optional<std::pair<std::string, double>>;    // kind and work of adhesion

/* Cohesion of a contact; ValueError if it is invalid or not supported by this law. */
inline CohesionModel cohesion_of(const LawEntry &entry, const Cohesion &given, bool line)
{
  if (!given) return {};
  const auto &[kind, energy] = *given;
  require(kind == "jkr" || kind == "dmt", "cohesion must be jkr or dmt, found '" + kind + "'");
  require(energy >= 0.0 && std::isfinite(energy), "the work of adhesion must not be negative");
  require(!entry.is_power() && !line, "cohesion requires spheres of two materials");
  require(kind == "dmt" || !entry.yields(), "cohesion jkr requires law hertz; with other laws use dmt");
  return energy == 0.0 ? CohesionModel{} : CohesionModel{kind == "jkr" ? CohesionKind::JKR : CohesionKind::DMT, energy};
}

/* Contact law and contact. History variables of the law, except the largest overlap, have their initial values. */
class BoundContact {
 public:
  BoundContact(const std::string &name, Two modulus, Two poisson, Two yield, Two radius,
               const std::map<std::string, double> &fit, bool checked, std::optional<double> effective_radius,
               const std::optional<LineContact> &line, const Cohesion &cohesion, const py::kwargs &parameters)
  {
    const LawEntry &entry = known_law(name);
    const auto both = [](const Two &two, const auto &holds) { return holds(two.first) && holds(two.second); };
    const auto positive = [](double value) { return value > 0.0; };
    require(both(modulus, positive) && both(yield, positive) && both(radius, positive),
            "moduli, yield strengths and radii must be positive");
    require(both(poisson, [](double nu) { return nu > -1.0 && nu <= 0.5; }), "Poisson's ratio must lie in (-1, 0.5]");
    LawOptions options;
    Material first{modulus.first, poisson.first, yield.first}, second{modulus.second, poisson.second, yield.second};
    for (const auto &[key, value] : parameters) set(key.cast<std::string>(), value, entry, options.values, first, second);
    for (const LawParameter *parameter : entry.parameters)
      require(!parameter->is_required() || options.values.has(*parameter),
              "law " + name + " needs " + parameter->name + ", which must " + must(parameter->range));
    options.fe_constants = fe_constants(entry, fit);
    options.cohesion = cohesion_of(entry, cohesion, line.has_value());
    const bool has_rate = first[RATE_SENSITIVITY] > 0.0 || second[RATE_SENSITIVITY] > 0.0;
    const std::string conflict = entry.conflict_of(options.values, has_rate);
    require(conflict.empty(), conflict);
    law = ContactLaw(entry, first, second, options);
    const std::string fault = checked && entry.has_constants(options.values) ? law.fault() : "";
    require(fault.empty(), "no passive law: " + fault);
    const double effective = effective_radius.value_or(granwave::effective_radius(radius.first, radius.second));
    require(effective > 0.0, "effective_radius must be positive");
    scaled = effective_radius ? ScaledLaw(law, effective) : ScaledLaw(law, effective, radius.first, radius.second);
    if (line) {
      elastic.emplace(*line, (std::isfinite(radius.first) && std::isfinite(radius.second) ? 0.2 : 0.1) * effective);
      scaled = ScaledLaw(law, effective, *elastic);
    } else {
      require(!entry.yields() || std::isfinite(scaled.yield_overlap()), "law '" + name + "' needs a yield strength");
    }
    extra.assign(law.n_extra(), 0.0);
  }
  /* Contact from the words of an input script. */
  BoundContact(const std::vector<std::string> &words, Two radius)
  {
    require(radius.first > 0.0 && radius.second > 0.0, "radii must be positive");
    const LawArguments args = parse_law(words);
    law = args.contact(args.first, args.second.value_or(args.first));
    scaled = ScaledLaw(law, granwave::effective_radius(radius.first, radius.second), radius.first, radius.second);
    extra.assign(law.n_extra(), 0.0);
  }
  BoundContact(const BoundContact &) = delete;    // `scaled` holds a pointer to `law`

  /* State of a contact with cohesion that has reached this peak. */
  CohesiveState sticking(double overlap, double peak) const
  {
    if (!scaled.joins(overlap, peak > 0.0, 0.0)) return {};
    return scaled.cohesive_state(overlap, history(std::max(peak, overlap)));
  }
  double loading_force(double overlap) const
  {
    return scaled.cohesive() ? sticking(overlap, overlap).force : scaled.loading_force(overlap, extra.data());
  }
  double loading_work(double overlap) const
  {
    if (overlap <= 0.0 || !scaled.cohesive()) return scaled.loading_work(overlap, extra.data());
    if (scaled.has_neck()) return sticking(overlap, overlap).energy - scaled.cohesive_state(0.0, history(0.0)).energy;
    return scaled.loading_work(overlap, extra.data()) + sticking(overlap, overlap).energy -
           scaled.elastic_energy(overlap, history(overlap));
  }
  double force(double overlap, double peak) const
  {
    return scaled.cohesive() ? sticking(overlap, peak).force : scaled.force(overlap, history(peak));
  }
  double elastic_energy(double overlap, double peak) const
  {
    if (scaled.cohesive()) return sticking(overlap, peak).energy;
    return scaled.elastic_energy(overlap, history(std::max(peak, overlap)));
  }
  double force_error(double overlap, double peak) const
  {
    const double now = std::max(overlap, 0.0);
    return scaled.force_error(now, history(std::max(peak, now)));
  }
  double restitution_error(double peak) const { return scaled.restitution_error(history(peak)); }
  double dissipated_energy(double peak) const { return scaled.dissipated_energy(history(peak)); }
  double residual_overlap(double peak) const { return scaled.residual_overlap(history(peak)); }
  double unloading_exponent(double peak) const { return scaled.unloading_exponent(history(peak)); }
  double unloading_stiffness(double peak) const { return scaled.unloading_stiffness(history(peak)); }
  double tangent_stiffness(double overlap, double peak) const
  {
    const LawHistory h = history(std::max(peak, overlap));
    if (!scaled.has_neck()) return scaled.tangent_stiffness(overlap, h);
    return scaled.joins(overlap, peak > 0.0, 0.0) ? scaled.cohesive_stiffness(overlap, h) : 0.0;
  }
  /* Branches of a Prony series: pairs of a weight and a time. */
  using Branches = std::vector<std::pair<double, double>>;
  PronySeries series_of(const Branches &branches) const
  {
    require(branches.size() <= PronySeries::MOST, "a Prony series has at most four branches");
    require(!law.entry().yields() && !scaled.cohesive(), "a Prony series requires an elastic law without cohesion");
    PronySeries series;
    for (const auto &[weight, time] : branches) {
      require(weight >= 0.0 && time > 0.0, "weights of a Prony series must not be negative, times must be positive");
      series.weight[series.n] = weight;
      series.time[series.n++] = time;
    }
    require(series.remains() > 0.0, "the weights of a Prony series must sum to less than 1");
    return series;
  }
  ViscousLoss loss_of(const std::optional<double> &time, const std::optional<double> &dashpot,
                      const Branches &branches) const
  {
    require(!(time && dashpot) && (branches.empty() || !(time || dashpot)),
            "use only one of loss_time, loss_dashpot and loss_prony");
    if (!branches.empty()) return {LossKind::PRONY, 0.0, 0.0, series_of(branches)};
    require(time.value_or(0.0) >= 0.0 && dashpot.value_or(0.0) >= 0.0, "damping must not be negative");
    if (time) return {LossKind::TIME, *time};
    return dashpot ? ViscousLoss{LossKind::DASHPOT, *dashpot} : ViscousLoss{};
  }
  py::dict collide(double mass, double speed, const std::optional<double> &time, const std::optional<double> &dashpot,
                   const Branches &branches, int steps) const
  {
    require(mass > 0.0 && speed > 0.0 && steps > 0, "mass, speed and steps must be positive");
    const Collision found = bindings::collide(scaled, loss_of(time, dashpot, branches), mass, speed, steps);
    using namespace py::literals;
    return py::dict("restitution"_a = found.restitution, "duration"_a = found.duration, "peak_force"_a = found.peak_force,
                    "peak_overlap"_a = found.peak_overlap);
  }
  /* Path of a new contact, from the overlaps at these times. */
  py::dict follow(const std::vector<double> &overlap, const std::vector<double> &time) const
  {
    require(overlap.size() == time.size(), "overlap and time must have the same length");
    std::vector<double> block(extra), force, elastic, dissipated, factor;
    double peak = 0.0;
    for (std::size_t k = 0; k < overlap.size(); k++) {
      const double x = overlap[k], dt = k > 0 ? time[k] - time[k - 1] : 0.0;
      require(k == 0 || dt > 0.0, "times must increase");
      if (x > 0.0) scaled.update(x, peak, k > 0 ? (x - overlap[k - 1]) / dt : 0.0, block.data());
      peak = std::max(peak, x);
      const LawHistory h{peak, block.data()};
      force.push_back(scaled.force(x, h));
      elastic.push_back(scaled.elastic_energy(x, h));
      dissipated.push_back(scaled.dissipated_energy(h));
      factor.push_back(law.rate() && block[0] > 0.0 ? block[0] : 1.0);
    }
    using namespace py::literals;
    const auto array = [](const std::vector<double> &values) { return py::array_t<double>(values.size(), values.data()); };
    return py::dict("force"_a = array(force), "elastic_energy"_a = array(elastic), "dissipated_energy"_a = array(dissipated),
                    "rate_factor"_a = array(factor));
  }
  /* Path of a new contact that relaxes, from the overlaps at these times. */
  py::dict relax(const std::vector<double> &overlap, const std::vector<double> &time, const Branches &series_given) const
  {
    require(overlap.size() == time.size(), "overlap and time must have the same length");
    require(!series_given.empty(), "loss_prony must have a branch");
    const PronySeries series = series_of(series_given);
    PronyHistory branches;
    double lost = 0.0;
    std::vector<double> force, stored, dissipated, surface;
    for (std::size_t k = 0; k < overlap.size(); k++) {
      const double of_law = overlap[k] > 0.0 ? scaled.elastic_force(overlap[k]) : 0.0;
      require(k == 0 || time[k] > time[k - 1], "times must increase");
      if (k == 0) branches.start(series, scaled, std::max(overlap[k], 0.0), of_law);
      else lost += branches.advance(series, scaled, overlap[k], of_law, time[k] - time[k - 1]);
      force.push_back(branches.force);
      stored.push_back(branches.stored);
      dissipated.push_back(lost);
      surface.push_back(branches.surface);
    }
    using namespace py::literals;
    const auto array = [](const std::vector<double> &values) { return py::array_t<double>(values.size(), values.data()); };
    return py::dict("force"_a = array(force), "elastic_energy"_a = array(stored), "dissipated_energy"_a = array(dissipated),
                    "surface_overlap"_a = array(surface));
  }
  double rate_factor(double overlap, double velocity) const
  {
    return law.rate() ? law.rate().factor(scaled.normalised(overlap), velocity / scaled.effective_radius()) : 1.0;
  }
  double contact_radius(double overlap, double peak) const { return std::sqrt(circle_squared(overlap, peak)); }
  double circle_squared(double overlap, double peak) const
  {
    return scaled.cohesive() ? sticking(overlap, peak).circle_squared : scaled.circle_squared(overlap, history(peak));
  }
  double peak_contact_radius(double peak) const { return contact_radius(peak, peak); }
  double tangential_stiffness(double overlap, double peak) const
  {
    return law.tangential_stiffness(std::sqrt(circle_squared(overlap, peak)));
  }

  py::dict friction_path(const py::array_t<double> &overlaps, const py::array_t<double> &slips, double friction,
                         const std::string &model, int cells) const
  {
    if (cells == 8) return path<8>(overlaps, slips, friction, model);
    if (cells == 16) return path<16>(overlaps, slips, friction, model);
    if (cells == 32) return path<32>(overlaps, slips, friction, model);
    throw py::value_error("cells must be 8, 16 or 32");
  }

  /* Tangential force, stored energy and loss along a path of overlaps and slips in the tangent plane. */
  template <int N>
  py::dict path(const py::array_t<double> &overlaps, const py::array_t<double> &slips, double friction,
                const std::string &model) const
  {
    const auto overlap = overlaps.unchecked<1>();
    const auto slip = slips.unchecked<2>();
    const py::ssize_t n = overlap.shape(0);
    require(slip.shape(0) == n && slip.shape(1) == 2, "slip must have the shape (n, 2)");
    const TangentialModel kind = tangential_model(model);
    py::array_t<double> force({n, py::ssize_t(2)}), stored(n), lost(n);
    TangentialSpring spring;
    std::array<double, SlipCells<N>::SIZE> doubles{};
    SlipCells<N> cells(doubles.data());
    double peak = 0.0;
    for (py::ssize_t m = 0; m < n; m++) {
      peak = std::max(peak, overlap(m));
      const double normal_force = overlap(m) > 0.0 ? scaled.force(overlap(m), history(peak)) : 0.0;
      if (normal_force > 0.0 && friction > 0.0) {
        const SlipContact contact{{0.0, 0.0, 1.0},
                                  {slip(m, 0), slip(m, 1), 0.0},
                                  contact_radius(overlap(m), peak),
                                  tangential_stiffness(overlap(m), peak),
                                  friction * normal_force,
                                  scaled.effective_radius()};
        if (kind == TangentialModel::PARTIAL_SLIP) cells.advance(spring, contact);
        else compute_tangential(spring, contact.normal, contact.slip, contact.stiffness, contact.limit, kind);
      } else if (cells.active()) {
        cells.release(spring);
      } else {
        release(spring);
      }
      for (int d = 0; d < 2; d++) force.mutable_at(m, d) = spring.force[d];
      stored.mutable_at(m) = SlipCells<N>::energy(doubles.data(), spring);
      lost.mutable_at(m) = spring.loss;
    }
    using namespace py::literals;
    return py::dict("force"_a = force, "stored_energy"_a = stored, "loss"_a = lost);
  }

  ContactLaw law;
  std::optional<ElasticContact> elastic;    // along a line
  ScaledLaw scaled;

 private:
  std::vector<double> extra;
  LawHistory history(double peak) const { return {peak, extra.data()}; }

  /* Set a parameter of the contact, or of both materials, which may have parameters of other laws. */
  static void set(const std::string &name, py::handle value, const LawEntry &entry, LawValues &values, Material &first,
                  Material &second)
  {
    const LawParameter *const parameter = find_parameter(name);
    require(parameter, "'" + name + "' is no parameter of a law");
    if (parameter->is_of_material()) {
      const auto [value1, value2] = value.cast<std::pair<py::object, py::object>>();
      first.values.set(*parameter, from_python(*parameter, value1));
      second.values.set(*parameter, from_python(*parameter, value2));
      return;
    }
    values.set(*parameter, from_python(*parameter, value));
    require(entry.takes(*parameter), "'" + name + "' must be omitted: it is not an option of law '" + entry.name + "'");
  }

  /* Constants of elastoplastic-fe, with changes of its fit. */
  static FeConstants fe_constants(const LawEntry &entry, const std::map<std::string, double> &fit)
  {
    FeConstants constants;
    require(fit.empty() || entry.takes(HARDENING), "fit contains constants of law elastoplastic-fe");
    for (const auto &[key, value] : fit) {
      const auto *const constant = std::find_if(std::begin(FE_CONSTANTS), std::end(FE_CONSTANTS),
                                                [&name = key](const auto &row) { return name == row.first; });
      require(constant != std::end(FE_CONSTANTS), "fit: '" + key + "' is no constant of the law");
      require(std::isfinite(value), "fit: constants must be finite numbers, found " + key);
      constants.*constant->second = value;
    }
    return constants;
  }
};

/* Define the Python class ContactLaw. */
void bind_contact(pybind11::module_ &module);

}    // namespace granwave::bindings

#endif
