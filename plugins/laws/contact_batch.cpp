// SPDX-License-Identifier: GPL-2.0-only
#include "contact_batch.h"

#include "processors.h"

#include <cstring>

using namespace granwave;

namespace {

typedef double Two __attribute__((vector_size(2 * sizeof(double))));

/* Add a vector, whose first two components are added at once. */
inline void add(double (&to)[3], const Two &xy, double z)
{
  Two sum;
  std::memcpy(&sum, to, sizeof(sum));
  sum += xy;
  std::memcpy(to, &sum, sizeof(sum));
  to[2] += z;
}

}    // namespace

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

template <bool ADVANCES> __attribute__((always_inline)) inline void ContactBatch::compute_friction(double dt)
{
  for (int m = 0; m < size; m++) {
    const double inverse = 1.0 / r[m], li = radius_i[m] - 0.5 * overlap[m], lj = radius_j[m] - 0.5 * overlap[m];
    double n[3], f[3], per_lever[3];
    for (int d = 0; d < 3; d++) {
      n[d] = del[d][m] * inverse;
      f[d] = tangential[d][m];
    }
    if (ADVANCES) {
      double v[3], spin[3], slip[3];
      for (int d = 0; d < 3; d++) {
        v[d] = velocity[d][m];
        spin[d] = li * omega_i[d][m] + lj * omega_j[d][m];
      }
      slip_of_step(v, spin, n, dt, slip);
      TangentialSpring spring{{f[0], f[1], f[2]}, compliance[m], loss[m]};
      granwave::compute_tangential(spring, n, slip, shear_stiffness[m] * std::sqrt(circle[m]), limit[m],
                                   keeps[m] > 0.0 ? TangentialModel::MINDLIN : TangentialModel::MINDLIN_RESCALE);
      for (int d = 0; d < 3; d++) tangential[d][m] = f[d] = spring.force[d];
      compliance[m] = spring.compliance;
      loss[m] = spring.loss;
    }
    torque_per_lever(n, f, per_lever);
    pair_force[m] = force[m] / r[m];
    for (int d = 0; d < 3; d++) {
      force_i[d][m] = del[d][m] * pair_force[m] + f[d];
      torque[d][m] = per_lever[d];
    }
    lever_i[m] = li;
    lever_j[m] = lj;
  }
}

FOR_EACH_PROCESSOR void ContactBatch::compute_forces_and_torques() { compute_friction<false>(0.0); }
FOR_EACH_PROCESSOR void ContactBatch::advance_forces_and_torques(double dt) { compute_friction<true>(dt); }

void ContactBatch::add_normal(double (*forces)[3], int owned) const
{
  for (int m = 0; m < size; m++) {
    const Two f = Two{del[0][m], del[1][m]} * pair_force[m];
    const double fz = del[2][m] * pair_force[m];
    if (i[m] < owned) add(forces[i[m]], f, fz);
    if (j[m] < owned) add(forces[j[m]], -f, -fz);
  }
}

void ContactBatch::add_forces_and_torques(double (*forces)[3], double (*torques)[3], int owned) const
{
  for (int m = 0; m < size; m++) {
    const Two f = {force_i[0][m], force_i[1][m]}, t = {torque[0][m], torque[1][m]};
    if (i[m] < owned) {
      add(forces[i[m]], f, force_i[2][m]);
      add(torques[i[m]], lever_i[m] * t, lever_i[m] * torque[2][m]);
    }
    if (j[m] < owned) {
      add(forces[j[m]], -f, -force_i[2][m]);
      add(torques[j[m]], lever_j[m] * t, lever_j[m] * torque[2][m]);
    }
  }
}
