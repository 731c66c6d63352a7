// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: flat list of pairs within reach, and its exchange with the records of the spheres. */

#include "pair_gran_hysteretic.h"

#include "domain.h"
#include "error.h"
#include "force.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "update.h"

using namespace LAMMPS_NS;
using namespace granwave;

void PairGranHysteretic::build_contacts()
{
  const double *radius = atom->radius;
  const int *type = atom->type;
  const int nlocal = atom->nlocal, nall = nlocal + atom->nghost;
  const double reach = gap + neighbor->skin;

  require_room();
  require_largest_radii();
  uniform = !radii_vary;
  for (int i = 1; i < nall && uniform; i++) uniform = radius[i] == radius[0] && type[i] == type[0];

  std::vector<std::pair<int, int>> plain, special;
  std::vector<int> pairs_of(nall, 0);
  std::size_t listed = 0;
  for (int ii = 0; ii < list->inum; ii++) listed += list->numneigh[list->ilist[ii]];
  plain.reserve(listed);
  for (int ii = 0; ii < list->inum; ii++) {
    const int i = list->ilist[ii], itype = type[i], *const jlist = list->firstneigh[i];
    const double ri = radius[i], largest_i = largest_radius[itype];
    int n_pairs = 0;
    for (int jj = 0; jj < list->numneigh[i]; jj++) {
      if (force->special_lj[sbmask(jlist[jj])] == 0.0) continue;
      const int j = jlist[jj] & NEIGHMASK;
      const double rj = radius[j];
      if (ri == 0.0 && rj == 0.0) continue;    // two faces
      const double far = (radii_vary ? largest_i + largest_radius[type[j]] : ri + rj) + reach;
      if (laws.is_special(itype, type[j])) {
        const CylinderPair::Separation found = geometry.separation(i, j);
        if (!(found.distance < far && found.beyond < reach)) continue;
        special.emplace_back(i, j);
      } else {
        const bool crosses = j >= nlocal && geometry.crosses(i, j);
        const double rsq = crosses ? geometry.distance_squared(i, j) : geometry.rounded_distance_squared(i, j);
        if (!(rsq < far * far)) continue;
        (crosses ? special : plain).emplace_back(i, j);
      }
      n_pairs++;
      pairs_of[j]++;
    }
    pairs_of[i] += n_pairs;
  }
  ContactList &c = contacts;
  ContactHistory &history = fix_history->history;
  if (has.n != history.layout().n_extra) release_contacts();
  has.n = history.layout().n_extra;
  require_same_ids();
  check_displacements();
  c.build(
      plain, special, atom->tag, nlocal, nall,
      [this, &history](int i) {
        return ContactList::Sphere{atom->radius[i], atom->tag[i], atom->type[i], history.birth(i)};
      },
      history, [this](int i, const ContactRecord &record, const double *block) { end_contact(i, record, block); });
  if (radii_vary) c.discard_turnings();
  c.most_pairs = c.owned > 0 ? *std::max_element(pairs_of.begin(), pairs_of.begin() + c.owned) : 0;
  fix_history->expect_records(c.most_pairs);
  c.find_springs();
}

