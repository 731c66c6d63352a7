// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: flat list of pairs within reach, and its exchange with the records of the spheres. */

#include "pair_gran_hysteretic.h"

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
using namespace granwave;

void PairGranHysteretic::build_contacts()
{
  const double *radius = atom->radius;
  const int *type = atom->type;
  const int nall = atom->nlocal + atom->nghost;
  const double reach = gap + neighbor->skin;

  require_room();
  require_largest_radii();
  uniform = !radii_vary;
  for (int i = 1; i < nall && uniform; i++) uniform = radius[i] == radius[0] && type[i] == type[0];

  std::vector<std::pair<int, int>> plain, special;
  std::size_t listed = 0;
  for (int ii = 0; ii < list->inum; ii++) listed += list->numneigh[list->ilist[ii]];
  plain.reserve(listed);
  for (int ii = 0; ii < list->inum; ii++) {
    const int i = list->ilist[ii];
    const int *jlist = list->firstneigh[i];
    for (int jj = 0; jj < list->numneigh[i]; jj++) {
      if (force->special_lj[sbmask(jlist[jj])] == 0.0) continue;
      const int j = jlist[jj] & NEIGHMASK;
      if (radius[i] == 0.0 && radius[j] == 0.0) continue;    // two faces
      if (is_special(type[i], type[j])) {
        if (near_special(i, j)) special.emplace_back(i, j);
        continue;
      }
      const double far = (radii_vary ? largest_radius[type[i]] + largest_radius[type[j]] : radius[i] + radius[j]) + reach;
      if (distance_squared(i, j) < far * far) plain.emplace_back(i, j);
    }
  }
  Contacts &c = contacts;
  c.owned = atom->nlocal;
  c.row.clear();
  c.begin.assign(1, 0);
  c.partner.clear();
  add_rows(plain);
  c.plain = static_cast<int>(c.row.size());
  c.resting.build(c.row, c.begin, c.partner);
  c.groups.build(c.row, c.begin, c.partner, RestingBlocks::SIZE);
  add_rows(special);

  const std::size_t n = c.partner.size();
  c.peak.assign(n, 0.0);
  for (auto *times : {&c.time_first, &c.time_peak, &c.time_yield}) times->assign(n, -1.0);
  c.n_extra = fix_history->history.layout().n_extra;
  c.extra.assign(n * c.n_extra, 0.0);
  c.turning.assign(n, -1);
  c.turnings.clear();
  c.work_lost.clear();
  c.circle.clear();
  if (has_friction) c.spring.assign(n, TangentialSpring());
  if (has_initial_dents) {
    c.initial.assign(n, 0.0);
    c.reached.assign(n, 0.0);
    c.initial_extra.assign(n * c.n_extra, 0.0);
  }
  const auto as_now = [this](int i) { return Sphere{atom->radius[i], atom->tag[i], atom->type[i]}; };
  c.row_sphere.resize(c.row.size());
  std::transform(c.row.begin(), c.row.end(), c.row_sphere.begin(), as_now);
  c.partner_sphere.resize(n);
  std::transform(c.partner.begin(), c.partner.end(), c.partner_sphere.begin(), as_now);
  check_displacements();
  restore_history();
  std::vector<int> pairs_of(c.owned, 0);
  c.each_pair([&](int, int, int i, int j) {
    for (const int one : {i, j})
      if (one < c.owned) pairs_of[one]++;
  });
  c.most_pairs = pairs_of.empty() ? 0 : *std::max_element(pairs_of.begin(), pairs_of.end());
  for (int i = 0; i < c.owned; i++) fix_history->expect_records(i, c.most_pairs);
  if (has_friction || has_loss) c.touched = c.groups.bits([this](int k) { return has_spring(k); });
  c.valid = true;
  c.published = false;
}

/* Stop with an error if two spheres could meet both directly and across a periodic boundary. */

