// SPDX-License-Identifier: GPL-2.0-only
#include "contact_list.h"

using namespace granwave;

/* Append the rows of these pairs, in the order of the IDs of their spheres. The row is that of the lower ID, whose sphere may be
   a ghost, and has its partners in the order of their IDs: the forces on a sphere are summed in the order of the IDs of its
   partners, and are the same to the last bit on any number of processors. */
void ContactList::add_rows(const std::vector<std::pair<int, int>> &pairs, const tagint *tag, int nall)
{
  const auto precedes = [tag](int i, int j) { return tag[i] < tag[j]; };
  const auto in_order = [&](const std::pair<int, int> &pair) { return std::minmax(pair.first, pair.second, precedes); };
  std::vector<int> place(nall, 0);    // number of pairs of a row, then where the next one goes
  for (const auto &pair : pairs) place[in_order(pair).first]++;
  const auto first_row = static_cast<std::ptrdiff_t>(row.size());
  for (std::size_t i = 0; i < place.size(); i++)
    if (place[i] > 0) row.push_back(static_cast<int>(i));
  if (!std::is_sorted(row.begin() + first_row, row.end(), precedes)) std::sort(row.begin() + first_row, row.end(), precedes);
  for (std::size_t r = first_row; r < row.size(); r++) {
    const int n = place[row[r]];
    place[row[r]] = begin.back();
    begin.push_back(begin.back() + n);
  }
  partner.resize(begin.back());
  for (const auto &pair : pairs) {
    const auto [i, j] = in_order(pair);
    partner[place[i]++] = j;
  }
  for (std::size_t r = first_row; r < row.size(); r++)
    std::sort(partner.begin() + begin[r], partner.begin() + begin[r + 1], precedes);
}

std::pair<int, int> ContactList::find(tagint lower, tagint higher) const
{
  std::pair<int, int> found = {-1, -1};
  const auto precedes = [](const Sphere &sphere, tagint tag) { return sphere.tag < tag; };
  const auto search = [&](int first, int last) {    // rows in the order of the IDs
    const auto rows = row_sphere.begin();
    for (auto r = std::lower_bound(rows + first, rows + last, lower, precedes) - rows; r < last && rows[r].tag == lower; r++)
      for (int k = begin[r]; k < begin[r + 1]; k++)
        if (partner_sphere[k].tag == higher) found = {static_cast<int>(r), k};
  };
  search(0, plain);
  search(plain, static_cast<int>(row.size()));
  return found;
}

void ContactList::clear_histories()
{
  const std::size_t n = partner.size();
  start.kept = false;
  peak.assign(n, 0.0);
  front.assign(n, Front());
  for (auto *times : {&time_peak, &time_yield}) times->assign(n, -1.0);
  extra.assign(n * has.n, 0.0);
  turning.assign(n, -1);
  turnings.clear();
  work_lost.clear();
  circle.clear();
  if (has.friction) spring.assign(n, TangentialSpring());
  if (!has.dents) return;
  initial.assign(n, 0.0);
  reached.assign(n, 0.0);
  initial_extra.assign(n * has.n, 0.0);
}

void ContactList::renew_turning(int k, const ScaledLaw &contact)
{
  if (turning[k] < 0) {
    turning[k] = static_cast<int>(turnings.size());
    turnings.emplace_back();
    work_lost.push_back(0.0);
    if (has.friction) circle.push_back(0.0);
  }
  const int t = turning[k];
  turnings[t] = contact.turning(law_history(k));
  work_lost[t] = -1.0;
  if (has.friction) circle[t] = contact.area(turnings[t].peak, block(k));
}

BlockView ContactList::view(int k) const
{
  BlockView view;
  view.extra = block(k);
  if (has.friction) view.spring = spring[k];
  if (!has.dents) return view;
  view.initial = initial[k];
  view.reached = reached[k];
  view.initial_extra = initial_extra.data() + static_cast<std::size_t>(k) * has.n;
  return view;
}

void ContactList::pack(int k, double side, const BlockLayout &layout, double *packed) const
{
  if (layout.size() == 0) return;
  BlockView seen = view(k);
  std::copy_n(seen.extra, has.n, packed);
  if (!layout.extended) return;
  for (double &force : seen.spring.force) force *= side;
  std::memcpy(packed + layout.n_extra, static_cast<const ExtendedState *>(&seen), sizeof(ExtendedState));
  if (has.dents) std::copy_n(seen.initial_extra, has.n, packed + layout.initial_extra());
}

/* Read the block of pair k, as seen from the sphere of the row (side 1) or its partner (-1). */
void ContactList::unpack(int k, double side, const BlockLayout &layout, const double *packed)
{
  if (layout.size() == 0) return;
  const BlockView seen(layout, packed);
  std::copy_n(seen.extra, has.n, block(k));
  if (has.friction) {
    spring[k] = seen.spring;
    for (double &force : spring[k].force) force *= side;
  }
  if (!has.dents) return;
  initial[k] = seen.initial;
  reached[k] = seen.reached;
  std::copy_n(seen.initial_extra, has.n, initial_extra.data() + static_cast<std::size_t>(k) * has.n);
}