/* Stop with an error if two spheres could meet both directly and across a periodic boundary. */
void PairGranHysteretic::require_room()
{
  const Cylinders *const cylinders = laws.cylinders();
  const double reach = 2.0 * *std::max_element(largest_radius.begin(), largest_radius.end()) + gap + neighbor->skin;
  for (int axis = 0; axis < domain->dimension; axis++) {
    double least = 2.0 * reach;
    for (int type = 1; cylinders && type <= laws.types(); type++)    // the longest of the cylinders along this axis
      least = std::max(least, 2.0 * reach + cylinders->shape(type).length * std::fabs(cylinders->shape(type).axis[axis]));
    if (domain->periodicity[axis] && domain->prd[axis] < least)
      error->all(FLERR,
                 "Pair style gran/hysteretic: the periodic box is {:.3g} long in {}, where two spheres could meet both "
                 "directly and across the boundary; it must be at least {:.3g}",
                 domain->prd[axis], "xyz"[axis], least);
  }
  if (!domain->triclinic) return;
  if (cylinders) error->all(FLERR, "Pair style gran/hysteretic: cylinders require an orthogonal box");
  int most[3];    // images along the edges of the box
  for (int axis = 0; axis < 3; axis++) most[axis] = domain->periodicity[axis] && axis < domain->dimension ? 2 : 0;
  const double *const h = domain->h;
  double nearest = INFINITE;
  for (int i = -most[0]; i <= most[0]; i++)
    for (int j = -most[1]; j <= most[1]; j++)
      for (int k = -most[2]; k <= most[2]; k++)
        if (i != 0 || j != 0 || k != 0)
          nearest = std::min(nearest, std::hypot(i * h[0] + j * h[5] + k * h[4], j * h[1] + k * h[3], k * h[2]));
  if (nearest < 2.0 * reach)
    error->all(
        FLERR,
        "Pair style gran/hysteretic: the tilted periodic box has images at a distance of {:.3g}, where two spheres could "
        "meet twice; it must be at least {:.3g}",
        nearest, 2.0 * reach);
}

/* Stop with an error if a sphere has grown beyond the radii assumed in the neighbor lists. */
void PairGranHysteretic::require_largest_radii()
{
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->radius[i] > largest_radius[atom->type[i]] * (1.0 + TouchingPairs::ROUNDING))
      error->one(FLERR,
                 "Sphere {} has the radius {:.6g}, above the largest of its type at the start of the run, {:.6g}: contacts "
                 "would be found too late; place an atom of the type with this radius away from the others",
                 atom->tag[i], atom->radius[i], largest_radius[atom->type[i]]);
}

/* Stop with an error if a sphere moves by a large part of its radius in one timestep, or a face by a large part of the radius
   of the largest sphere: they could pass through others undetected. */
void PairGranHysteretic::check_displacements()
{
  constexpr double LARGEST = 0.5;    // relative to the radius
  const double *const *v = atom->v;
  const double largest = *std::max_element(largest_radius.begin(), largest_radius.end());
  for (int i = 0; i < atom->nlocal; i++) {
    const double radius = atom->radius[i] > 0.0 ? atom->radius[i] : largest;
    if (radius == 0.0) continue;    // nodes only
    const double leap = std::sqrt(v[i][0] * v[i][0] + v[i][1] * v[i][1] + v[i][2] * v[i][2]) * update->dt;
    if (!(leap <= LARGEST * radius))
      error->one(FLERR,
                 "Sphere {} moves by {:.3g} of {} radius in one timestep: the timestep is far too large for its "
                 "velocity, or the run is unstable",
                 atom->tag[i], leap / radius, atom->radius[i] > 0.0 ? "its" : "the largest sphere's");
  }
}

/* Stop with an error if the ID of a sphere with contacts has changed. */
void PairGranHysteretic::require_same_ids()
{
  const ContactHistory &history = fix_history->history;
  for (int i = 0; i < atom->nlocal; i++)
    if (history.owner(i) != atom->tag[i] &&
        (history.count(i) > 0 || history.has_forgotten(i) || contacts.has_touched(history, i)))
      error->one(FLERR,
                 "The ID of sphere {} was {} when its contacts were made: dents are stored by the IDs of their spheres. "
                 "Use 'delete_atoms ... compress no', and no reset_atoms id",
                 atom->tag[i], history.owner(i));
}

void PairGranHysteretic::publish_contacts()
{
  if (fix_history) contacts.publish(fix_history->history, atom->nlocal);
}

/* Store all contacts with the spheres, from whose records the next list is built. */
void PairGranHysteretic::release_contacts()
{
  if (fix_history) contacts.release(fix_history->history, atom->nlocal);
}