void PairGranHysteretic::require_room()
{
  const double reach = 2.0 * *std::max_element(largest_radius.begin(), largest_radius.end()) + gap + neighbor->skin;
  for (int axis = 0; axis < domain->dimension; axis++)
    if (const double least = 2.0 * reach + longest_cylinder(axis); domain->periodicity[axis] && domain->prd[axis] < least)
      error->all(FLERR,
                 "Pair style gran/hysteretic: the periodic box is {:.3g} long in {}, where two spheres could meet both "
                 "directly and across the boundary; it must be at least {:.3g}",
                 domain->prd[axis], "xyz"[axis], least);
  if (!domain->triclinic) return;
  if (cylinders) error->all(FLERR, "Pair style gran/hysteretic: cylinders need a box that is not triclinic");
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

/* Stop with an error if a sphere has grown beyond those that the neighbor lists reckon with. */

void PairGranHysteretic::require_largest_radii()
{
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->radius[i] > largest_radius[atom->type[i]] * (1.0 + TouchingPairs::ROUNDING))
      error->one(FLERR,
                 "Sphere {} has the radius {:.6g}, above the largest of its type at the start of the run, {:.6g}: contacts "
                 "would be found too late; let an atom of the type have that radius, away from the others",
                 atom->tag[i], atom->radius[i], largest_radius[atom->type[i]]);
}

/* Append the rows of these pairs, in the order of the IDs of their spheres. The row is that of the lower ID, whose sphere may be
   a ghost, and has its partners in the order of their IDs: the forces on a sphere are summed in the order of the IDs of its
   partners, and are the same to the last bit on any number of processors. */

