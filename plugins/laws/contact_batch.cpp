// SPDX-License-Identifier: GPL-2.0-only
#include "contact_batch.h"

#include "processors.h"

using namespace granwave;

FOR_EACH_PROCESSOR bool ContactBatch::compute_overlap()
{
  int errors = 0;
  for (int m = 0; m < size; m++) {
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
  for (int m = 0; m < size; m++) pair_force[m] = force[m] / r[m];
}

FOR_EACH_PROCESSOR void ContactBatch::compute_tangential(double dt)
{
  for (int m = 0; m < size; m++) {
    const double inverse = 1.0 / r[m], li = radius_i[m] - 0.5 * overlap[m], lj = radius_j[m] - 0.5 * overlap[m];
    double n[3], v[3], spin[3], slip[3];
    for (int d = 0; d < 3; d++) {
      n[d] = direction[d][m] * inverse;
      v[d] = velocity[d][m];
      spin[d] = li * omega_i[d][m] + lj * omega_j[d][m];
    }
    slip_of_step(v, spin, n, dt, slip);
    TangentialSpring spring{{tangential[0][m], tangential[1][m], tangential[2][m]}, compliance[m], loss[m]};
    granwave::compute_tangential(spring, n, slip, shear_stiffness[m] * std::sqrt(circle[m]), limit[m],
                                 keeps[m] > 0.0 ? TangentialModel::MINDLIN : TangentialModel::MINDLIN_RESCALE);
    for (int d = 0; d < 3; d++) tangential[d][m] = spring.force[d];
    compliance[m] = spring.compliance;
    loss[m] = spring.loss;
  }
}

FOR_EACH_PROCESSOR void ContactBatch::compute_forces_and_torques()
{
  for (int m = 0; m < size; m++) {
    pair_force[m] = force[m] / r[m];
    const double inverse = 1.0 / r[m];
    double n[3], f[3], torque[3];
    for (int d = 0; d < 3; d++) {
      n[d] = direction[d][m] * inverse;
      f[d] = tangential[d][m];
      force_i[d][m] = direction[d][m] * pair_force[m] + f[d];
    }
    torque_per_lever(n, f, torque);
    const double lever_i = radius_i[m] - 0.5 * overlap[m], lever_j = radius_j[m] - 0.5 * overlap[m];
    for (int d = 0; d < 3; d++) {
      torque_i[d][m] = lever_i * torque[d];
      torque_j[d][m] = lever_j * torque[d];
    }
  }
}

namespace {

/* Add forces to the sums of both spheres. Pairs of one row are consecutive: the sum of sphere i stays in registers. */
template <class Force>
__attribute__((always_inline)) inline void add(const ContactBatch &batch, TwofoldSums &sums, int owned, char *reached,
                                               int block, const Force &force)
{
  for (int m = 0; m < batch.size;) {
    const int i = batch.i[m];
    TwofoldSum sum = sums[i];
    reached[i / block] = 1;
    for (; m < batch.size && batch.i[m] == i; m++) {
      Components f;
      force(m, f);
      const int j = batch.j[m];
      sum.add(f);
      if (j >= owned) continue;
      sums[j].add(-f);
      reached[j / block] = 1;
    }
    sums[i] = sum;
  }
}

}    // namespace

FOR_EACH_PROCESSOR void ContactBatch::add_normal(TwofoldSums &sums, int owned, char *reached, int block) const
{
  add(*this, sums, owned, reached, block, [this](int m, Components &f) { f = del[m] * pair_force[m]; });
}

FOR_EACH_PROCESSOR void ContactBatch::add_forces(TwofoldSums &sums, int owned, char *reached, int block) const
{
  add(*this, sums, owned, reached, block,
      [this](int m, Components &f) { f = Components{force_i[0][m], force_i[1][m], force_i[2][m], 0.0}; });
}

FOR_EACH_PROCESSOR void ContactBatch::add_torques(TwofoldSums &sums, int owned) const
{
  for (int m = 0; m < size;) {
    const int of = i[m];
    TwofoldSum sum = sums[of];
    for (; m < size && i[m] == of; m++) {
      const Components on_i = {torque_i[0][m], torque_i[1][m], torque_i[2][m], 0.0};
      const Components on_j = {torque_j[0][m], torque_j[1][m], torque_j[2][m], 0.0};
      sum.add(on_i);
      if (j[m] < owned) sums[j[m]].add(on_j);
    }
    sums[of] = sum;
  }
}
