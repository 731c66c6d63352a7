// SPDX-License-Identifier: GPL-2.0-only
/* Kernels of pair style gran/hysteretic/kk: one timestep of all contacts in the memory of a card, or of a processor with threads. Normal
   forces of spheres with the laws hertz and elastoplastic, and friction (tangential.h). No LAMMPS types.

   There are two loops, and no thread writes where another one does. The first, over pairs, computes distance, history and force of each;
   the second, over spheres, sums the forces and torques of each in the order of the plain style. Positions and histories are therefore the
   same to the last bit as those of the plain style, for any number of threads. The virial is summed in another order. */

#ifndef GRANWAVE_CONTACT_KERNELS_H
#define GRANWAVE_CONTACT_KERNELS_H

#include <Kokkos_Core.hpp>

#include "../kernels/front.h"
#include "../kernels/periodic_images.h"
#include "../laws/elastoplastic.h"
#include "../laws/tangential.h"

namespace granwave {

/* Law of the pairs of two types and radii, in physical units. */
struct PairLaw {
  double radsum, touch_squared, reach, largest_overlap;    // reach: distance beyond which the contact is forgotten
  double hertz, elastic_limit;                             // F = hertz overlap^1.5 up to the elastic limit
  double yield_overlap, yield_force;
  int curve;    // index of its elastoplastic curve; arbitrary for law hertz, whose elastic limit is infinite
};

/* Friction of the pairs of two types and radii. */
struct PairFriction {
  double radius_first, radius_second, effective_radius, root_radius;    // root_radius: square root of the effective radius
  double coefficient;
  double shear_stiffness;    // stiffness of a spring / radius of the contact circle
  TangentialModel model;
};

/* Force of a pair with friction. */
struct SurfaceForce {
  double on_first[3];                  // on the first sphere, normal and tangential
  double torque[3];                    // on either sphere, per unit of its lever arm
  double lever_first, lever_second;    // lever arms
};

/* Normal force of a pair whose spheres touch. */
struct NormalForce {
  double force, circle;    // circle: radius of the contact circle, with friction
};

/* Geometry of a pair whose spheres touch: vector from the second to the first sphere, distance, overlap. */
struct TouchingPair {
  double del[3], distance, overlap;
};

/* Ghost of a pair across a periodic boundary. */
struct Crossing {
  std::int8_t images[3];
  bool ghost_is_second;
};

/* State of a timestep that is the same for all pairs. */
struct KernelStep {
  double now, dt;
  double edges[6];         // of the box (periodic_images.h)
  bool advances = true;    // false where springs keep their forces (Step in contact_memory.h)
};

/* Pairs within reach, and their histories. Pairs from `plain` on cross a periodic boundary. */
template <class Device> struct ContactViews {
  template <class T> using Array = Kokkos::View<T *, Device>;
  static constexpr double APART = -1.0;      // in place of a force, of spheres that do not touch
  static constexpr double UNKNOWN = -1.0;    // in place of the peak of a turning point that has to be computed

  int pairs = 0, plain = 0;
  bool friction = false;       // true if the arrays of friction are in use
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
  Array<double> force;    // of this timestep: normal force over distance, with friction the normal force; or APART
  // friction
  Array<PairFriction> frictions;    // of `laws`
  Array<TangentialSpring> spring;
  Array<double> peak_area;        // normalized area of the contact circle at the turning point
  Array<SurfaceForce> surface;    // of this timestep

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
    // a unit vector and a distance, as in the plain style, so that results are rounded in the same way
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

  /* Radius of the contact circle of pair k beyond its elastic limit, from its normalized area; with friction. */
  KOKKOS_INLINE_FUNCTION double circle(int k, double area) const
  {
    return std::sqrt(frictions(law(k)).effective_radius * laws(law(k)).yield_overlap * area);
  }

  /* Advance the history of pair k, whose spheres touch, and return its normal force. */
  KOKKOS_INLINE_FUNCTION NormalForce advance(int k, double overlap, const KernelStep &step) const
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
    if (!yielded) {
      const double root = std::sqrt(overlap);
      return {of.hertz * overlap * root, friction ? frictions(law(k)).root_radius * root : 0.0};
    }
    const double a = overlap / of.yield_overlap;
    const Elastoplastic &curve = curves(of.curve);
    Turning &branch = turning(k);
    if (raised) {
      branch.peak = UNKNOWN;
      return {of.yield_force * curve.loading_beyond_yield(a), friction ? circle(k, curve.area_beyond_yield(a)) : 0.0};
    }
    if (branch.peak < 0.0) {
      branch = turning_point(of, before);
      if (friction) peak_area(k) = curve.area(branch.peak, {});
    }
    return {of.yield_force * branch.unloading(a), friction ? circle(k, branch.area(a, peak_area(k))) : 0.0};
  }

  /* End the spring of pair k, whose surfaces have parted or are not held by friction. */
  KOKKOS_INLINE_FUNCTION void release_spring(int k) const
  {
    TangentialSpring released = spring(k);
    release(released);
    spring(k) = released;
  }