void PairGranHysteretic::add_rows(const std::vector<std::pair<int, int>> &pairs)
{
  Contacts &c = contacts;
  const tagint *const tag = atom->tag;
  const auto precedes = [tag](int i, int j) { return tag[i] < tag[j]; };
  const auto in_order = [&](const std::pair<int, int> &pair) { return std::minmax(pair.first, pair.second, precedes); };
  std::vector<int> place(atom->nlocal + atom->nghost, 0);    // number of pairs of a row, then where the next one goes
  for (const auto &pair : pairs) place[in_order(pair).first]++;
  const auto first_row = static_cast<std::ptrdiff_t>(c.row.size());
  for (std::size_t i = 0; i < place.size(); i++)
    if (place[i] > 0) c.row.push_back(static_cast<int>(i));
  if (!std::is_sorted(c.row.begin() + first_row, c.row.end(), precedes))
    std::sort(c.row.begin() + first_row, c.row.end(), precedes);
  for (std::size_t r = first_row; r < c.row.size(); r++) {
    const int n = place[c.row[r]];
    place[c.row[r]] = c.begin.back();
    c.begin.push_back(c.begin.back() + n);
  }
  c.partner.resize(c.begin.back());
  for (const auto &pair : pairs) {
    const auto [i, j] = in_order(pair);
    c.partner[place[i]++] = j;
  }
  for (std::size_t r = first_row; r < c.row.size(); r++)
    std::sort(c.partner.begin() + c.begin[r], c.partner.begin() + c.begin[r + 1], precedes);
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

/* Restore the flat list from the live records of the spheres. A live record whose pair is no longer within reach is forgotten. */

void PairGranHysteretic::restore_history()
{
  ContactHistory &history = fix_history->history;
  if (history.size() == 0 && !history.has_forgotten()) return;
  for (int i = 0; i < atom->nlocal; i++)
    if ((history.count(i) > 0 || !history.forgotten(i).none()) && history.owner(i) != atom->tag[i])
      error->one(FLERR,
                 "The ID of sphere {} was {} when its contacts were made: dents are known by the IDs of their spheres. "
                 "Use 'delete_atoms ... compress no', and no reset_atoms id",
                 atom->tag[i], history.owner(i));
  Contacts &c = contacts;
  constexpr int FOUND = 2;
  const auto restore = [&](int k, int of, tagint partner, double side) {    // from the record of one of the spheres
    if (of >= atom->nlocal) return;
    ContactRecord *record = history.records(of);
    for (int m = 0; m < history.count(of); m++, record++) {
      if (!record->live || record->partner != partner) continue;
      if (history.layout().size() > 0) unpack_block(k, side, history.layout(), history.block(of, m));
      c.peak[k] = record->dent.peak;
      c.time_first[k] = record->dent.time_first;
      c.time_peak[k] = record->dent.time_peak;
      c.time_yield[k] = record->dent.time_yield;
      record->live = FOUND;
      return;
    }
  };
  c.each_pair([&](int r, int k, int i, int j) {
    restore(k, i, c.partner_sphere[k].tag, 1.0);
    restore(k, j, c.row_sphere[r].tag, -1.0);
  });
  history.each_record(atom->nlocal, [&](int i, int m, ContactRecord &record) {
    if (record.live == FOUND) return;
    if (!lists_forgotten) sum_up(i, record, history.block(i, m));
    record.live = lists_forgotten ? 0 : FOUND;    // the others are dropped
  });
  history.keep_forgotten(atom->nlocal, std::vector<int>(atom->nlocal, 0));
}

void PairGranHysteretic::publish_contacts()
{
  Contacts &c = contacts;
  if (!c.valid || c.published || !fix_history) return;
  ContactHistory &history = fix_history->history;
  std::vector<int> extra(c.owned, 0);
  c.each_pair([&](int, int k, int i, int j) {
    if (c.peak[k] > 0.0)
      for (const int one : {i, j})
        if (one < c.owned) extra[one]++;
  });
  history.keep_forgotten(c.owned, extra);
  c.each_pair([&](int r, int k, int i, int j) {
    if (c.peak[k] <= 0.0) return;
    const auto place = [&](int of, const Sphere &sphere, const Sphere &partner, double side) {
      if (of >= c.owned) return;
      history.own(of, sphere.tag);
      pack_block(k, side, history.place(of, {partner.tag, partner.radius, partner.type, 1, dent_of(k)}));
    };
    place(i, c.row_sphere[r], c.partner_sphere[k], 1.0);
    place(j, c.partner_sphere[k], c.row_sphere[r], -1.0);
  });
  c.published = true;
}

void PairGranHysteretic::release_contacts()
{
  publish_contacts();
  contacts.valid = false;
}

Dent PairGranHysteretic::dent_of(int k) const
{
  const Contacts &c = contacts;
  return {c.peak[k], c.time_first[k], c.time_peak[k], c.time_yield[k]};
}

LawHistory PairGranHysteretic::law_history(int k) const
{
  const Contacts &c = contacts;
  return {c.peak[k], c.extra.data() + static_cast<std::size_t>(k) * c.n_extra};
}

/* Block of pair k, as seen from the sphere of the row. */

BlockView PairGranHysteretic::block_view(int k) const
{
  const Contacts &c = contacts;
  BlockView view;
  view.extra = law_history(k).extra;
  if (has_friction) view.spring = c.spring[k];
  if (!has_initial_dents) return view;
  view.initial = c.initial[k];
  view.reached = c.reached[k];
  view.initial_extra = c.initial_extra.data() + static_cast<std::size_t>(k) * c.n_extra;
  return view;
}

/* Write the block of pair k, as seen from the sphere of the row (side 1) or its partner (-1), into a zero block. */

void PairGranHysteretic::pack_block(int k, double side, double *block) const
{
  const BlockLayout &layout = fix_history->history.layout();
  if (layout.size() == 0) return;
  BlockView view = block_view(k);
  std::copy_n(view.extra, contacts.n_extra, block);
  if (!layout.extended) return;
  for (double &force : view.spring.force) force *= side;
  std::memcpy(block + layout.n_extra, static_cast<const ExtendedState *>(&view), sizeof(ExtendedState));
  if (has_initial_dents) std::copy_n(view.initial_extra, contacts.n_extra, block + layout.initial_extra());
}

/* Read the block of pair k, as seen from the sphere of the row (side 1) or its partner (-1). */

void PairGranHysteretic::unpack_block(int k, double side, const BlockLayout &layout, const double *block)
{
  Contacts &c = contacts;
  const BlockView view(layout, block);
  std::copy_n(view.extra, c.n_extra, c.extra.data() + static_cast<std::size_t>(k) * c.n_extra);
  if (has_friction) {
    c.spring[k] = view.spring;
    for (double &force : c.spring[k].force) force *= side;
  }
  if (!has_initial_dents) return;
  c.initial[k] = view.initial;
  c.reached[k] = view.reached;
  std::copy_n(view.initial_extra, c.n_extra, c.initial_extra.data() + static_cast<std::size_t>(k) * c.n_extra);
}

/* Reset pair k to a contact that has not touched in this run, with this peak. With `dented` the peak is that of an initial dent,
   whose history is kept. */

void PairGranHysteretic::reset_history(int k, double peak, bool dented)
{
  Contacts &c = contacts;
  double *const extra = c.extra.data() + static_cast<std::size_t>(k) * c.n_extra;
  ResistanceHistory rolling = has_resistance ? *resistance(k) : ResistanceHistory();
  rolling.rolling.loss = rolling.twisting.loss = 0.0;
  const SlipHistory slipping = has_slip ? *slip(k) : SlipHistory();
  CohesionHistory sticking = has_cohesion ? *cohesion(k) : CohesionHistory();
  sticking.lost = 0.0;
  if (!dented) std::fill_n(extra, c.n_extra, 0.0);
  if (has_slip) *slip(k) = slipping;
  if (has_resistance) *resistance(k) = rolling;
  if (has_cohesion) *cohesion(k) = sticking;
  c.peak[k] = peak;
  c.time_first[k] = c.time_peak[k] = c.time_yield[k] = -1.0;
  c.turning[k] = -1;
  if (has_friction) c.spring[k].loss = 0.0;
  if (has_loss) *viscous(k) = {};
  if (!has_initial_dents) return;
  c.initial[k] = dented ? peak : 0.0;
  c.reached[k] = 0.0;
  std::copy_n(extra, c.n_extra, c.initial_extra.data() + static_cast<std::size_t>(k) * c.n_extra);
}

/* Discard the history of a separated pair: its sums or its record are stored with both spheres, and a new contact may start. */

void PairGranHysteretic::forget(int row, int k)
{
  Contacts &c = contacts;
  const Dent dent = dent_of(k);
  ContactHistory &history = fix_history->history;
  std::vector<double> block(history.layout().size(), 0.0);
  const auto append = [&](int i, int j, double side) {
    if (i >= atom->nlocal) return;
    history.own(i, atom->tag[i]);
    pack_block(k, side, block.data());
    const ContactRecord record{atom->tag[j], atom->radius[j], atom->type[j], 0, dent};
    if (lists_forgotten) {
      history.append(i, record, block.data());
      fix_history->expect_records(i, c.most_pairs);
    } else sum_up(i, record, block.data());
  };
  append(c.row[row], c.partner[k], 1.0);
  append(c.partner[k], c.row[row], -1.0);
  reset_history(k, 0.0, false);
}

void PairGranHysteretic::require_contacts()
{
  if (!contacts.valid)
    error->one(FLERR, "The contacts of pair style gran/hysteretic are not current: spheres were added, deleted or put into "
                      "another order since the last run; use 'run 0' first");
}

/* ---------------------------------------------------------------------- initial dents */

void PairGranHysteretic::prepare_initial_dents()
{
  release_contacts();
  has_initial_dents = true;
  fix_history->history.extend({0, true});
  build_contacts();
}

void PairGranHysteretic::begin_initial_dents()
{
  contacts.each_pair([&](int, int k, int i, int j) {
    const double peak = contacts.peak[k];
    if (peak == 0.0) return;
    const PairParameters p = pair_parameters(i, j);
    const double apart = distance(i, j), rounding = TouchingPairs::ROUNDING * p.radsum;
    double overlap = apart * apart < p.touch_sq ? p.radsum - apart : 0.0;
    if (has_cohesion && cohesion(k)->active()) overlap = std::max(overlap, rounding);    // so that its record is kept
    const bool dented = p.contact.yielded(peak);
    reset_history(k, dented ? peak : overlap, dented);
  });
  for (int i = 0; i < atom->nlocal; i++) fix_history->history.forget_sphere(i);
  contacts.resting.disturb();
  contacts.published = false;
}

std::map<PairGranHysteretic::Ids, PairGranHysteretic::DentStatus>
PairGranHysteretic::set_dents(const std::map<Ids, double> &dents)
{
  std::map<Ids, DentStatus> found;
  contacts.each_pair([&](int r, int k, int i, int j) {
    const auto given = dents.find({contacts.row_sphere[r].tag, contacts.partner_sphere[k].tag});
    if (given == dents.end()) return;
    const auto [ids, peak] = *given;
    const double ri = atom->radius[i], rj = atom->radius[j];
    found[ids] = peak > largest_overlap(ri, rj)   ? DentStatus::TOO_DEEP
                 : distance(i, j) > ri + rj + gap ? DentStatus::OUT_OF_REACH
                                                  : DentStatus::SET;
    if (found[ids] != DentStatus::SET) return;
    reset_history(k, 0.0, false);
    if (pair_parameters(i, j).contact.yielded(peak)) reset_history(k, peak, true);    // a smaller peak is no dent
  });
  contacts.resting.disturb();
  contacts.published = false;
  return found;
}
