// SPDX-License-Identifier: GPL-2.0-only
#include "contact_batch.h"

#include "processors.h"
#include "resting_blocks.h"

using namespace granwave;

FOR_EACH_PROCESSOR bool ContactBatch::compute_overlap()
{
  int errors = 0;
  for (int first = 0; first < size; first += GROUP)
    for (int m = first; m < first + GROUP; m++) {
      r[m] = std::sqrt(rsq[m]);
      overlap[m] = radsum[m] - r[m];
      force[m] = hertz[m] * overlap[m] * std::sqrt(overlap[m]);
      circle[m] = effective_radius[m] * overlap[m];
      errors += overlap[m] <= largest_overlap[m] ? 0 : 1;
    }
  return errors > 0;
}

FOR_EACH_PROCESSOR void ContactBatch::compute_normal()
{
  for (int first = 0; first < size; first += GROUP)
    for (int m = first; m < first + GROUP; m++) pair_force[m] = force[m] / r[m];
}

void ContactBatch::prefetch(const double *v, const double *omega, const SpringForce *spring, const double *loss) const
{
  for (int m = 0; m < size; m++) {
    __builtin_prefetch(spring + k[m]);
    __builtin_prefetch(loss + k[m]);
    __builtin_prefetch(v + 3 * j[m]);
    __builtin_prefetch(omega + 3 * j[m]);
  }
}

FOR_EACH_PROCESSOR bool ContactBatch::compute_limit()
{
  int without = 0;
  for (int first = 0; first < size; first += GROUP)
    for (int m = first; m < first + GROUP; m++) {
      lever_i[m] = radius_i[m] - 0.5 * overlap[m];
      lever_j[m] = radius_j[m] - 0.5 * overlap[m];
      const double product = friction[m] * force[m];
      limit[m] = product < 0.0 ? 0.0 : product;
      circle[m] = limit[m] == 0.0 ? 1.0 : circle[m];    // any value, for a pair without friction
      without += limit[m] == 0.0 ? 1 : 0;
    }
  return without > 0;
}

FOR_EACH_PROCESSOR void ContactBatch::gather(const double *v, const double *omega, int last, const double *last_v,
                                             const double *last_omega, const SpringForce *spring)
{
  for (int first = 0; first < size; first += 4) {
    Components by_pair[4], by_axis[4], of_i, of_j;
    const auto put = [&](double (&to)[3][CAPACITY]) {
      transpose(by_pair, by_axis);
      for (int d = 0; d < 3; d++) write(to[d] + first, by_axis[d]);
    };
    for (int q = 0; q < 4; q++) by_pair[q] = del[first + q];
    put(direction);
    for (int q = 0; q < 4; q++) {
      const int a = i[first + q], b = j[first + q];
      read(of_i, a == last ? last_v : v + 3 * a);
      read(of_j, b == last ? last_v : v + 3 * b);
      by_pair[q] = of_i - of_j;
    }
    put(velocity);
    for (int q = 0; q < 4; q++) {
      const int a = i[first + q], b = j[first + q];
      read(of_i, a == last ? last_omega : omega + 3 * a);
      read(of_j, b == last ? last_omega : omega + 3 * b);
      by_pair[q] = lever_i[first + q] * of_i + lever_j[first + q] * of_j;
    }
    put(spin);
    for (int q = 0; q < 4; q++) std::memcpy(by_pair + q, spring + k[first + q], sizeof(SpringForce));
    put(tangential);
    write(compliance + first, by_axis[3]);
  }
}

FOR_EACH_PROCESSOR void ContactBatch::compute_tangential(double dt)
{
  for (int first = 0; first < size; first += GROUP)
    for (int m = first; m < first + GROUP; m++) {
      const double inverse = 1.0 / r[m];
      double n[3], v[3], rolling[3], slip[3];
      for (int d = 0; d < 3; d++) {
        n[d] = direction[d][m] * inverse;
        v[d] = velocity[d][m];
        rolling[d] = spin[d][m];
      }
      slip_of_step(v, rolling, n, dt, slip);
      TangentialSpring spring{{tangential[0][m], tangential[1][m], tangential[2][m]}, compliance[m], 0.0};
      granwave::compute_tangential(spring, n, slip, shear_stiffness[m] * std::sqrt(circle[m]), limit[m],
                                   keeps[m] > 0.0 ? TangentialModel::MINDLIN : TangentialModel::MINDLIN_RESCALE);
      for (int d = 0; d < 3; d++) tangential[d][m] = spring.force[d];
      compliance[m] = spring.compliance;
      lost[m] = spring.loss;
    }
}

