// The columns with the laws of the plain pair style, with friction if there is an argument; no header of Kokkos is included.
#include "columns.h"

#include "kernels/front.h"

#ifdef KOKKOS_INLINE_FUNCTION
#error "this program is to be compiled without Kokkos"
#endif

struct Contact {
  double peak = 0.0, time_peak = -1.0, time_yield = -1.0;
  Front front;
  TangentialSpring spring;

  /* Advance by a timestep in which the spheres touch, and return the force. */
  double advance(const ScaledLaw &law, double overlap, double now)
  {
    const double before = peak;
    if (overlap > before) {
      if (Front::crosses(before, overlap)) front.rise(before, overlap, now, DT);
      if (!law.yielded(before) && law.yielded(overlap) && time_yield < 0.0) time_yield = now;
      peak = overlap;
      time_peak = now;
    }
    return law.force(overlap, {peak, nullptr});
  }

  /* Radius of the contact circle. */
  double circle(const ScaledLaw &law, double overlap) const
  {
    if (!law.yielded(peak)) return std::sqrt(law.effective_radius()) * std::sqrt(overlap);
    if (overlap >= peak) return std::sqrt(law.loading_circle(overlap, nullptr));
    const Turning turning = law.turning({peak, nullptr});
    return std::sqrt(law.unloading_circle(overlap, turning, law.area(turning.peak, nullptr)));
  }
};

/* Forces and torques of all spheres at a step. */
struct Sums {
  std::vector<double> f, torque;
};

/* Add force and torque of a contact of spheres i and i + 1, with friction.

   del    from sphere i + 1 to sphere i */
void add_sliding(Contact &contact, int i, const double (&del)[3], double r, double overlap, double force, int step, Sums &to)
{
  static std::vector<double> v, omega;
  static int at = -1;
  if (at != step) {
    v = velocities(step, SPEED);
    omega = velocities(step, SPIN);
    at = step;
  }
  const ScaledLaw law = contact_of(i);
  const double limit = std::max(coefficient(i) * force, 0.0), inverse = 1.0 / r;
  const double lever[2] = {radius(i) - 0.5 * overlap, radius(i + 1) - 0.5 * overlap};
  double n[3], velocity[3], spin[3], slip[3], torque[3];
  for (int d = 0; d < 3; d++) {
    n[d] = del[d] * inverse;
    velocity[d] = v[3 * i + d] - v[3 * i + 3 + d];
    spin[d] = lever[0] * omega[3 * i + d] + lever[1] * omega[3 * i + 3 + d];
  }
  if (!(limit > 0.0)) release(contact.spring);
  TangentialSpring present = contact.spring;
  slip_of_step(velocity, spin, n, DT, slip);
  const double stiffness = law.law().tangential_stiffness(1.0) * (limit > 0.0 ? contact.circle(law, overlap) : 1.0);
  compute_tangential(present, n, slip, stiffness, limit, model(i));
  if (limit > 0.0) contact.spring = present;
  torque_per_lever(n, present.force, torque);
  for (int d = 0; d < 3; d++) {
    const double on_first = n[d] * force + present.force[d];
    to.f[3 * i + d] += on_first;
    to.f[3 * i + 3 + d] -= on_first;
    to.torque[3 * i + d] += lever[0] * torque[d];
    to.torque[3 * i + 3 + d] += lever[1] * torque[d];
  }
}

int main(int narg, char **)
{
  const bool friction = narg > 1;
  std::vector<Contact> contacts(SPHERES);
  for (int step = 0; step < STEPS; step++) {
    const std::vector<double> x = positions(step);
    Sums sums{std::vector<double>(x.size(), 0.0), std::vector<double>(x.size(), 0.0)};
    std::vector<double> &f = sums.f;
    for (int i = 0; i < SPHERES; i++) {
      if (!has_next(i)) continue;
      const ScaledLaw law = contact_of(i);
      const double *const xi = x.data() + 3 * static_cast<std::ptrdiff_t>(i), *const xj = xi + 3;
      const double radsum = radius(i) + radius(i + 1), del[3] = {xi[0] - xj[0], xi[1] - xj[1], xi[2] - xj[2]};
      const double square = del[0] * del[0] + del[1] * del[1] + del[2] * del[2];
      if (square >= TouchingPairs::touch_squared(radsum)) {
        if (contacts[i].spring.compliance > 0.0) release(contacts[i].spring);
        continue;
      }
      const double r = std::sqrt(square), normal = contacts[i].advance(law, radsum - r, step * DT), force = normal / r;
      if (friction) {
        add_sliding(contacts[i], i, del, r, radsum - r, normal, step, sums);
        continue;
      }
      for (int d = 0; d < 3; d++) {
        f[3 * i + d] += del[d] * force;
        f[3 * i + 3 + d] -= del[d] * force;
      }
    }
    for (int i = 0; i < SPHERES; i++) {
      print("force", step, i, {f[3 * i], f[3 * i + 1], f[3 * i + 2]});
      if (friction) print("torque", step, i, {sums.torque[3 * i], sums.torque[3 * i + 1], sums.torque[3 * i + 2]});
    }
  }
  for (int i = 0; i < SPHERES; i++) {
    const Contact &c = contacts[i];
    if (!has_next(i)) continue;
    print("contact", STEPS, i, {c.peak, c.time_peak, c.time_yield, c.front.time[0], c.front.time[5]});
    const TangentialSpring &s = c.spring;
    if (friction) print("spring", STEPS, i, {s.force[0], s.force[1], s.force[2], s.compliance, s.loss});
  }
}
