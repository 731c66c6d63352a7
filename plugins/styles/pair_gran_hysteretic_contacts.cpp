/* Pair style gran/hysteretic: the flat list of near pairs, and the records of the spheres that it is made of and returns to. */

#include "pair_gran_hysteretic.h"

#include "atom.h"
#include "domain.h"
#include "error.h"
#include "fix_gran_hysteretic_history.h"
#include "force.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "update.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using granwave::ContactPast;
using granwave::Dent;
using granwave::DentRecord;

void PairGranHysteretic::build_contacts()
{
  const double *const *x = atom->x;
  const double *radius = atom->radius;
  const int *type = atom->type;
  const int nall = atom->nlocal + atom->nghost;
  const double reach = gap + neighbor->skin;

  const double widest = 2.0 * *std::max_element(largest_radius.begin(), largest_radius.end()) + reach;
  for (int axis = 0; axis < domain->dimension; axis++)
    if (domain->periodicity[axis] && domain->prd[axis] < 2.0 * widest)
      error->all(FLERR, "Pair style gran/hysteretic: the periodic box is {:.3g} long in {}, where two spheres could meet both "
                        "directly and across the boundary; it must be at least {:.3g}", domain->prd[axis], "xyz"[axis], 2.0 * widest);

  uniform = true;
  for (int i = 1; i < nall && uniform; i++) uniform = radius[i] == radius[0] && type[i] == type[0];

  Contacts &c = contacts;
  c.row.clear();
  c.begin.clear();
  c.partner.clear();
  c.row_tag.clear();
  c.partner_tag.clear();
  c.owned = atom->nlocal;
  c.span = 0;
  c.ordered = std::is_sorted(list->ilist, list->ilist + list->inum);
  std::size_t pairs = 0;
  for (int ii = 0; ii < list->inum; ii++) pairs += list->numneigh[list->ilist[ii]];
  c.row.reserve(list->inum);
  c.begin.reserve(list->inum + 1);
  c.partner.reserve(pairs);

  for (int ii = 0; ii < list->inum; ii++) {
    const int i = list->ilist[ii];
    const int *jlist = list->firstneigh[i];
    c.row.push_back(i);
    c.begin.push_back(static_cast<int>(c.partner.size()));
    for (int jj = 0; jj < list->numneigh[i]; jj++) {
      if (force->special_lj[sbmask(jlist[jj])] == 0.0) continue;
      const int j = jlist[jj] & NEIGHMASK;
      const double dx = x[i][0] - x[j][0], dy = x[i][1] - x[j][1], dz = x[i][2] - x[j][2];
      if (radius[i] == 0.0 && radius[j] == 0.0) continue;    // two faces
      const double far = radius[i] + radius[j] + reach;
      if (dx * dx + dy * dy + dz * dz >= far * far) continue;
      c.partner.push_back(j);
      if (j < i) c.ordered = false;
      if (j < atom->nlocal) c.span = std::max(c.span, j - i);
    }
  }
  c.begin.push_back(static_cast<int>(c.partner.size()));

  const std::size_t n = c.partner.size();
  c.peak.assign(n, 0.0);
  c.time_first.assign(n, -1.0);
  c.time_peak.assign(n, -1.0);
  c.time_yield.assign(n, -1.0);
  c.turning.assign(n, -1);
  c.turnings.clear();
  c.work_lost.clear();
  c.circle.clear();
  if (rubbing) c.held.assign(n + HELD_AT_A_TIME, 0);
  if (rubbing) c.spring.assign(n, granwave::Spring());
  if (pasts) {
    c.initial.assign(n, 0.0);
    c.reached.assign(n, 0.0);
  }
  c.row_tag.resize(c.row.size());
  c.partner_tag.resize(n);
  for (std::size_t r = 0; r < c.row.size(); r++) c.row_tag[r] = atom->tag[c.row[r]];
  for (std::size_t k = 0; k < n; k++) c.partner_tag[k] = atom->tag[c.partner[k]];
  const std::size_t rows = uniform ? std::min<std::size_t>(1, c.row.size()) : c.row.size(), pairs_kept = uniform ? std::min<std::size_t>(1, n) : n;
  c.row_radius.resize(rows);
  c.row_type.resize(rows);
  c.partner_radius.resize(pairs_kept);
  c.partner_type.resize(pairs_kept);
  for (std::size_t r = 0; r < rows; r++) {
    c.row_radius[r] = radius[c.row[r]];
    c.row_type[r] = type[c.row[r]];
  }
  for (std::size_t k = 0; k < pairs_kept; k++) {
    c.partner_radius[k] = radius[c.partner[k]];
    c.partner_type[k] = type[c.partner[k]];
  }
  refuse_leaps();
  restore_dents();
  c.valid = true;
  c.published = false;
}

