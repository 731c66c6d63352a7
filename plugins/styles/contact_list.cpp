// SPDX-License-Identifier: GPL-2.0-only
#include "contact_list.h"

#include <numeric>

using namespace granwave;

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

/* Move all histories to the positions of their pairs in the new list. */
void ContactList::carry(const CommonPairs &common)
{
  common.carry(peak, 0.0);
  common.carry(front, Front());
  for (auto *times : {&time_peak, &time_yield}) common.carry(*times, -1.0);
  common.carry(extra, 0.0, has.n);
  common.carry(turning, -1);
  if (has.friction) common.carry(spring, TangentialSpring());
  if (!has.dents) return;
  common.carry(initial, 0.0);
  common.carry(reached, 0.0);
  common.carry(initial_extra, 0.0, has.n);
}

void ContactList::discard_turnings()
{
  std::fill(turning.begin(), turning.end(), -1);
  turnings.clear();
  work_lost.clear();
  circle.clear();
}

/* Drop the turning points of pairs that are no longer in the list, once these are most of them. */
void ContactList::order_turnings()
{
  const auto used = std::count_if(turning.begin(), turning.end(), [](int t) { return t >= 0; });
  if (turnings.size() <= UNUSED * static_cast<std::size_t>(used)) return;
  std::vector<Turning> points;
  std::vector<double> work, area;
  for (int &t : turning) {
    if (t < 0) continue;
    points.push_back(turnings[t]);
    work.push_back(work_lost[t]);
    if (has.friction) area.push_back(circle[t]);
    t = static_cast<int>(points.size()) - 1;
  }
  turnings.swap(points);
  work_lost.swap(work);
  circle.swap(area);
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
  if (layout.friction) {
    for (double &force : seen.spring.force) force *= side;
    to_doubles(seen.spring, packed + layout.spring());
  }
  if (!layout.dents) return;
  packed[layout.initial()] = seen.initial;
  packed[layout.initial() + 1] = seen.reached;
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
  if (layout.dents) std::copy_n(seen.initial_extra, has.n, initial_extra.data() + static_cast<std::size_t>(k) * has.n);
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
  const double *const law = start.extra.data() + static_cast<std::size_t>(k) * has.n;
  // the doubles of the law; the histories behind them do not advance in a minimization
  const int size = has.n - has.size();
  // turning points are expensive, and follow from the peak and these doubles
  if (peak[k] != start.peak[k] || !std::equal(law, law + size, block(k))) discard_turning(k);
  peak[k] = start.peak[k];
  front[k] = start.front[k];
  time_peak[k] = start.time_peak[k];
  time_yield[k] = start.time_yield[k];
  if (has.dents) reached[k] = start.reached[k];
  std::copy_n(law, size, block(k));
}

void ContactList::return_to_start()
{
  if (!start.kept) return;
  for (int k = 0; k < static_cast<int>(peak.size()); k++)
    if (peak[k] != start.peak[k] || (has.dents && reached[k] != start.reached[k])) return_to_start_of(k);
  published = false;
}

/* ---------------------------------------------------------------------- exchange with the records of the spheres */

void ContactList::suspend(ContactHistory &history)
{
  valid = false;
  if (recorded) drop_records(history);
}

/* Drop the live records of the spheres, which the list has, too. */
void ContactList::drop_records(ContactHistory &history)
{
  history.keep_forgotten(owned);
  recorded = published = false;
}

/* List the contacts of each sphere. */
void ContactList::find_sides()
{
  if (!sides.first.empty()) return;
  sides.first.assign(owned + 1, 0);
  each_dent([&](int, int, int i, int j) {
    for (const int sphere : {i, j})
      if (sphere < owned) sides.first[sphere + 1]++;
  });
  std::partial_sum(sides.first.begin(), sides.first.end(), sides.first.begin());
  sides.all.resize(sides.first.back());
  std::vector<int> next(sides.first.begin(), sides.first.end() - 1);
  each_dent([&](int r, int k, int i, int j) {
    for (const int sphere : {i, j})
      if (sphere < owned) sides.all[next[sphere]++] = {r, k};
  });
}

/* Append the contacts of sphere i, of this index in the list, to its records. */
void ContactList::append_records(ContactHistory &history, int i, int listed)
{
  std::vector<double> block(history.layout().size());
  for (int s = sides.first[listed]; s < sides.first[listed + 1]; s++) {
    const auto [r, k] = sides.all[s];
    const bool is_row = row[r] == listed;
    pack(k, is_row ? 1.0 : -1.0, history.layout(), block.data());
    history.append(i, record_of(k, is_row ? partner_of_pair(k) : sphere_of_row(r)), block.data());
  }
}

void ContactList::publish(ContactHistory &history, int nlocal)
{
  if (!holds || published) return;
  if (!valid) return release(history, nlocal);
  if (recorded) drop_records(history);
  find_sides();
  for (int i = 0; i < owned; i++) append_records(history, i, i);
  sides.clear();    // contacts touch and separate before these are needed again
  published = recorded = true;
}

void ContactList::hand_over(ContactHistory &history, int i)
{
  if (!holds || history.listed(i) < 0) return;
  find_sides();
  append_records(history, i, history.listed(i));
  history.list(i, -1);
}

void ContactList::release(ContactHistory &history, int nlocal)
{
  if (!holds) return;
  suspend(history);
  for (int i = 0; i < nlocal; i++) hand_over(history, i);
  sides.clear();
  holds = false;
}

bool ContactList::has_touched(const ContactHistory &history, int i)
{
  if (!holds || history.listed(i) < 0) return false;
  find_sides();
  return sides.first[history.listed(i)] < sides.first[history.listed(i) + 1];
}

/* Copy the live record of one of the spheres of pair k to the list. */
void ContactList::take_up(ContactHistory &history, int k, int of, const Sphere &other, double side)
{
  if (of >= owned) return;
  ContactRecord *record = history.records(of);
  for (int m = 0; m < history.count(of); m++, record++) {
    if (!record->live || record->partner != other.tag || record->partner_birth != other.birth) continue;
    set_history(k, side, history.layout(), record->dent, history.block(of, m));
    record->live = FOUND;
    return;
  }
}

double ContactList::bytes() const
{
  const auto bytes = [](const auto &...vectors) { return (... + double(vectors.capacity() * sizeof(*vectors.data()))); };
  return PairRows::bytes() + resting.bytes() + groups.bytes() +
         bytes(quiet_special, peak, front, time_peak, time_yield, turning, turnings, work_lost, circle, spring, touched,
               extra, initial, reached, initial_extra);
}