FOR_EACH_PROCESSOR void ContactBatch::scatter(SpringForce *spring) const
{
  for (int first = 0; first < size; first += 4) {
    Components by_axis[4], by_pair[4];
    for (int d = 0; d < 3; d++) read(by_axis[d], tangential[d] + first);
    read(by_axis[3], compliance + first);
    transpose(by_axis, by_pair);
    for (int q = 0; q < std::min(4, size - first); q++)
      std::memcpy(static_cast<void *>(spring + k[first + q]), by_pair + q, sizeof(SpringForce));
  }
}

FOR_EACH_PROCESSOR void ContactBatch::compute_forces_and_torques()
{
  for (int first = 0; first < size; first += GROUP)
    for (int m = first; m < first + GROUP; m++) {
      pair_force[m] = force[m] / r[m];
      const double inverse = 1.0 / r[m];
      double n[3], f[3], per_lever[3];
      for (int d = 0; d < 3; d++) {
        n[d] = direction[d][m] * inverse;
        f[d] = tangential[d][m];
        force_i[d][m] = direction[d][m] * pair_force[m] + f[d];
      }
      torque_per_lever(n, f, per_lever);
      for (int d = 0; d < 3; d++) torque[d][m] = per_lever[d];
    }
  for (int first = 0; first < size; first += 4) {
    Components by_axis[4] = {}, force_of[4], torque_of[4];
    for (int d = 0; d < 3; d++) read(by_axis[d], force_i[d] + first);
    transpose(by_axis, force_of);
    for (int d = 0; d < 3; d++) read(by_axis[d], torque[d] + first);
    transpose(by_axis, torque_of);
    for (int q = 0; q < 4; q++) {
      const int m = first + q;
      double *const on_i = reinterpret_cast<double *>(load_i + m), *const on_j = reinterpret_cast<double *>(load_j + m);
      write(on_i, force_of[q]);
      write(on_i + 4, lever_i[m] * torque_of[q]);
      write(on_j, -force_of[q]);
      write(on_j + 4, lever_j[m] * torque_of[q]);
    }
  }
}

namespace {

/* Add what the function `terms` gives for each pair to the sums of its spheres. Pairs of one row are consecutive: the sum of
   sphere i stays in registers. Their number is unpredictable in a rattling packing: the sum is selected without branches. */
template <class Vector, class Terms>
__attribute__((always_inline)) inline void add_pairs(const ContactBatch &batch, typename TwofoldSums<Vector>::Window sums,
                                                     int owned, char *reached, const Terms &terms)
{
  using Sum = TwofoldSum<Vector>;
  Sum sum;
  Vector on_i, on_j;
  int before = -1;
  for (int m = 0, n = batch.size; m < n; m++) {
    const int i = batch.i[m], j = batch.j[m];
    Sum &stored = sums[i];
    sum.replace(typename Sum::Mask{} - static_cast<long long>(i != before), stored);
    before = i;
    terms(m, on_i, on_j);
    sum.add(on_i);
    stored = sum;
    reached[RestingBlocks::of(i)] = 1;
    if (j >= owned) continue;
    sums[j].add(on_j);
    reached[RestingBlocks::of(j)] = 1;
  }
}

}    // namespace

FOR_EACH_PROCESSOR void ContactBatch::add_normal(TwofoldSums<Components>::Window sums, int owned, char *reached) const
{
  add_pairs<Components>(*this, sums, owned, reached, [this](int m, Components &on_i, Components &on_j) {
    on_i = del[m] * pair_force[m];
    on_j = -on_i;
  });
}

FOR_EACH_PROCESSOR void ContactBatch::add_forces_and_torques(TwofoldSums<TwoComponents>::Window sums, int owned,
                                                             char *reached) const
{
  add_pairs<TwoComponents>(*this, sums, owned, reached, [this](int m, TwoComponents &on_i, TwoComponents &on_j) {
    on_i = load_i[m];
    on_j = load_j[m];
  });
}
