#include "touching.h"

using namespace granwave;

// Built for several processors, of which the one at hand takes its own at run time. The results have the same bits.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__gnu_linux__)
#define FOR_EACH_PROCESSOR __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define FOR_EACH_PROCESSOR
#endif

FOR_EACH_PROCESSOR void Touching::measure()
{
  for (int m = 0; m < size; m++) {
    distance[m] = std::sqrt(square[m]);
    overlap[m] = sum_radii[m] - distance[m];
    force[m] = hertz[m] * overlap[m] * std::sqrt(overlap[m]);
    circle[m] = effective_radius[m] * overlap[m];
  }
}

FOR_EACH_PROCESSOR void Touching::push()
{
  for (int m = 0; m < size; m++) {
    const double pair_force = force[m] / distance[m];
    for (int d = 0; d < 3; d++) {
      push_i[d][m] = apart[d][m] * pair_force;
      push_j[d][m] = -push_i[d][m];
    }
  }
}

FOR_EACH_PROCESSOR void Touching::slide(double dt)
{
  for (int m = 0; m < size; m++) {
    const double inverse = 1.0 / distance[m], li = radius_i[m] - 0.5 * overlap[m], lj = radius_j[m] - 0.5 * overlap[m];
    double n[3], v[3], spin[3], slip[3];
    for (int d = 0; d < 3; d++) {
      n[d] = apart[d][m] * inverse;
      v[d] = velocity[d][m];
      spin[d] = li * omega_i[d][m] + lj * omega_j[d][m];
    }
    slip_of_step(v, spin, n, dt, slip);
    Spring spring{{held[0][m], held[1][m], held[2][m]}, compliance[m], loss[m]};
    advance(spring, n, slip, shear_stiffness[m] * std::sqrt(circle[m]), limit[m],
            keeps[m] > 0.0 ? Grip::KEPT : Grip::RESCALED);
    for (int d = 0; d < 3; d++) held[d][m] = spring.force[d];
    compliance[m] = spring.compliance;
    loss[m] = spring.loss;
  }
}

FOR_EACH_PROCESSOR void Touching::push_and_twist()
{
  for (int m = 0; m < size; m++) {
    const double pair_force = force[m] / distance[m], inverse = 1.0 / distance[m];
    double n[3], f[3], torque[3];
    for (int d = 0; d < 3; d++) {
      n[d] = apart[d][m] * inverse;
      f[d] = held[d][m];
      push_i[d][m] = apart[d][m] * pair_force + f[d];
      push_j[d][m] = -push_i[d][m];
    }
    torque_per_lever(n, f, torque);
    const double lever_i = radius_i[m] - 0.5 * overlap[m], lever_j = radius_j[m] - 0.5 * overlap[m];
    for (int d = 0; d < 3; d++) {
      twist_i[d][m] = lever_i * torque[d];
      twist_j[d][m] = lever_j * torque[d];
    }
  }
}
