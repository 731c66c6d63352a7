// SPDX-License-Identifier: GPL-2.0-only
#include "contact_batch.h"

using namespace granwave;

// Compiled for several instruction sets; the best available one is selected at run time. Results are bitwise identical.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__gnu_linux__)
#define FOR_EACH_PROCESSOR __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define FOR_EACH_PROCESSOR
#endif

FOR_EACH_PROCESSOR void ContactBatch::compute_overlap()
{
  for (int m = 0; m < size; m++) {
    r[m] = std::sqrt(rsq[m]);
    overlap[m] = radsum[m] - r[m];
    force[m] = hertz[m] * overlap[m] * std::sqrt(overlap[m]);
    circle[m] = effective_radius[m] * overlap[m];
  }
}

FOR_EACH_PROCESSOR void ContactBatch::compute_normal()
{
  for (int m = 0; m < size; m++) {
    const double pair_force = force[m] / r[m];
    for (int d = 0; d < 3; d++) {
      force_i[d][m] = del[d][m] * pair_force;
      force_j[d][m] = -force_i[d][m];
    }
  }
}

FOR_EACH_PROCESSOR void ContactBatch::compute_tangential(double dt)
{
  for (int m = 0; m < size; m++) {
    const double inverse = 1.0 / r[m], li = radius_i[m] - 0.5 * overlap[m], lj = radius_j[m] - 0.5 * overlap[m];
    double n[3], v[3], spin[3], slip[3];
    for (int d = 0; d < 3; d++) {
      n[d] = del[d][m] * inverse;
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
    const double pair_force = force[m] / r[m], inverse = 1.0 / r[m];
    double n[3], f[3], torque[3];
    for (int d = 0; d < 3; d++) {
      n[d] = del[d][m] * inverse;
      f[d] = tangential[d][m];
      force_i[d][m] = del[d][m] * pair_force + f[d];
      force_j[d][m] = -force_i[d][m];
    }
    torque_per_lever(n, f, torque);
    const double lever_i = radius_i[m] - 0.5 * overlap[m], lever_j = radius_j[m] - 0.5 * overlap[m];
    for (int d = 0; d < 3; d++) {
      torque_i[d][m] = lever_i * torque[d];
      torque_j[d][m] = lever_j * torque[d];
    }
  }
}
