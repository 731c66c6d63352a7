// SPDX-License-Identifier: GPL-2.0-only
#include "pair_gran_hysteretic_kokkos.h"

#include "../styles/motion.h"
#include "domain.h"
#include "error.h"
#include "neighbor.h"

#include <tuple>

using namespace LAMMPS_NS;
using namespace granwave;

namespace {

template <class T>
using HostArray = Kokkos::View<T, Kokkos::LayoutRight, Kokkos::HostSpace, Kokkos::MemoryTraits<Kokkos::Unmanaged>>;

/* Return the first n elements of an array, which is enlarged if necessary. */
template <class Array> auto first_of(Array &array, std::size_t n)
{
  if (array.extent(0) < n)
    array = Array(Kokkos::view_alloc(Kokkos::WithoutInitializing, std::string("gran/hysteretic/kk")), n);
  const std::pair<std::size_t, std::size_t> range(0, n);
  if constexpr (Array::rank == 1) return Kokkos::subview(array, range);
  else return Kokkos::subview(array, range, Kokkos::ALL);
}

/* Copy numbers to the card, or back. */
template <class Array, class T> void to_card(const std::vector<T> &from, Array &to)
{
  Kokkos::deep_copy(first_of(to, from.size()), HostArray<const T *>(from.data(), from.size()));
}

template <class Array, class T> void from_card(Array &from, std::vector<T> &to)
{
  Kokkos::deep_copy(HostArray<T *>(to.data(), to.size()), first_of(from, to.size()));
}

template <class Array> void vectors_to_card(double *const *from, int n, Array &to)
{
  Kokkos::deep_copy(first_of(to, n), HostArray<const double *[3]>(n > 0 ? from[0] : nullptr, n));
}

template <class Array> void vectors_from_card(Array &from, int n, double **to)
{
  Kokkos::deep_copy(HostArray<double *[3]>(n > 0 ? to[0] : nullptr, n), first_of(from, n));
}

/* Start Kokkos, unless LAMMPS has started it. It is never stopped: a LAMMPS in Python may be closed after everything
   else. */
void start_kokkos()
{
  if (!Kokkos::is_initialized()) Kokkos::initialize();
}

}    // namespace

template <class DeviceType>
PairGranHystereticKokkos<DeviceType>::PairGranHystereticKokkos(LAMMPS *lmp) : PairGranHysteretic(lmp)
{
  start_kokkos();
  contacts.bring_back = [this] { bring_back(); };
}

template <class DeviceType> void PairGranHystereticKokkos<DeviceType>::init_style()
{
  PairGranHysteretic::init_style();
  refuse_others();
}

/* Stop with an error if a contact needs what the kernels do not have. */
template <class DeviceType> void PairGranHystereticKokkos<DeviceType>::refuse_others()
{
  std::string found;
  for (int i = 1; i <= laws.types(); i++)
    for (int j = i; j <= laws.types(); j++) {
      const std::string name = laws.arguments(i, j).law->name;
      if (setflag[i][j] && name != "hertz" && name != "elastoplastic") found = "law " + name;
    }
  if (has.slip) found = "partial slip";
  if (has.resistance) found = "a resistance to rolling or twisting";
  if (has.loss) found = "a viscous loss";
  if (has.cohesion) found = "cohesion";
  if (has_rate) found = "a yield strength that depends on the rate";
  if (has.dents) found = "initial indentations (gran_dents)";
  if (laws.cylinders()) found = "cylinders";
  if (normals_initial) found = "initial normals";
  if (radii_vary) found = "radii that change during a run";
  if (update->whichflag == 2) found = "a minimization";
  if (!found.empty())
    error->all(FLERR,
               "Pair style gran/hysteretic/kk computes normal forces with the laws hertz and elastoplastic, and friction, "
               "found {}: "
               "use pair style gran/hysteretic",
               found);
}

/* Stop with an error if springs would need velocities that jump across a periodic boundary, or steps that a rerun lacks. */
template <class DeviceType> void PairGranHystereticKokkos<DeviceType>::refuse_flow()
{
  if (!has.friction) return;
  if (domain->deform_vremap)
    error->all(FLERR, "Pair style gran/hysteretic/kk with friction does not support fix deform with remap v: use pair style "
                      "gran/hysteretic");
  if (is_rerun(*update))
    error->all(FLERR, "Pair style gran/hysteretic/kk: rerun lacks the steps between its snapshots, by which the history of "
                      "contacts with friction grows");
}

/* ---------------------------------------------------------------------- transfer */

/* Send a new list of pairs, with laws and histories. */
template <class DeviceType> void PairGranHystereticKokkos<DeviceType>::send_pairs()
{
  const ContactList &c = contacts;
  std::vector<int> first;
  std::vector<Crossing> crossings;
  first.reserve(c.size());
  c.each_pair([&](int r, int, int i, int j) {
    first.push_back(i);
    if (r < c.plain) return;
    const bool ghost_is_second = geometry.images(i).none();
    Crossing crossing{{}, ghost_is_second};
    std::copy_n(geometry.images(ghost_is_second ? j : i).along, 3, crossing.images);
    crossings.push_back(crossing);
  });
  views.pairs = c.size();
  views.friction = has.friction;
  views.plain = c.begin[c.plain];
  to_card(first, views.first);
  to_card(c.partner, views.second);
  to_card(crossings, views.crossings);
  send_laws();
  send_contacts_of_spheres();
  send_histories();
  first_of(views.force, first.size());
  if (views.friction) first_of(views.surface, first.size());
}