/* Add the history of a contact of sphere i that has been discarded to the sums of the sphere, or keep it on record. */
void PairGranHysteretic::end_contact(int i, const ContactRecord &record, const double *block)
{
  if (!lists_forgotten) return sum_up(i, record, block);
  ContactRecord ended = record;
  ended.live = 0;
  fix_history->history.append(i, ended, block);
  fix_history->expect_records_of(i);
}

/* Discard the history of a separated pair: its sums or its record are stored with both spheres, and a new contact may start. */
void PairGranHysteretic::forget(int row, int k)
{
  ContactList &c = contacts;
  const Dent dent = c.dent(k);
  ContactHistory &history = fix_history->history;
  std::vector<double> block(history.layout().size(), 0.0);
  const auto append = [&](int i, int j, double side) {
    if (i >= atom->nlocal) return;
    c.pack(k, side, history.layout(), block.data());
    end_contact(i, {atom->tag[j], history.birth(j), atom->radius[j], atom->type[j], 0, dent}, block.data());
  };
  append(c.row[row], c.partner[k], 1.0);
  append(c.partner[k], c.row[row], -1.0);
  c.reset(k, 0.0, false);
}

void PairGranHysteretic::require_contacts()
{
  if (!contacts.valid)
    error->one(FLERR, "The contacts of pair style gran/hysteretic are not current: spheres were added, deleted or reordered "
                      "since the last run; use 'run 0' first");
  if (contacts.bring_back) contacts.bring_back();
}

/* ---------------------------------------------------------------------- initial dents */

void PairGranHysteretic::prepare_initial_dents()
{
  release_contacts();
  has.dents = true;
  fix_history->history.extend({0, false, true});
  build_contacts();
}

void PairGranHysteretic::begin_initial_dents(bool keeps)
{
  contacts.each_dent([&](int, int k, int i, int j) {
    const double peak = contacts.peak[k];
    const PairParameters p = pair_parameters(i, j);
    const double apart = geometry.distance(i, j), rounding = TouchingPairs::ROUNDING * p.radsum;
    double overlap = apart * apart < p.touch_sq ? p.radsum - apart : 0.0;
    if (has.cohesion && has.cohesion_of(contacts.block(k))->active())
      overlap = std::max(overlap, rounding);    // so that its record is kept
    if (!keeps) overlap = std::min(overlap, rounding);
    const bool dented = keeps && p.contact.yielded(peak);
    contacts.reset(k, dented ? peak : overlap, dented);
  });
  for (int i = 0; i < atom->nlocal; i++) fix_history->history.forget_sphere(i);
  contacts.disturb();
  contacts.published = false;
}

std::map<PairGranHysteretic::Ids, PairGranHysteretic::DentStatus>
PairGranHysteretic::set_contacts(const std::map<Ids, KnownContact> &known)
{
  std::map<Ids, DentStatus> found;
  contacts.each_pair([&](int r, int k, int i, int j) {
    const auto given = known.find({contacts.sphere_of_row(r).tag, contacts.partner_of_pair(k).tag});
    if (given == known.end()) return;
    const auto &[ids, contact] = *given;
    const double peak = contact.peak;
    const double ri = atom->radius[i], rj = atom->radius[j];
    found[ids] = peak > PairLaws::largest_overlap(ri, rj)  ? DentStatus::TOO_DEEP
                 : geometry.distance(i, j) > ri + rj + gap ? DentStatus::OUT_OF_REACH
                 : !has.takes(contact)                     ? DentStatus::OTHER_LAW
                                                           : DentStatus::SET;
    if (found[ids] != DentStatus::SET) return;
    const bool yielded = pair_parameters(i, j).contact.yielded(peak);
    if (contact.whole) return contacts.set(k, contact, yielded);
    contacts.reset(k, 0.0, false);
    if (yielded) contacts.reset(k, peak, true);    // a smaller peak is no dent
  });
  contacts.find_springs();
  contacts.disturb();
  contacts.published = false;
  return found;
}
