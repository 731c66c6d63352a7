// SPDX-License-Identifier: GPL-2.0-only
/* History of spheres at a pair of walls: their dents, springs of friction, and doubles of the law and of further histories
   (contact_memory.h). Messages and restart files hold them by sphere, in this order. */

#ifndef GRANWAVE_WALL_HISTORY_H
#define GRANWAVE_WALL_HISTORY_H

#include "../kernels/stored.h"
#include "../laws/tangential.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace granwave {

/* Dent of a sphere on one of the walls; all members are doubles, for communication. */
struct WallSide {
  double dent = 0.0, place[3] = {}, lost_before = 0.0, touching = 0.0;
  double initial = 0.0;    // initial dent, if beyond the elastic limit
};

class WallHistory {
 public:
  static constexpr int WALLS = 2;    // the lower and the upper one
  static constexpr int N_SIDES = WALLS * doubles_of<WallSide>(), N_SPRINGS = WALLS * doubles_of<TangentialSpring>();

  /* Set, before there are spheres, what a contact has: a spring, doubles of a block, and of those the first of which initial values
     are kept. */
  void set_contents(bool sprung, int n_block, int n_initial)
  {
    sprung_ = sprung;
    n_block_ = n_block;
    n_initial_ = n_initial;
  }

  /* Doubles of a sphere in messages and restart files. */
  int size() const { return N_SIDES + (sprung_ ? N_SPRINGS : 0) + n_doubles(); }

  void resize(std::size_t n)
  {
    sides_.resize(WALLS * n);
    if (sprung_) springs_.resize(WALLS * n);
    doubles_.resize(n_doubles() * n);
  }

  WallSide &side(int i, int which) { return sides_[at(i, which)]; }
  TangentialSpring &spring(int i, int which) { return springs_[at(i, which)]; }
  double *block(int i, int which) { return doubles(i) + which * n_block_; }
  double *initial(int i, int which) { return doubles(i) + WALLS * n_block_ + which * n_initial_; }

  /* Copy the history of sphere i, from these walls or a copy of them, to sphere j. */
  void take(const WallHistory &from, int i, int j)
  {
    std::copy_n(from.sides_.begin() + from.at(i, 0), static_cast<int>(WALLS), sides_.begin() + at(j, 0));
    if (sprung_) std::copy_n(from.springs_.begin() + from.at(i, 0), static_cast<int>(WALLS), springs_.begin() + at(j, 0));
    std::copy_n(from.doubles(i), n_doubles(), doubles(j));
  }

  void forget(int i)
  {
    for (int which = 0; which < WALLS; which++) {
      side(i, which) = WallSide();
      if (sprung_) spring(i, which) = TangentialSpring();
    }
    std::fill_n(doubles(i), n_doubles(), 0.0);
  }

  /* True if sphere i has the history of a sphere that has not touched a wall. */
  bool is_new(int i) const
  {
    const auto zero = [](const auto *members, std::size_t bytes) {
      const auto *const from = reinterpret_cast<const unsigned char *>(members);
      return std::all_of(from, from + bytes, [](unsigned char byte) { return byte == 0; });
    };
    return zero(&sides_[at(i, 0)], WALLS * sizeof(WallSide)) &&
           (!sprung_ || zero(&springs_[at(i, 0)], WALLS * sizeof(TangentialSpring))) &&
           zero(doubles(i), n_doubles() * sizeof(double));
  }

  double *pack(int i, double *to) const
  {
    for (int which = 0; which < WALLS; which++) to = to_doubles(sides_[at(i, which)], to);
    for (int which = 0; which < WALLS && sprung_; which++) to = to_doubles(springs_[at(i, which)], to);
    return std::copy_n(doubles(i), n_doubles(), to);
  }

  /* Read sphere i. With `sides_only` nothing follows the dents: springs and blocks are as at the start. */
  void unpack(int i, const double *from, bool sides_only = false)
  {
    forget(i);
    for (int which = 0; which < WALLS; which++, from += doubles_of<WallSide>())
      side(i, which) = from_doubles<WallSide>(from);
    if (sides_only) return;
    for (int which = 0; which < WALLS && sprung_; which++, from += doubles_of<TangentialSpring>())
      spring(i, which) = from_doubles<TangentialSpring>(from);
    std::copy_n(from, n_doubles(), doubles(i));
  }

 private:
  bool sprung_ = false;
  int n_block_ = 0, n_initial_ = 0;
  std::vector<WallSide> sides_;
  std::vector<TangentialSpring> springs_;    // empty without friction
  std::vector<double> doubles_;              // by sphere: blocks at both walls, then their initial doubles

  static std::ptrdiff_t at(int i, int which) { return static_cast<std::ptrdiff_t>(i) * WALLS + which; }
  int n_doubles() const { return WALLS * (n_block_ + n_initial_); }
  double *doubles(int i) { return doubles_.data() + static_cast<std::ptrdiff_t>(i) * n_doubles(); }
  const double *doubles(int i) const { return doubles_.data() + static_cast<std::ptrdiff_t>(i) * n_doubles(); }
};

}    // namespace granwave

#endif