/* A sphere that moves by much of its radius in one step would pass through others unseen; so would a face that moves by
   much of theirs. */

void PairGranHysteretic::refuse_leaps()
{
  constexpr double LARGEST = 0.5;    // of the radius
  const double *const *v = atom->v;
  const double largest = *std::max_element(largest_radius.begin(), largest_radius.end());
  for (int i = 0; i < atom->nlocal; i++) {
    const double radius = atom->radius[i] > 0.0 ? atom->radius[i] : largest;
    if (radius == 0.0) continue;    // nodes alone
    const double leap = std::sqrt(v[i][0] * v[i][0] + v[i][1] * v[i][1] + v[i][2] * v[i][2]) * update->dt;
    if (!(leap <= LARGEST * radius))
      error->one(FLERR, "Sphere {} moves by {:.3g} of {} radius in one timestep: the timestep is far too large for its "
                        "velocity, or the run is unstable", atom->tag[i], leap / radius,
                 atom->radius[i] > 0.0 ? "its" : "the largest sphere's");
  }
}

/* The spheres' live records become flat again. A live record whose pair is out of reach now is forgotten. */

void PairGranHysteretic::restore_dents()
{
  granwave::ContactHistory &history = fix_history->history;
  if (history.size() == 0) return;
  for (int i = 0; i < atom->nlocal; i++)
    if (history.count(i) > 0 && history.owner(i) != atom->tag[i])
      error->one(FLERR, "The ID of sphere {} was {} when its contacts were made: dents are known by the IDs of their spheres. "
                        "Use 'delete_atoms ... compress no', and no reset_atoms id", atom->tag[i], history.owner(i));
  Contacts &c = contacts;
  constexpr int FOUND = 2;
  for (std::size_t r = 0; r < c.row.size(); r++) {
    const int i = c.row[r];
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++) {
      const int j = c.partner[k];
      const auto find = [&](int of, tagint partner) -> DentRecord * {
        DentRecord *record = history.records(of);
        for (int m = 0; m < history.count(of); m++, record++)
          if (record->live && record->partner == partner) return record;
        return nullptr;
      };
      DentRecord *record = find(i, c.partner_tag[k]);
      if (record && history.wide()) {
        const ContactPast past = history.past(i, static_cast<int>(record - history.records(i)));
        if (rubbing) c.spring[k] = past.spring;
        if (rubbing) c.held[k] = past.spring.compliance > 0.0;
        if (pasts) c.initial[k] = past.initial;
        if (pasts) c.reached[k] = past.reached;
      }
      if (record) {
        c.peak[k] = record->dent.peak;
        c.time_first[k] = record->dent.time_first;
        c.time_peak[k] = record->dent.time_peak;
        c.time_yield[k] = record->dent.time_yield;
        record->live = FOUND;
      }
      if (j < atom->nlocal)
        if (DentRecord *other = find(j, c.row_tag[r])) other->live = FOUND;
    }
  }
  for (int i = 0; i < atom->nlocal; i++) {
    DentRecord *record = history.records(i);
    for (int m = 0; m < history.count(i); m++, record++)
      if (record->live == 1) record->live = 0;
  }
  history.keep_forgotten(atom->nlocal);
}

void PairGranHysteretic::publish_contacts()
{
  Contacts &c = contacts;
  if (!c.valid || c.published || !fix_history) return;
  granwave::ContactHistory &history = fix_history->history;
  const int rows = static_cast<int>(c.row.size());
  history.keep_forgotten(c.owned);
  std::vector<int> extra(c.owned, 0);
  for (int r = 0; r < rows; r++)
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++)
      if (c.peak[k] > 0.0) {
        extra[c.row[r]]++;
        if (c.partner[k] < c.owned) extra[c.partner[k]]++;
      }
  history.reserve(c.owned, extra);
  for (int r = 0; r < rows; r++) history.own(c.row[r], c.row_tag[r]);
  for (int r = 0; r < rows; r++) {
    const int of_row = uniform ? 0 : r;
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++) {
      if (c.peak[k] <= 0.0) continue;
      const int of_pair = uniform ? 0 : k;
      const Dent dent = dent_of(k);
      history.place(c.row[r], {c.partner_tag[k], c.partner_radius[of_pair], c.partner_type[of_pair], 1, dent}, past_of(k, 1.0));
      if (c.partner[k] < c.owned)
        history.place(c.partner[k], {c.row_tag[r], c.row_radius[of_row], c.row_type[of_row], 1, dent}, past_of(k, -1.0));
    }
  }
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

/* The rest of what pair k remembers, as the row's sphere (side 1) or its partner (-1) feels it. */

