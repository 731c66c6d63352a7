// SPDX-License-Identifier: GPL-2.0-only
/* Partial slip of a contact with friction, after Mindlin and Deresiewicz (1953): a row of springs, each with a slider, in
   place of the single spring of tangential.h. No LAMMPS types.

   The contact circle of radius a is a row over 0 <= x <= a of tangential stiffness K = 8 G* per unit length, in which the place x bears

       q(x) = (3/2) mu F_n (a^2 - x^2)/a^3        at most, for Hertz's pressure

   and slips by itself where it would bear more. That is the method of dimensionality reduction (Popov and Hess 2015), for equal bodies
   the solution of Cattaneo and Mindlin under any history of both forces (Jaeger 1993): at a constant normal force
   F = mu F_n (1 - (1 - d/d_max)^(3/2)), d_max = (3/2) mu F_n/(K a), and loops follow. A place stays as the circle grows and shrinks: it is
   unstressed when it comes into contact.

   The row is divided into N = 16 cells of one force each, their edges at reach (n/N)^(2/3), where cells err alike. In a timestep with slip s,
   with k the stiffness of a cell's part within the circle and l its part of mu F_n:

       f <- f min(1, k/k_before) - k s,  |f| <= l

   The reach is R* 2^(2m/3) with the smallest whole m for which the circle is within: if that rises by 1, two cells each become one, and the
   reverse where the circle is below 2/5 of the reach. So 8 to 16 cells are within a circle that grows.

   With damping along the surface (tangential_damping.h) a cell of stiffness k has that part k/k_t of its force D, at most l, and
   |f + D k/k_t| <= l.

   Stored energy: sum of f^2/(2k). Loss: work against the slip, (F_before + F)/2 . (-s), minus the increase of the stored energy, with F the
   sum of f. It is the slip of the cells, and the part of the stored energy that depends on differences within a cell. */

#ifndef GRANWAVE_PARTIAL_SLIP_H
#define GRANWAVE_PARTIAL_SLIP_H

#include "tangential_damping.h"

#include <algorithm>
#include <array>

namespace granwave {

/* State of a contact with partial slip. */
struct SlipContact {
  double normal[3];    // unit normal towards the first body
  double slip[3];      // of the timestep
  double circle;       // radius of the contact circle
  double stiffness;    // k_t of the circle, 8 G* a
  double limit;        // mu F_n
  double effective_radius;
};

/* Damping along the surface in a timestep of a contact with partial slip. */
struct SlipDamping {
  double force[3];     // -c V, then D within the limits of the cells
  double before[3];    // D at the end of the last step
  double lost;         // energy from the elongation of the cells
};

/* History of a contact with partial slip, in its doubles. Total force, compliance and dissipated energy are those of the
   contact's TangentialSpring. */
template <int N> class SlipCells {
 public:
  static_assert(N % 2 == 0);

  enum {
    AXIS,         // in the tangent plane: the forces have a component along it, and one along normal x axis
    REACH = 3,    // 0: no cells
    CIRCLE,       // radius of the circle at the last step
    STORED,       // energy
    FORCES,       // forces of the cells on the first body, two components each
    SIZE = FORCES + 2 * N
  };

  explicit SlipCells(double *doubles) : doubles_(doubles) {}

  bool active() const { return doubles_[REACH] > 0.0; }

  /* Stored energy; without cells, that of the single spring. */
  static double energy(const double *doubles, const TangentialSpring &spring)
  {
    return doubles[REACH] > 0.0 ? doubles[STORED] : tangential_energy(spring);
  }

  /* Advance by the slip of a timestep, with a positive normal force. */
  void advance(TangentialSpring &spring, const SlipContact &c, SlipDamping *damping = nullptr)
  {
    const double per_length = c.stiffness / c.circle;
    turn(c.normal);
    follow(c.circle, c.effective_radius);
    const double (&n)[3] = c.normal;
    const double u[3] = {doubles_[AXIS], doubles_[AXIS + 1], doubles_[AXIS + 2]}, circle = doubles_[CIRCLE];
    const double v[3] = {n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0]};
    const double slip[2] = {dot(c.slip, u), dot(c.slip, v)};
    double sum[2] = {}, before[2] = {}, energy = 0.0, first = 0.0;
    double drag[2] = {}, last_drag[2] = {}, damped[2] = {}, lost_by_damping = 0.0;
    if (damping)
      for (int d = 0; d < 2; d++) {
        drag[d] = dot(damping->force, d == 0 ? u : v);
        before[d] = last_drag[d] = dot(damping->before, d == 0 ? u : v);
      }
    for (int m = 0; m < N; m++) {
      double *const f = force(m);
      const double k_before = per_length * covered(m, circle), k = per_length * covered(m, c.circle);
      const double last = share(edge(m + 1) / c.circle), limit = c.limit * (last - first);
      const double kept = k < k_before ? k / k_before : 1.0;
      first = last;
      double held[2];
      for (int d = 0; d < 2; d++) {
        before[d] += f[d];
        held[d] = kept * f[d];
        f[d] = held[d] - k * slip[d];
      }
      double square = 0.0;
      if (damping && k > 0.0) {
        const double weight = k / c.stiffness;
        double part[2] = {weight * drag[0], weight * drag[1]};
        limit_cell(part, limit);
        square = limit_cell_sum(f, part, limit);
        for (int d = 0; d < 2; d++) {
          damped[d] += part[d];
          lost_by_damping -= 0.5 * (weight * last_drag[d] + part[d]) * (held[d] - f[d]) / k;
        }
      } else {
        square = limit_cell(f, limit);
      }
      for (int d = 0; d < 2; d++) sum[d] += f[d];
      if (k > 0.0) energy += 0.5 * square / k;
    }
    const double work = -0.5 * ((before[0] + (sum[0] + damped[0])) * slip[0] + (before[1] + (sum[1] + damped[1])) * slip[1]);
    for (int d = 0; d < 3; d++) spring.force[d] = sum[0] * u[d] + sum[1] * v[d];
    spring.compliance = 1.0 / c.stiffness;
    // without damping it is negative only by rounding, or negligibly if the slip of a step exceeds the elongation of a cell
    const double lost = work - (energy - doubles_[STORED]) - lost_by_damping;
    spring.loss += damping ? lost : std::max(lost, 0.0);
    if (damping) {
      damping->lost = lost_by_damping;
      for (int d = 0; d < 3; d++) damping->force[d] = damped[0] * u[d] + damped[1] * v[d];
    }
    doubles_[STORED] = energy;
    doubles_[CIRCLE] = c.circle;
  }

