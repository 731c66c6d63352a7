// SPDX-License-Identifier: GPL-2.0-only
#include "pair_rows.h"

using namespace granwave;

namespace {

/* Sort the elements of a vector from the first one on by the IDs of their spheres: one digit of the ID after the other. */
void sort_by_id(std::vector<int> &spheres, std::ptrdiff_t first, const LAMMPS_NS::tagint *tag)
{
  constexpr int BITS = 11, DIGITS = 1 << BITS;
  const auto n = spheres.size() - first;
  std::vector<int> before(n);
  std::int64_t largest = 0;
  for (auto i = spheres.begin() + first; i != spheres.end(); i++) largest = std::max<std::int64_t>(largest, tag[*i]);
  for (int shift = 0; shift < 64 && largest >> shift != 0; shift += BITS) {
    std::copy(spheres.begin() + first, spheres.end(), before.begin());
    int place[DIGITS + 1] = {};
    const auto digit = [&](int i) { return static_cast<int>(tag[i] >> shift & (DIGITS - 1)); };
    for (const int i : before) place[digit(i) + 1]++;
    for (int d = 0; d < DIGITS; d++) place[d + 1] += place[d];
    for (const int i : before) spheres[first + place[digit(i)]++] = i;
  }
}

}    // namespace

void PairRows::clear()
{
  row.clear();
  begin.assign(1, 0);
  partner.clear();
  spheres.clear();
}

/* The row is that of the lower ID, whose sphere may be a ghost, and has its partners in the order of their IDs; rows are in the order
   of the IDs of their spheres. The forces on a sphere are summed in the order of the IDs of its partners, and are the same to the last
   bit on any number of processors. */
void PairRows::add_rows(const std::vector<std::pair<int, int>> &pairs, const tagint *tag, int nall)
{
  const auto precedes = [tag](int i, int j) { return tag[i] < tag[j]; };
  const auto in_order = [&](const std::pair<int, int> &pair) { return std::minmax(pair.first, pair.second, precedes); };
  std::vector<int> place(nall, 0);    // number of pairs of a row, then the position of the next one
  for (const auto &pair : pairs) place[in_order(pair).first]++;
  const auto first_row = static_cast<std::ptrdiff_t>(row.size());
  const auto more = nall - std::count(place.begin(), place.end(), 0);
  row.reserve(row.size() + more);
  begin.reserve(begin.size() + more);
  for (std::size_t i = 0; i < place.size(); i++)
    if (place[i] > 0) row.push_back(static_cast<int>(i));
  if (!std::is_sorted(row.begin() + first_row, row.end(), precedes)) sort_by_id(row, first_row, tag);
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

std::pair<int, int> PairRows::search(tagint lower, tagint higher, int first, int last) const
{
  std::pair<int, int> found = {-1, -1};
  const auto precedes = [this](int i, tagint tag) { return spheres[i].tag < tag; };
  for (auto r = std::lower_bound(row.begin() + first, row.begin() + last, lower, precedes) - row.begin();
       r < last && spheres[row[r]].tag == lower; r++)
    for (int k = begin[r]; k < begin[r + 1]; k++)
      if (spheres[partner[k]].tag == higher) found = {static_cast<int>(r), k};
  return found;
}

std::pair<int, int> PairRows::find(tagint lower, tagint higher) const
{
  const std::pair<int, int> found = search(lower, higher, plain, rows());
  return found.second >= 0 ? found : search(lower, higher, 0, plain);
}

int PairRows::find(const Sphere &lower, const Sphere &higher) const
{
  const auto [r, k] = find(lower.tag, higher.tag);
  return k >= 0 && sphere_of_row(r).is(lower) && partner_of_pair(k).is(higher) ? k : -1;
}

double PairRows::bytes() const
{
  return static_cast<double>((row.capacity() + begin.capacity() + partner.capacity()) * sizeof(int) +
                             spheres.capacity() * sizeof(Sphere));
}

/* ---------------------------------------------------------------------- pairs of two lists */

CommonPairs::CommonPairs(const PairRows &before, const PairRows &after) : n_before_(before.size()), n_after_(after.size())
{
  match(before, 0, before.plain, after, 0, after.plain);
  match(before, before.plain, before.rows(), after, after.plain, after.rows());
}

/* Find the pairs of the rows from `first` to the one before `last` in those of the other list. Rows of one sphere are compared
   pair by pair, as both are in the order of IDs; if it has several rows, their pairs are searched. */
void CommonPairs::match(const PairRows &before, int first_before, int last_before, const PairRows &after, int first,
                        int last)
{
  const auto end_of_rows = [](const PairRows &list, int r, int end) {    // of the sphere of row r
    const auto tag = list.sphere_of_row(r).tag;
    while (r < end && list.sphere_of_row(r).tag == tag) r++;
    return r;
  };
  const bool one_kind = last_before - first_before == before.rows();    // a pair is among these rows or in none
  int b = first_before;
  for (int r = first, next = first; r < last; r = next) {
    next = end_of_rows(after, r, last);
    const auto tag = after.sphere_of_row(r).tag;
    while (b < last_before && before.sphere_of_row(b).tag < tag) b++;
    const bool present = b < last_before && before.sphere_of_row(b).tag == tag;
    const int end = present ? end_of_rows(before, b, last_before) : b;
    if (present && end == b + 1 && next == r + 1) {
      if (before.sphere_of_row(b).is(after.sphere_of_row(r))) match_row(before, b, after, r, one_kind);
    } else if (present || !one_kind) {
      for (; r < next; r++)
        for (int k = after.begin[r]; k < after.begin[r + 1]; k++)
          if (!present || first != after.plain || !search_rows(before, b, end, after, r, k)) search(before, after, r, k);
    }
  }
}

void CommonPairs::match_row(const PairRows &before, int r_before, const PairRows &after, int r, bool one_kind)
{
  int b = before.begin[r_before];
  const int end = before.begin[r_before + 1];
  for (int k = after.begin[r]; k < after.begin[r + 1]; k++) {
    const PairRows::Sphere &sphere = after.partner_of_pair(k);
    while (b < end && before.partner_of_pair(b).tag < sphere.tag) b++;
    if (b < end && before.partner_of_pair(b).is(sphere)) add(b, k);
    else if (!one_kind) search(before, after, r, k);
  }
}

void CommonPairs::search(const PairRows &before, const PairRows &after, int r, int k)
{
  const int other = before.find(after.sphere_of_row(r), after.partner_of_pair(k));
  if (other >= 0) scattered_.emplace_back(other, k);
}

/* Search pair k of row r in the rows of its sphere in the list before, `first` to the one before `last`. Returns false if it is not
   there. */
bool CommonPairs::search_rows(const PairRows &before, int first, int last, const PairRows &after, int r, int k)
{
  const PairRows::Sphere &partner = after.partner_of_pair(k);
  int row = -1, pair = -1;
  for (int b = first; b < last; b++)
    for (int other = before.begin[b]; other < before.begin[b + 1]; other++)
      if (before.partner_of_pair(other).tag == partner.tag) {
        row = b;
        pair = other;
      }
  if (pair < 0) return false;
  if (before.sphere_of_row(row).is(after.sphere_of_row(r)) && before.partner_of_pair(pair).is(partner))
    scattered_.emplace_back(pair, k);
  return true;
}

/* Append a pair to the last run, or begin a new run. */
void CommonPairs::add(int from, int to)
{
  if (!runs_.empty()) {
    Run &last = runs_.back();
    if (last.from + last.n == from && last.to + last.n == to) {
      last.n++;
      return;
    }
  }
  runs_.push_back({from, to, 1});
}
