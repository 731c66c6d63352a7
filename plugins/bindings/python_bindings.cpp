/* The contact laws of contact_laws.h for Python: numpy arrays in and out, SI units. */

#include "../laws/contact_laws.h"
#include "../laws/law_arguments.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <map>
#include <string>
#include <utility>

namespace py = pybind11;
using granwave::ContactLaw;
using granwave::ContactScale;
using granwave::Law;
using granwave::Material;
using granwave::Turning;
using granwave::Variant;

namespace {

using Two = std::pair<double, double>;

py::dict by_name(const granwave::LawConstants &constants)
{
  py::dict found;
  for (const auto &[name, member] : granwave::LAW_CONSTANTS) found[name] = constants.*member;
  return found;
}

/* A law at one contact: what ContactLaw says in normalised units, in physical ones. */
class BoundLaw {
 public:
  BoundLaw(const std::string &name, Two modulus, Two poisson, Two yield, Two radius, const std::string &variant,
           double yield_factor, double beta, const std::map<std::string, double> &own, bool checked)
  {
    int index = 0;
    while (index < 4 && name != granwave::law_name(static_cast<Law>(index))) index++;
    if (index == 4) throw py::value_error("law must be hertz, elastoplastic, bilinear or thornton, found '" + name + "'");
    if (variant != "continuous" && variant != "published")
      throw py::value_error("variant must be continuous or published, found '" + variant + "'");
    for (const double value : {modulus.first, modulus.second, yield.first, yield.second, radius.first, radius.second})
      if (!(value > 0.0)) throw py::value_error("moduli, yield strengths and radii must be positive");
    for (const double value : {poisson.first, poisson.second})
      if (!(value > -1.0 && value <= 0.5)) throw py::value_error("Poisson's ratio must lie in (-1, 0.5]");
    if (!(yield_factor > 0.0)) throw py::value_error("yield_factor must be positive");
    if (!(beta >= 0.0 && beta < 1.0)) throw py::value_error("beta must lie in [0, 1)");
    granwave::LawConstants constants;
    for (const auto &[key, value] : own) {
      const auto member = granwave::law_constant(key);
      if (!member) throw py::value_error("constants: '" + key + "' is none of LAW_CONSTANTS");
      if (!std::isfinite(value)) throw py::value_error("constants must be finite numbers, found " + key);
      constants.*member = value;
    }
    if (!own.empty() && (name != "elastoplastic" || variant != "continuous"))
      throw py::value_error("constants belong to law elastoplastic, variant continuous");
    const Material first{modulus.first, poisson.first, yield.first}, second{modulus.second, poisson.second, yield.second};
    law = ContactLaw(static_cast<Law>(index), first, second, variant == "published" ? Variant::published : Variant::continuous,
                     yield_factor, beta, constants);
    if (const std::string fault = law.fault(); checked && !own.empty() && !fault.empty()) throw py::value_error(fault);
    effective_radius = granwave::effective_radius(radius.first, radius.second);
    scale = law.scale(effective_radius);
    if (law.plastic() && !std::isfinite(scale.overlap)) throw py::value_error("law '" + name + "' needs a yield strength");
  }

  bool hertzian(double peak) const { return peak <= scale.elastic_limit; }
  double loading_force(double overlap) const
  {
    if (overlap <= 0.0) return 0.0;
    return hertzian(overlap) ? scale.hertz * overlap * std::sqrt(overlap) : scale.force * law.loading(overlap / scale.overlap);
  }
  double loading_work(double overlap) const
  {
    if (overlap <= 0.0) return 0.0;
    return hertzian(overlap) ? 0.4 * scale.hertz * overlap * overlap * std::sqrt(overlap) : unit() * law.loading_work(overlap / scale.overlap);
  }
  double force(double overlap, double peak) const
  {
    if (overlap >= peak || hertzian(peak)) return loading_force(overlap);
    return scale.force * ContactLaw::unloading(overlap / scale.overlap, turning(peak));
  }
  double elastic_energy(double overlap, double peak) const
  {
    peak = std::max(peak, overlap);
    if (hertzian(peak)) return loading_work(overlap);
    return unit() * ContactLaw::elastic_energy(overlap / scale.overlap, turning(peak));
  }
  double dissipated_energy(double peak) const { return hertzian(peak) ? 0.0 : unit() * law.dissipated_energy(turning(peak)); }
  double residual_overlap(double peak) const { return hertzian(peak) ? 0.0 : scale.overlap * turning(peak).residual; }
  double unloading_exponent(double peak) const { return hertzian(peak) ? 1.5 : turning(peak).exponent; }
  double unloading_stiffness(double peak) const
  {
    if (hertzian(peak)) return peak > 0.0 ? 1.5 * scale.hertz * std::sqrt(peak) : 0.0;
    return scale.force / scale.overlap * law.unloading_slope(turning(peak));
  }
  double contact_radius(double overlap, double peak) const { return std::sqrt(circle(overlap, peak)); }
  double peak_contact_radius(double peak) const { return contact_radius(peak, peak); }
  double tangential_stiffness(double overlap, double peak) const { return law.tangential_stiffness(circle(overlap, peak)); }

  ContactLaw law;
  ContactScale scale;
  double effective_radius;