  /* End the contact: the stored energy is dissipated. */
  void release(TangentialSpring &spring)
  {
    const double lost = spring.loss + doubles_[STORED];
    spring = {{0.0, 0.0, 0.0}, 0.0, lost};
    std::fill_n(doubles_, static_cast<int>(SIZE), 0.0);
  }

 private:
  static constexpr double STEP = 1.5874010519681994;    // 2^(2/3), factor of the reach

  /* Edges of the cells / radius of the circle that the cells cover. */
  inline static const std::array<double, N + 1> EDGES = [] {
    std::array<double, N + 1> edges{};
    for (int n = 0; n <= N; n++) edges[n] = std::cbrt(double(n) * n / (double(N) * N));
    return edges;
  }();

  /* Scale the force of a cell to its limit. Returns its square. */
  static double limit_cell(double *f, double limit)
  {
    const double square = f[0] * f[0] + f[1] * f[1];
    const double factor = square > limit * limit ? limit / std::sqrt(square) : 1.0;
    for (int d = 0; d < 2; d++) f[d] *= factor;
    return factor * factor * square;
  }

  /* Same for the sum of the force and a fraction of the damping, by a change of the force. */
  static double limit_cell_sum(double *f, const double (&part)[2], double limit)
  {
    double both[2] = {f[0] + part[0], f[1] + part[1]};
    if (both[0] * both[0] + both[1] * both[1] > limit * limit) {
      limit_cell(both, limit);
      for (int d = 0; d < 2; d++) f[d] = both[d] - part[d];
    }
    return f[0] * f[0] + f[1] * f[1];
  }

  double *force(int m) const { return doubles_ + FORCES + 2 * m; }

  double edge(int m) const { return doubles_[REACH] * EDGES[m]; }

  /* Length of a cell within a circle. */
  double covered(int m, double circle) const { return std::max(std::min(edge(m + 1), circle) - edge(m), 0.0); }

  /* Fraction of the normal force within x, which is in units of the radius. */
  static double share(double x) { return x < 1.0 ? x * (1.5 - 0.5 * x * x) : 1.0; }

  /* Rotate the axis into the plane normal to n. */
  void turn(const double (&n)[3])
  {
    double *const axis = doubles_ + AXIS;
    double along = dot(axis, n), square = dot(axis, axis) - along * along;
    if (!(square > 0.25)) {    // new axis, or a rotation so large that the forces have lost their direction
      const int least = std::fabs(n[0]) < 0.6 ? 0 : 1;
      for (int d = 0; d < 3; d++) axis[d] = d == least;
      along = n[least];
      square = 1.0 - along * along;
    }
    for (int d = 0; d < 3; d++) axis[d] = (axis[d] - along * n[d]) / std::sqrt(square);
  }

  /* Adapt the cells to the circle. */
  void follow(double now, double unit)
  {
    double &reach = doubles_[REACH], &circle = doubles_[CIRCLE];
    if (reach == 0.0) {
      reach = unit * std::exp2(std::ceil(1.5 * std::log2(now / unit)) / 1.5);
      circle = now;
    }
    for (; now > reach; reach *= STEP)
      for (int m = 0; m < N; m++)
        for (int d = 0; d < 2; d++) force(m)[d] = 2 * m < N ? force(2 * m)[d] + force(2 * m + 1)[d] : 0.0;
    while (std::max(now, circle) < reach / (STEP * STEP)) {
      reach /= STEP;
      for (int m = N / 2 - 1; m >= 0; m--) {    // from the last one, because two cells replace each
        const double inner = covered(2 * m, circle), outer = covered(2 * m + 1, circle), both = inner + outer;
        for (int d = 0; d < 2; d++) {
          const double whole = force(m)[d];
          force(2 * m)[d] = both > 0.0 ? whole * inner / both : 0.0;
          force(2 * m + 1)[d] = both > 0.0 ? whole * outer / both : 0.0;
        }
      }
    }
  }

  double *doubles_;
};

using SlipHistory = SlipCells<16>;

}    // namespace granwave

#endif
