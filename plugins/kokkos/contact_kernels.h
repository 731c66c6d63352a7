// SPDX-License-Identifier: GPL-2.0-only
/* Kernels of pair style gran/hysteretic/kk: one timestep of all contacts in the memory of a card, or of a processor with threads. Normal
   forces of spheres with the laws hertz and elastoplastic. No LAMMPS types.

   There are two loops, and no thread writes where another one does. The first, over pairs, computes distance, history and force of each;
   the second, over spheres, sums the forces of each in the order of the plain style. Positions and histories are therefore the same to
   the last bit as those of the plain style, for any number of threads. The virial is summed in another order. */

#ifndef GRANWAVE_CONTACT_KERNELS_H
#define GRANWAVE_CONTACT_KERNELS_H

#include <Kokkos_Core.hpp>

#include "../laws/elastoplastic.h"
#include "../kernels/front.h"
#include "../kernels/periodic_images.h"

namespace granwave {

/* Law of the pairs of two types and radii, in physical units. */
struct PairLaw {
  double radsum, touch_squared, reach, largest_overlap;    // reach: distance beyond which the contact is forgotten
  double hertz, elastic_limit;                             // F = hertz overlap^1.5 up to the elastic limit
  double yield_overlap, yield_force;
  int curve;    // index of its elastoplastic curve; of law hertz any, since its elastic limit is infinite
};

/* Ghost of a pair across a periodic boundary. */
struct Crossing {
  std::int8_t images[3];
  bool ghost_is_second;
};

/* State of a timestep that is the same for all pairs. */
struct KernelStep {
  double now, dt;
  double edges[6];    // of the box (periodic_images.h)
};

/* Pairs within reach, and their histories. Pairs from `plain` on are those across a periodic boundary. */
template <class Device> struct ContactViews {
  template <class T> using Array = Kokkos::View<T *, Device>;
  static constexpr double APART = -1.0;      // in place of a force, of spheres that do not touch
  static constexpr double UNKNOWN = -1.0;    // in place of the peak of a turning point that has to be computed

  int pairs = 0, plain = 0;
  Array<int> first, second;    // spheres of each pair, local or ghost
  Array<int> law;              // of each pair, index into `laws`
  Array<PairLaw> laws;
  Array<Elastoplastic> curves;
  Array<Crossing> crossings;    // of pairs from `plain` on
  Array<int> begin,
      contact;    // contacts of owned sphere i: contact[begin[i]] to contact[begin[i + 1]]; k, or -1 - k of the second
  Array<double> peak;    // largest overlap
  Array<double> time_peak, time_yield;
  Array<Front> front;
  Array<Turning> turning;
  Array<double> force;    // of this timestep: normal force over distance, or APART

  /* Vector from the second to the first sphere of pair k, as far as it determines the force. Returns its length squared. */
  template <class Positions>
  KOKKOS_INLINE_FUNCTION double separation(const Positions &x, int k, const KernelStep &step, double (&del)[3]) const
  {
    const int i = first(k), j = second(k);
    if (k < plain) {
      for (int d = 0; d < 3; d++) del[d] = x(i, d) - x(j, d);
      return del[0] * del[0] + del[1] * del[1] + del[2] * del[2];
    }
    const double xi[3] = {x(i, 0), x(i, 1), x(i, 2)}, xj[3] = {x(j, 0), x(j, 1), x(j, 2)};
    const Crossing &crossing = crossings(k - plain);
    image_difference(xi, xj, image_shift(crossing.images, step.edges), crossing.ghost_is_second, true, true, del);
    // the plain style has a unit vector and a distance, here too so that results are rounded in the same way
    const double r = std::sqrt(del[0] * del[0] + del[1] * del[1] + del[2] * del[2]);
    for (int d = 0; d < 3; d++) del[d] = del[d] / r * r;
    return r * r;
  }

  /* Branch below the peak of a contact beyond its elastic limit. */
  KOKKOS_INLINE_FUNCTION Turning turning_point(const PairLaw &of, double largest) const
  {
    const double a = largest / of.yield_overlap;
    const Elastoplastic &curve = curves(of.curve);
    return a > 1.0 ? curve.turning(a, {}) : Turning{a, curve.loading(a, {}), 0.0, 1.5};
  }

  /* Advance the history of pair k, whose spheres touch, and return its normal force. */
  KOKKOS_INLINE_FUNCTION double advance(int k, double overlap, const KernelStep &step) const
  {
    const PairLaw &of = laws(law(k));
    const double before = peak(k);
    const bool raised = overlap > before;
    const bool yielded = overlap > of.elastic_limit || before > of.elastic_limit;
    if (raised) {
      if (Front::crosses(before, overlap)) front(k).rise(before, overlap, step.now, step.dt);
      if (before <= of.elastic_limit && yielded && time_yield(k) < 0.0) time_yield(k) = step.now;
      peak(k) = overlap;
      time_peak(k) = step.now;
    }
    if (!yielded) return of.hertz * overlap * std::sqrt(overlap);
    const double a = overlap / of.yield_overlap;
    Turning &branch = turning(k);
    if (raised) {
      branch.peak = UNKNOWN;
      return of.yield_force * curves(of.curve).loading_beyond_yield(a);
    }
    if (branch.peak < 0.0) branch = turning_point(of, before);
    return of.yield_force * branch.unloading(a);
  }
};

/* Findings of the loop over pairs, to be summed. */
struct PairFindings {
  int far = 0;      // contacts beyond the gap of the pair style
  int wrong = 0;    // overlaps that are too large, or not a number
  double virial[6] = {};