 private:
  double unit() const { return scale.force * scale.overlap; }
  Turning turning(double peak) const { return law.turning(peak / scale.overlap); }
  double circle(double overlap, double peak) const
  {
    if (overlap <= 0.0) return 0.0;
    if (hertzian(std::max(overlap, peak))) return effective_radius * overlap;
    const double a = overlap / scale.overlap, unit = effective_radius * scale.overlap;
    return unit * (overlap >= peak ? law.area(a) : ContactLaw::unloading_area(a, turning(peak), law.area(peak / scale.overlap)));
  }
};

template <auto Method> auto one()
{
  return [](const BoundLaw &self, const py::array_t<double> &x) -> py::object {
    return py::vectorize([&self](double v) { return (self.*Method)(v); })(x);
  };
}

template <auto Method> auto two()
{
  return [](const BoundLaw &self, const py::array_t<double> &overlap, const py::array_t<double> &peak) -> py::object {
    return py::vectorize([&self](double a, double b) { return (self.*Method)(a, b); })(overlap, peak);
  };
}

}    // namespace

PYBIND11_MODULE(_contact_laws, module)
{
  module.doc() = "Force-overlap laws of a contact: the functions that the LAMMPS pair style uses, for numpy arrays in SI units.";
  module.attr("LAMMPS_RELEASE") = GRANWAVE_LAMMPS_RELEASE;
  module.attr("LAW_CONSTANTS") = by_name({});
  py::class_<BoundLaw>(module, "ContactLaw",
                       "Contact of two spheres, or of a sphere and a plane (radius inf), rigid where the modulus is inf.\n\n"
                       "Every pair of arguments is (first, second) body. Overlaps in m, forces in N, energies in J.\n"
                       "The elasto-plastic law takes other constants than those of LAW_CONSTANTS, by name.\n"
                       "Raises ValueError for constants without meaning, or (unless checked is False) that make no passive law.")
      .def(py::init<const std::string &, Two, Two, Two, Two, const std::string &, double, double,
                    const std::map<std::string, double> &, bool>(),
           py::arg("law") = "elastoplastic", py::kw_only(), py::arg("youngs_modulus"), py::arg("poisson_ratio"),
           py::arg("yield_strength"), py::arg("radius"), py::arg("variant") = "continuous", py::arg("yield_factor") = 1.6,
           py::arg("beta") = 0.8, py::arg("constants") = std::map<std::string, double>(), py::arg("checked") = true)
      .def_property_readonly("name", [](const BoundLaw &b) { return std::string(granwave::law_name(b.law.law())); })
      .def_property_readonly("constants", [](const BoundLaw &b) { return by_name(b.law.constants()); },
                             "of the elasto-plastic law, by name")
      .def_property_readonly("effective_radius", [](const BoundLaw &b) { return b.effective_radius; }, "R*, m")
      .def_property_readonly("effective_modulus", [](const BoundLaw &b) { return b.law.modulus(); }, "E*, Pa")
      .def_property_readonly("shear_modulus", [](const BoundLaw &b) { return b.law.shear_modulus(); },
                             "G*, 1/G* = (2 - nu1)/G1 + (2 - nu2)/G2, Pa")
      .def_property_readonly("yield_strength", [](const BoundLaw &b) { return b.law.yield_strength(); }, "of the softer body, Pa")
      .def_property_readonly("yield_overlap", [](const BoundLaw &b) { return b.scale.overlap; }, "alpha_y, m")
      .def_property_readonly("yield_force", [](const BoundLaw &b) { return b.scale.force; }, "F_y, N")
      .def_property_readonly("share_of_first", [](const BoundLaw &b) { return b.law.share_of_first(); },
                             "share of the dissipated energy that belongs to the first body")
      .def("force", two<&BoundLaw::force>(), py::arg("overlap"), py::arg("peak_overlap"),
           "Force at an overlap when the largest so far was peak_overlap, N.")
      .def("loading_force", one<&BoundLaw::loading_force>(), py::arg("overlap"), "Force of first loading, N.")
      .def("loading_work", one<&BoundLaw::loading_work>(), py::arg("overlap"), "Work of first loading from zero, J.")
      .def("elastic_energy", two<&BoundLaw::elastic_energy>(), py::arg("overlap"), py::arg("peak_overlap"),
           "Energy that unloading would give back, J.")
      .def("dissipated_energy", one<&BoundLaw::dissipated_energy>(), py::arg("peak_overlap"),
           "Energy lost once peak_overlap was reached, J.")
      .def("residual_overlap", one<&BoundLaw::residual_overlap>(), py::arg("peak_overlap"), "Overlap of the unloaded dent, m.")
      .def("unloading_exponent", one<&BoundLaw::unloading_exponent>(), py::arg("peak_overlap"), "n of the unloading branch.")
      .def("unloading_stiffness", one<&BoundLaw::unloading_stiffness>(), py::arg("peak_overlap"),
           "Slope dF/d(overlap) where unloading starts, N/m.")
      .def("contact_radius", one<&BoundLaw::peak_contact_radius>(), py::arg("peak_overlap"), "Radius of the contact circle at a peak, m.")
      .def("contact_radius", two<&BoundLaw::contact_radius>(), py::arg("overlap"), py::arg("peak_overlap"),
           "Radius of the contact circle at an overlap when the largest so far was peak_overlap, m.")
      .def("tangential_stiffness", two<&BoundLaw::tangential_stiffness>(), py::arg("overlap"), py::arg("peak_overlap"),
           "k_t = 8 G* a of that circle, N/m.");
}