/* Send the laws of all pairs, each once. */
template <class DeviceType> void PairGranHystereticKokkos<DeviceType>::send_laws()
{
  std::map<std::tuple<int, int, double, double>, int> known;
  std::map<const ContactLaw *, int> curve_of;
  std::vector<PairLaw> laws_of_pairs;
  std::vector<PairFriction> frictions;
  std::vector<Elastoplastic> curves;
  std::vector<int> law_of_pair;
  law_of_pair.reserve(contacts.size());
  contacts.each_pair([&](int, int, int i, int j) {
    if (uniform && !laws_of_pairs.empty()) return law_of_pair.push_back(0);
    const std::tuple<int, int, double, double> kind{atom->type[i], atom->type[j], atom->radius[i], atom->radius[j]};
    const auto [at, is_new] = known.emplace(kind, static_cast<int>(laws_of_pairs.size()));
    law_of_pair.push_back(at->second);
    if (!is_new) return;
    const PairParameters p = pair_parameters(i, j);
    const auto [curve, is_new_curve] = curve_of.emplace(&p.contact.law(), static_cast<int>(curves.size()));
    if (is_new_curve) {
      const auto *const of_law = std::get_if<Elastoplastic>(&p.contact.law().normal());
      curves.push_back(of_law ? *of_law : Elastoplastic({}, {}));
    }
    laws_of_pairs.push_back({p.radsum, p.touch_sq, p.radsum + gap, p.largest_overlap, p.contact.hertz(),
                             p.contact.elastic_limit(), p.contact.yield_overlap(), p.contact.yield_force(), curve->second});
    frictions.push_back({p.radius_i, p.radius_j, p.contact.effective_radius(), p.root_radius, p.friction, p.shear_stiffness,
                         p.tangential_model});
  });
  to_card(law_of_pair, views.law);
  to_card(laws_of_pairs, views.laws);
  to_card(curves, views.curves);
  if (views.friction) to_card(frictions, views.frictions);
}

/* Send the contacts of each owned sphere, in the order in which the plain style adds their forces. */
template <class DeviceType> void PairGranHystereticKokkos<DeviceType>::send_contacts_of_spheres()
{
  const ContactList &c = contacts;
  std::vector<int> order, first(c.size()), begin(atom->nlocal + 1, 0);
  c.each_pair([&](int, int k, int i, int) { first[k] = i; });
  for (int row = 0; row < c.plain; row += RestingBlocks::SIZE) {
    const int block = RestingBlocks::of(row);
    for (const RowGroup *g = c.groups.begin(block); g != c.groups.end(block); g++)
      for (int l = 0; l < g->lanes; l++)
        for (int m = 0; m < g->partners; m++) order.push_back(g->pair + l * g->stride + m);
  }
  for (int k = c.begin[c.plain]; k < c.size(); k++) order.push_back(k);

  const auto each_side = [&](const auto &visit) {
    for (const int k : order) {
      if (first[k] < atom->nlocal) visit(first[k], k);
      if (c.partner[k] < atom->nlocal) visit(c.partner[k], -1 - k);
    }
  };
  each_side([&](int i, int) { begin[i + 1]++; });
  for (int i = 0; i < atom->nlocal; i++) begin[i + 1] += begin[i];
  std::vector<int> next(begin), of_spheres(begin.back());
  each_side([&](int i, int contact) { of_spheres[next[i]++] = contact; });
  to_card(begin, views.begin);
  to_card(of_spheres, views.contact);
}

template <class DeviceType> void PairGranHystereticKokkos<DeviceType>::send_histories()
{
  const ContactList &c = contacts;
  to_card(c.peak, views.peak);
  to_card(c.time_peak, views.time_peak);
  to_card(c.time_yield, views.time_yield);
  to_card(c.front, views.front);
  to_card(std::vector<Turning>(c.size(), {views.UNKNOWN, 0.0, 0.0, 1.0}), views.turning);
  if (views.friction) {
    to_card(c.spring, views.spring);
    first_of(views.peak_area, c.size());
  }
  ahead = false;
}

/* Bring the histories back to the list, which still contains the pairs that were sent. */
template <class DeviceType> void PairGranHystereticKokkos<DeviceType>::bring_back()
{
  if (!ahead) return;
  ahead = false;
  ContactList &c = contacts;
  const std::vector<double> before = c.peak;
  from_card(views.peak, c.peak);
  from_card(views.time_peak, c.time_peak);
  from_card(views.time_yield, c.time_yield);
  from_card(views.front, c.front);
  if (views.friction) from_card(views.spring, c.spring);
  for (int k = 0; k < c.size(); k++)
    if (c.peak[k] != before[k]) c.discard_turning(k);
}

