// SPDX-License-Identifier: GPL-2.0-only
/* Python bindings of the contact laws: the table of laws, and the law of one contact, with numpy arrays and SI units. */

#include "../laws/cylinders.h"
#include "../laws/law_arguments.h"
#include "../laws/load_shape.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <iterator>
#include <map>
#include <memory>
#include <sstream>

namespace py = pybind11;
using namespace granwave;

namespace {

using Two = std::pair<double, double>;
using Cohesion = std::optional<std::pair<std::string, double>>;    // kind and work of adhesion

void require(bool holds, const std::string &fault)
{
  if (!holds) throw py::value_error(fault);
}

std::pair<Material, Material> elastic_bodies(Two modulus, Two poisson)
{
  return {{modulus.first, poisson.first, INFINITE}, {modulus.second, poisson.second, INFINITE}};
}

/* Value of a parameter in Python: a number or a word. */
py::object as_python(const LawParameter &parameter, double value)
{
  if (parameter.is_word()) return py::str(parameter.words[static_cast<std::size_t>(value)]);
  return py::float_(value);
}

double from_python(const LawParameter &parameter, py::handle object)
{
  const std::string name(parameter.name);
  if (!parameter.is_word()) {
    const double value = object.cast<double>();
    require(std::isfinite(value), name + " must be a finite number");
    require(parameter.range.holds(value), name + " must " + must(parameter.range));
    return value;
  }
  const std::string word = object.cast<std::string>();
  const int value = parameter.number_of(word);
  require(value >= 0, name + " must be " + parameter.all_words(" or ") + ", found '" + word + "'");
  return value;
}

/* Bounds of a range by the names that the schema of case files has for them. */
py::dict bounds(const Range &range)
{
  const auto plain = [](double bound) {    // 1, not 1.0
    return bound == std::floor(bound) ? py::object(py::int_(static_cast<long>(bound))) : py::object(py::float_(bound));
  };
  py::dict keywords;
  if (std::isfinite(range.low)) keywords[range.with_low ? "at_least" : "above"] = plain(range.low);
  if (std::isfinite(range.high)) keywords[range.with_high ? "at_most" : "below"] = plain(range.high);
  return keywords;
}

/* Constants of the curve of a law, by name. */
py::dict constants_of(const LawEntry &entry, const LawValues &values)
{
  py::dict constants;
  for (const LawParameter *parameter : entry.parameters)
    if (parameter->is_optional() && !parameter->is_of_material())
      constants[parameter->name] = as_python(*parameter, values[*parameter]);
  return constants;
}

const LawParameter *find_parameter(const std::string &name)
{
  for (const LawParameter *parameter : law_parameters())
    if (name == parameter->name) return parameter;
  return nullptr;
}

const LawEntry &known_law(const std::string &name)
{
  const LawEntry *const entry = find_law(name);
  require(entry, "law must be one of " + law_names(", ") + ", found '" + name + "'");
  return *entry;
}

/* Head-on collision of two bodies with a contact law and a viscous loss, by the classical Runge-Kutta method. */
struct Collision {
  double restitution;    // speed of separation over that of approach, 0 if the bodies do not part, NaN if nothing stops them
  double duration, peak_force, peak_overlap;
};

/* Collide bodies of an effective mass with a speed of approach. `steps` is about the number of steps in the collision. */
Collision collide(const ScaledLaw &law, const ViscousLoss &loss, double mass, double speed, int steps)
{
  constexpr double MOST_OVERLAP = 4.0;    // over the effective radius
  constexpr double LONGEST = 50.0;    // end of a collision in which the bodies do not part, over its duration without loss
  // the time scale: overlap at which first loading has taken up the kinetic energy, over the speed
  const std::vector<double> zero(std::max(law.law().n_extra(), 1), 0.0);
  const double energy = 0.5 * mass * speed * speed + law.pull_off() * law.balanced_overlap();
  double low = 0.0, high = 1e-9 * law.effective_radius();
  const double most = std::min(law.largest_overlap(), MOST_OVERLAP * law.effective_radius());
  while (high < most && law.loading_work(high, zero.data()) < energy) high *= 2.0;
  if (!(high < most)) return {NAN, NAN, NAN, NAN};
  for (int n = 0; n < 60; n++) {
    const double middle = 0.5 * (low + high);
    (law.loading_work(middle, zero.data()) < energy ? low : high) = middle;
  }
  const double scale = 2.9432 * high / std::sqrt(2.0 * energy / mass);    // duration of a Hertzian collision
  const double least = -law.neck_length();

  std::vector<double> extra(zero);
  double peak = 0.0, peak_force = 0.0, t = 0.0, x = 0.0, v = speed;
  const auto force = [&](double overlap, double rate) {
    if (overlap <= least) return 0.0;
    const LawHistory h{std::max(peak, overlap), extra.data()};
    if (law.cohesive()) {
      const CohesiveState state = law.cohesive_state(overlap, h);
      const double c = loss.coefficient(2.0 * law.law().modulus() * std::sqrt(state.circle_squared), mass);
      return state.force + viscous_force(state.force + law.pull_off(), c, rate);
    }
    const double of_law = law.force(overlap, h);
    return of_law + viscous_force(of_law, loss.coefficient(law.tangent_stiffness(overlap, h), mass), rate);
  };
  const double usual = scale / steps;
  bool parts = !law.cohesive();    // false while bodies may stick
  while (t < LONGEST * scale) {
    // a loss that is large beside the inertia needs shorter steps
    const LawHistory h{std::max(peak, x), extra.data()};
    const double at_start = x, v_start = v;
    const double c = x > 0.0 ? loss.coefficient(law.tangent_stiffness(x, h), mass) : 0.0;
    const double dt = c > 0.0 ? std::min(usual, 0.5 * mass / c) : usual;
    const auto slope = [&](double at, double rate) { return -force(at, rate) / mass; };
    const double a1 = slope(x, v), v2 = v + 0.5 * dt * a1, a2 = slope(x + 0.5 * dt * v, v2), v3 = v + 0.5 * dt * a2,
                 a3 = slope(x + 0.5 * dt * v2, v3), v4 = v + dt * a3, a4 = slope(x + dt * v3, v4);
    x += dt / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
    v += dt / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    t += dt;
    if (x <= least) {
      if (law.has_neck())    // the force at its end is singular
        v = -std::sqrt(
            std::max(0.0, v_start * v_start -
                              2.0 / mass * (law.cohesive_state(least, h).energy - law.cohesive_state(at_start, h).energy)));
      parts = true;
      break;
    }
    law.update(x, peak, v, extra.data());
    peak = std::max(peak, x);
    const double f = force(x, v);
    peak_force = std::max(peak_force, f);
    if (v < 0.0 && f == 0.0) {    // no force from here on: nothing slows the separation
      parts = true;
      break;
    }
  }
  return {parts && v < 0.0 ? -v / speed : 0.0, t, peak_force, peak};
}

CohesionModel cohesion_of(const LawEntry &entry, const Cohesion &given, bool line)
{
  if (!given) return {};
  const auto &[kind, energy] = *given;
  require(kind == "jkr" || kind == "dmt", "cohesion must be jkr or dmt, found '" + kind + "'");
  require(energy >= 0.0 && std::isfinite(energy), "the work of adhesion must not be negative");
  require(!entry.is_power() && !line, "cohesion is of spheres of two materials");
  require(kind == "dmt" || !entry.yields(), "cohesion jkr is of law hertz; with others take dmt");
  return energy == 0.0 ? CohesionModel{} : CohesionModel{kind == "jkr" ? CohesionKind::JKR : CohesionKind::DMT, energy};
}

/* Contact law and contact. History variables of the law other than the largest overlap are those of a new contact. */
class Contact {
 public:
  Contact(const std::string &name, Two modulus, Two poisson, Two yield, Two radius, const std::map<std::string, double> &fit,
          bool checked, std::optional<double> effective_radius, const std::optional<LineContact> &line,
          const Cohesion &cohesion, const py::kwargs &parameters)
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
  Contact(const std::vector<std::string> &words, Two radius)
  {
    require(radius.first > 0.0 && radius.second > 0.0, "radii must be positive");
    const LawArguments args = parse_law(words);
    law = args.contact(args.first, args.second.value_or(args.first));
    scaled = ScaledLaw(law, granwave::effective_radius(radius.first, radius.second), radius.first, radius.second);
    extra.assign(law.n_extra(), 0.0);
  }
  Contact(const Contact &) = delete;    // `scaled` points to `law`

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
  ViscousLoss loss_of(const std::optional<double> &time, const std::optional<double> &dashpot) const
  {
    require(!(time && dashpot), "take one of loss_time and loss_dashpot");
    require(time.value_or(0.0) >= 0.0 && dashpot.value_or(0.0) >= 0.0, "a loss must not be negative");
    if (time) return {LossKind::TIME, *time};
    return dashpot ? ViscousLoss{LossKind::DASHPOT, *dashpot} : ViscousLoss{};
  }
  py::dict collide(double mass, double speed, const std::optional<double> &time, const std::optional<double> &dashpot,
                   int steps) const
  {
    require(mass > 0.0 && speed > 0.0 && steps > 0, "mass, speed and steps must be positive");
    const Collision found = ::collide(scaled, loss_of(time, dashpot), mass, speed, steps);
    using namespace py::literals;
    return py::dict("restitution"_a = found.restitution, "duration"_a = found.duration, "peak_force"_a = found.peak_force,
                    "peak_overlap"_a = found.peak_overlap);
  }
  /* Path of a new contact, from the overlaps at these times. */
  py::dict follow(const std::vector<double> &overlap, const std::vector<double> &time) const
  {
    require(overlap.size() == time.size(), "overlap and time must be of one length");
    std::vector<double> block(extra), force, elastic, dissipated, factor;
    double peak = 0.0;
    for (std::size_t k = 0; k < overlap.size(); k++) {
      const double x = overlap[k], dt = k > 0 ? time[k] - time[k - 1] : 0.0;
      require(k == 0 || dt > 0.0, "times must rise");
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
    return law.tangential_stiffness(circle_squared(overlap, peak));
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
    SlipCells<N> cells;
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
      stored.mutable_at(m) = cells.energy(spring);
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

  /* Set a parameter of the contact, or of both materials, which may have more than the law takes. */
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
    require(entry.takes(*parameter), "'" + name + "' must be left out: it is no option of law '" + entry.name + "'");
  }

  /* Constants of elastoplastic-fe, some of them other than those of its fit. */
  static FeConstants fe_constants(const LawEntry &entry, const std::map<std::string, double> &fit)
  {
    FeConstants constants;
    require(fit.empty() || entry.takes(HARDENING), "fit holds constants of law elastoplastic-fe");
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

/* A constant of the contact, from its member of this method. */
template <auto Member, auto Method> auto of()
{
  return [](const Contact &contact) { return ((contact.*Member).*Method)(); };
}

}    // namespace

PYBIND11_MODULE(_contact_laws, module)
{
  const py::arg x("x"), overlap("overlap"), peak("peak_overlap");
  module.doc() =
      "Force-overlap laws of a contact: the functions that the LAMMPS pair style uses, for numpy arrays in SI units.";
  module.attr("LAMMPS_RELEASE") = GRANWAVE_LAMMPS_RELEASE;
  module.def("power", py::vectorize(power), x, py::arg("y"), "x^y as the laws compute it, for positive x.");
  module.def("elliptic_radius", py::vectorize(elliptic_radius), py::arg("first"), py::arg("second"),
             "Radius of the sphere that is as stiff on a plane as a contact with these two relative curvatures (1/m), m.");
  module.def(
      "load_at",
      [](const std::string &shape, const std::vector<double> &numbers, const py::array_t<double> &time) -> py::object {
        const auto load = LoadShape::named(shape, numbers);
        return py::vectorize([&load](double t) { return load.value(t); })(time);
      },
      py::arg("shape"), py::arg("numbers"), py::arg("time"),
      "Force or displacement at times (s), from the name and the numbers that fix gran/load takes.");
  module.def("logarithm", py::vectorize(logarithm), x, "ln(x) as the laws compute it, for positive x.");
  py::class_<LineContact>(module, "LineContact",
                          "Contact along a line: a cylinder on a plane, or two parallel cylinders.\n\n"
                          "Pairs are (first, second) body, rigid where the modulus is inf. SI units.")
      .def(py::init([](Two modulus, Two poisson, double diameter, double length) {
             require(diameter > 0.0 && length > 0.0, "diameter and length must be positive");
             const auto [first, second] = elastic_bodies(modulus, poisson);
             return LineContact(first, second, diameter, length);
           }),
           py::kw_only(), py::arg("youngs_modulus"), py::arg("poisson_ratio"), py::arg("diameter"), py::arg("length"))
      .def_static(
          "plane_strain",
          [](Two modulus, Two poisson, Two radius, double length) {
            require(radius.first > 0.0 && radius.second > 0.0 && length > 0.0, "radii and length must be positive");
            require(std::isfinite(radius.first) || std::isfinite(radius.second),
                    "one of two bodies must be a cylinder, found two planes");
            const auto [first, second] = elastic_bodies(modulus, poisson);
            return LineContact::plane_strain(first, second, radius.first, radius.second, length);
          },
          py::kw_only(), py::arg("youngs_modulus"), py::arg("poisson_ratio"), py::arg("radius"), py::arg("length"),
          "Contact in plane strain after Johnson; a plane has the radius inf.")
      .def_property_readonly("largest_overlap", &LineContact::largest_overlap, "end of the law, m")
      .def("force", py::vectorize(&LineContact::force), overlap, "Force at an overlap, N.")
      .def("stiffness", py::vectorize(&LineContact::stiffness), overlap, "Slope of the force over the overlap, N/m.")
      .def("energy", py::vectorize(&LineContact::energy), overlap, "Stored energy, J.");
  module.def("exponential", py::vectorize(exponential), x, "exp(x) as the laws compute it.");
  using Axis = std::array<double, 3>;
  py::class_<CylinderPair>(module, "CylinderPair",
                           "Two bodies, one of them a cylinder at least; a sphere has the length 0. SI units.")
      .def(py::init([](Two length, const Axis &first, const Axis &second) {
             Cylinder one{length.first, {}}, other{length.second, {}};
             std::copy(first.begin(), first.end(), one.axis);
             std::copy(second.begin(), second.end(), other.axis);
             require(!one.is_sphere() || !other.is_sphere(), "one of two bodies must be a cylinder");
             return CylinderPair(one, other);
           }),
           py::kw_only(), py::arg("length"), py::arg("first_axis"), py::arg("second_axis"))
      .def_property_readonly("parallel", &CylinderPair::parallel, "True if they touch along a line")
      .def_property_readonly("nearly_parallel", &CylinderPair::nearly_parallel,
                             "True if they cross at so small an angle that no law holds")
      .def_property_readonly("length", &CylinderPair::length, "length of that line, m")
      .def("effective_radius", &CylinderPair::effective_radius, py::arg("first"), py::arg("second"),
           "Radius of the sphere that is as stiff on a plane, from both radii, m.");
  py::class_<LawParameter>(module, "LawParameter", "A parameter of contact laws: a number, or one of some words.")
      .def_readonly("name", &LawParameter::name)
      .def_readonly("symbol", &LawParameter::symbol, "of its value")
      .def_readonly("keyword", &LawParameter::keyword, "in input scripts; those of one keyword follow it together")
      .def_readonly("description", &LawParameter::description)
      .def_readonly("unit", &LawParameter::unit, "SI; empty if the description tells it, or there is none")
      .def_property_readonly("of_material", &LawParameter::is_of_material,
                             "True if each material has a value, False if the contact has one")
      .def_property_readonly("optional", &LawParameter::is_optional, "True if it is left out of cases unless it is given")
      .def_property_readonly("required", &LawParameter::is_required, "True if laws have no default for it")
      .def_property_readonly(
          "default",
          [](const LawParameter &p) -> py::object {
            return p.is_required() ? py::object(py::none()) : as_python(p, p.fallback);
          },
          "value where it is not given: a number or a word; None if it is required")
      .def_property_readonly(
          "example", [](const LawParameter &p) { return as_python(p, p.example); }, "value that the documents show")
      .def_property_readonly(
          "words",
          [](const LawParameter &p) {
            py::list words;
            for (int n = 0; n < LawParameter::MOST_WORDS && p.words[n]; n++) words.append(p.words[n]);
            return py::tuple(words);
          },
          "its values, if it is no number")
      .def_property_readonly(
          "range", [](const LawParameter &p) { return bounds(p.range); },
          "bounds of the law by name: above, at_least, below, at_most")
      .def_property_readonly(
          "case_range", [](const LawParameter &p) { return bounds(p.case_range); }, "bounds of case files, likewise")
      .def("__repr__", [](const LawParameter &p) { return "<LawParameter " + std::string(p.name) + ">"; });
  py::class_<LawEntry>(module, "LawEntry", "A contact law of the table LAWS.")
      .def_readonly("name", &LawEntry::name)
      .def_readonly("elastic_limit", &LawEntry::elastic_limit,
                    "largest overlap that leaves no dent, in alpha_y; infinite: it never yields")
      .def_readonly("fitted", &LawEntry::fitted, "True for a fit, valid to overlaps of 0.2 R*")
      .def_readonly("states_error", &LawEntry::states_error, "True if the law states error bars of its own")
      .def_property_readonly("yields", &LawEntry::yields, "True if the law needs a yield strength")
      .def_property_readonly("is_power", &LawEntry::is_power,
                             "True for a power of the overlap, or no force at all, whatever the radii")
      .def_property_readonly(
          "parameters",
          [](const LawEntry &entry) {
            py::dict table;
            for (const LawParameter *parameter : entry.parameters)
              table[parameter->name] = py::cast(parameter, py::return_value_policy::reference);
            return table;
          },
          "its parameters, by name, in the order of input scripts");
  using Fe = ElastoplasticFe;
  py::dict range;
  range["poisson_ratio"] = std::pair(0.0, Fe::LARGEST_POISSON);
  range["modulus_over_strength"] = std::pair(Fe::LEAST_RATIO, Fe::LARGEST_RATIO);
  range["hardening"] = std::pair(0.0, Fe::LARGEST_HARDENING);
  module.attr("FE_RANGE") = range;
  py::dict laws;
  for (const LawEntry &entry : law_table()) laws[entry.name] = py::cast(entry, py::return_value_policy::reference);
  module.attr("LAWS") = laws;
  py::dict parameters;
  for (const LawParameter *parameter : law_parameters())
    parameters[parameter->name] = py::cast(parameter, py::return_value_policy::reference);
  module.attr("PARAMETERS") = parameters;
  py::class_<Contact>(
      module, "ContactLaw",
      "Contact of two spheres, or of a sphere and a plane (radius inf), rigid where the modulus is inf.\n\n"
      "Every pair of arguments is (first, second) body. Overlaps in m, forces in N, energies in J.\n"
      "Further arguments are parameters of the law by name, those of materials as pairs; `fit` has constants of\n"
      "elastoplastic-fe by name, for its fit.\n"
      "Raises ValueError for values without meaning, or (unless checked is False) constants that make no passive law.")
      .def(py::init<const std::string &, Two, Two, Two, Two, const std::map<std::string, double> &, bool,
                    std::optional<double>, const std::optional<LineContact> &, const Cohesion &, const py::kwargs &>(),
           py::arg("law") = "elastoplastic", py::kw_only(), py::arg("youngs_modulus"), py::arg("poisson_ratio"),
           py::arg("yield_strength"), py::arg("radius"), py::arg("fit") = std::map<std::string, double>(),
           py::arg("checked") = true, py::arg("effective_radius") = py::none(), py::arg("line") = py::none(),
           py::arg("cohesion") = py::none())
      .def_static(
          "from_words",
          [](const std::string &words, Two radius) {
            std::istringstream text(words);
            using Word = std::istream_iterator<std::string>;
            return std::make_unique<Contact>(std::vector<std::string>(Word(text), Word()), radius);
          },
          py::arg("words"), py::kw_only(), py::arg("radius"),
          "Contact of two spheres from a law and its arguments in an input script, after pair_coeff I J.\n\n"
          "Friction, losses and resistances in them are checked, and have no part in it.")
      .def_property_readonly("name", [](const Contact &b) { return std::string(b.law.entry().name); })
      .def_property_readonly(
          "entry", [](const Contact &b) { return b.law.entry(); }, "of the table LAWS")
      .def_property_readonly(
          "constants", [](const Contact &b) { return constants_of(b.law.entry(), b.law.values()); },
          "of the curve of the law, by name")
      .def_property_readonly("effective_radius", of<&Contact::scaled, &ScaledLaw::effective_radius>(), "R*, m")
      .def_property_readonly("effective_modulus", of<&Contact::law, &ContactLaw::modulus>(), "E*, Pa")
      .def_property_readonly("shear_modulus", of<&Contact::law, &ContactLaw::shear_modulus>(),
                             "G*, 1/G* = (2 - nu1)/G1 + (2 - nu2)/G2, Pa")
      .def_property_readonly("yield_strength", of<&Contact::law, &ContactLaw::yield_strength>(), "of the softer body, Pa")
      .def_property_readonly(
          "rate_sensitivity", [](const Contact &b) { return b.law.rate().sensitivity; }, "C of the softer body")
      .def_property_readonly("yield_overlap", of<&Contact::scaled, &ScaledLaw::yield_overlap>(), "alpha_y, m")
      .def_property_readonly(
          "elastic_limit", of<&Contact::scaled, &ScaledLaw::elastic_limit>(),
          "largest overlap that leaves no dent, m: alpha_y, 0 without an elastic range, infinite if it never yields")
      .def_property_readonly("valid_overlap", of<&Contact::scaled, &ScaledLaw::valid_overlap>(),
                             "overlap beyond which the law no longer describes the contact, m")
      .def_property_readonly("yield_force", of<&Contact::scaled, &ScaledLaw::yield_force>(), "F_y, N")
      .def_property_readonly("balanced_overlap", of<&Contact::scaled, &ScaledLaw::balanced_overlap>(),
                             "overlap without force of a contact with cohesion; 0 without, m")
      .def_property_readonly("pull_off_force", of<&Contact::scaled, &ScaledLaw::pull_off>(),
                             "largest pull of a contact with cohesion that has no dent; 0 without, N")
      .def_property_readonly("neck_length", of<&Contact::scaled, &ScaledLaw::neck_length>(),
                             "largest gap of surfaces that a neck holds together (JKR), m")
      .def_property_readonly("share_of_first", of<&Contact::law, &ContactLaw::share_of_first>(),
                             "share of the dissipated energy that belongs to the first body")
      .def("force", py::vectorize(&Contact::force), overlap, peak,
           "Force at an overlap when the largest so far was peak_overlap, N.")
      .def("force_error", py::vectorize(&Contact::force_error), overlap, peak,
           "Error bar of that force, N, that the law states for itself; NaN where it states none.")
      .def("restitution_error", py::vectorize(&Contact::restitution_error), peak,
           "Error bar of the coefficient of restitution of a collision with this largest overlap; NaN if there is none.")
      .def("loading_force", py::vectorize(&Contact::loading_force), overlap, "Force of first loading, N.")
      .def("loading_work", py::vectorize(&Contact::loading_work), overlap, "Work of first loading from zero, J.")
      .def("elastic_energy", py::vectorize(&Contact::elastic_energy), overlap, peak,
           "Energy that unloading would give back, J.")
      .def("dissipated_energy", py::vectorize(&Contact::dissipated_energy), peak,
           "Energy lost once peak_overlap was reached, J.")
      .def("residual_overlap", py::vectorize(&Contact::residual_overlap), peak, "Overlap of the unloaded dent, m.")
      .def("unloading_exponent", py::vectorize(&Contact::unloading_exponent), peak, "n of the unloading branch.")
      .def("unloading_stiffness", py::vectorize(&Contact::unloading_stiffness), peak,
           "Slope dF/d(overlap) where unloading starts, N/m.")
      .def("tangent_stiffness", py::vectorize(&Contact::tangent_stiffness), overlap, peak,
           "Slope dF/d(overlap) at an overlap, of loading at the peak and of unloading below it, N/m.")
      .def("collide", &Contact::collide, py::arg("effective_mass"), py::arg("speed"), py::kw_only(),
           py::arg("loss_time") = py::none(), py::arg("loss_dashpot") = py::none(), py::arg("steps") = 400,
           "Head-on collision of the two bodies: restitution, duration (s), peak_force (N), peak_overlap (m).\n\n"
           "effective_mass in kg, speed of approach in m/s; loss_time in s, or the factor of Tsuji's dashpot.")
      .def("follow", &Contact::follow, overlap, py::arg("time"),
           "Path of a new contact through overlaps at rising times, s: arrays force (N), elastic_energy, dissipated_energy "
           "(J) "
           "and rate_factor, that of the yield strength.")
      .def("rate_factor", py::vectorize(&Contact::rate_factor), overlap, py::arg("velocity"),
           "Factor of the yield strength on loading at this velocity of approach, m/s.")
      .def("contact_radius", py::vectorize(&Contact::peak_contact_radius), peak,
           "Radius of the contact circle at a peak, m.")
      .def("contact_radius", py::vectorize(&Contact::contact_radius), overlap, peak,
           "Radius of the contact circle at an overlap when the largest so far was peak_overlap, m.")
      .def("tangential_stiffness", py::vectorize(&Contact::tangential_stiffness), overlap, peak,
           "k_t = 8 G* a of that circle, N/m.")
      .def("friction_path", &Contact::friction_path, overlap, py::arg("slip"), py::kw_only(), py::arg("friction"),
           py::arg("tangential") = "mindlin_rescale", py::arg("cells") = 16,
           "Force (n, 2), N, stored_energy and loss (n,), J, of friction along a path, from a new contact on.\n\n"
           "Overlaps (n,), and the slips of the steps that end there, (n, 2), of the first body over the second, m.\n"
           "Partial slip is computed with 16 cells in LAMMPS; 8 and 32 tell how much that matters.");
}