void ContactList::begin_anew(int k, double new_peak, bool dented)
{
  has.begin(block(k), dented);
  peak[k] = new_peak;
  front[k] = Front();
  time_peak[k] = time_yield[k] = -1.0;
  turning[k] = -1;
  if (has.friction) spring[k].loss = 0.0;
  if (!has.dents) return;
  initial[k] = dented ? new_peak : 0.0;
  reached[k] = 0.0;
  std::copy_n(block(k), has.n, initial_extra.data() + static_cast<std::size_t>(k) * has.n);
}

void ContactList::reset(int k, double new_peak, bool dented)
{
  begin_anew(k, new_peak, dented);
  if (start.kept) keep_start_of(k);
}

void ContactList::set(int k, const KnownContact &contact, bool yielded)
{
  std::fill_n(block(k), has.n, 0.0);
  std::copy(contact.block.begin(), contact.block.end(), block(k));
  reset(k, contact.peak, yielded);
  if (!has.friction) return;
  spring[k] = TangentialSpring();
  std::copy_n(contact.force, 3, spring[k].force);
  spring[k].compliance = contact.compliance;
}

void ContactList::find_springs()
{
  if (has.friction || has.loss) touched = groups.bits([this](int k) { return has_spring(k); });
}

/* ---------------------------------------------------------------------- minimization */

void ContactList::keep_start()
{
  start = {true, front, peak, time_peak, time_yield, has.dents ? reached : std::vector<double>(), extra};
}

void ContactList::keep_start_of(int k)
{
  start.peak[k] = peak[k];
  start.front[k] = front[k];
  start.time_peak[k] = time_peak[k];
  start.time_yield[k] = time_yield[k];
  if (has.dents) start.reached[k] = reached[k];
  std::copy_n(block(k), has.n, start.extra.data() + static_cast<std::size_t>(k) * has.n);
}

void ContactList::return_to_start_of(int k)
{
  peak[k] = start.peak[k];
  front[k] = start.front[k];
  time_peak[k] = start.time_peak[k];
  time_yield[k] = start.time_yield[k];
  if (has.dents) reached[k] = start.reached[k];
  // the doubles of the law; the histories behind them do not advance in a minimization
  std::copy_n(start.extra.data() + static_cast<std::size_t>(k) * has.n, has.n - has.size(), block(k));
  discard_turning(k);
}

void ContactList::return_to_start()
{
  if (!start.kept) return;
  for (int k = 0; k < static_cast<int>(peak.size()); k++)
    if (peak[k] != start.peak[k] || (has.dents && reached[k] != start.reached[k])) return_to_start_of(k);
  published = false;
}

/* ---------------------------------------------------------------------- exchange with the records of the spheres */

void ContactList::store(ContactHistory &history)
{
  std::vector<int> extra_records(owned, 0);
  each_dent([&](int, int, int i, int j) {
    for (const int one : {i, j})
      if (one < owned) extra_records[one]++;
  });
  history.keep_forgotten(owned, extra_records);
  each_dent([&](int r, int k, int i, int j) {
    const auto place = [&](int of, const Sphere &sphere, const Sphere &other, double side) {
      if (of >= owned) return;
      history.own(of, sphere.tag);
      pack(k, side, history.layout(), history.place(of, {other.tag, other.birth, other.radius, other.type, 1, dent(k)}));
    };
    place(i, row_sphere[r], partner_sphere[k], 1.0);
    place(j, partner_sphere[k], row_sphere[r], -1.0);
  });
}

/* Take up the live record of one of the spheres of pair k. */
void ContactList::take_up(ContactHistory &history, int k, int of, const Sphere &other, double side)
{
  if (of >= owned) return;
  ContactRecord *record = history.records(of);
  for (int m = 0; m < history.count(of); m++, record++) {
    if (!record->live || record->partner != other.tag || record->partner_birth != other.birth) continue;
    unpack(k, side, history.layout(), history.block(of, m));
    peak[k] = record->dent.peak;
    front[k] = record->dent.front;
    time_peak[k] = record->dent.time_peak;
    time_yield[k] = record->dent.time_yield;
    record->live = FOUND;
    return;
  }
}

double ContactList::bytes() const
{
  const auto bytes = [](const auto &...vectors) { return (... + double(vectors.capacity() * sizeof(*vectors.data()))); };
  return resting.bytes() + groups.bytes() +
         bytes(row, begin, quiet_special, row_sphere, partner, partner_sphere, peak, front, time_peak, time_yield, turning,
               turnings, work_lost, circle, spring, touched, extra, initial, reached, initial_extra);
}