/* ---------------------------------------------------------------------- forces */

template <class DeviceType> void PairGranHystereticKokkos<DeviceType>::compute_contacts(bool with_virial)
{
  const int owned = atom->nlocal;
  vectors_to_card(atom->x, owned + atom->nghost, x);
  vectors_to_card(atom->f, owned, f);
  if (views.friction) {
    vectors_to_card(atom->v, owned + atom->nghost, v);
    vectors_to_card(atom->omega, owned + atom->nghost, omega);
    vectors_to_card(atom->torque, owned, torque);
  }
  const KernelStep present{
      now, step.dt, {domain->xprd, domain->yprd, domain->zprd, domain->yz, domain->xz, domain->xy}, step.advances};
  PairFindings found;
  Kokkos::parallel_reduce("gran/hysteretic/kk, pairs", Kokkos::RangePolicy<DeviceType>(0, views.pairs),
                          AdvancePairs<DeviceType, Vectors>{views, x, v, omega, present, owned}, found);
  ahead = true;
  if (found.wrong > 0) stop_at_wrong_overlap();
  const Kokkos::RangePolicy<DeviceType> spheres(0, owned);
  if (views.friction)
    Kokkos::parallel_for("gran/hysteretic/kk, spheres", spheres, SumForcesAndTorques<DeviceType, Vectors>{views, f, torque});
  else
    Kokkos::parallel_for("gran/hysteretic/kk, spheres", spheres,
                         SumForces<DeviceType, Vectors, Vectors>{views, x, f, present});
  vectors_from_card(f, owned, atom->f);
  if (views.friction) vectors_from_card(torque, owned, atom->torque);
  if (with_virial) std::copy_n(found.virial, 6, virial);
  if (found.far > 0) forget_far();
}

/* Discard the histories of all pairs beyond the gap. */
template <class DeviceType> void PairGranHystereticKokkos<DeviceType>::forget_far()
{
  bring_back();
  const ContactList &c = contacts;
  for (int r = 0; r < c.plain; r++) forget_far_pairs(r);
  for (int r = c.plain; r < c.rows(); r++)
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++) {
      const int i = c.row[r], j = c.partner[k];
      if (c.peak[k] > 0.0 && geometry.separation(i, j).distance > atom->radius[i] + atom->radius[j] + gap) forget(r, k);
    }
  send_histories();
}

/* Stop with an error at the first overlap that is too large or not a number. */
template <class DeviceType> void PairGranHystereticKokkos<DeviceType>::stop_at_wrong_overlap()
{
  contacts.each_pair([&](int, int, int i, int j) {
    const PairParameters p = pair_parameters(i, j);
    const double overlap = p.radsum - geometry.distance(i, j);
    if (!(overlap <= p.largest_overlap)) overlap_error(i, j, overlap);
  });
  error->one(FLERR,
             "Pair style gran/hysteretic/kk: an overlap that is too large was found on the card, and not on the host");
}

/* Send velocities to the ghosts, which friction needs, as the plain style does. */
template <class DeviceType> void PairGranHystereticKokkos<DeviceType>::send_velocities()
{
  if (!sends_velocities) return;
  if (neighbor->ago == 0) ghosts.renew();
  send(Message::VELOCITIES);
}

template <class DeviceType> void PairGranHystereticKokkos<DeviceType>::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  if (eflag_atom || vflag_atom || cvflag_atom || num_tally_compute > 0)
    error->all(FLERR, "Pair style gran/hysteretic/kk has no energies and stresses of single atoms or pairs: use pair style "
                      "gran/hysteretic");
  refuse_flow();
  if (evaluations++ % STEPS_BETWEEN_CHECKS == 0) require_finite_motion(lmp);
  if (neighbor->ago == 0) renew_ghosts();
  if (!contacts.valid) {
    bring_back();
    build_contacts();
    send_pairs();
  }
  send_velocities();
  begin_evaluation();
  contacts.published = false;
  now = simulated_time(*update);
  step = {update->dt, update->whichflag == 1 && !update->setupflag};
  if (atom->nlocal > 0) compute_contacts(vflag_global != 0);
  if (eflag_global) eng_vdwl = tally_totals();
}

template <class DeviceType> double PairGranHystereticKokkos<DeviceType>::memory_usage()
{
  constexpr double BYTES = 6 * sizeof(int) + 4 * sizeof(double) + sizeof(Front) + sizeof(Turning);
  constexpr double OF_FRICTION = sizeof(TangentialSpring) + sizeof(double) + sizeof(SurfaceForce);
  const double of_pair = BYTES + (views.friction ? OF_FRICTION : 0.0);
  const double of_vectors =
      3 * sizeof(double) * (x.extent(0) + v.extent(0) + omega.extent(0) + f.extent(0) + torque.extent(0));
  return PairGranHysteretic::memory_usage() + of_pair * views.pairs + of_vectors;
}

template class LAMMPS_NS::PairGranHystereticKokkos<Kokkos::DefaultExecutionSpace>;