  KOKKOS_INLINE_FUNCTION PairFindings() {}
  KOKKOS_INLINE_FUNCTION void operator+=(const PairFindings &other)
  {
    far += other.far;
    wrong += other.wrong;
    for (int n = 0; n < 6; n++) virial[n] += other.virial[n];
  }
};

/* Loop over pairs. */
template <class Device, class Positions> struct AdvancePairs {
  ContactViews<Device> contacts;
  Positions x;
  KernelStep step;
  int owned;    // number of owned spheres; pairs with others count half in the virial

  KOKKOS_INLINE_FUNCTION void operator()(int k, PairFindings &found) const
  {
    const PairLaw &law = contacts.laws(contacts.law(k));
    double del[3];
    const double square = contacts.separation(x, k, step, del);
    double &force = contacts.force(k);
    force = contacts.APART;
    if (square >= law.touch_squared) {    // false for NaN
      if (contacts.peak(k) > 0.0 && is_far(k, square, law.reach)) found.far++;
      return;
    }
    const double r = std::sqrt(square), overlap = law.radsum - r;
    if (!(overlap <= law.largest_overlap)) {
      found.wrong++;
      return;
    }
    force = contacts.advance(k, overlap, step) / r;
    const double share = contacts.first(k) < owned && contacts.second(k) < owned ? 1.0 : 0.5;
    const int along[6] = {0, 1, 2, 0, 0, 1}, of[6] = {0, 1, 2, 1, 2, 2};
    for (int n = 0; n < 6; n++) found.virial[n] += share * del[along[n]] * (del[of[n]] * force);
  }

 private:
  KOKKOS_INLINE_FUNCTION bool is_far(int k, double square, double reach) const
  {
    return k < contacts.plain ? square > reach * reach : std::sqrt(square) > reach;
  }
};

/* Loop over owned spheres. */
template <class Device, class Positions, class Forces> struct SumForces {
  ContactViews<Device> contacts;
  Positions x;
  Forces f;
  KernelStep step;

  KOKKOS_INLINE_FUNCTION void operator()(int i) const
  {
    double sum[3] = {f(i, 0), f(i, 1), f(i, 2)};
    for (int s = contacts.begin(i); s < contacts.begin(i + 1); s++) {
      const bool is_first = contacts.contact(s) >= 0;
      const int k = is_first ? contacts.contact(s) : -1 - contacts.contact(s);
      const double force = contacts.force(k);
      if (force < 0.0) continue;
      double del[3];
      contacts.separation(x, k, step, del);
      for (int d = 0; d < 3; d++) sum[d] += is_first ? del[d] * force : -(del[d] * force);
    }
    for (int d = 0; d < 3; d++) f(i, d) = sum[d];
  }
};

}    // namespace granwave

#endif
