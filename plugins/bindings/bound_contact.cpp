// SPDX-License-Identifier: GPL-2.0-only
#include "bound_contact.h"

#include <memory>
#include <sstream>

namespace granwave::bindings {

namespace {

/* A constant of the contact, from its member of this method. */
template <auto Member, auto Method> auto of()
{
  return [](const BoundContact &contact) { return ((contact.*Member).*Method)(); };
}

}    // namespace

void bind_contact(py::module_ &module)
{
  const py::arg overlap("overlap"), peak("peak_overlap");
  py::class_<BoundContact>(
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
            return std::make_unique<BoundContact>(std::vector<std::string>(Word(text), Word()), radius);
          },
          py::arg("words"), py::kw_only(), py::arg("radius"),
          "Contact of two spheres from a law and its arguments in an input script, after pair_coeff I J.\n\n"
          "Friction, losses and resistances in them are checked, but have no effect here.")
      .def_property_readonly("name", [](const BoundContact &b) { return std::string(b.law.entry().name); })
      .def_property_readonly(
          "entry", [](const BoundContact &b) { return b.law.entry(); }, "of the table LAWS")
      .def_property_readonly(
          "constants", [](const BoundContact &b) { return constants_of(b.law.entry(), b.law.values()); },
          "of the curve of the law, by name")
      .def_property_readonly("effective_radius", of<&BoundContact::scaled, &ScaledLaw::effective_radius>(), "R*, m")
      .def_property_readonly("effective_modulus", of<&BoundContact::law, &ContactLaw::modulus>(), "E*, Pa")
      .def_property_readonly("shear_modulus", of<&BoundContact::law, &ContactLaw::shear_modulus>(),
                             "G*, 1/G* = (2 - nu1)/G1 + (2 - nu2)/G2, Pa")
      .def_property_readonly("yield_strength", of<&BoundContact::law, &ContactLaw::yield_strength>(),
                             "of the softer body, Pa")
      .def_property_readonly(
          "rate_sensitivity", [](const BoundContact &b) { return b.law.rate().sensitivity; }, "C of the softer body")
      .def_property_readonly("yield_overlap", of<&BoundContact::scaled, &ScaledLaw::yield_overlap>(), "alpha_y, m")
      .def_property_readonly(
          "elastic_limit", of<&BoundContact::scaled, &ScaledLaw::elastic_limit>(),
          "largest overlap without plastic indentation, m: alpha_y, 0 without an elastic range, infinite if it never yields")
      .def_property_readonly("valid_overlap", of<&BoundContact::scaled, &ScaledLaw::valid_overlap>(),
                             "overlap beyond which the law no longer describes the contact, m")
      .def_property_readonly("yield_force", of<&BoundContact::scaled, &ScaledLaw::yield_force>(), "F_y, N")
      .def_property_readonly("balanced_overlap", of<&BoundContact::scaled, &ScaledLaw::balanced_overlap>(),
                             "overlap at zero force of a contact with cohesion; 0 without cohesion, m")
      .def_property_readonly(
          "pull_off_force", of<&BoundContact::scaled, &ScaledLaw::pull_off>(),
          "pull-off force of a contact with cohesion and without plastic indentation; 0 without cohesion, N")
      .def_property_readonly("neck_length", of<&BoundContact::scaled, &ScaledLaw::neck_length>(),
                             "largest gap at which a neck still joins the surfaces (JKR), m")
      .def_property_readonly("share_of_first", of<&BoundContact::law, &ContactLaw::share_of_first>(),
                             "share of the dissipated energy that belongs to the first body")
      .def("force", py::vectorize(&BoundContact::force), overlap, peak,
           "Force at an overlap when the largest so far was peak_overlap, N.")
      .def("force_error", py::vectorize(&BoundContact::force_error), overlap, peak,
           "Error bar of this force, N, as given by the law; NaN if it gives none.")
      .def("restitution_error", py::vectorize(&BoundContact::restitution_error), peak,
           "Error bar of the coefficient of restitution of a collision with this largest overlap; NaN if there is none.")
      .def("loading_force", py::vectorize(&BoundContact::loading_force), overlap, "Force of first loading, N.")
      .def("loading_work", py::vectorize(&BoundContact::loading_work), overlap, "Work of first loading from zero, J.")
      .def("elastic_energy", py::vectorize(&BoundContact::elastic_energy), overlap, peak,
           "Energy recovered on unloading, J.")
      .def("dissipated_energy", py::vectorize(&BoundContact::dissipated_energy), peak,
           "Energy dissipated up to peak_overlap, J.")
      .def("residual_overlap", py::vectorize(&BoundContact::residual_overlap), peak, "Residual overlap after unloading, m.")
      .def("unloading_exponent", py::vectorize(&BoundContact::unloading_exponent), peak, "n of the unloading branch.")
      .def("unloading_stiffness", py::vectorize(&BoundContact::unloading_stiffness), peak,
           "Slope dF/d(overlap) where unloading starts, N/m.")
      .def("tangent_stiffness", py::vectorize(&BoundContact::tangent_stiffness), overlap, peak,
           "Slope dF/d(overlap) at an overlap, of loading at the peak and of unloading below it, N/m.")
      .def("collide", &BoundContact::collide, py::arg("effective_mass"), py::arg("speed"), py::kw_only(),
           py::arg("loss_time") = py::none(), py::arg("loss_dashpot") = py::none(),
           py::arg("loss_prony") = BoundContact::Branches(), py::arg("steps") = 400,
           "Head-on collision of the two bodies: restitution, duration (s), peak_force (N), peak_overlap (m).\n\n"
           "effective_mass in kg, speed of approach in m/s; loss_time in s, the factor of Tsuji's dashpot, or the "
           "branches of a Prony series, (weight, time in s) each.")
      .def("relax", &BoundContact::relax, overlap, py::arg("time"), py::arg("loss_prony"),
           "Path of a contact of viscoelastic bodies through overlaps at increasing times, s, pressed to the first of them "
           "just "
           "then: arrays force (N), elastic_energy, dissipated_energy (J) and surface_overlap (m), the overlap of the "
           "recovering "
           "surfaces.\n\n"
           "loss_prony: (weight, time in s) of each branch.")
      .def("follow", &BoundContact::follow, overlap, py::arg("time"),
           "Path of a new contact through overlaps at increasing times, s: arrays force (N), elastic_energy, "
           "dissipated_energy "
           "(J) "
           "and rate_factor, the factor of the yield strength.")
      .def("rate_factor", py::vectorize(&BoundContact::rate_factor), overlap, py::arg("velocity"),
           "Factor of the yield strength on loading at this velocity of approach, m/s.")
      .def("contact_radius", py::vectorize(&BoundContact::peak_contact_radius), peak,
           "Radius of the contact circle at a peak, m.")
      .def("contact_radius", py::vectorize(&BoundContact::contact_radius), overlap, peak,
           "Radius of the contact circle at an overlap when the largest so far was peak_overlap, m.")
      .def("tangential_stiffness", py::vectorize(&BoundContact::tangential_stiffness), overlap, peak,
           "k_t = 8 G* a of that circle, N/m.")
      .def("friction_path", &BoundContact::friction_path, overlap, py::arg("slip"), py::kw_only(), py::arg("friction"),
           py::arg("tangential") = "mindlin_rescale", py::arg("cells") = 16,
           "Force (n, 2), N, stored_energy and loss (n,), J, of friction along a path, from a new contact on.\n\n"
           "Overlaps (n,), and the slips of the steps that end there, (n, 2), of the first body over the second, m.\n"
           "Partial slip is computed with 16 cells in LAMMPS; 8 and 32 show the effect of this number.");
}

}    // namespace granwave::bindings