  /* Advance the spring of pair k, and compute the force and torque on its spheres.

     v, omega    velocities and angular velocities of all spheres */
  template <class Motion>
  KOKKOS_INLINE_FUNCTION void slide(int k, const TouchingPair &pair, const NormalForce &normal, const Motion &v,
                                    const Motion &omega, const KernelStep &step) const
  {
    const PairFriction &of = frictions(law(k));
    const int i = first(k), j = second(k);
    const double limit = larger(of.coefficient * normal.force, 0.0), inverse = 1.0 / pair.distance;
    const bool holds = limit > 0.0;
    if (!holds) release_spring(k);
    SurfaceForce &result = surface(k);
    result.lever_first = of.radius_first - 0.5 * pair.overlap;
    result.lever_second = of.radius_second - 0.5 * pair.overlap;
    double n[3], velocity[3], spin[3], slip[3];
    for (int d = 0; d < 3; d++) {
      n[d] = pair.del[d] * inverse;
      velocity[d] = v(i, d) - v(j, d);
      spin[d] = result.lever_first * omega(i, d) + result.lever_second * omega(j, d);
    }
    TangentialSpring present = spring(k);
    if (step.advances) {
      slip_of_step(velocity, spin, n, step.dt, slip);
      const double stiffness = of.shear_stiffness * (holds ? normal.circle : 1.0);    // any value without a limit
      compute_tangential(present, n, slip, stiffness, limit, of.model);
      if (holds) spring(k) = present;
    }
    torque_per_lever(n, present.force, result.torque);
    for (int d = 0; d < 3; d++) result.on_first[d] = n[d] * normal.force + present.force[d];
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
  Positions x, v, omega;    // velocities with friction only
  KernelStep step;
  int owned;    // number of owned spheres; pairs with others count half in the virial

  KOKKOS_INLINE_FUNCTION void operator()(int k, PairFindings &found) const
  {
    const PairLaw &law = contacts.laws(contacts.law(k));
    TouchingPair pair;
    const double square = contacts.separation(x, k, step, pair.del);
    double &force = contacts.force(k);
    force = contacts.APART;
    if (square >= law.touch_squared) {    // false for NaN
      if (contacts.friction && contacts.spring(k).compliance > 0.0) contacts.release_spring(k);
      if (contacts.peak(k) > 0.0 && is_far(k, square, law.reach)) found.far++;
      return;
    }
    pair.distance = std::sqrt(square);
    pair.overlap = law.radsum - pair.distance;
    if (!(pair.overlap <= law.largest_overlap)) {
      found.wrong++;
      return;
    }
    const NormalForce normal = contacts.advance(k, pair.overlap, step);
    double on_first[3];
    if (contacts.friction) {
      force = normal.force;
      contacts.slide(k, pair, normal, v, omega, step);
      for (int d = 0; d < 3; d++) on_first[d] = contacts.surface(k).on_first[d];
    } else {
      force = normal.force / pair.distance;
      for (int d = 0; d < 3; d++) on_first[d] = pair.del[d] * force;
    }
    const double share = contacts.first(k) < owned && contacts.second(k) < owned ? 1.0 : 0.5;
    const int along[6] = {0, 1, 2, 0, 0, 1}, of[6] = {0, 1, 2, 1, 2, 2};
    for (int n = 0; n < 6; n++) found.virial[n] += share * pair.del[along[n]] * on_first[of[n]];
  }

 private:
  KOKKOS_INLINE_FUNCTION bool is_far(int k, double square, double reach) const
  {
    return k < contacts.plain ? square > reach * reach : std::sqrt(square) > reach;
  }
};

/* Loop over owned spheres, without friction. */
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

/* Loop over owned spheres, with friction. */
template <class Device, class Forces> struct SumForcesAndTorques {
  ContactViews<Device> contacts;
  Forces f, torque;

  KOKKOS_INLINE_FUNCTION void operator()(int i) const
  {
    double sum[3] = {f(i, 0), f(i, 1), f(i, 2)}, turning[3] = {torque(i, 0), torque(i, 1), torque(i, 2)};
    for (int s = contacts.begin(i); s < contacts.begin(i + 1); s++) {
      const bool is_first = contacts.contact(s) >= 0;
      const int k = is_first ? contacts.contact(s) : -1 - contacts.contact(s);
      if (contacts.force(k) < 0.0) continue;
      const SurfaceForce &of = contacts.surface(k);
      const double lever = is_first ? of.lever_first : of.lever_second;
      for (int d = 0; d < 3; d++) {
        sum[d] += is_first ? of.on_first[d] : -of.on_first[d];
        turning[d] += lever * of.torque[d];
      }
    }
    for (int d = 0; d < 3; d++) {
      f(i, d) = sum[d];
      torque(i, d) = turning[d];
    }
  }
};

}    // namespace granwave

#endif