ContactPast PairGranHysteretic::past_of(int k, double side) const
{
  const Contacts &c = contacts;
  ContactPast past;
  if (rubbing) past.spring = c.spring[k];
  for (double &force : past.spring.force) force *= side;
  if (pasts) past.initial = c.initial[k];
  if (pasts) past.reached = c.reached[k];
  return past;
}

/* Pair k as if it had never met in this run, with a dent from before it. */

void PairGranHysteretic::set_fresh(int k, double peak, double initial)
{
  Contacts &c = contacts;
  c.peak[k] = peak;
  c.time_first[k] = c.time_peak[k] = c.time_yield[k] = -1.0;
  if (rubbing) c.spring[k].loss = 0.0;
  if (pasts) c.initial[k] = initial;
  if (pasts) c.reached[k] = 0.0;
}

/* The pair has parted for good: both spheres file the dent, a new one may start. */

void PairGranHysteretic::forget(int row, int k)
{
  Contacts &c = contacts;
  const int i = c.row[row], j = c.partner[k];
  const Dent dent = dent_of(k);
  granwave::ContactHistory &history = fix_history->history;
  history.own(i, c.row_tag[row]);
  if (j < atom->nlocal) history.own(j, c.partner_tag[k]);
  history.append(i, {c.partner_tag[k], atom->radius[j], atom->type[j], 0, dent}, past_of(k, 1.0));
  if (j < atom->nlocal)
    history.append(j, {c.row_tag[row], atom->radius[i], atom->type[i], 0, dent}, past_of(k, -1.0));
  set_fresh(k, 0.0, 0.0);
  c.turning[k] = -1;
}

void PairGranHysteretic::require_contacts()
{
  if (!contacts.valid)
    error->one(FLERR, "The contacts of pair style gran/hysteretic are not current: spheres were added, deleted or put into "
                      "another order since the last run; use 'run 0' first");
}

/* ---------------------------------------------------------------------- dents from before the run */

void PairGranHysteretic::prepare_pasts()
{
  release_contacts();
  pasts = true;
  fix_history->history.widen();
  build_contacts();
}

void PairGranHysteretic::begin_pasts()
{
  const double *const *x = atom->x;
  const double *radius = atom->radius;
  const Contacts &c = contacts;
  for (std::size_t r = 0; r < c.row.size(); r++) {
    const int i = c.row[r];
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++) {
      if (c.peak[k] == 0.0) continue;
      const int j = c.partner[k];
      const Pairing p = pairing(atom->type[i], atom->type[j], radius[i], radius[j]);
      const double dx = x[i][0] - x[j][0], dy = x[i][1] - x[j][1], dz = x[i][2] - x[j][2];
      const double rsq = dx * dx + dy * dy + dz * dz;
      const bool dented = c.peak[k] > p.scale.elastic_limit;
      const double touching = rsq < p.touch_sq ? p.sum_radii - std::sqrt(rsq) : 0.0;
      set_fresh(k, dented ? c.peak[k] : touching, dented ? c.peak[k] : 0.0);
    }
  }
  for (int i = 0; i < atom->nlocal; i++) fix_history->history.forget_sphere(i);
  contacts.published = false;
}

void PairGranHysteretic::set_dents(const std::function<double(tagint, tagint)> &dent,
                                   const std::function<void(tagint, tagint, Given)> &said)
{
  const double *const *x = atom->x;
  const double *radius = atom->radius;
  const Contacts &c = contacts;
  for (std::size_t r = 0; r < c.row.size(); r++) {
    const int i = c.row[r];
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++) {
      const tagint lower = std::min(c.row_tag[r], c.partner_tag[k]), higher = std::max(c.row_tag[r], c.partner_tag[k]);
      const double peak = dent(lower, higher);
      if (peak < 0.0) continue;
      const int j = c.partner[k];
      const double dx = x[i][0] - x[j][0], dy = x[i][1] - x[j][1], dz = x[i][2] - x[j][2];
      const double reach = radius[i] + radius[j] + gap;
      const Pairing p = pairing(atom->type[i], atom->type[j], radius[i], radius[j]);
      const bool lasts = peak > p.scale.elastic_limit;    // a smaller one would leave nothing
      if (peak > largest_overlap(radius[i], radius[j])) {
        said(lower, higher, Given::TOO_DEEP);
      } else if (dx * dx + dy * dy + dz * dz > reach * reach) {
        said(lower, higher, Given::OUT_OF_REACH);
      } else {
        set_fresh(k, lasts ? peak : 0.0, lasts ? peak : 0.0);
        said(lower, higher, Given::SET);
      }
    }
  }
  contacts.published = false;
}
