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
    double n[3], f[3], per_lever[3];
    for (int d = 0; d < 3; d++) {
      n[d] = direction[d][m] * inverse;
      f[d] = tangential[d][m];
      force_i[d][m] = direction[d][m] * pair_force[m] + f[d];
    }
    torque_per_lever(n, f, per_lever);
    for (int d = 0; d < 3; d++) torque[d][m] = per_lever[d];
    lever_i[m] = radius_i[m] - 0.5 * overlap[m];
    lever_j[m] = radius_j[m] - 0.5 * overlap[m];
  }
}

// Pairs of one row are consecutive: the sums of sphere i stay in registers.

FOR_EACH_PROCESSOR void ContactBatch::add_normal(TwofoldSums &sums, int owned, char *reached, int bits) const
{
  for (int m = 0; m < size;) {
    const int of = i[m];
    TwofoldSum sum = sums[of];
    reached[of >> bits] = 1;
    for (; m < size && i[m] == of; m++) {
      const Components f = del[m] * pair_force[m];
      sum.add(f);
      if (j[m] >= owned) continue;
      sums[j[m]].add(-f);
      reached[j[m] >> bits] = 1;
    }
    sums[of] = sum;
  }
}

FOR_EACH_PROCESSOR void ContactBatch::add_forces_and_torques(TwofoldSums &forces, TwofoldSums &torques, int owned,
                                                             char *reached, int bits) const
{
  for (int m = 0; m < size;) {
    const int of = i[m];
    TwofoldSum sum = forces[of], turning = torques[of];
    reached[of >> bits] = 1;
    for (; m < size && i[m] == of; m++) {
      const Components f = {force_i[0][m], force_i[1][m], force_i[2][m], 0.0};
      const Components t = {torque[0][m], torque[1][m], torque[2][m], 0.0};
      sum.add(f);
      turning.add(lever_i[m] * t);
      if (j[m] >= owned) continue;
      forces[j[m]].add(-f);
      torques[j[m]].add(lever_j[m] * t);
      reached[j[m] >> bits] = 1;
    }
    forces[of] = sum;
    torques[of] = turning;
  }
}
